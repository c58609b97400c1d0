"""Occupied cells -> straight walls and things that stand for them; all lengths in cells.

What stands alone and is a rectangle or a disc is taken as one. The rest is thinned to lines; each line is fitted
again to both sides of its wall, made square where the map is, and followed to where the wall ends. What is left
over is cut into rectangles.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.grid import Cells, Grid
from mjsim.exchange.shapes import Bar, Disc, cells_in, fitted_bar, fitted_disc
from mjsim.exchange.strips import along_walls
from mjsim.exchange.thin import lines, thinned
from mjsim.geometry import Array

THICKEST = 0.6
"""What is thicker is a thing, not a wall [m]."""
BULKY = 2.0
"""What is so many times as thick as the usual wall is not taken for one, unless it is very long."""
LONG = 12.0
"""Very long is so many times as long as thick: the outer walls of a building."""
SLENDER = 4.0
"""A wall is at least this many times as long as thick; shorter is a thing."""
ALIKE = 0.85
"""Overlap of a shape with cells at which it stands for them."""
ALIKE_ENOUGH = 0.65
"""The same for what is left over, before it is cut in two."""
ROUND = 1.2
"""A disc is at most this much longer than wide."""
SPECK = 3
"""Fewer cells than this are noise."""
REACH = 0.75
"""A cell whose middle is this near to a shape is explained by it [cells]."""
MOST_PARTS, MOST_MIDDLES, MOST_LINES = 20_000, 500_000, 4_000
"""More of them make no map: parts that hang together, cells in the middle of walls, straight lines."""
DEEPEST = 7
"""What is left over is cut in two at most so often."""


@dataclass(frozen=True, slots=True, eq=False)
class Traced:
    """What stands for the occupied cells of a grid."""

    walls: Sequence[Bar]
    boxes: Sequence[Bar]
    discs: Sequence[Disc]


def trace(grid: Grid) -> Traced:
    """Return walls and things that stand for the occupied cells of a grid.

    Raises:
        UsageError: It has more lines or parts than the map of a building.
    """
    cells = _tidied(grid.occupied)
    thickest = THICKEST / grid.resolution
    bars: list[Bar] = []
    discs: list[Disc] = []
    network = np.zeros_like(cells)
    for window, part in _parts(cells):
        shape = _one_shape(_middles(window, part))
        if isinstance(shape, Bar):
            bars.append(shape)
        elif isinstance(shape, Disc):
            discs.append(shape)
        else:
            network[window] |= part
    # What is much thicker than the walls of this map leans on them, or they on it.
    left = network & ~_bulky(network, min(thickest, max(BULKY * _usual_thickness(network), 3.0)), thickest)
    middles = thinned(left)
    _bounded(int(np.count_nonzero(middles)), MOST_MIDDLES, "cells of walls, thinned")
    centrelines = lines(middles, spur=max(3.0, thickest / 4))
    _bounded(len(centrelines), MOST_LINES, "straight lines")
    walls = along_walls(left, network, centrelines, grid.free, thickest=thickest)
    explained = np.zeros_like(cells)
    for wall in walls:
        window, inner = cells_in(wall.outline(grown=REACH), cells.shape)
        explained[window] |= inner
    for window, part in _parts(network & ~explained):
        if np.count_nonzero(part) >= SPECK:
            bars += _cut(_middles(window, part), 0)
    slender = [bar for bar in bars if bar.length >= SLENDER * bar.width and bar.width <= thickest]
    boxes = [bar for bar in bars if bar not in slender]
    return Traced([*walls, *slender], boxes, discs)


def _bounded(count: int, most: int, kind: str) -> None:
    if count > most:
        raise UsageError(
            f"the map has {count} {kind}, and that of a building at most {most}; clean it in a paint program"
        )


def _tidied(occupied: Cells) -> Cells:
    """Return the cells without specks, pinholes filled."""
    import cv2

    image = occupied.astype(np.uint8)
    around = cv2.boxFilter(image, cv2.CV_8U, (3, 3), normalize=False, borderType=cv2.BORDER_CONSTANT)
    image |= (around >= 6).astype(np.uint8) & (around - image >= 6)
    _, parts, stats, _ = cv2.connectedComponentsWithStats(image, connectivity=8)
    large = stats[:, cv2.CC_STAT_AREA] >= SPECK
    large[0] = False
    _bounded(int(np.count_nonzero(large[1:])), MOST_PARTS, "parts")
    return np.asarray(large[parts], dtype=bool)


def _parts(cells: Cells) -> Iterator[tuple[tuple[slice, slice], Cells]]:
    """Yield each set of cells that hang together: the window of the grid around it, and its cells there."""
    import cv2

    count, parts, stats, _ = cv2.connectedComponentsWithStats(cells.astype(np.uint8), connectivity=8)
    for index in range(1, count):
        left, top, width, height, _ = stats[index].tolist()
        window = slice(top, top + height), slice(left, left + width)
        yield window, parts[window] == index


def _middles(window: tuple[slice, slice], part: Cells) -> Array:
    """Return the middles of the cells of a window, shape (n, 2), (column, row)."""
    rows, columns = np.nonzero(part)
    return np.column_stack([columns + window[1].start, rows + window[0].start]) + 0.5


def _one_shape(points: Array) -> Bar | Disc | None:
    """Return the rectangle or the disc that stands for cells, if either does."""
    bar, alike = fitted_bar(points)
    if len(points) >= 12 and bar.length < ROUND * bar.width:
        disc, round_alike = fitted_disc(points)
        if round_alike >= ALIKE and round_alike > alike:
            return disc
    return bar if alike >= ALIKE or len(points) <= 6 else None


def _bulky(cells: Cells, limit: float, thickest: float) -> Cells:
    """Return the cells of parts that are thicker than a limit, without walls of at most the other thickness."""
    import cv2

    bulky = _thick(cells, limit / 2)
    for window, part in _parts(bulky):
        away = cv2.distanceTransform(np.pad(part.astype(np.uint8), 1), cv2.DIST_L2, 5)
        thickness = 2.0 * float(np.max(away))
        if thickness <= thickest + 1.0 and np.count_nonzero(part) >= LONG * thickness**2:
            bulky[window] &= ~part
    return bulky


def _thick(cells: Cells, radius: float) -> Cells:
    """Return the cells of parts that hold a disc."""
    import cv2

    away = cv2.distanceTransform(np.pad(cells.astype(np.uint8), 1), cv2.DIST_L2, 5)[1:-1, 1:-1]
    core = away > radius
    if not core.any():
        return np.zeros_like(cells)
    near = cv2.distanceTransform((~core).astype(np.uint8), cv2.DIST_L2, 5) <= radius + 0.5
    return np.asarray(cells & near, dtype=bool)


def _usual_thickness(cells: Cells) -> float:
    """Return twice the median distance from the middles of walls to their sides."""
    import cv2

    away = cv2.distanceTransform(np.pad(cells.astype(np.uint8), 1), cv2.DIST_L2, 5)[1:-1, 1:-1]
    crest = (away >= cv2.dilate(away, np.ones((3, 3), dtype=np.uint8))) & cells
    return 2.0 * float(np.median(away[crest])) if crest.any() else 0.0


def _cut(points: Array, depth: int) -> list[Bar]:
    """Return rectangles that stand for cells: one, or those of both halves."""
    bar, alike = fitted_bar(points)
    if alike >= ALIKE_ENOUGH or len(points) <= 2 * SPECK or depth == DEEPEST:
        return [bar]
    ahead = (points - [bar.x, bar.y]) @ bar.along > 0.0
    if ahead.all() or not ahead.any():
        return [bar]
    return _cut(points[ahead], depth + 1) + _cut(points[~ahead], depth + 1)
