"""Occupied cells made whole: gaps of walls closed, what lies between two faces filled."""

import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.pixels import Cells
from mjsim.world import Grid

CRACK = 0.05
"""Gaps of walls that are narrower are closed, free or not [m]."""
BETWEEN = 0.30
"""Two faces that are no farther apart, with nothing known between them, are those of one wall [m]."""
HOLLOW = 2.0
"""What stands alone, is no wider and encloses hardly anything known as free is solid [m]."""
MOST_FREE = 0.15
"""Fraction of what a thing encloses that may be known as free."""
MOST_SWOLLEN, FEW = 0.7, 1000
"""Closed gaps add more of its cells to noise where these are crowded; a map of fewer cells is not asked."""
AROUND, CROWDED = 3 * BETWEEN, 0.6
"""Walls and their corners take less of the ground around them [side of a square in m, share]."""


def tidied(clean: Cells, grid: Grid) -> Cells:
    """Return the occupied cells of a grid as walls and things have them.

    Args:
        clean: Those that are no noise, shape (rows, columns).
        grid: All of it.

    Raises:
        UsageError: They have gaps everywhere.
    """
    cells = clean
    crack = min(3, round(CRACK / grid.resolution))
    cells = cells | _closed(cells, crack / 2 + 0.55) if crack else cells
    cells = cells | (_closed(cells, BETWEEN / 2 / grid.resolution) & ~grid.free)
    swollen = np.count_nonzero(_crowded(cells, grid.resolution) & ~clean)
    if swollen > MOST_SWOLLEN * np.count_nonzero(clean) and np.count_nonzero(clean) > FEW:
        raise UsageError("the map has gaps everywhere, like noise; clean it in an image editor")
    cells = cells | _hollows(cells, grid)
    return _without_pinholes(cells)


def _closed(cells: Cells, radius: float) -> Cells:
    """Return the cells that no disc covers which touches none of the cells given."""
    import cv2

    pad = int(radius) + 2
    away = cv2.distanceTransform((~np.pad(cells, pad)).astype(np.uint8), cv2.DIST_L2, 5)
    outside = away > radius
    back = cv2.distanceTransform((~outside).astype(np.uint8), cv2.DIST_L2, 5)
    return np.asarray((back > radius)[pad:-pad, pad:-pad], dtype=bool)


def _crowded(cells: Cells, resolution: float) -> Cells:
    """Return the cells around which more is occupied than by a wall, even where walls meet."""
    import cv2

    side = 2 * round(AROUND / resolution / 2) + 1
    share = cv2.boxFilter(cells.astype(np.float32), cv2.CV_32F, (side, side), borderType=cv2.BORDER_CONSTANT)
    return np.asarray(cells & (share > CROWDED), dtype=bool)


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
