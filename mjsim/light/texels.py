"""Texels of an atlas: where in the world each lies, and the larger cells in which reflected light is computed."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.light.charts import Charts, Whole

BATCH_TEXELS = 250_000
"""Number of candidate texels that are tested at a time."""
MIN_BARYCENTRIC = -1e-6
"""Minimum barycentric coordinate of a point in a triangle, for texels on the edge between two."""


@dataclass(frozen=True, slots=True, eq=False)
class Texels:
    """Texels on surfaces, in the order of the atlas."""

    at: Whole
    """Row * columns of the atlas + column, shape (n,)."""
    points: Array
    """World frame, shape (n, 3) [m]."""
    normals: Array
    """Unit vectors, shape (n, 3)."""
    triangles: Whole
    """The triangle of each, shape (n,)."""

    def some(self, chosen: NDArray[np.bool_] | Whole) -> "Texels":
        """Return some of them."""
        return Texels(self.at[chosen], self.points[chosen], self.normals[chosen], self.triangles[chosen])


def texels_of(corners: Array, normals: Array, charts: Charts) -> Texels:
    """Return the texels whose centers lie on triangles; for a chart without any, one for each triangle."""
    used = np.flatnonzero(charts.of >= 0)
    of = charts.of[used]
    flat = np.stack([charts.on_atlas(corners[used][:, k], of) for k in range(3)], axis=1)
    low = np.clip(np.ceil(flat.min(axis=1) - 0.5), charts.place[of], charts.place[of] + charts.count[of]).astype(int)
    high = np.clip(np.floor(flat.max(axis=1) - 0.5) + 1, low, charts.place[of] + charts.count[of]).astype(int)
    sides = high - low
    found = [_inside(flat[part], low[part], sides[part], part) for part in _parts(sides.prod(axis=1))]
    owner, at, shares = (np.concatenate(each) for each in zip(*found, strict=True))
    bare = np.flatnonzero(~np.isin(of, of[owner]))
    middle = np.full((len(bare), 3), 1 / 3)
    places = charts.texel(np.einsum("ij,ijk->ik", middle, corners[used[bare]]), of[bare])
    owner, shares = np.concatenate([owner, bare]), np.concatenate([shares, middle])
    at = np.concatenate([at[:, 1] * charts.shape[1] + at[:, 0], places])
    at, once = np.unique(at, return_index=True)
    triangles = used[owner[once]]
    points, outward = (np.einsum("ij,ijk->ik", shares[once], each[triangles]) for each in (corners, normals))
    return Texels(at, points, outward / np.linalg.norm(outward, axis=1, keepdims=True), triangles)


def _parts(counts: Whole) -> list[Whole]:
    """Return groups of triangles with about `BATCH_TEXELS` candidates each."""
    return [part for part in np.split(np.arange(len(counts)), _bounds(counts)) if len(part)]


def _bounds(counts: Whole) -> Whole:
    batch = np.cumsum(counts) // BATCH_TEXELS
    bounds: Whole = np.flatnonzero(np.diff(batch)) + 1
    return bounds


def _inside(flat: Array, low: Whole, sides: Whole, names: Whole) -> tuple[Whole, Whole, Array]:
    """Return the triangle, the column and row, and the barycentric coordinates of each texel in a triangle."""
    counts = sides.prod(axis=1)
    owner = np.repeat(np.arange(len(flat)), counts)
    number = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    columns = np.maximum(sides[owner, 0], 1)
    at = low[owner] + np.stack([number % columns, number // columns], axis=1)
    a, b, c = np.moveaxis(flat, 1, 0)
    ab, ac = b - a, c - a
    area = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]
    area = np.where(np.abs(area) < 1e-12, np.inf, area)
    rest = at + 0.5 - a[owner]
    second = (rest[:, 0] * ac[owner, 1] - rest[:, 1] * ac[owner, 0]) / area[owner]
    third = (ab[owner, 0] * rest[:, 1] - ab[owner, 1] * rest[:, 0]) / area[owner]
    shares = np.stack([1.0 - second - third, second, third], axis=1)
    # A triangle without area in the chart has no texels.
    inside = (shares.min(axis=1) > MIN_BARYCENTRIC) & np.isfinite(area[owner])
    return names[owner[inside]], at[inside], shares[inside]


@dataclass(frozen=True, slots=True, eq=False)
class Cells:
    """Square groups of texels of one chart, each represented by one of them."""

    of: Whole
    """The cell of each texel, -1 for a texel that does not count, shape (texels,)."""
    lead: Whole
    """The texel nearest to the middle of each cell, shape (n,)."""
    middles: Whole
    """Column and row of that texel on the atlas, shape (n, 2)."""

    def mean(self, values: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return the mean over the texels of each cell, shape (texels, k) -> (n, k)."""
        counted = self.of >= 0
        of, count = self.of[counted], len(self.lead)
        number = np.maximum(np.bincount(of, minlength=count), 1)
        sums = [np.bincount(of, weights=column[counted], minlength=count) / number for column in values.T]
        return np.stack(sums, axis=1).astype(np.float32)


def cells_of(texels: Texels, valid: NDArray[np.bool_], charts: Charts, side: int, linked: Whole) -> Cells:
    """Return cells of at most `side` x `side` texels; only valid texels count.

    Args:
        texels: All texels.
        valid: Those that count.
        charts: The charts in which they lie.
        side: Texels along a side.
        linked: Pairs of texels between which nothing stands, shape (n, 2); others are not in one cell.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    at = np.stack([texels.at % charts.shape[1], texels.at // charts.shape[1]], axis=1)
    chart = charts.of[texels.triangles]
    block = (at - charts.place[chart]) // side
    one, other = linked[(block[linked[:, 0]] == block[linked[:, 1]]).all(axis=1)].T
    graph = coo_matrix((np.ones(len(one), np.int8), (one, other)), (len(at), len(at)))
    cell = connected_components(graph, directed=False)[1]
    of = np.full(len(at), -1)
    of[valid] = np.unique(cell[valid], return_inverse=True)[1]
    count = int(of.max(initial=-1)) + 1
    number = np.bincount(of[valid], minlength=count)
    middle = np.stack([np.bincount(of[valid], weights=column, minlength=count) / number for column in at[valid].T], 1)
    distance = ((at[valid] - middle[of[valid]]) ** 2).sum(axis=1)
    order = np.lexsort((distance, of[valid]))
    lead = np.flatnonzero(valid)[order[np.searchsorted(of[valid][order], np.arange(count))]]
    return Cells(of, lead, at[lead])
