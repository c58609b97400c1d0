"""Divides angled furniture, such as corner couches and desks in L or U shape, into rectangles; lengths in metres."""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from mjsim.exchange.maps import Cells
from mjsim.geometry import Array

MIN_FILLED_SHARE = 0.85
"""An outline that fills at least this fraction of its rectangle is that rectangle."""
LINE_TOLERANCE = 0.05
"""Corners closer than this along an axis are on one line [m]."""
MIN_CELL_SHARE = 0.5
"""A cell belongs to an outline that covers at least this fraction of it."""
MAX_AREA_ERROR = 0.1
"""Maximum difference of the area of the rectangles from that of the outline, as a fraction of it."""
MAX_PARTS, MAX_LINES = 6, 24
"""Maximum number of rectangles of one outline, and of lines through its corners along an axis."""


def rectangles_in(strokes: Sequence[Array]) -> list[Array]:
    """Return the corners of the rectangles that make up a shape, shape (4, 2) each [m]; none if one is enough.

    Args:
        strokes: The lines that the shape is drawn with, shape (n, 2) each [m].
    """
    import shapely
    from shapely import affinity

    if is_rectangle(strokes):
        return []
    shape = _surrounded(strokes)
    (x, y), (to_x, to_y) = shapely.get_coordinates(shapely.minimum_rotated_rectangle(shape))[:2]
    turn = math.atan2(to_y - y, to_x - x)
    level = affinity.rotate(shape, -turn, origin=(0.0, 0.0), use_radians=True)
    boxes = _boxes(level) if _is_rectilinear(level) else []
    area = sum(part.area for part in boxes)
    if not 2 <= len(boxes) <= MAX_PARTS or abs(area - shape.area) > MAX_AREA_ERROR * shape.area:
        return []
    turned = [affinity.rotate(part, turn, origin=(0.0, 0.0), use_radians=True) for part in boxes]
    return [shapely.get_coordinates(part)[:4] for part in turned]


def is_rectangle(strokes: Sequence[Array]) -> bool:
    """Return whether the rectangle around lines, shape (n, 2) each [m], is about the area that they surround."""
    import shapely

    shape = _surrounded(strokes)
    if shape is None:
        return True
    box = shapely.minimum_rotated_rectangle(shape)
    return box.geom_type != "Polygon" or bool(shape.area >= MIN_FILLED_SHARE * box.area)


def _surrounded(strokes: Sequence[Array]) -> Any:
    """Return the area that lines surround; None if they surround none, or several apart."""
    import shapely

    lines = shapely.union_all([shapely.LineString(points) for points in strokes], grid_size=1e-4)
    area = shapely.union_all(shapely.get_parts(shapely.polygonize([lines])))
    return area if area.geom_type == "Polygon" and area.area > 0.0 else None


def _is_rectilinear(shape: Any) -> bool:
    """Return whether nearly all sides of a shape are parallel to the axes."""
    import shapely

    sides = np.abs(np.diff(shapely.get_coordinates(shape.exterior), axis=0))
    return float(sides.min(axis=1).sum()) <= MAX_AREA_ERROR * float(sides.sum())


def _boxes(shape: Any) -> list[Any]:
    """Return disjoint rectangles that cover a shape whose sides are parallel to the axes, the largest first."""
    import shapely

    corners = shapely.get_coordinates(shape)
    columns, rows = _steps(corners[:, 0]), _steps(corners[:, 1])
    if max(len(columns), len(rows)) > MAX_LINES:
        return []
    cells = np.array(
        [
            [
                shape.intersection(cell := shapely.box(left, low, right, high)).area >= MIN_CELL_SHARE * cell.area
                for left, right in pairwise(columns)
            ]
            for low, high in pairwise(rows)
        ]
    ).reshape(len(rows) - 1, len(columns) - 1)
    found: list[Any] = []
    while cells.any() and len(found) <= MAX_PARTS:
        left, right, low, high = _largest(cells, np.array(columns), np.array(rows))
        cells[low:high, left:right] = False
        found.append(shapely.box(columns[left], rows[low], columns[right], rows[high]))
    return found


def _steps(values: Array) -> list[float]:
    """Return the distinct values among coordinates, ascending; close ones become one."""
    steps: list[float] = []
    for value in sorted(values.tolist()):
        if not steps or value - steps[-1] > LINE_TOLERANCE:
            steps.append(value)
    return steps


def _largest(cells: Cells, columns: Array, rows: Array) -> tuple[int, int, int, int]:
    """Return the first and last line of the largest rectangle of cells in both directions."""
    best, found = 0.0, (0, 0, 0, 0)
    for low in range(len(cells)):
        open_columns = np.ones(cells.shape[1], dtype=bool)
        for high in range(low + 1, len(cells) + 1):
            open_columns &= cells[high - 1]
            edges = np.flatnonzero(np.diff(np.pad(open_columns.astype(int), 1)))
            for left, right in edges.reshape(-1, 2).tolist():
                area = float((columns[right] - columns[left]) * (rows[high] - rows[low]))
                if area > best:
                    best, found = area, (left, right, low, high)
    return found
