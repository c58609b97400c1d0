"""Finds walls drawn as filled shapes: two sides that face each other across the fill are faces of a wall; in metres."""

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mjsim.exchange.drawings.drawing import Line
from mjsim.exchange.drawings.strokes import Pieces, split
from mjsim.exchange.drawings.united import MIN_SLENDERNESS, is_compact, united
from mjsim.exchange.drawings.wall_faces import continued, merged, paired
from mjsim.exchange.maps import Bar, fitted_rectangle
from mjsim.geometry import Array
from mjsim.world import Wall, World, solid

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

MIN_DARKNESS = 0.3
"""Minimum darkness of the fill of walls, 0 to 1; rooms and furniture are lighter."""
MAX_MEAN_WIDTH = 0.6
"""Maximum of twice the area of a wall's shape divided by its perimeter, which is about its thickness [m]."""
OUTLINE_MARGIN = 0.015
"""Margin by which a wall covers more than its outline [m]."""
MIN_SLAB_WIDTH = 0.03
"""Minimum width of slabs [m]."""
MAX_SIDE_DEVIATION, SLANTED = 0.03, 0.15
"""A rectangle replaces a part if their sides deviate by less than this on average; otherwise the part is cut [m]."""
MAX_COLUMN_SIZE = 1.2
"""A filled shape that is no larger, and not slender, is a column [m]."""


def bars_of_filled(lines: Sequence[Line]) -> tuple[list[Bar], list[Line], "BaseGeometry"]:
    """Return the walls and the outlines of columns among filled shapes, and the area that the rest covers."""
    bars: list[Bar] = []
    columns: list[Line] = []
    dark = [line for line in lines if (line.dark or 0.0) >= MIN_DARKNESS]
    alone = _alone(dark)
    rest = [line for line in dark if line.path not in alone]
    whole = united([line for line in dark if line.path in alone])
    alone = _alone(whole)
    for line in whole:
        bar = fitted_rectangle(line.points) if line.path in alone else None
        if bar is not None and bar.length >= MIN_SLENDERNESS * bar.width and bar.width <= MAX_MEAN_WIDTH:
            bars.append(bar)
        elif (
            line.path in alone
            and max(np.ptp(line.points, axis=0).tolist()) <= MAX_COLUMN_SIZE
            and is_compact(line.points)
        ):
            columns.append(line)
        else:
            rest.append(line)
    bars = continued(bars, Pieces(np.zeros((0, 2, 2)), np.zeros(0, dtype=int)))
    shape = _narrow(rest)
    if shape.is_empty:
        return bars, columns, shape
    import shapely

    rings = [ring for part in shapely.get_parts(shape) for ring in (part.exterior, *part.interiors)]
    pieces, _ = split([shapely.get_coordinates(ring)[:-1] for ring in rings], [True] * len(rings))
    pieces = merged(pieces)
    walls = continued(paired(pieces, solid=shape.buffer(0.005)).bars, pieces)
    return [*bars, *walls], columns, shape


def rest_of_filled(shape: "BaseGeometry", walls: Sequence[Wall]) -> list[Line]:
    """Return rectangles that cover the filled area outside walls: piers, shafts, thickened corners."""
    import shapely

    if shape.is_empty:
        return []
    longest = max((segment for wall in walls for segment in wall.segments()), key=lambda ends: math.dist(*ends))
    heading = math.atan2(longest[1][1] - longest[0][1], longest[1][0] - longest[0][0])
    whole = World(walls=tuple(wall.model_copy(update={"openings": ()}) for wall in walls))
    covered = solid(whole).buffer(OUTLINE_MARGIN, join_style="mitre")
    # Slivers are removed; sharp corners remain.
    left = (
        shape.difference(covered).buffer(-OUTLINE_MARGIN, join_style="mitre").buffer(OUTLINE_MARGIN, join_style="mitre")
    )
    c, s = np.cos(heading), np.sin(heading)
    turned = shapely.transform(left, lambda points: points @ [[c, -s], [s, c]])
    corners = [box for part in shapely.get_parts(turned) for box in _slabs(part)]
    # Each is a separate item, however close they are.
    return [Line(box @ [[c, s], [-s, c]], closed=True, part=-number) for number, box in enumerate(corners, start=1)]


def _slabs(polygon: "BaseGeometry") -> Iterator[Array]:
    """Yield axis-aligned rectangles that cover a polygon, corners in shape (4, 2) [m]; narrow ones where it slants."""
    import shapely

    places = np.unique(shapely.get_coordinates(polygon)[:, 0])
    places = places[np.diff(places, prepend=-np.inf) > MIN_SLAB_WIDTH]
    low, high = polygon.bounds[1], polygon.bounds[3]
    for left, right in itertools.pairwise(places.tolist()):
        for first, last in itertools.pairwise(np.linspace(left, right, _steps(polygon, left, right) + 1).tolist()):
            for part in shapely.get_parts(polygon.intersection(shapely.box(first, low, last, high))):
                if min(part.bounds[2] - part.bounds[0], part.bounds[3] - part.bounds[1]) > MIN_SLAB_WIDTH:
                    yield shapely.get_coordinates(shapely.box(*part.bounds))[:4]


def _steps(polygon: "BaseGeometry", left: float, right: float) -> int:
    """Return the number of slabs between two x positions for which their ends follow the polygon's outline."""
    import shapely

    part = polygon.intersection(shapely.box(left, polygon.bounds[1], right, polygon.bounds[3]))
    boxes = [shapely.box(*each.bounds) for each in shapely.get_parts(part)]
    level = sum(box.area - each.area for box, each in zip(boxes, shapely.get_parts(part), strict=True))
    jagged = level > MAX_SIDE_DEVIATION * sum(box.length for box in boxes)
    return max(1, math.ceil((right - left) / SLANTED)) if jagged else 1


def _alone(lines: Sequence[Line]) -> set[int]:
    """Return the numbers of the drawn shapes that have a single outline."""
    counts: dict[int, int] = {}
    for line in lines:
        counts[line.path] = counts.get(line.path, 0) + 1
    return {path for path, count in counts.items() if count == 1}


def _narrow(lines: Sequence[Line]) -> "BaseGeometry":
    """Return the area that filled outlines cover, by the even-odd rule within a shape, without rooms."""
    import shapely

    shapes: dict[int, BaseGeometry] = {}
    for line in lines:
        ring = shapely.make_valid(shapely.Polygon(line.points))
        shapes[line.path] = shapes[line.path].symmetric_difference(ring) if line.path in shapes else ring
    polygons = [part for shape in shapes.values() for part in shapely.get_parts(shape) if part.geom_type == "Polygon"]
    narrow = [part for part in polygons if part.length and 2 * part.area / part.length <= MAX_MEAN_WIDTH]
    return shapely.union_all(narrow).buffer(0.0)
