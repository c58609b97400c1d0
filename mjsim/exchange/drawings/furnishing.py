"""Converts furniture and columns of a drawing to boxes and cylinders; all lengths in metres."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mjsim.exchange.drawings.drawing import Line
from mjsim.exchange.drawings.rectilinear import rectangles_in
from mjsim.exchange.maps import DIGITS, WALL_HEIGHT
from mjsim.geometry import Array
from mjsim.world import BoxObstacle, CylinderObstacle

MIN_SIZE, MAX_SIZE = 0.1, 6.0
"""Smallest and largest size of a piece of furniture [m]."""
HEIGHT = 0.75
"""Height of furniture, which a drawing does not state: that of a table [m]."""
MAX_GAP = 0.02
"""Lines closer than this belong to one piece [m]."""
ROUND_TOLERANCE = 0.02
"""Maximum deviation of the corners of a round item from its radius, as a fraction of it."""

MAX_AREA_RATIO = 1.15
"""An axis-aligned box is used if its area is at most this multiple of the smallest box's."""
MIN_HIDDEN_SHARE = 0.7
"""An outline is part of a larger one if at least this fraction of it lies inside."""

Thing = BoxObstacle | CylinderObstacle


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """Outline of one item."""

    points: Array
    """Corners, shape (n, 2) [m]."""
    name: str
    """Name of its block, or its kind."""
    strokes: Sequence[Array] = ()
    """The lines that it is drawn with, closed ones with their first corner at the end, shape (n, 2) each [m]."""

    @property
    def parts(self) -> "list[Outline]":
        """The rectangles that make up an angled item; else the outline itself."""
        return [Outline(corners, self.name) for corners in rectangles_in(self.strokes)] or [self]


def with_parts(lines: Sequence[Line]) -> list[Line]:
    """Return lines, each with its outermost block instance no larger than a piece of furniture; all in metres.

    A block that contains a whole floor is ignored.
    """
    boxes: dict[int, Array] = {}
    for line in lines:
        box = np.stack([line.points.min(axis=0), -line.points.max(axis=0)])
        for number in line.parts:
            boxes[number] = np.minimum(boxes[number], box) if number in boxes else box
    small = {number for number, (low, high) in boxes.items() if float(np.max(-high - low)) <= MAX_SIZE}
    return [
        replace(line, part=next((number for number in line.parts if number in small), 0)) if line.parts else line
        for line in lines
    ]


def outlines_of(lines: Sequence[Line], name: str) -> list[Outline]:
    """Return one outline per block instance, and one per group of other lines that touch."""
    blocks: dict[int, list[Line]] = {}
    loose: list[Line] = []
    for line in lines:
        blocks.setdefault(line.part, []).append(line) if line.part else loose.append(line)
    found = [_outline(group, _name_of(group[0].block) or name) for group in blocks.values()]
    return found + [_outline(group, name) for group in touching(loose)]


def touching(lines: Sequence[Line], *, reach: float = MAX_GAP) -> list[list[Line]]:
    """Return groups of lines that touch, or are within `reach` of each other [m]."""
    import shapely
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    if not lines:
        return []
    rings = _strokes(lines)
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
    """Return the box or cylinder around an outline; None if its size is implausible."""
    import shapely

    points = outline.points
    name = f"{outline.name}-{number}"
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    away = np.hypot(*(points - middle).T)
    if len(points) >= 12 and np.ptp(away) <= ROUND_TOLERANCE * away.max() and away.max() <= MAX_SIZE / 2:
        radius = round(float(away.max()), DIGITS)
        return CylinderObstacle(name=name, at=_point(middle), cylinder=(radius, height)) if radius > 0.03 else None
    level = shapely.box(*points.min(axis=0), *points.max(axis=0))
    box = shapely.minimum_rotated_rectangle(shapely.MultiPoint(points))
    box = level if level.area <= MAX_AREA_RATIO * box.area else box
    if box.geom_type != "Polygon":
        return None
    corners = shapely.get_coordinates(box)[:4]
    sides = corners[1] - corners[0], corners[2] - corners[1]
    long, wide = sorted(sides, key=lambda side: -math.hypot(*side))
    sizes = [round(math.hypot(*side), DIGITS) for side in (long, wide)]
    if sizes[0] > MAX_SIZE or sizes[0] < MIN_SIZE or sizes[1] < 0.02:
        return None
    heading = (math.degrees(math.atan2(long[1], long[0])) + 90.0) % 180.0 - 90.0
    return BoxObstacle(
        name=name, at=_point(corners.mean(axis=0)), heading_deg=round(heading, 2) + 0.0, box=(*sizes, height)
    )


def column_of(outline: Outline, number: int) -> Thing | None:
    """Return the column for an outline, as high as the walls."""
    return thing_of(outline, height=WALL_HEIGHT, number=number)


def distinct_outlines(outlines: Sequence[Outline]) -> list[Outline]:
    """Return outlines without those inside larger ones, in the same order."""
    import shapely

    hulls = [shapely.MultiPoint(outline.points).convex_hull for outline in outlines]
    tree = shapely.STRtree(hulls)
    distinct = []
    for index, hull in enumerate(hulls):
        others = [k for k in tree.query(hull).tolist() if (hulls[k].area, -k) > (hull.area, -index)]
        if not any(hulls[k].intersection(hull).area >= MIN_HIDDEN_SHARE * hull.area for k in others):
            distinct.append(outlines[index])
    return distinct


def _outline(lines: Sequence[Line], name: str) -> Outline:
    return Outline(np.concatenate([line.points for line in lines]), name, _strokes(lines))


def _strokes(lines: Sequence[Line]) -> list[Array]:
    """Return lines, the closed ones with their first corner at the end."""
    return [np.concatenate([line.points, line.points[:1]]) if line.closed else line.points for line in lines]


def _point(place: Array) -> tuple[float, float]:
    x, y = np.round(place, DIGITS).tolist()
    return x + 0.0, y + 0.0


def _name_of(block: str) -> str:
    """Return a block's name as a valid world name; '' for a name that a program generated."""
    plain = re.sub(r"[^A-Za-z0-9_]+", "-", block).strip("-").lower()[:32]
    return "" if not re.search(r"[a-z]{3}", plain) or plain.startswith(("a-c", "u-")) else plain
