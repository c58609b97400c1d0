"""Charts: flat pieces of surfaces, side by side on an atlas of square texels.

Flat triangles in one plane that are joined make one chart, also across geoms, so that no seam shows between them.
Curved surfaces are divided by the axis nearest to their normals, and projected along it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array

MIN_FLAT_COSINE = 0.999
"""Minimum cosine between the normals of a triangle's corners and its own for a flat triangle."""
NORMAL_STEPS, DISTANCE_STEPS, CORNER_STEPS = 200.0, 1000.0, 5000.0
"""Steps per unit of normals, distances of planes [1/m] and corners [1/m] within which values are equal."""
ROUNDING_OFFSET = 0.318
"""Offset of rounding, so that round values do not lie on a boundary between two steps."""
MIN_LEVEL_COSINE = 0.99
"""Minimum vertical component of the normal of a level chart."""
MIN_AREA = 1e-10
"""Area below which a triangle has no chart [m^2]."""
MIN_WIDTH = 512
"""Minimum width of an atlas [texels]."""
MAX_CHART_SIDE = 8000
"""Maximum columns and rows of a chart [texels]: OpenGL refuses textures larger than 16384, on some machines 8192."""
BORDER_TEXELS = 1
"""Texels around each chart, which repeat its edge."""

Whole = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Charts:
    """Charts of triangles and their places on the atlas; arrays have a row per chart unless said otherwise."""

    of: Whole
    """Chart of each triangle, -1 for none, shape (triangles,)."""
    across: Array
    """World direction of columns, shape (n, 3)."""
    down: Array
    """World direction of rows, shape (n, 3)."""
    first: Array
    """Coordinates along both at which the chart begins, shape (n, 2) [m]."""
    size: Array
    """Width and height of a texel, shape (n, 2) [m]."""
    count: Whole
    """Columns and rows, shape (n, 2)."""
    place: Whole
    """Column and row of the first texel on the atlas, shape (n, 2)."""
    shape: tuple[int, int]
    """Rows and columns of the atlas."""

    def on_atlas(self, points: Array, charts: Whole) -> Array:
        """Return positions on the atlas, columns and rows from its corner, shape (n, 2).

        Args:
            points: World frame, shape (n, 3) [m].
            charts: The chart of each, shape (n,).
        """
        flat = np.stack(
            [np.einsum("ij,ij->i", points, self.across[charts]), np.einsum("ij,ij->i", points, self.down[charts])], 1
        )
        placed: Array = (flat - self.first[charts]) / self.size[charts] + self.place[charts]
        return placed

    def texel(self, points: Array, charts: Whole) -> Whole:
        """Return the texel of each point, row * columns of the atlas + column, shape (n,)."""
        low = self.place[charts]
        inside = np.clip(np.floor(self.on_atlas(points, charts)).astype(np.int64), low, low + self.count[charts] - 1)
        texels: Whole = inside[:, 1] * self.shape[1] + inside[:, 0]
        return texels


def charts_of(corners: Array, normals: Array, *, texel: float) -> Charts:
    """Return the charts of triangles.

    Args:
        corners: World frame, shape (n, 3, 3) [m].
        normals: Normals at each corner, shape (n, 3, 3).
        texel: Side of a texel [m].
    """
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(cross, axis=1)
    faces = cross / np.maximum(area, 1e-300)[:, None]
    flat = np.einsum("ijk,ik->ij", normals, faces).min(axis=1) > MIN_FLAT_COSINE
    of = _joined(corners, _kinds(corners, faces, flat))
    of[area < MIN_AREA] = -1
    kept, of[of >= 0] = np.unique(of[of >= 0], return_inverse=True)
    across, down = _axes(corners, faces, flat, of, len(kept))
    first, extent = _extents(corners, of, across, down)
    count = np.clip(np.ceil(extent / texel - 1e-6), 1, MAX_CHART_SIDE).astype(np.int64)
    place, shape = _packed(count)
    return Charts(of, across, down, first, np.maximum(extent, 1e-6) / count, count, place, shape)


