"""Separates noise in a map from small objects, by how many groups of occupied cells chance would make."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjsim.errors import UsageError
from mjsim.exchange.maps.map_pixels import Cells
from mjsim.world import Grid

GROUP_DISTANCES = (4, 2, 1)
"""Distances within which cells form one group [cells]; the denser the noise, the smaller the distance used."""
MAX_NEIGHBOURS = 0.5
"""Noise cells must have fewer noise neighbours than this on average, otherwise their groups grow without bound."""
MAX_ITERATIONS = 20
"""Number of iterations after which the noise fraction has converged."""
MORE, SOME = 3.0, 2.0
"""Groups are not noise if there are more of them than this multiple of the number by chance, plus this number."""
MAX_SPECK = 12
"""Larger groups of cells are never noise."""
MAX_PARTS = 20_000
"""With more connected components than this, a grid is not a map."""


@dataclass(frozen=True, slots=True, eq=False)
class Cleaned:
    """The occupied cells of a grid without noise."""

    cells: Cells
    """Occupied cells without noise, shape (rows, columns)."""
    noise: float
    """Fraction of the free ground that noise occupies, 0 to 1."""


def without_specks(grid: Grid) -> Cleaned:
    """Return the occupied cells of a grid without noise.

    Raises:
        UsageError: There are more connected components than in a building.
    """
    ground = _ground(grid)
    dense = _noise(grid.occupied, ground, GROUP_DISTANCES[-1])
    reach = next(
        (reach for reach in GROUP_DISTANCES if _neighbours(reach) * dense < MAX_NEIGHBOURS), GROUP_DISTANCES[-1]
    )
    noise = _noise(grid.occupied, ground, reach)
    groups, sizes = _groups(grid.occupied, reach)
    chosen = sizes >= _least(sizes, _neighbours(reach) * noise)
    chosen[0] = False
    if (parts := int(np.count_nonzero(chosen))) > MAX_PARTS:
        raise UsageError(
            f"the map has {parts} parts; the map of a building has at most {MAX_PARTS}, clean it in an image editor"
        )
    return Cleaned(np.asarray(chosen[groups] & grid.occupied, dtype=bool), noise)


def has_lone_things(grid: Grid, single: int, *, noise: float) -> bool:
    """Return whether a map has more isolated cells near others than noise explains: legs, edges hit by few beams.

    Args:
        grid: The map.
        single: Number of cells connected to no other, but near others.
        noise: Fraction of the free ground that noise occupies, 0 to 1.
    """
    import cv2

    side = 2 * GROUP_DISTANCES[0] + 1
    around = cv2.dilate(grid.occupied.astype(np.uint8), np.ones((side, side), dtype=np.uint8))
    close = int(np.count_nonzero((around > 0) & grid.free))
    return single > MORE * noise * close + SOME


def _ground(grid: Grid) -> Cells:
    """Return the cells that are free or next to a free cell: occupied cells there stand on free ground."""
    import cv2

    return np.asarray(cv2.dilate(grid.free.astype(np.uint8), np.ones((3, 3), dtype=np.uint8)) > 0)


def _noise(occupied: Cells, ground: Cells, reach: int) -> float:
    """Return the noise fraction of the ground, from the number of isolated cells on it, 0 to 1.

    A noise fraction p leaves p (1 - p)^n of the cells isolated among n neighbours, with a maximum at p = 1 / (n + 1).
    """
    _, sizes = _groups(occupied & ground, reach)
    alone = int(np.count_nonzero(sizes == 1)) / max(1, int(np.count_nonzero(ground)))
    neighbours, noise = _neighbours(reach), alone
    for _ in range(MAX_ITERATIONS):
        noise = min(1.0 / (neighbours + 1), alone / (1.0 - noise) ** neighbours)
    return noise


def _neighbours(reach: int) -> int:
    """Return the number of cells within `reach` of a cell."""
    return (2 * reach + 1) ** 2 - 1


def _least(sizes: NDArray[Any], neighbours: float) -> int:
    """Return the minimum number of nearby occupied cells that is more than noise.

    Noise also forms groups of k cells by chance; the result is the smallest size of which a map of this size has fewer
    than one by chance, or has many more than chance explains.

    Args:
        sizes: Number of cells in each group.
        neighbours: Mean number of noise cells near each cell.
    """
    lonely = int(np.count_nonzero(sizes == 1))
    for size in range(2, MAX_SPECK):
        expected = lonely * neighbours ** (size - 1)
        if expected < 1.0 or np.count_nonzero(sizes == size) > MORE * expected + SOME:
            return size
    return MAX_SPECK


def _groups(cells: Cells, reach: int) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return the group of each cell, nearby cells sharing one, and the number of cells in each group."""
    import cv2

    dilated = cv2.dilate(cells.astype(np.uint8), np.ones((reach, reach), dtype=np.uint8))
    count, groups = cv2.connectedComponents(dilated, connectivity=8)
    return groups, np.bincount(groups[cells], minlength=count)
