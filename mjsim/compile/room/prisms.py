"""Upright prisms -> the visible faces of their union: no overlaps, no inner faces, no cracks.

The prisms' outlines divide the plane into cells; each cell is solid over some spans of height, its column. There is a
side face wherever a cell is solid and its neighbour is not, and a level face at each end of a span. The corners of all
faces come from one set of nodes, so that neighbouring faces share their edges exactly. There are few columns and many
cells: work per column is done once for each, work per cell in arrays. The module is independent of MuJoCo.
"""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
import shapely
from numpy.typing import NDArray

from mjsim.geometry import Array

GRID = 1e-6
"""Points nearer than this are merged [m]."""

Whole = NDArray[np.int64]
Span = tuple[float, float, int]
"""Lower and upper height [m] of a solid span, and its look."""
Column = tuple[Span, ...]
"""The solid spans over a cell, from below."""


@dataclass(frozen=True, slots=True, eq=False)
class Prisms:
    """Upright solids on convex outlines."""

    outlines: Array
    """Counter-clockwise, world frame, shape (n, corners, 2) [m]."""
    low: Array
    """Shape (n,) [m]."""
    high: Array
    """Shape (n,) [m]."""
    material: Whole
    """Index of the colour or texture of each, shape (n,); where prisms overlap, the lowest index is visible."""


@dataclass(frozen=True, slots=True, eq=False)
class Face:
    """A flat face, divided into triangles."""

    points: Array
    """Corners, world frame, shape (n, 3) [m]."""
    triangles: NDArray[np.int32]
    """Indices of corners, counter-clockwise seen from outside, shape (m, 3)."""
    normal: Array
    """Outwards, shape (3,)."""
    material: int


@dataclass(frozen=True, slots=True, eq=False)
class Faces:
    """Many flat faces; each has corners of its own."""

    points: Array
    """Corners, world frame, shape (n, 3) [m]."""
    normals: Array
    """Outward normal of the face of each corner, shape (n, 3)."""
    triangles: NDArray[np.int32]
    """Indices of corners, counter-clockwise seen from outside, shape (m, 3)."""
    material: Whole
    """Look of each triangle, shape (m,)."""

    @classmethod
    def joined(cls, parts: Sequence["Faces"]) -> Self:
        """Return the faces of all parts together."""
        first = np.cumsum([0, *(len(part.points) for part in parts)])
        return cls(
            np.concatenate([np.zeros((0, 3)), *(part.points for part in parts)]),
            np.concatenate([np.zeros((0, 3)), *(part.normals for part in parts)]),
            np.concatenate(
                [np.zeros((0, 3), np.int32), *(p.triangles + np.int32(f) for p, f in zip(parts, first, strict=False))]
            ),
            np.concatenate([np.zeros(0, np.int64), *(part.material for part in parts)]),
        )

    @classmethod
    def of(cls, faces: Sequence[Face]) -> Self:
        """Return separate faces as one set."""
        return cls.joined(
            [
                Faces(
                    face.points,
                    np.tile(face.normal, (len(face.points), 1)),
                    face.triangles,
                    np.full(len(face.triangles), face.material),
                )
                for face in faces
            ]
        )

    def some(self, chosen: NDArray[np.bool_] | Whole) -> "Faces":
        """Return some of the triangles, with only the corners that they use."""
        corners, triangles = np.unique(self.triangles[chosen], return_inverse=True)
        return Faces(
            self.points[corners],
            self.normals[corners],
            triangles.reshape(-1, 3).astype(np.int32),
            self.material[chosen],
        )


def visible_faces(prisms: Prisms, *, floor: float = 0.0) -> Faces:
    """Return the faces of the union of prisms, without those on or below the floor."""
    if not len(prisms.low):
        return Faces.joined([])
    cells, columns, column_of = _cells(prisms)
    return Faces.joined([_sides(cells, columns, column_of), _levels(cells, columns, column_of, floor)])


