"""Walls drawn as filled shapes: each side that faces another through the fill is the face of a wall; in metres."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from mjsim.exchange.drawing import Line
from mjsim.exchange.faces import continued, merged, paired
from mjsim.exchange.shapes import Bar, fitted_rectangle
from mjsim.exchange.strokes import split

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

DARK = 0.3
"""Walls are filled at least so dark, 0 to 1; rooms and furniture are lighter."""
NARROW = 0.6
"""Twice the area of a wall's shape by its circumference at most: it is about as thick [m]."""
SLENDER = 2.0
"""A filled rectangle that is so many times as long as wide is a wall."""
COLUMN = 1.2
"""A filled shape that is no larger, and not slender, is a column [m]."""


def bars_of_filled(lines: Sequence[Line]) -> tuple[list[Bar], list[Line]]:
    """Return the walls that filled shapes are, and the lines of those that are columns."""
    bars: list[Bar] = []
    columns: list[Line] = []
    rest: list[Line] = []
    alone = _alone(lines)
    for line in lines:
        if (line.dark or 0.0) < DARK:
            continue
        bar = fitted_rectangle(line.points) if line.path in alone else None
        if bar is not None and bar.length >= SLENDER * bar.width and bar.width <= NARROW:
            bars.append(bar)
        elif line.path in alone and max(np.ptp(line.points, axis=0).tolist()) <= COLUMN:
            columns.append(line)
        else:
            rest.append(line)
    shape = _narrow(rest)
    if shape.is_empty:
        return bars, columns
    import shapely

    rings = [ring for part in shapely.get_parts(shape) for ring in (part.exterior, *part.interiors)]
    pieces, _ = split([shapely.get_coordinates(ring)[:-1] for ring in rings], [True] * len(rings))
    pieces = merged(pieces)
    found = paired(pieces, solid=shape.buffer(0.005))
    return [*bars, *continued(found.bars, pieces)], columns


def _alone(lines: Sequence[Line]) -> set[int]:
    """Return the numbers of the drawn shapes that have one outline."""
    counts: dict[int, int] = {}
    for line in lines:
        counts[line.path] = counts.get(line.path, 0) + 1
    return {path for path, count in counts.items() if count == 1}


def _narrow(lines: Sequence[Line]) -> "BaseGeometry":
    """Return what filled outlines cover, those of one shape by the even-odd rule, rooms left out."""
    import shapely

    shapes: dict[int, BaseGeometry] = {}
    for line in lines:
        ring = shapely.make_valid(shapely.Polygon(line.points))
        shapes[line.path] = shapes[line.path].symmetric_difference(ring) if line.path in shapes else ring
    polygons = [part for shape in shapes.values() for part in shapely.get_parts(shape) if part.geom_type == "Polygon"]
    narrow = [part for part in polygons if part.length and 2 * part.area / part.length <= NARROW]
    return shapely.union_all(narrow).buffer(0.0)
