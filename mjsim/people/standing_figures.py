"""Figures standing on floors, slopes and steps: ankles follow the slope, and the leg on higher ground bends."""

import math
from collections.abc import Callable, Collection

import numpy as np

from mjsim.geometry import Array
from mjsim.people.figure import Figure
from mjsim.people.figure_joints import SIDES

Ground = Callable[[Array], float]
"""Height of the ground at a point, world frame, shape (2,) [m]."""
STEEPEST = math.radians(20.0)
"""Steeper ground under a foot is an edge, not a slope [rad]; assumed."""
SLOPE_BASELINE = 0.03
"""Distance from the centreline of a sole at which the lateral slope is measured [m]; assumed."""
MAX_LEG_SHORTENING = 0.2
"""Maximum shortening of a leg [m]; assumed."""


def stand(
    figure: Figure, values: Array, root: Array, ground: Ground, *, held: Collection[str] = ()
) -> tuple[Array, Array]:
    """Return joint values and pelvis pose of a figure that stands with its feet on the ground.

    The trunk keeps its lean and heading. Each ankle follows the slope under its foot, and the leg on higher ground
    bends. No sole is below the ground, and one touches it.

    Args:
        figure: The body.
        values: Joint values on a level floor, shape (n,) [rad].
        root: world_from_pelvis above the standing position, at any height, shape (4, 4) [m].
        ground: The ground.
        held: Joints that must not change.

    Returns:
        values: Joint values, shape (n,) [rad].
        root: world_from_pelvis, shape (4, 4) [m].
    """
    values, root = values.copy(), root.copy()
    names = list(figure.joints)
    for side in SIDES:
        for name, turn in _slopes(figure, values, root, ground, side).items():
            _turn(figure, values, names, {name: turn}, held)
    rooms = {side: _room(figure, values, root, ground, side) for side in SIDES}
    lower = max(rooms, key=rooms.__getitem__)
    for side, room in rooms.items():
        if 0.0 < (by := rooms[lower] - room) <= MAX_LEG_SHORTENING:
            _turn(figure, values, names, _bend(figure, values, side, by), held)
    root[2, 3] -= min(_room(figure, values, root, ground, side) for side in SIDES)
    return values, root


def _slopes(figure: Figure, values: Array, root: Array, ground: Ground, side: str) -> dict[str, float]:
    """Return the ankle angles that follow the ground under a foot, by joint [rad]; none at an edge."""
    spots = figure.spots(figure.poses(values, root))
    heel, ball = (spots[f"{side}_{part}"][:2] for part in ("heel", "ball"))
    ahead = (ball - heel) / np.linalg.norm(ball - heel)
    middle, left = (heel + ball) / 2, np.array([-ahead[1], ahead[0]])
    outward = left if side == "left" else -left
    up = math.atan2(ground(ball) - ground(heel), float(np.linalg.norm(ball - heel)))
    out = math.atan2(
        ground(middle + SLOPE_BASELINE * outward) - ground(middle - SLOPE_BASELINE * outward), 2 * SLOPE_BASELINE
    )
    turns = {f"{side}_ankle_flexion": up, f"{side}_ankle_inversion": -out}
    return {name: turn for name, turn in turns.items() if abs(turn) <= STEEPEST}


def _room(figure: Figure, values: Array, root: Array, ground: Ground, side: str) -> float:
    """Return the height of a foot above the ground below its heel and ball; negative if it is below the ground [m]."""
    spots = figure.spots(figure.poses(values, root))
    soles = (spots[f"{side}_{part}"] for part in ("heel", "ball"))
    return min(float(sole[2]) - ground(sole[:2]) for sole in soles)


def _bend(figure: Figure, values: Array, side: str, by: float) -> dict[str, float]:
    """Return the angles of hip, knee and ankle that shorten a stretched leg with a level foot [rad].

    The foot is below the hip if the ankle can bend so far, otherwise in front of it.

    Args:
        figure: The body.
        values: Joint values, shape (n,) [rad].
        side: Side of the leg.
        by: Shortening [m].
    """
    thigh, shank = (float(np.linalg.norm(figure.segments[f"{side}_{name}"].at)) for name in ("shank", "foot"))
    ankle, length = f"{side}_ankle_flexion", thigh + shank - by
    knee = math.acos((length**2 - thigh**2 - shank**2) / (2.0 * thigh * shank))
    free = figure.joints[ankle].high - float(values[list(figure.joints).index(ankle)])
    lean = min(knee - math.asin(shank * math.sin(knee) / length), max(free, 0.0))
    hip = math.acos((length - shank * math.cos(lean)) / thigh)
    return {f"{side}_hip_flexion": hip, f"{side}_knee_flexion": hip + lean, ankle: lean}


def _turn(figure: Figure, values: Array, names: list[str], turns: dict[str, float], held: Collection[str]) -> None:
    """Change joint values within their ranges; not at all if one of the joints is held."""
    if any(name in held for name in turns):
        return
    for name, turn in turns.items():
        joint, place = figure.joints[name], names.index(name)
        values[place] = min(max(values[place] + turn, joint.low), joint.high)
