"""Upright prisms -> the faces that can be seen of their union: no overlaps, no inner faces, no cracks.

The prisms' outlines cut the plane into cells; each cell is solid over some spans of height. A side face stands
wherever a cell is solid and its neighbour is not, a level face wherever a span ends. All faces take their
corners from one set of nodes, so that neighbouring faces share their edges exactly. The mathematics knows nothing
of MuJoCo.
"""

import itertools
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from mjsim.geometry import Array

GRID = 1e-6
"""Points nearer than this are one [m]."""

Node = tuple[float, float]
Span = tuple[float, float, int]
"""Lower and upper height [m] of what is solid, and its look."""


@dataclass(frozen=True, slots=True, eq=False)
class Prism:
    """An upright solid on a convex outline."""

    outline: Array
    """Counter-clockwise, world frame, shape (n, 2) [m]."""
    low: float
    """[m]"""
    high: float
    """[m]"""
    look: int = 0
    """Index of its colour or texture; where prisms overlap, the lowest index is seen."""


@dataclass(frozen=True, slots=True, eq=False)
class Face:
    """A flat face, cut into triangles."""

    points: Array
    """Corners, world frame, shape (n, 3) [m]."""
    triangles: NDArray[np.int32]
    """Indices of corners, counter-clockwise seen from outside, shape (m, 3)."""
    normal: Array
    """Outwards, shape (3,)."""
    look: int


def visible_faces(prisms: Sequence[Prism], *, floor: float = 0.0) -> list[Face]:
    """Return the faces of the union of prisms; those that lie on the floor or below are left out."""
    if not prisms:
        return []
    cells, spans = _cells(prisms)
    sides = list(_sides(cells, spans))
    heights: dict[Node, set[float]] = defaultdict(set)
    for (start, end), (low, high, _) in sides:
        heights[start] |= {low, high}
        heights[end] |= {low, high}
    faces = [_side(start, end, span, heights) for (start, end), span in sides]
    return faces + list(_levels(cells, spans, floor))


def _cells(prisms: Sequence[Prism]) -> tuple[list[shapely.Polygon], list[list[Span]]]:
    """Return the solid cells that the outlines cut out of the plane, and the solid spans of each."""
    outlines = shapely.polygons([np.round(prism.outline / GRID) * GRID for prism in prisms])
    lines = shapely.union_all(shapely.boundary(outlines), grid_size=GRID)
    cells = shapely.orient_polygons(shapely.get_parts(shapely.polygonize(shapely.get_parts(lines))))
    inner_points = shapely.point_on_surface(cells)
    owners: dict[int, list[Prism]] = defaultdict(list)
    for cell, owner in shapely.STRtree(outlines).query(inner_points, predicate="within").T.tolist():
        owners[cell].append(prisms[owner])
    found = sorted(owners)
    return [cells[cell] for cell in found], [_spans(owners[cell]) for cell in found]


def _spans(prisms: Sequence[Prism]) -> list[Span]:
    """Return what is solid where prisms lie over each other, from below, neighbours of one look as one."""
    heights = sorted({round(height, 6) for prism in prisms for height in (prism.low, prism.high)})
    spans: list[Span] = []
    for low, high in itertools.pairwise(heights):
        middle = (low + high) / 2
        look = min((prism.look for prism in prisms if prism.low < middle < prism.high), default=None)
        if look is None:
            continue
        if spans and spans[-1][1:] == (low, look):
            low = spans.pop()[0]
        spans.append((low, high, look))
    return spans


def _sides(cells: Sequence[shapely.Polygon], spans: Sequence[list[Span]]) -> Iterator[tuple[tuple[Node, Node], Span]]:
    """Yield each upright face: the edge on which it stands, solid to the left, and its span."""
    edges = {
        (tuple(start), tuple(end)): cell
        for cell, polygon in enumerate(cells)
        for ring in (polygon.exterior, *polygon.interiors)
        for start, end in itertools.pairwise(np.round(shapely.get_coordinates(ring), 6).tolist())
    }
    for (start, end), cell in edges.items():
        neighbour = edges.get((end, start))
        for span in _without(spans[cell], spans[neighbour] if neighbour is not None else []):
            yield (start, end), span


def _without(spans: Sequence[Span], others: Sequence[Span]) -> Iterator[Span]:
    """Yield the parts of spans that no other span covers."""
    for low, high, look in spans:
        free = low
        for other_low, other_high, _ in others:
            if other_high <= free or other_low >= high:
                continue
            if other_low > free:
                yield free, other_low, look
            free = max(free, other_high)
        if free < high:
            yield free, high, look


def _side(start: Node, end: Node, span: Span, heights: Mapping[Node, set[float]]) -> Face:
    """Return an upright face with a corner wherever a neighbour has one, lest a crack of a pixel be seen."""
    low, high, look = span
    near = [(*start, z) for z in sorted(heights[start]) if low <= z <= high]
    far = [(*end, z) for z in sorted(heights[end]) if low <= z <= high]
    triangles, i, j = [], 0, 0
    while i + 1 < len(near) or j + 1 < len(far):
        a, b = i, len(near) + j
        if j + 1 < len(far) and (i + 1 == len(near) or far[j + 1][2] <= near[i + 1][2]):
            j += 1
            triangles.append((a, b, b + 1))
        else:
            i += 1
            triangles.append((a, b, a + 1))
    along = np.subtract(end, start)
    along /= np.hypot(*along)
    return Face(np.array(near + far), np.array(triangles, dtype=np.int32), np.array([along[1], -along[0], 0.0]), look)


def _levels(cells: Sequence[shapely.Polygon], spans: Sequence[list[Span]], floor: float) -> Iterator[Face]:
    """Yield the level faces, tops and undersides, where a span ends and none of another look goes on."""
    triangulated = shapely.constrained_delaunay_triangles(np.array(cells, dtype=object))
    for polygon, column in zip(triangulated, spans, strict=True):
        corners = shapely.get_coordinates(shapely.orient_polygons(shapely.get_parts(polygon))).reshape(-1, 4, 2)
        corners = corners[:, :3].reshape(-1, 2)
        upwards = np.arange(len(corners), dtype=np.int32).reshape(-1, 3)
        lows, highs = {low for low, _, _ in column}, {high for _, high, _ in column}
        for low, high, look in column:
            if high not in lows:
                yield Face(_at_height(corners, high), upwards, np.array([0.0, 0.0, 1.0]), look)
            if low > floor and low not in highs:
                yield Face(_at_height(corners, low), upwards[:, ::-1].copy(), np.array([0.0, 0.0, -1.0]), look)


def _at_height(points: Array, height: float) -> Array:
    return np.column_stack([points, np.full(len(points), height)])