def _kinds(corners: Array, faces: Array, flat: NDArray[np.bool_]) -> Whole:
    """Return a number for each triangle, equal for those that may share a chart, shape (n,)."""
    heights = np.einsum("ij,ij->i", faces, corners[:, 0])
    planes = np.column_stack([faces * NORMAL_STEPS, heights * DISTANCE_STEPS]) + ROUNDING_OFFSET
    axis = np.abs(faces).argmax(axis=1)
    sides = 2 * axis + (np.take_along_axis(faces, axis[:, None], 1)[:, 0] > 0.0)
    keys = np.where(flat[:, None], np.round(planes), np.column_stack([np.tile([1e9] * 3, (len(faces), 1)), sides]))
    kinds: Whole = np.unique(keys.astype(np.int64), axis=0, return_inverse=True)[1].ravel()
    return kinds


def _joined(corners: Array, kinds: Whole) -> Whole:
    """Return a number for each triangle, equal for those of one kind that are joined at corners, shape (n,)."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    points = np.round(corners.reshape(-1, 3) * CORNER_STEPS + ROUNDING_OFFSET).astype(np.int64)
    _, point = np.unique(points, axis=0, return_inverse=True)
    count = len(kinds)
    _, node = np.unique(kinds.repeat(3) * (int(point.max()) + 1) + point.ravel(), return_inverse=True)
    size = count + int(node.max()) + 1
    graph = coo_matrix((np.ones(3 * count, np.int8), (np.arange(count).repeat(3), count + node)), shape=(size, size))
    joined: Whole = connected_components(graph, directed=False)[1][:count].astype(np.int64)
    return joined


def _axes(corners: Array, faces: Array, flat: NDArray[np.bool_], of: Whole, count: int) -> tuple[Array, Array]:
    """Return the directions of columns and rows of each chart, shape (count, 3) both.

    Columns of upright charts are level; those of level ones follow x or an edge, so that the chart is smallest.
    """
    lead = np.full(count, len(of))
    np.minimum.at(lead, of[of >= 0], np.flatnonzero(of >= 0))
    axis = np.abs(faces[lead]).argmax(axis=1)
    straight = np.eye(3)[axis] * np.sign(faces[lead, axis])[:, None]
    normals = np.where(flat[lead, None], faces[lead], straight)
    upright = np.abs(normals[:, 2]) < MIN_LEVEL_COSINE
    edges = np.moveaxis(corners[lead][:, [1, 2, 0]] - corners[lead], 1, 0)
    best, across, down = np.full(count, np.inf), np.zeros((count, 3)), np.zeros((count, 3))
    for ahead in ([1.0, 0.0, 0.0], *edges):
        one = np.where(upright[:, None], np.cross([0.0, 0.0, 1.0], normals), ahead)
        one = one - np.einsum("ij,ij->i", one, normals)[:, None] * normals
        one /= np.maximum(np.linalg.norm(one, axis=1, keepdims=True), 1e-12)
        other = np.cross(normals, one)
        area = _extents(corners, of, one, other)[1].prod(axis=1)
        better = area < 0.99 * best
        best[better], across[better], down[better] = area[better], one[better], other[better]
    return across, down


def _extents(corners: Array, of: Whole, across: Array, down: Array) -> tuple[Array, Array]:
    """Return where each chart begins and how far it extends, shape (charts, 2) both [m]."""
    chosen = of >= 0
    points, charts = corners[chosen].reshape(-1, 3), of[chosen].repeat(3)
    flat = np.stack([np.einsum("ij,ij->i", points, axes[charts]) for axes in (across, down)], axis=1)
    low, high = np.full((len(across), 2), np.inf), np.full((len(across), 2), -np.inf)
    np.minimum.at(low, charts, flat)
    np.maximum.at(high, charts, flat)
    return low, high - low


def _packed(count: Whole) -> tuple[Whole, tuple[int, int]]:
    """Return a place for each chart in rows of similar height, and the rows and columns of the atlas."""
    sizes = count + 2 * BORDER_TEXELS
    side = int(np.sqrt(1.1 * sizes.prod(axis=1).sum())) + 1
    width = max(MIN_WIDTH, -(-max(side, int(sizes[:, 0].max())) // 4) * 4)
    place = np.zeros_like(count)
    x = y = tall = 0
    for chart in np.lexsort((-sizes[:, 0], -sizes[:, 1])).tolist():
        columns, rows = sizes[chart].tolist()
        if x + columns > width:
            x, y, tall = 0, y + tall, 0
        place[chart] = x + BORDER_TEXELS, y + BORDER_TEXELS
        x, tall = x + columns, max(tall, rows)
    return place, (y + tall, width)
