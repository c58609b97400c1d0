"""Occupied cells -> straight walls and things that stand for them; all lengths in cells.

What stands alone and is a rectangle or a disc is taken as one. The rest is thinned to lines; each line is fitted
again to both sides of its wall, made square where the map is, and followed to where the wall ends. What is left
over is cut into rectangles.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.gather import gathered
from mjsim.exchange.pixels import Cells
from mjsim.exchange.shapes import Bar, Disc, cells_in, fitted_bar, fitted_disc
from mjsim.exchange.specks import has_lone_things, without_specks
from mjsim.exchange.stacked import unstacked
from mjsim.exchange.strips import along_walls
from mjsim.exchange.thin import lines, thinned
from mjsim.exchange.tidy import tidied
from mjsim.geometry import Array
from mjsim.world import Grid

THICKEST, BROADEST = 0.6, 1.2
"""What is thicker is a thing, not a wall; where walls are usually thick, walls up to the second are walls too [m]."""
SHORTEST = 0.4
"""What stands alone and is shorter is a thing, not a wall [m]."""
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
ROUNDER = 0.03
"""A disc that covers cells worse than a rectangle by this is still preferred."""
SPECK = 2
"""Fewer cells than this, if they are part of nothing else, are noise, unless the map has many more than noise makes."""
FRAGMENT = 0.1
"""What is smaller may be part of something larger [m^2]."""
TOGETHER = 0.3
"""Fragments of one wall are no farther apart [m]."""
REACH = 1.0
"""A cell whose middle is this near to a shape is explained by it [cells]."""
MOST_OCCUPIED, MOST_MIDDLES, MOST_LINES = 6_000_000, 500_000, 4_000
"""More of them make no map: occupied cells, cells in the middle of walls, straight lines."""
DEEPEST = 12
"""What is left over is cut in two at most so often."""


@dataclass(frozen=True, slots=True, eq=False)
class Traced:
    """What stands for the occupied cells of a grid."""

    walls: list[Bar]
    boxes: list[Bar]
    discs: list[Disc]


def trace(grid: Grid) -> Traced:
    """Return walls and things that stand for the occupied cells of a grid.

    Raises:
        UsageError: It has more lines or parts than the map of a building.
    """
    _bounded(int(np.count_nonzero(grid.occupied)), MOST_OCCUPIED, "occupied cells")
    clean = without_specks(grid)
    cells = tidied(clean.cells, grid)
    single = sum(np.count_nonzero(part) == 1 for _, part in _parts(cells))
    least = 1 if has_lone_things(grid, single, noise=clean.noise) else SPECK
    alone, network = _alone(cells, grid.resolution, least)
    walls = _walls(network, grid)
    explained = np.zeros_like(cells)
    for wall in walls:
        window, inner = cells_in(wall.outline(grown=REACH), cells.shape)
        explained[window] |= inner
    left = [_middles(window, part) for window, part in _parts(network & ~explained)]
    rows, single = gathered(left, gap=TOGETHER / grid.resolution)
    bars = [
        *alone.boxes,
        *rows,
        *(bar for points in single if len(points) >= least for bar in rectangles_for(points, 0)),
    ]
    thick = _thickest(network)
    whole = unstacked([*walls, *bars], cells)
    own = {id(wall) for wall in walls}
    kept = [bar for bar in whole if id(bar) in own or _is_slender(bar, thick, grid.resolution)]
    chosen = {id(bar) for bar in kept}
    return Traced(kept, [bar for bar in whole if id(bar) not in chosen], alone.discs)


def _thickest(network: Cells) -> float:
    """Return how thick walls are at most that are not very long: what is thicker leans on them, or they on it."""
    return max(BULKY * _usual_thickness(network), 3.0)


def _is_slender(bar: Bar, thick: float, resolution: float) -> bool:
    """Return whether a rectangle that is no part of the walls that hang together is a wall by itself."""
    if bar.length < max(SLENDER * bar.width, SHORTEST / resolution) or bar.width > THICKEST / resolution:
        return False
    return bar.width <= thick or bar.length >= LONG * bar.width


def _alone(cells: Cells, resolution: float, least: int) -> tuple[Traced, Cells]:
    """Return what stands alone and is a rectangle or a disc, or a row of fragments; and the cells of all else."""
    found = Traced([], [], [])
    network = np.zeros_like(cells)
    fragments: list[Array] = []
    for window, part in _parts(cells):
        points = _middles(window, part)
        if len(points) * resolution**2 <= FRAGMENT:
            fragments.append(points)
        elif not _taken(points, found):
            network[window] |= part
    rows, single = gathered(fragments, gap=TOGETHER / resolution)
    found.boxes.extend(rows)
    for points in single:
        if len(points) >= least and not _taken(points, found):
            found.boxes.extend(rectangles_for(points, 0))
    return found, network


def _walls(network: Cells, grid: Grid) -> list[Bar]:
    """Return the walls that cells form which hang together.

    Raises:
        UsageError: They have more lines than the map of a building.
    """
    thick = _thickest(network)
    thickest = min(max(THICKEST, thick * grid.resolution), BROADEST) / grid.resolution
    slim = network & ~_bulky(network, min(thickest, thick), thickest)
    middles = thinned(slim)
    _bounded(int(np.count_nonzero(middles)), MOST_MIDDLES, "cells of walls, thinned")
    centrelines = lines(middles, spur=max(3.0, thickest / 4))
    _bounded(len(centrelines), MOST_LINES, "straight lines")
    return along_walls(slim, network, centrelines, grid.free, thickest=thickest)


def _bounded(count: int, most: int, kind: str) -> None:
    if count > most:
        raise UsageError(
            f"the map has {count} {kind}, and that of a building at most {most}; clean it in an image editor"
        )


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


def _taken(points: Array, found: Traced) -> bool:
    """Return whether cells are one rectangle or one disc, which is added to what is found."""
    shape = _one_shape(points)
    if isinstance(shape, Bar):
        found.boxes.append(shape)
    elif isinstance(shape, Disc):
        found.discs.append(shape)
    return shape is not None


def _one_shape(points: Array) -> Bar | Disc | None:
    """Return the rectangle or the disc that stands for cells, if either does."""
    bar, alike = fitted_bar(points)
    if len(points) >= 12 and bar.length < ROUND * bar.width:
        disc, round_alike = fitted_disc(points)
        if round_alike >= ALIKE and round_alike > alike - ROUNDER:
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


def rectangles_for(points: Array, depth: int) -> list[Bar]:
    """Return rectangles that stand for cells: one, or those of what hangs together in both halves."""
    bar, alike = fitted_bar(points)
    if alike >= ALIKE_ENOUGH or len(points) <= 2 * SPECK or depth == DEEPEST:
        return [bar]
    ahead = (points - [bar.x, bar.y]) @ bar.along > 0.0
    if ahead.all() or not ahead.any():
        return [bar]
    halves = points[ahead], points[~ahead]
    return [bar for half in halves for part in _hanging_together(half) for bar in rectangles_for(part, depth + 1)]


def _hanging_together(points: Array) -> list[Array]:
    """Return the middles of cells, shape (n, 2), of each part of them that hangs together."""
    lower = points.min(axis=0)
    columns, rows = np.round(points - lower).astype(int).T
    cells = np.zeros((rows.max() + 1, columns.max() + 1), dtype=bool)
    cells[rows, columns] = True
    return [_middles(window, part) - 0.5 + lower for window, part in _parts(cells)]
