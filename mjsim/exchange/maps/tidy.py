"""Completes occupied areas: closes gaps in walls, fills the space between two faces."""

import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.maps.map_pixels import Cells
from mjsim.world import Grid

MAX_CRACK = 0.05
"""Narrower gaps in walls are closed, even if they are free [m]."""
BETWEEN = 0.30
"""Two faces within this distance, with only unknown cells between them, belong to one wall [m]."""
MAX_HOLLOW = 2.0
"""An isolated object no wider than this that encloses hardly any free cells is solid [m]."""
MAX_FREE = 0.15
"""Maximum free fraction of the enclosed area of such an object."""
MAX_SWOLLEN, FEW = 0.7, 1000
"""Maximum growth of noise by closing gaps where cells are crowded; not checked for maps with fewer cells."""
AROUND, CROWDED = 3 * BETWEEN, 0.6
"""Window side [m], and the occupied fraction of it that walls and their corners do not exceed."""


def tidied(clean: Cells, grid: Grid) -> Cells:
    """Return the occupied cells of a grid, completed to solid walls and objects.

    Args:
        clean: Occupied cells without noise, shape (rows, columns).
        grid: The whole map.

    Raises:
        UsageError: The cells have gaps everywhere.
    """
    cells = clean
    crack = min(3, round(MAX_CRACK / grid.resolution))
    cells = cells | _closed(cells, crack / 2 + 0.55) if crack else cells
    cells = cells | (_closed(cells, BETWEEN / 2 / grid.resolution) & ~grid.free)
    swollen = np.count_nonzero(_crowded(cells, grid.resolution) & ~clean)
    if swollen > MAX_SWOLLEN * np.count_nonzero(clean) and np.count_nonzero(clean) > FEW:
        raise UsageError("the map has gaps everywhere, like noise; clean it in an image editor")
    cells = cells | _hollows(cells, grid)
    return _without_pinholes(cells)


def _closed(cells: Cells, radius: float) -> Cells:
    """Return the morphological closing of cells by a disc."""
    import cv2

    pad = int(radius) + 2
    away = cv2.distanceTransform((~np.pad(cells, pad)).astype(np.uint8), cv2.DIST_L2, 5)
    outside = away > radius
    back = cv2.distanceTransform((~outside).astype(np.uint8), cv2.DIST_L2, 5)
    return np.asarray((back > radius)[pad:-pad, pad:-pad], dtype=bool)


def _crowded(cells: Cells, resolution: float) -> Cells:
    """Return the cells around which more is occupied than by a wall, even at junctions of walls."""
    import cv2

    side = 2 * round(AROUND / resolution / 2) + 1
    share = cv2.boxFilter(cells.astype(np.float32), cv2.CV_32F, (side, side), borderType=cv2.BORDER_CONSTANT)
    return np.asarray(cells & (share > CROWDED), dtype=bool)


def _hollows(cells: Cells, grid: Grid) -> Cells:
    """Return the inside of small isolated objects where hardly any cell is known to be free."""
    import cv2

    _, parts, stats, _ = cv2.connectedComponentsWithStats(cells.astype(np.uint8), connectivity=8)
    found = np.zeros_like(cells)
    small = np.min(stats[:, 2:4], axis=1) * grid.resolution <= MAX_HOLLOW
    for index in np.flatnonzero(small[1:] & (stats[1:, cv2.CC_STAT_AREA] > 6)) + 1:
        left, top, width, height, _ = stats[index].tolist()
        window = slice(top, top + height), slice(left, left + width)
        part = parts[window] == index
        inner = _enclosed(part)
        if np.count_nonzero(inner & grid.free[window]) <= MAX_FREE * np.count_nonzero(inner):
            found[window] |= inner
    return found


def _enclosed(part: Cells) -> Cells:
    """Return the cells of a window that a connected part cuts off from its border."""
    import cv2

    outside = np.pad((~part).astype(np.uint8), 1, constant_values=1)
    _, regions = cv2.connectedComponents(outside, connectivity=4)
    return np.asarray(((regions != regions[0, 0]) & (outside > 0))[1:-1, 1:-1], dtype=bool)


def _without_pinholes(cells: Cells) -> Cells:
    import cv2

    image = cells.astype(np.uint8)
    around = cv2.boxFilter(image, cv2.CV_8U, (3, 3), normalize=False, borderType=cv2.BORDER_CONSTANT)
    return np.asarray(cells | ((around >= 6) & (around - image >= 6)), dtype=bool)
