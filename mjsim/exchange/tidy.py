"""Occupied cells made whole: specks left out, gaps of walls closed, what lies between two faces filled."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjsim.errors import UsageError
from mjsim.exchange.grid import Grid
from mjsim.exchange.pixels import Cells

ALONE = 3
"""A cell is alone when no other occupied one is so near to it [cells]."""
NEIGHBOURS = (2 * ALONE + 1) ** 2 - 1
"""Cells that near."""
CRACK = 0.05
"""Gaps of walls that are narrower are closed, free or not [m]."""
BETWEEN = 0.30
"""Two faces that are no farther apart, with nothing known between them, are those of one wall [m]."""
HOLLOW = 2.0
"""What stands alone, is no wider and encloses hardly anything known as free is solid [m]."""
MOST_FREE = 0.15
"""Share of what a thing encloses that may be known as free."""
MOST_SWOLLEN, FEW = 1.7, 1000
"""Noise has so many times as many cells when its gaps are closed; a map of fewer cells is not asked."""
MORE, SOME = 3.0, 2.0
"""So many times as many, and so many more, as chance makes are no noise."""
MOST_SPECK = 12
"""More cells near to each other are never taken for noise."""
MOST_PARTS = 20_000
"""More parts that hang together make no map."""


def tidied(grid: Grid) -> Cells:
    """Return the occupied cells of a grid as walls and things have them.

    Raises:
        UsageError: They are in more parts than those of a building.
    """
    clean = cells = without_specks(grid)
    crack = min(3, round(CRACK / grid.resolution))
    cells = cells | _closed(cells, crack / 2 + 0.55) if crack else cells
    cells = cells | (_closed(cells, BETWEEN / 2 / grid.resolution) & ~grid.free)
    if np.count_nonzero(cells) > MOST_SWOLLEN * np.count_nonzero(clean) and np.count_nonzero(clean) > FEW:
        raise UsageError("the map has gaps everywhere, as noise has; clean it in a paint program")
    cells = cells | _hollows(cells, grid)
    return _without_pinholes(cells)


def speck_size(grid: Grid) -> int:
    """Return how many occupied cells must lie near to each other to be more than noise.

    Cells that are alone give the share of cells that noise occupies. It makes groups of k cells by chance too; the
    size is the least of which a map of this size has fewer than one by chance, or has many more than chance makes.
    """
    _, sizes = _groups(grid.occupied)
    lonely, share = int(np.count_nonzero(sizes == 1)), _noise_share(grid, sizes)
    for size in range(2, MOST_SPECK):
        expected = lonely * (NEIGHBOURS * share) ** (size - 1)
        if expected < 1.0 or np.count_nonzero(sizes == size) > MORE * expected + SOME:
            return size
    return MOST_SPECK


def has_lone_things(grid: Grid, single: int) -> bool:
    """Say whether a map has more single cells near others than noise puts there: legs, edges that few beams hit.

    Args:
        grid: The map.
        single: How many single cells there are that hang together with nothing, near others.
    """
    import cv2

    _, sizes = _groups(grid.occupied)
    around = cv2.dilate(grid.occupied.astype(np.uint8), np.ones((2 * ALONE + 1, 2 * ALONE + 1), dtype=np.uint8))
    near = int(np.count_nonzero((around > 0) & grid.free))
    return single > MORE * _noise_share(grid, sizes) * near + SOME


def _noise_share(grid: Grid, sizes: NDArray[Any]) -> float:
    """Return the share of free cells that noise occupies, from how many groups have how many cells."""
    return min(1.0, int(np.count_nonzero(sizes == 1)) / max(1, int(np.count_nonzero(grid.free))))


def without_specks(grid: Grid) -> Cells:
    """Return the occupied cells of a grid that are no noise.

    Raises:
        UsageError: They are in more parts than those of a building.
    """
    groups, sizes = _groups(grid.occupied)
    kept = sizes >= speck_size(grid)
    kept[0] = False
    if (parts := int(np.count_nonzero(kept))) > MOST_PARTS:
        raise UsageError(
            f"the map has {parts} parts, and that of a building at most {MOST_PARTS}; clean it in a paint program"
        )
    return np.asarray(kept[groups] & grid.occupied, dtype=bool)


def _groups(cells: Cells) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return the group of each cell, those near to each other being in one, and how many cells each group has."""
    import cv2

    reach = cv2.dilate(cells.astype(np.uint8), np.ones((ALONE + 1, ALONE + 1), dtype=np.uint8))
    count, groups = cv2.connectedComponents(reach, connectivity=8)
    return groups, np.bincount(groups[cells], minlength=count)


def _closed(cells: Cells, radius: float) -> Cells:
    """Return the cells that no disc covers which touches none of the cells given."""
    import cv2

    pad = int(radius) + 2
    away = cv2.distanceTransform((~np.pad(cells, pad)).astype(np.uint8), cv2.DIST_L2, 5)
    outside = away > radius
    back = cv2.distanceTransform((~outside).astype(np.uint8), cv2.DIST_L2, 5)
    return np.asarray((back > radius)[pad:-pad, pad:-pad], dtype=bool)


def _hollows(cells: Cells, grid: Grid) -> Cells:
    """Return what small things that stand alone enclose, where hardly any of it is known to be free."""
    import cv2

    _, parts, stats, _ = cv2.connectedComponentsWithStats(cells.astype(np.uint8), connectivity=8)
    found = np.zeros_like(cells)
    small = np.min(stats[:, 2:4], axis=1) * grid.resolution <= HOLLOW
    for index in np.flatnonzero(small[1:] & (stats[1:, cv2.CC_STAT_AREA] > 6)) + 1:
        left, top, width, height, _ = stats[index].tolist()
        window = slice(top, top + height), slice(left, left + width)
        part = parts[window] == index
        inner = _enclosed(part)
        if np.count_nonzero(inner & grid.free[window]) <= MOST_FREE * np.count_nonzero(inner):
            found[window] |= inner
    return found


def _enclosed(part: Cells) -> Cells:
    """Return the cells of a window that are cut off from its edge by some that hang together."""
    import cv2

    outside = np.pad((~part).astype(np.uint8), 1, constant_values=1)
    _, regions = cv2.connectedComponents(outside, connectivity=4)
    return np.asarray(((regions != regions[0, 0]) & (outside > 0))[1:-1, 1:-1], dtype=bool)


def _without_pinholes(cells: Cells) -> Cells:
    import cv2

    image = cells.astype(np.uint8)
    around = cv2.boxFilter(image, cv2.CV_8U, (3, 3), normalize=False, borderType=cv2.BORDER_CONSTANT)
    return np.asarray(cells | ((around >= 6) & (around - image >= 6)), dtype=bool)
