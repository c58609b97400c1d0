"""Positions on a texture of the corners of flat faces: metric, and continuous round upright edges.

A texture runs to the right along a wall and downwards. Faces of one plane that touch (beside, above and below a
doorway) are a sheet, on which it is continuous. Sheets that meet in an upright edge are moved along the texture until
it runs round that edge: the longest ones first, since not all edges of a room can have it. The end of a wall and the
sides of a doorway move, but do not join both sides of the wall. The longest of joined sheets is counted from the
origin.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array

SAME_PLACE, SAME_WAY = 1e-6, 1e-3
"""Grid of positions [m] and of normals on which corners are the same."""
MAX_END_LENGTH, MAX_TURN_COSINE = 0.4, 0.7
"""Maximum length of a sheet that may be the end of a wall [m], and maximum cosine of the turn into it."""
LEVEL_TOLERANCE = 1e-9
"""Horizontal part of a normal below which a face is level."""

Whole = NDArray[np.int64]


class _Edge(NamedTuple):
    """Two sheets that meet in an upright edge."""

    length: float
    """Length of the shorter sheet [m]."""
    first: int
    second: int
    end: bool
    """Whether it is where a wall ends: one of them is thin, and they meet at a sharp angle."""
    step: float
    """Position of the second sheet on the texture relative to that of the first, for a continuous texture [m]."""


def metric_places(points: Array, normals: Array) -> Array:
    """Return the position of each corner on a texture, right and down, counted from the origin, shape (n, 2) [m].

    Args:
        points: Corners, each of one flat face, z up, shape (n, 3) [m].
        normals: Outward normal of the face of each corner, shape (n, 3).
    """
    (x, y, z), (nx, ny, nz) = points.T, normals.T
    level, upright = np.hypot(nx, ny) < LEVEL_TOLERANCE, nz == 0.0
    # On slanted faces: to the viewer's right, and down the slope.
    steep = np.where(level | upright, 1.0, np.hypot(nx, ny))
    right = np.where(level, x, (y * nx - x * ny) / steep)
    down = np.where(level, -y, np.where(upright, -z, nz * (x * nx + y * ny) / steep - steep * z))
    return np.column_stack([right, down])


def unrolled(points: Array, normals: Array, triangles: NDArray[np.int32]) -> Array:
    """Return the position of each corner on a texture that continues round upright edges, shape (n, 2) [m].

    Args:
        points: Corners, each of one flat face, z up, shape (n, 3) [m].
        normals: Outward normal of the face of each corner, shape (n, 3).
        triangles: Indices of corners, shape (m, 3).
    """
    places = metric_places(points, normals)
    upright = np.abs(normals[:, 2]) < SAME_WAY
    if upright.any():
        places[upright, 0] += _offsets(points, normals, triangles, places[:, 0], upright)
    return places


def _offsets(
    points: Array, normals: Array, triangles: NDArray[np.int32], right: Array, upright: NDArray[np.bool_]
) -> Array:
    """Return how far the texture is moved to the right at each corner of upright faces [m]."""
    spots = np.round(points[upright, :2] / SAME_PLACE).astype(np.int64)
    ways = np.round(normals[upright, :2] / SAME_WAY).astype(np.int64)
    renumbered = np.cumsum(upright) - 1
    corners = renumbered[triangles[upright[triangles].all(axis=1)]]
    sheet = _sheets(np.column_stack([spots, ways]), corners)
    lengths = _lengths(sheet, right[upright])
    moved = np.zeros(len(lengths))
    group = np.arange(len(moved))
    members = [[index] for index in range(len(moved))]
    longest = lengths.copy()
    for edge in sorted(_edges(spots, ways, sheet, right[upright], lengths), reverse=True):
        one, other = group[edge.first], group[edge.second]
        if one == other or (edge.end and min(longest[one], longest[other]) > MAX_END_LENGTH):
            continue
        step = moved[edge.first] + edge.step - moved[edge.second]
        if longest[one] < longest[other]:
            one, other, step = other, one, -step
        moved[members[other]] += step
        group[members[other]] = one
        members[one] += members[other]
    return np.asarray(moved[sheet])


def _lengths(sheet: Whole, right: Array) -> Array:
    """Return the length of each sheet, given the sheet and position of each corner [m]."""
    low, high = np.full((2, sheet.max() + 1), [[np.inf], [-np.inf]])
    np.minimum.at(low, sheet, right)
    np.maximum.at(high, sheet, right)
    return np.asarray(high - low)


def _sheets(places: Whole, triangles: Whole) -> Whole:
    """Return the sheet of each corner: those of triangles that share a place, with the same normal."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    _, node = np.unique(places, axis=0, return_inverse=True)
    starts, ends = node.ravel()[triangles].ravel(), node.ravel()[np.roll(triangles, -1, axis=1)].ravel()
    count = int(node.max()) + 1
    _, sheet = connected_components(coo_array((np.ones(len(starts)), (starts, ends)), shape=(count, count)))
    return np.asarray(sheet[node.ravel()], dtype=np.int64)


def _edges(spots: Whole, ways: Whole, sheet: Whole, right: Array, lengths: Array) -> list[_Edge]:
    """Return the upright edges at which sheets meet."""
    _, once = np.unique(np.column_stack([spots, sheet]), axis=0, return_index=True)
    # Sorted by place: sheets at one place follow each other.
    meet = np.flatnonzero((spots[once[:-1]] == spots[once[1:]]).all(axis=1))
    first, second = once[meet], once[meet + 1]
    shorter = np.minimum(lengths[sheet[first]], lengths[sheet[second]])
    turn = np.einsum("ij,ij->i", ways[first], ways[second]) * SAME_WAY**2
    columns = (
        shorter,
        sheet[first],
        sheet[second],
        (shorter < MAX_END_LENGTH) & (turn < MAX_TURN_COSINE),
        right[first] - right[second],
    )
    return [_Edge(*row) for row in zip(*(column.tolist() for column in columns), strict=True)]