def _cells(prisms: Prisms) -> tuple[NDArray[np.object_], list[Column], Whole]:
    """Return the solid cells between the outlines, the distinct columns, and the column of each cell."""
    corners = np.round(prisms.outlines / GRID).astype(np.int64)
    # A window leaves two prisms with one outline.
    _, once, outline_of = _unique_rows(corners.reshape(len(corners), -1))
    corners = corners[once]
    outlines = shapely.polygons(corners * GRID)
    cut = _touched(corners, outlines)
    lines = shapely.union_all(shapely.boundary(outlines[cut]), grid_size=GRID)
    pieces = shapely.orient_polygons(shapely.get_parts(shapely.polygonize(shapely.get_parts(lines))))
    piece, owner = shapely.STRtree(outlines[cut]).query(shapely.point_on_surface(pieces), predicate="within")
    cells = np.concatenate([pieces, outlines[~cut]])
    cell = np.concatenate([piece, len(pieces) + np.arange(np.count_nonzero(~cut))])
    outline = np.concatenate([np.flatnonzero(cut)[owner], np.flatnonzero(~cut)])
    spans = np.column_stack([prisms.low.round(6), prisms.high.round(6), prisms.material])
    kinds, kind_of = np.unique(spans, axis=0, return_inverse=True)
    # Each outline with the prisms on it.
    order = np.argsort(outline_of, kind="stable")
    some, prism = _expanded(np.bincount(outline_of), outline)
    pairs = np.unique(np.column_stack([cell[some], kind_of.ravel()[order[prism]]]), axis=0)
    solid, first = np.unique(pairs[:, 0], return_index=True)
    owners, ends = pairs[:, 1].tolist(), [*first.tolist()[1:], len(pairs)]
    numbers: dict[tuple[int, ...], int] = {}
    keys = (tuple(owners[a:b]) for a, b in zip(first.tolist(), ends, strict=True))
    column_of = [numbers.setdefault(key, len(numbers)) for key in keys]
    spans_of = [(low, high, int(material)) for low, high, material in kinds.tolist()]
    columns = [_column([spans_of[kind] for kind in key]) for key in numbers]
    return cells[solid], columns, np.array(column_of, dtype=np.int64)


def _touched(corners: Whole, outlines: NDArray[np.object_]) -> NDArray[np.bool_]:
    """Return for each outline whether another one meets it other than along a complete edge of both.

    An outline that none meets is a cell.
    """
    one, other = shapely.STRtree(outlines).query(outlines, predicate="dwithin", distance=2 * GRID)
    one, other = one[one < other], other[one < other]
    ahead, back = corners, np.roll(corners, -1, axis=1)
    # Both are counter-clockwise, so a shared edge has opposite directions.
    shared = np.zeros(len(one), dtype=bool)
    for a in range(corners.shape[1]):
        for b in range(corners.shape[1]):
            same = (ahead[one, a] == back[other, b]) & (back[one, a] == ahead[other, b])
            shared |= same.all(axis=1)
    touched = np.zeros(len(outlines), dtype=bool)
    touched[one[~shared]] = touched[other[~shared]] = True
    return touched


def _column(prisms: Sequence[Span]) -> Column:
    """Return the column of overlapping prisms, from below, with adjacent spans of one look merged."""
    heights = sorted({height for low, high, _ in prisms for height in (low, high)})
    spans: list[Span] = []
    for low, high in itertools.pairwise(heights):
        middle = (low + high) / 2
        material = min((material for bottom, top, material in prisms if bottom < middle < top), default=None)
        if material is None:
            continue
        if spans and spans[-1][1:] == (low, material):
            low = spans.pop()[0]
        spans.append((low, high, material))
    return tuple(spans)


