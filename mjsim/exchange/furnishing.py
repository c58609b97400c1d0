"""Furniture and columns of a drawing -> boxes and cylinders; all lengths in metres."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mjsim.exchange.drawing import Line
from mjsim.exchange.maps import DIGITS, WALL_HEIGHT
from mjsim.geometry import Array
from mjsim.world import BoxObstacle, CylinderObstacle

SMALLEST, LARGEST = 0.1, 6.0
"""Size of a piece of furniture [m]."""
HEIGHT = 0.75
"""A drawing does not tell it: that of a table [m]."""
TOUCHING = 0.02
"""Lines so near to each other are of one piece [m]."""
ROUND = 0.02
"""The corners of a round thing differ in their distance from its middle by this share at most."""

LEVEL = 1.15
"""A box along the axes is taken when it is at most so many times as large as the smallest."""
HIDDEN = 0.7
"""What lies in something larger by this share is part of it."""

Thing = BoxObstacle | CylinderObstacle


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """Corners of one thing."""

    points: Array
    """Shape (n, 2) [m]."""
    name: str
    """Of its block, or what it is."""


def with_parts(lines: Sequence[Line]) -> list[Line]:
    """Return lines in metres with the placed block that each is part of: the outermost that is no larger than a thing.

    A block that holds a whole floor is none.
    """
    boxes: dict[int, Array] = {}
    for line in lines:
        box = np.stack([line.points.min(axis=0), -line.points.max(axis=0)])
        for number in line.parts:
            boxes[number] = np.minimum(boxes[number], box) if number in boxes else box
    small = {number for number, (low, high) in boxes.items() if float(np.max(-high - low)) <= LARGEST}
    return [
        replace(line, part=next((number for number in line.parts if number in small), 0)) if line.parts else line
        for line in lines
    ]


def outlines_of(lines: Sequence[Line], name: str) -> list[Outline]:
    """Return one outline for each placed block, and for all other lines that touch each other."""
    blocks: dict[int, list[Line]] = {}
    loose: list[Line] = []
    for line in lines:
        blocks.setdefault(line.part, []).append(line) if line.part else loose.append(line)
    found = [Outline(_corners(group), _name_of(group[0].block) or name) for group in blocks.values()]
    return found + [Outline(_corners(group), name) for group in touching(loose)]


def touching(lines: Sequence[Line], *, reach: float = TOUCHING) -> list[list[Line]]:
    """Return lines in groups of those that touch, or are no farther apart than `reach` [m]."""
    import shapely
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    if not lines:
        return []
    rings = [np.concatenate([line.points, line.points[:1]]) if line.closed else line.points for line in lines]
    shapes = [
        shapely.Polygon(ring) if line.closed and len(ring) > 3 else shapely.LineString(ring)
        for ring, line in zip(rings, lines, strict=True)
    ]
    one, other = shapely.STRtree(shapes).query(shapes, predicate="dwithin", distance=reach)
    graph = coo_matrix((np.ones(len(one)), (one, other)), shape=(len(lines), len(lines)))
    _, label = connected_components(graph, directed=False)
    groups: dict[int, list[Line]] = {}
    for line, number in zip(lines, label.tolist(), strict=True):
        groups.setdefault(number, []).append(line)
    return list(groups.values())


def thing_of(outline: Outline, *, height: float, number: int) -> Thing | None:
    """Return the box or the cylinder around an outline; None when it is too small or too large to stand there."""
    import shapely

    points = outline.points
    name = f"{outline.name}-{number}"
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    away = np.hypot(*(points - middle).T)
    if len(points) >= 12 and np.ptp(away) <= ROUND * away.max() and away.max() <= LARGEST / 2:
        radius = round(float(away.max()), DIGITS)
        return CylinderObstacle(name=name, at=_point(middle), cylinder=(radius, height)) if radius > 0.03 else None
    level = shapely.box(*points.min(axis=0), *points.max(axis=0))
    box = shapely.minimum_rotated_rectangle(shapely.MultiPoint(points))
    box = level if level.area <= LEVEL * box.area else box
    if box.geom_type != "Polygon":
        return None
    corners = shapely.get_coordinates(box)[:4]
    sides = corners[1] - corners[0], corners[2] - corners[1]
    long, wide = sorted(sides, key=lambda side: -math.hypot(*side))
    sizes = [round(math.hypot(*side), DIGITS) for side in (long, wide)]
    if sizes[0] > LARGEST or sizes[0] < SMALLEST or sizes[1] < 0.02:
        return None
    heading = (math.degrees(math.atan2(long[1], long[0])) + 90.0) % 180.0 - 90.0
    return BoxObstacle(
        name=name, at=_point(corners.mean(axis=0)), heading_deg=round(heading, 2) + 0.0, box=(*sizes, height)
    )


def column_of(outline: Outline, number: int) -> Thing | None:
    """Return the column that an outline stands for, as high as walls."""
    return thing_of(outline, height=WALL_HEIGHT, number=number)


def distinct_outlines(outlines: Sequence[Outline]) -> list[Outline]:
    """Return outlines without those that lie in larger ones, in their order."""
    import shapely

    hulls = [shapely.MultiPoint(outline.points).convex_hull for outline in outlines]
    tree = shapely.STRtree(hulls)
    kept = []
    for index, hull in enumerate(hulls):
        others = [k for k in tree.query(hull).tolist() if (hulls[k].area, -k) > (hull.area, -index)]
        if not any(hulls[k].intersection(hull).area >= HIDDEN * hull.area for k in others):
            kept.append(outlines[index])
    return kept


def _corners(lines: Sequence[Line]) -> Array:
    return np.concatenate([line.points for line in lines])


def _point(place: Array) -> tuple[float, float]:
    x, y = np.round(place, DIGITS).tolist()
    return x + 0.0, y + 0.0


def _name_of(block: str) -> str:
    """Return a block's name as names of worlds are written; nothing for one that a program made up."""
    plain = re.sub(r"[^A-Za-z0-9_]+", "-", block).strip("-").lower()[:32]
    return "" if not re.search(r"[a-z]{3}", plain) or plain.startswith(("a-c", "u-")) else plain
