"""Finds walls among the upright boxes of a scene, with the doorways and windows between boxes on one line."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from mjsim.exchange.maps import DIGITS
from mjsim.exchange.scenes.scene_solids import SceneSolid, SceneTexture
from mjsim.geometry import Array
from mjsim.world import Opening, Wall

MIN_WALL_HEIGHT, LOW_WALL_HEIGHT, TALLEST_FLOOR = 0.3, 1.2, 0.1
"""Minimum height of a wall, height below which it must be slender, and maximum height of its underside [m]."""
MAX_THICKNESS, MIN_LENGTH = 0.35, 0.4
"""Maximum thickness and minimum length of a wall [m]."""
SLENDER, SLENDER_LOW = 1.5, 6.0
"""Minimum length of a wall as a multiple of its thickness, and of a low one."""
SAME, SHIFT = 0.01, 0.0017
"""Step within which boxes are in line, and equally thick; and offset of the steps from round numbers [m]."""
MIN_OPENING = 0.3
"""Minimum width of a doorway or window [m]."""
PARALLEL = math.radians(0.2)


@dataclass(frozen=True, slots=True, eq=False)
class Slab:
    """A box from the side: a stretch of a line, and heights."""

    line: tuple[float, float, float]
    """Direction in [0, pi) [rad], distance from the origin, left positive, and thickness [m]."""
    span: tuple[float, float]
    """Start and end along the line [m]."""
    heights: tuple[float, float]
    color: str | None
    texture: SceneTexture | None


def slab_of(box: SceneSolid) -> Slab | None:
    """Return an upright box as a part of a wall; None if it is too thick for one."""
    if box.kind != "box" or not box.is_upright:
        return None
    wide, deep, high = box.size
    long, thick = max(wide, deep), min(wide, deep)
    heading = (box.heading + (math.pi / 2 if deep > wide else 0.0)) % math.pi
    if thick > MAX_THICKNESS or long < thick:
        return None
    heading = 0.0 if math.pi - heading < PARALLEL / 2 else heading
    along = np.array([math.cos(heading), math.sin(heading)])
    x, y, z = box.pose[:3, 3]
    middle, offset = float(along @ [x, y]), float(along @ [y, -x])
    return Slab(
        (heading, offset, thick),
        (middle - long / 2, middle + long / 2),
        (z - high / 2, z + high / 2),
        box.color,
        box.texture,
    )


def walls_of(boxes: Sequence[SceneSolid]) -> tuple[list[Wall], list[int]]:
    """Return the walls that boxes make up, and the indices of the boxes that are part of them."""
    slabs = {index: slab for index, box in enumerate(boxes) if (slab := slab_of(box)) is not None}
    walls: list[Wall] = []
    used: list[int] = []
    for group in _in_line(slabs):
        for wall, members in _walls_on_line({index: slabs[index] for index in group}):
            walls.append(wall)
            used += members
    return walls, used


def _in_line(slabs: dict[int, Slab]) -> list[list[int]]:
    """Return the indices of slabs on one line, of one thickness."""
    groups: dict[tuple[int, int, int], list[int]] = {}
    for index, slab in slabs.items():
        heading, offset, thick = slab.line
        key = (round(heading / PARALLEL), round((offset + SHIFT) / SAME), round((thick + SHIFT) / SAME))
        groups.setdefault(key, []).append(index)
    return list(groups.values())


def _walls_on_line(slabs: dict[int, Slab]) -> list[tuple[Wall, list[int]]]:
    """Return the walls on a line, and the slabs of each."""
    places = sorted({round(end, DIGITS) for slab in slabs.values() for end in slab.span})
    stretches = []
    for start, end in pairwise(places):
        middle = (start + end) / 2
        over = [index for index, slab in slabs.items() if slab.span[0] <= middle <= slab.span[1]]
        stretches.append((start, end, over, _profile([slabs[index].heights for index in over])))
    found = []
    for run in _runs(stretches):
        members = sorted({index for _, _, over, _ in run for index in over})
        wall = _wall(run, slabs[members[0]], slabs)
        if wall is not None:
            found.append((wall, members))
    return found


Profile = tuple[float, float, float] | None
"""Sill and head of the hole in a stretch of a wall, equal for none, and its top [m]; None where it is not a wall."""
Stretch = tuple[float, float, list[int], Profile]


def _profile(heights: Sequence[tuple[float, float]]) -> Profile:
    """Return the profile of boxes above each other."""
    merged: list[list[float]] = []
    for low, high in sorted(heights):
        if merged and low <= merged[-1][1] + SAME:
            merged[-1][1] = max(merged[-1][1], high)
        else:
            merged.append([low, high])
    if not merged or len(merged) > 2 or merged[-1][1] < MIN_WALL_HEIGHT:
        return None
    top = merged[-1][1]
    if len(merged) == 2:
        return (merged[0][1], merged[1][0], top) if merged[0][0] <= TALLEST_FLOOR else None
    return (0.0, 0.0, top) if merged[0][0] <= TALLEST_FLOOR else (0.0, merged[0][0], top)


def _runs(stretches: Sequence[Stretch]) -> list[list[Stretch]]:
    """Return consecutive stretches of one height that form a wall: at least one has no hole."""
    runs: list[list[Stretch]] = [[]]
    for stretch in stretches:
        profile = stretch[3]
        before = runs[-1][-1][3] if runs[-1] else None
        if profile is None or (before is not None and abs(before[2] - profile[2]) > SAME):
            runs.append([])
        if profile is not None:
            runs[-1].append(stretch)
    return [run for run in runs if any(profile is not None and profile[0] == profile[1] for *_, profile in run)]


def _wall(run: Sequence[Stretch], first: Slab, slabs: dict[int, Slab]) -> Wall | None:
    """Return the wall of a run; None if it is too short for one."""
    heading, offset, thick = first.line
    start, end = run[0][0], run[-1][1]
    top = max(profile[2] for *_, profile in run if profile is not None)
    if end - start < max(MIN_LENGTH, thick * (SLENDER if top >= LOW_WALL_HEIGHT else SLENDER_LOW)):
        return None
    along = np.array([math.cos(heading), math.sin(heading)])
    across = np.array([-along[1], along[0]]) * offset
    points = tuple(_point(along * place + across) for place in (start, end))
    holes = _openings(run)
    if points[0] == points[1] or holes is None:
        return None
    keys: dict[str, Any] = {} if first.color is None else {"color": first.color}
    if first.texture is not None:
        keys |= {"texture": first.texture.name, "tile": round(first.texture.tile or top, DIGITS)}
    return Wall(
        points=points,
        thickness=round(max(thick, 1e-3), DIGITS),
        height=round(top, DIGITS),
        openings=tuple(holes),
        **keys,
    )


def _openings(run: Sequence[Stretch]) -> list[Opening] | None:
    """Return the doorways and windows of a run; None if one is too narrow."""
    holes: list[list[float]] = []
    for start, end, _, profile in run:
        assert profile is not None, "runs have none of these"
        sill, head, _ = profile
        if sill == head:
            continue
        if holes and holes[-1][1] == start and holes[-1][2:] == [sill, head]:
            holes[-1][1] = end
        else:
            holes.append([start, end, sill, head])
    if any(end - start < MIN_OPENING for start, end, *_ in holes):
        return None
    origin = run[0][0]
    return [
        Opening(
            at=round(start - origin, DIGITS),
            width=round(end - start, DIGITS),
            sill=round(sill, DIGITS) if sill > TALLEST_FLOOR else 0.0,
            head=round(head, DIGITS),
        )
        for start, end, sill, head in holes
    ]


def _point(place: Array) -> tuple[float, float]:
    x, y = np.round(place, DIGITS).tolist()
    return x + 0.0, y + 0.0
