"""Converts occupied cells to straight walls and objects; all lengths in cells.

An isolated rectangle or disc becomes one object. The rest is thinned to lines; each line is fitted to both sides of its
wall, aligned with the main direction of the map, and extended to the end of the wall. What remains is cut into
rectangles.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.maps.cell_shapes import Bar, Disc, cells_in, fitted_bar, fitted_disc
from mjsim.exchange.maps.cleaning import has_lone_things, without_specks
from mjsim.exchange.maps.gather import gathered
from mjsim.exchange.maps.map_pixels import Cells
from mjsim.exchange.maps.stacked import unstacked
from mjsim.exchange.maps.strips import along_walls
from mjsim.exchange.maps.thin import lines, thinned
from mjsim.exchange.maps.tidy import tidied
from mjsim.geometry import Array
from mjsim.world import Grid

MAX_THICKNESS, MAX_USUAL_THICKNESS = 0.6, 1.2
"""Maximum thickness of a wall, and its maximum where walls are usually thick; thicker parts are objects [m]."""
MIN_LENGTH = 0.4
"""Minimum length of an isolated wall; shorter parts are objects [m]."""
MAX_THICKNESS_RATIO = 2.0
"""A part this many times as thick as the usual wall is not a wall, unless it is very long."""
LONG_WALL_RATIO = 12.0
"""Ratio of length to thickness that counts as very long: the outer walls of a building."""
MIN_SLENDERNESS = 4.0
"""Minimum ratio of length to thickness of a wall; a shorter part is an object."""
SIMILARITY = 0.85
"""Minimum overlap with the cells (intersection over union) at which a shape represents them."""
MIN_SIMILARITY = 0.65
"""The same for remaining cells, before they are cut in two."""
MAX_DISC_RATIO = 1.2
"""Maximum ratio of length to width of a disc."""
DISC_PREFERENCE = 0.03
"""A disc is preferred to a rectangle if its overlap is smaller by at most this."""
MIN_CELLS = 2
"""Isolated groups of fewer cells are noise, unless the map has many more of them than noise explains."""
MIN_OBJECT_AREA = 0.1
"""A smaller part may be a fragment of a larger object [m^2]."""
MAX_FRAGMENT_GAP = 0.3
"""Maximum distance between fragments of one wall [m]."""
REACH = 1.0
"""A cell is explained by a shape if its centre is within this distance of it [cells]."""
MAX_OCCUPIED, MAX_MIDDLES, MAX_LINES = 6_000_000, 500_000, 4_000
"""Maximum numbers of occupied cells, of thinned cells, and of straight lines in a map."""
MAX_DEPTH = 12
"""Maximum number of times that remaining cells are cut in two."""


@dataclass(frozen=True, slots=True, eq=False)
class Traced:
    """The shapes that represent the occupied cells of a grid."""

    walls: list[Bar]
    boxes: list[Bar]
    discs: list[Disc]


def trace(grid: Grid) -> Traced:
    """Return walls and objects that represent the occupied cells of a grid.

    Raises:
        UsageError: There are more lines or components than in a building.
    """
    _bounded(int(np.count_nonzero(grid.occupied)), MAX_OCCUPIED, "occupied cells")
    clean = without_specks(grid)
    cells = tidied(clean.cells, grid)
    single = sum(np.count_nonzero(part) == 1 for _, part in _parts(cells))
    least = 1 if has_lone_things(grid, single, noise=clean.noise) else MIN_CELLS
    alone, network = _alone(cells, grid.resolution, least)
    walls = _walls(network, grid)
    explained = np.zeros_like(cells)
    for wall in walls:
        window, inner = cells_in(wall.outline(grown=REACH), cells.shape)
        explained[window] |= inner
    left = [_middles(window, part) for window, part in _parts(network & ~explained)]
    rows, single = gathered(left, gap=MAX_FRAGMENT_GAP / grid.resolution)
    bars = [
        *alone.boxes,
        *rows,
        *(bar for points in single if len(points) >= least for bar in rectangles_for(points, 0)),
    ]
    thick = _thickest(network)
    whole = unstacked([*walls, *bars], cells)
    own = {id(wall) for wall in walls}
    slender = [bar for bar in whole if id(bar) in own or _is_slender(bar, thick, grid.resolution)]
    chosen = {id(bar) for bar in slender}
    return Traced(slender, [bar for bar in whole if id(bar) not in chosen], alone.discs)


def _thickest(network: Cells) -> float:
    """Return the maximum thickness of walls that are not very long; thicker parts are attached objects."""
    return max(MAX_THICKNESS_RATIO * _usual_thickness(network), 3.0)


def _is_slender(bar: Bar, thick: float, resolution: float) -> bool:
    """Return whether a rectangle outside the connected walls is a wall by itself."""
    if bar.length < max(MIN_SLENDERNESS * bar.width, MIN_LENGTH / resolution) or bar.width > MAX_THICKNESS / resolution:
        return False
    return bar.width <= thick or bar.length >= LONG_WALL_RATIO * bar.width


def _alone(cells: Cells, resolution: float, least: int) -> tuple[Traced, Cells]:
    """Return the isolated rectangles, discs and rows of fragments, and the remaining cells."""
    found = Traced([], [], [])
    network = np.zeros_like(cells)
    fragments: list[Array] = []
    for window, part in _parts(cells):
        points = _middles(window, part)
        if len(points) * resolution**2 <= MIN_OBJECT_AREA:
            fragments.append(points)
        elif not _taken(points, found):
            network[window] |= part
    rows, single = gathered(fragments, gap=MAX_FRAGMENT_GAP / resolution)
    found.boxes.extend(rows)
    for points in single:
        if len(points) >= least and not _taken(points, found):
            found.boxes.extend(rectangles_for(points, 0))
    return found, network


def _walls(network: Cells, grid: Grid) -> list[Bar]:
    """Return the walls formed by connected cells.

    Raises:
        UsageError: There are more lines than in a building.
    """
    thick = _thickest(network)
    thickest = min(max(MAX_THICKNESS, thick * grid.resolution), MAX_USUAL_THICKNESS) / grid.resolution
    slim = network & ~_bulky(network, min(thickest, thick), thickest)
    middles = thinned(slim)
    _bounded(int(np.count_nonzero(middles)), MAX_MIDDLES, "cells of walls, thinned")
    centrelines = lines(middles, spur=max(3.0, thickest / 4))
    _bounded(len(centrelines), MAX_LINES, "straight lines")
    return along_walls(slim, network, centrelines, grid.free, thickest=thickest)


def _bounded(count: int, limit: int, kind: str) -> None:
    if count > limit:
        raise UsageError(
            f"the map has {count} {kind}; the map of a building has at most {limit}, clean it in an image editor"
        )


def _parts(cells: Cells) -> Iterator[tuple[tuple[slice, slice], Cells]]:
    """Yield each connected component: its window of the grid, and its cells in that window."""
    import cv2

    count, parts, stats, _ = cv2.connectedComponentsWithStats(cells.astype(np.uint8), connectivity=8)
    for index in range(1, count):
        left, top, width, height, _ = stats[index].tolist()
        window = slice(top, top + height), slice(left, left + width)
        yield window, parts[window] == index


def _middles(window: tuple[slice, slice], part: Cells) -> Array:
    """Return the centres of the cells of a window, shape (n, 2), as (column, row)."""
    rows, columns = np.nonzero(part)
    return np.column_stack([columns + window[1].start, rows + window[0].start]) + 0.5


def _taken(points: Array, found: Traced) -> bool:
    """Return whether cells form one rectangle or disc, which is then added to `found`."""
    shape = _one_shape(points)
    if isinstance(shape, Bar):
        found.boxes.append(shape)
    elif isinstance(shape, Disc):
        found.discs.append(shape)
    return shape is not None


def _one_shape(points: Array) -> Bar | Disc | None:
    """Return the rectangle or disc that represents cells; None if neither does."""
    bar, similarity = fitted_bar(points)
    if len(points) >= 12 and bar.length < MAX_DISC_RATIO * bar.width:
        disc, round_similarity = fitted_disc(points)
        if round_similarity >= SIMILARITY and round_similarity > similarity - DISC_PREFERENCE:
            return disc
    return bar if similarity >= SIMILARITY or len(points) <= 6 else None


def _bulky(cells: Cells, limit: float, thickest: float) -> Cells:
    """Return the cells of components thicker than `limit`, without long walls of at most the other thickness."""
    import cv2

    bulky = _thick(cells, limit / 2)
    for window, part in _parts(bulky):
        away = cv2.distanceTransform(np.pad(part.astype(np.uint8), 1), cv2.DIST_L2, 5)
        thickness = 2.0 * float(np.max(away))
        if thickness <= thickest + 1.0 and np.count_nonzero(part) >= LONG_WALL_RATIO * thickness**2:
            bulky[window] &= ~part
    return bulky


def _thick(cells: Cells, radius: float) -> Cells:
    """Return the cells of components that contain a disc of the given radius."""
    import cv2

    away = cv2.distanceTransform(np.pad(cells.astype(np.uint8), 1), cv2.DIST_L2, 5)[1:-1, 1:-1]
    core = away > radius
    if not core.any():
        return np.zeros_like(cells)
    close = cv2.distanceTransform((~core).astype(np.uint8), cv2.DIST_L2, 5) <= radius + 0.5
    return np.asarray(cells & close, dtype=bool)


def _usual_thickness(cells: Cells) -> float:
    """Return twice the median distance from the centreline of walls to their sides."""
    import cv2

    away = cv2.distanceTransform(np.pad(cells.astype(np.uint8), 1), cv2.DIST_L2, 5)[1:-1, 1:-1]
    crest = (away >= cv2.dilate(away, np.ones((3, 3), dtype=np.uint8))) & cells
    return 2.0 * float(np.median(away[crest])) if crest.any() else 0.0


def rectangles_for(points: Array, depth: int) -> list[Bar]:
    """Return rectangles that represent cells: one, or those of the connected components of both halves."""
    bar, similarity = fitted_bar(points)
    if similarity >= MIN_SIMILARITY or len(points) <= 2 * MIN_CELLS or depth == MAX_DEPTH:
        return [bar]
    ahead = (points - [bar.x, bar.y]) @ bar.along > 0.0
    if ahead.all() or not ahead.any():
        return [bar]
    halves = points[ahead], points[~ahead]
    return [bar for half in halves for part in _hanging_together(half) for bar in rectangles_for(part, depth + 1)]


def _hanging_together(points: Array) -> list[Array]:
    """Return the cell centres of each connected component, shape (n, 2)."""
    lower = points.min(axis=0)
    columns, rows = np.round(points - lower).astype(int).T
    cells = np.zeros((rows.max() + 1, columns.max() + 1), dtype=bool)
    cells[rows, columns] = True
    return [_middles(window, part) - 0.5 + lower for window, part in _parts(cells)]