def _sides(cells: NDArray[np.object_], columns: Sequence[Column], column_of: Whole) -> Faces:
    """Return the side faces: the parts of the spans of each cell that its neighbour's spans do not cover."""
    places, start, end, cell, neighbour = _edges(cells)
    count = len(columns)
    other = np.where(neighbour < 0, count, column_of[neighbour])
    pairs, pair_of = np.unique(column_of[cell] * (count + 1) + other, return_inverse=True)
    known = [*columns, ()]
    free = [list(_without(known[pair // (count + 1)], known[pair % (count + 1)])) for pair in pairs.tolist()]
    edge, span = _expanded([len(spans) for spans in free], pair_of.ravel())
    if not len(edge):
        return Faces.joined([])
    low, high, material = np.array([span for spans in free for span in spans]).reshape(-1, 3)[span].T
    return _upright(places, start[edge], end[edge], low, high, material.astype(np.int64))


def _edges(cells: NDArray[np.object_]) -> tuple[Array, Whole, Whole, Whole, Whole]:
    """Return the nodes, and for each edge of a cell both nodes, solid to the left, its cell and the cell beyond or -1.

    Nodes have shape (n, 2) [m], the others (edges,).
    """
    rings, cell_of_ring = shapely.get_rings(cells, return_index=True)
    points, ring = shapely.get_coordinates(rings, return_index=True)
    nodes, _, node_of = _unique_rows(np.round(points / GRID).astype(np.int64))
    goes_on = ring[:-1] == ring[1:]
    start, end, cell = node_of[:-1][goes_on], node_of[1:][goes_on], cell_of_ring[ring[:-1][goes_on]]
    codes, back = start * len(nodes) + end, end * len(nodes) + start
    order = np.argsort(codes)
    found = order[np.searchsorted(codes[order], back).clip(max=len(codes) - 1)]
    neighbour = np.where(codes[found] == back, cell[found], -1)
    return np.asarray(nodes * GRID, dtype=float), start, end, cell, neighbour


def _without(spans: Column, others: Column) -> Iterator[Span]:
    """Yield the parts of spans not covered by others."""
    for low, high, material in spans:
        free = low
        for other_low, other_high, _ in others:
            if other_high <= free or other_low >= high:
                continue
            if other_low > free:
                yield free, other_low, material
            free = max(free, other_high)
        if free < high:
            yield free, high, material


def _upright(places: Array, start: Whole, end: Whole, low: Array, high: Array, material: Whole) -> Faces:
    """Return side faces with a corner wherever a neighbour has one, so that no cracks are visible."""
    heights, level = np.unique(np.concatenate([low, high]), return_inverse=True)
    bottom, top = level.ravel().reshape(2, -1)
    # All positions and heights at which a face has a corner, in order.
    known = np.unique(np.concatenate([node * len(heights) + z for node in (start, end) for z in (bottom, top)]))
    ends = np.stack([start, end], axis=1) * len(heights)
    first = np.searchsorted(known, ends + bottom[:, None])
    counts = np.searchsorted(known, ends + top[:, None]) - first + 1
    # The corners of a face: upwards along its first edge, then upwards along its last.
    edge, step = _fan(counts.ravel())
    corner = known[first.ravel()[edge] + step]
    points = np.column_stack([places[corner // len(heights)], heights[corner % len(heights)]])
    along = places[end] - places[start]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    normals = np.column_stack([along[:, 1], -along[:, 0], np.zeros(len(along))])
    bottom_first, top_first = (np.cumsum(counts) - counts.ravel()).reshape(-1, 2).T
    # Fans: from the bottom of the last edge to all of the first, then from the top of the first to all of the last.
    left, i = _fan(counts[:, 0] - 1)
    right, j = _fan(counts[:, 1] - 1)
    triangles = np.concatenate(
        [
            np.column_stack([bottom_first[left] + i, top_first[left], bottom_first[left] + i + 1]),
            np.column_stack([top_first[right] - 1, top_first[right] + j, top_first[right] + j + 1]),
        ]
    )
    return Faces(points, normals[edge // 2], triangles.astype(np.int32), material[np.concatenate([left, right])])


def _levels(cells: NDArray[np.object_], columns: Sequence[Column], column_of: Whole, floor: float) -> Faces:
    """Return the level faces, tops and undersides, where a span ends and no other one continues."""
    parts, cell = shapely.get_parts(shapely.constrained_delaunay_triangles(cells), return_index=True)
    corners = shapely.get_coordinates(parts).reshape(-1, 4, 2)[:, :3]
    (ax, ay), (bx, by) = (corners[:, 1] - corners[:, 0]).T, (corners[:, 2] - corners[:, 0]).T
    corners = np.where((ax * by - ay * bx < 0.0)[:, None, None], corners[:, ::-1], corners)
    ends = [list(_ends(column, floor)) for column in columns]
    triangle, found = _expanded([len(faces) for faces in ends], column_of[cell])
    height, up, material = np.array([face for faces in ends for face in faces]).reshape(-1, 3)[found].T
    corners = corners[triangle]
    corners = np.where((up < 0.0)[:, None, None], corners[:, ::-1], corners)
    points = np.concatenate([corners, np.broadcast_to(height[:, None, None], (len(height), 3, 1))], axis=2)
    normals = np.column_stack([np.zeros((len(up), 2)), up]).repeat(3, axis=0)
    triangles = np.arange(3 * len(height), dtype=np.int32).reshape(-1, 3)
    return Faces(points.reshape(-1, 3), normals, triangles, material.astype(np.int64))


def _ends(column: Column, floor: float) -> Iterator[tuple[float, float, int]]:
    """Yield the height of each level face of a column [m], 1 if it faces up and -1 if down, and its look."""
    lows, highs = {low for low, _, _ in column}, {high for _, high, _ in column}
    for low, high, material in column:
        if high not in lows:
            yield high, 1.0, material
        if low > floor and low not in highs:
            yield low, -1.0, material


def _expanded(counts: Sequence[int] | Whole, kinds: Whole) -> tuple[Whole, Whole]:
    """Expand items into the members of their kinds; return the item of each member and its index among all members."""
    many = np.asarray(counts, dtype=np.int64)
    first = np.cumsum(many) - many
    item, step = _fan(many[kinds])
    return item, first[kinds][item] + step


def _fan(counts: Whole) -> tuple[Whole, Whole]:
    """Return each index as often as its count, and with it 0, 1, 2 and so on."""
    item = np.repeat(np.arange(len(counts)), counts)
    return item, np.arange(len(item)) - (np.cumsum(counts) - counts)[item]


def _unique_rows(rows: Whole) -> tuple[Whole, Whole, Whole]:
    """Return the unique rows, the first index of each, and the inverse indices; faster than numpy's own."""
    order = np.lexsort(rows.T)
    new = np.ones(len(rows), dtype=bool)
    new[1:] = (rows[order][1:] != rows[order][:-1]).any(axis=1)
    which = np.empty(len(rows), dtype=np.int64)
    which[order] = np.cumsum(new) - 1
    return rows[order][new], order[new], which
