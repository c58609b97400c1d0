"""Merges filled shapes that together form one wall: halves side by side, tiles end to end; in metres."""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from mjsim.exchange.drawings.drawing import Line
from mjsim.exchange.maps import fitted_rectangle
from mjsim.geometry import Array

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

MIN_SLENDERNESS = 2.0
"""Minimum ratio of length to width of a wall."""
MIN_HULL_SHARE = 0.95
"""Minimum fraction of its convex hull that a column covers."""
TOUCHING_DISTANCE = 0.005
"""Shapes this close touch; a corner this close to the line between its neighbours is removed [m]."""


def united(lines: Sequence[Line]) -> list[Line]:
    """Return filled outlines, with those that form one wall merged.

    Two are merged if they touch along half of the longer side of the smaller one, and if both are slender, such as the
    two halves of a wall drawn with the rooms on either side, or if together they form a rectangle.

    Args:
        lines: Outlines of filled shapes, each the only outline of its shape.
    """
    import shapely
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    shapes = [shapely.make_valid(shapely.Polygon(line.points)) for line in lines]
    owners = [[index] for index in range(len(lines))]
    while len(shapes) > 1 and (pairs := _parts_of_one(shapes)):
        one, other = np.array(pairs).T
        graph = coo_matrix((np.ones(len(pairs)), (one, other)), shape=(len(shapes), len(shapes)))
        count, label = connected_components(graph, directed=False)
        groups = [np.flatnonzero(label == index).tolist() for index in range(count)]
        shapes = [_union([shapes[index] for index in group]) for group in groups]
        owners = [[owner for index in group for owner in owners[index]] for group in groups]
    made = []
    for shape, members in zip(shapes, owners, strict=True):
        first = lines[members[0]]
        made += [first] if len(members) == 1 else [replace(first, points=ring) for ring in _rings(shape)]
    return made


def is_compact(points: Array) -> bool:
    """Return whether an outline, shape (n, 2), suits a column: neither slender nor with concave corners."""
    import shapely

    shape = shapely.Polygon(points)
    length, width = _sides(shape)
    return length < MIN_SLENDERNESS * width and shape.area >= MIN_HULL_SHARE * shape.convex_hull.area


def _parts_of_one(shapes: Sequence["BaseGeometry"]) -> list[tuple[int, int]]:
    """Return pairs of shapes that are parts of one wall."""
    import shapely

    sides = [_sides(shape) for shape in shapes]
    one, other = shapely.STRtree(shapes).query(shapes, predicate="dwithin", distance=TOUCHING_DISTANCE)
    found = []
    for i, j in zip(one[one < other].tolist(), other[one < other].tolist(), strict=True):
        small, large = (i, j) if sides[i] < sides[j] else (j, i)
        shared = shapes[large].buffer(2 * TOUCHING_DISTANCE).intersection(shapes[small].boundary).length
        if shared < sides[small][0] / MIN_SLENDERNESS:
            continue
        slender = all(length >= MIN_SLENDERNESS * width for length, width in (sides[i], sides[j]))
        if slender or _is_rectangle(_union([shapes[i], shapes[j]])):
            found.append((i, j))
    return found


def _sides(shape: "BaseGeometry") -> tuple[float, float]:
    """Return length and width of the smallest rectangle around a shape [m]."""
    import shapely

    corners = shapely.get_coordinates(shapely.minimum_rotated_rectangle(shape))
    if len(corners) < 4:
        return float(shape.length), 0.0
    lengths = np.hypot(*np.diff(corners[:3], axis=0).T).tolist()
    return max(lengths), min(lengths)


def _union(shapes: Sequence["BaseGeometry"]) -> "BaseGeometry":
    """Return the union of shapes, including the cracks between them."""
    import shapely

    grown = shapely.buffer(np.array(shapes, dtype=object), TOUCHING_DISTANCE, join_style="mitre")
    return shapely.union_all(grown).buffer(-TOUCHING_DISTANCE, join_style="mitre")


def _is_rectangle(shape: "BaseGeometry") -> bool:
    outlines = list(itertools.islice(_rings(shape), 2))
    return len(outlines) == 1 and fitted_rectangle(outlines[0]) is not None


def _rings(shape: "BaseGeometry") -> Iterator[Array]:
    """Yield the corners of the outlines of a shape, shape (n, 2) each [m], without corners on straight lines."""
    import shapely

    for part in shapely.get_parts(shape):
        for ring in (part.exterior, *part.interiors) if isinstance(part, shapely.Polygon) else ():
            points = shapely.get_coordinates(ring)[:-1]
            before, after = points - np.roll(points, 1, axis=0), np.roll(points, -1, axis=0) - points
            span = np.maximum(1e-12, np.hypot(*(before + after).T))
            bends = np.abs(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]) / span > TOUCHING_DISTANCE
            if np.count_nonzero(bends) > 2:
                yield points[bends]
