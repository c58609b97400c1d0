"""Figures that stand on floors, slopes and steps: ankles follow the slope, and the leg that stands higher bends."""

import math
from collections.abc import Callable, Collection

import numpy as np

from mjsim.geometry import Array
from mjsim.people.figure import Figure
from mjsim.people.joints import SIDES

Ground = Callable[[Array], float]
"""Height of what is below a place, world frame, shape (2,) [m]."""
STEEPEST = math.radians(20.0)
"""What is steeper under a foot is the edge of something, not a slope [rad]; assumed."""
BESIDE = 0.03
"""From the middle of a sole, where the slope across it is looked for [m]; assumed."""
BEND = 0.2
"""A leg is made shorter by so much at most [m]; assumed."""


def stand(
    figure: Figure, values: Array, root: Array, ground: Ground, *, held: Collection[str] = ()
) -> tuple[Array, Array]:
    """Return the joints and the place of a figure that stands with its feet on the ground.

    The trunk keeps its lean and heading. Each ankle follows the slope under its foot, and the leg whose foot would
    stand higher bends. No sole is below the ground, and one touches it.

    Args:
        figure: The body.
        values: Of its joints on a level floor, shape (n,) [rad].
        root: World from pelvis, above the place where it stands, at any height, shape (4, 4) [m].
        ground: What it stands on.
        held: Joints that stay as they are.

    Returns:
        values: Of the joints, shape (n,) [rad].
        root: World from pelvis, shape (4, 4) [m].
    """
    values, root = values.copy(), root.copy()
    names = list(figure.joints)
    for side in SIDES:
        for name, turn in _slopes(figure, values, root, ground, side).items():
            _turn(figure, values, names, {name: turn}, held)
    rooms = {side: _room(figure, values, root, ground, side) for side in SIDES}
    lower = max(rooms, key=rooms.__getitem__)
    for side, room in rooms.items():
        if 0.0 < (by := rooms[lower] - room) <= BEND:
            _turn(figure, values, names, _bend(figure, values, side, by), held)
    root[2, 3] -= min(_room(figure, values, root, ground, side) for side in SIDES)
    return values, root


def _slopes(figure: Figure, values: Array, root: Array, ground: Ground, side: str) -> dict[str, float]:
    """Return how far an ankle turns to follow the ground under its foot, by joint [rad]; none at an edge."""
    spots = figure.spots(figure.poses(values, root))
    heel, ball = (spots[f"{side}_{part}"][:2] for part in ("heel", "ball"))
    ahead = (ball - heel) / np.linalg.norm(ball - heel)
    middle, left = (heel + ball) / 2, np.array([-ahead[1], ahead[0]])
    outward = left if side == "left" else -left
    up = math.atan2(ground(ball) - ground(heel), float(np.linalg.norm(ball - heel)))
    out = math.atan2(ground(middle + BESIDE * outward) - ground(middle - BESIDE * outward), 2 * BESIDE)
    turns = {f"{side}_ankle_flexion": up, f"{side}_ankle_inversion": -out}
    return {name: turn for name, turn in turns.items() if abs(turn) <= STEEPEST}


def _room(figure: Figure, values: Array, root: Array, ground: Ground, side: str) -> float:
    """Return how far a foot is above what is below its heel and ball; negative where it is below that [m]."""
    spots = figure.spots(figure.poses(values, root))
    soles = (spots[f"{side}_{part}"] for part in ("heel", "ball"))
    return min(float(sole[2]) - ground(sole[:2]) for sole in soles)


def _bend(figure: Figure, values: Array, side: str, by: float) -> dict[str, float]:
    """Return how far hip, knee and ankle turn for a stretched leg to be shorter, its foot level [rad].

    The foot is below the hip where the ankle bends so far, else ahead of it.

    Args:
        figure: The body.
        values: Of its joints, shape (n,) [rad].
        side: Of the leg.
        by: How much shorter [m].
    """
    thigh, shank = (float(np.linalg.norm(figure.segments[f"{side}_{name}"].at)) for name in ("shank", "foot"))
    ankle, length = f"{side}_ankle_flexion", thigh + shank - by
    knee = math.acos((length**2 - thigh**2 - shank**2) / (2.0 * thigh * shank))
    free = figure.joints[ankle].high - float(values[list(figure.joints).index(ankle)])
    lean = min(knee - math.asin(shank * math.sin(knee) / length), max(free, 0.0))
    hip = math.acos((length - shank * math.cos(lean)) / thigh)
    return {f"{side}_hip_flexion": hip, f"{side}_knee_flexion": hip + lean, ankle: lean}


def _turn(figure: Figure, values: Array, names: list[str], turns: dict[str, float], held: Collection[str]) -> None:
    """Turn joints further, within their ranges; none where one of them is held."""
    if any(name in held for name in turns):
        return
    for name, turn in turns.items():
        joint, place = figure.joints[name], names.index(name)
        values[place] = min(max(values[place] + turn, joint.low), joint.high)
