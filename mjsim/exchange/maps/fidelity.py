"""Measures how well a world explains the map from which it was made."""

from dataclasses import dataclass

import numpy as np

from mjsim.exchange.maps.map_pixels import Cells
from mjsim.geometry import Array
from mjsim.world import Grid, World, cells_of, solid

TOLERANCE = 1.0
"""A cell is explained if its centre is within this distance of something solid [cells]."""
MIN_COVERED_DEPTH = 0.5
"""A free cell is covered if its centre is deeper than this inside something solid [cells]."""


@dataclass(frozen=True, slots=True)
class Fidelity:
    """Statistics that compare a world with a map; specks count like all other cells."""

    occupied: int
    """Number of occupied cells in the map."""
    explained: int
    """Number of occupied cells whose centre is at most one cell from something solid."""
    touched: int
    """Number of occupied cells that something solid touches: their centre is at most half a cell from it."""
    covered: int
    """Number of free cells whose centre is more than half a cell deep inside something solid."""
    solid: int
    """Number of cells whose centre is inside something solid."""
    false_walls: float
    """Fraction of the total wall length that has no occupied cell within one cell of its faces, 0 to 1."""

    @property
    def share(self) -> float:
        """Fraction of the occupied cells that are explained, 0 to 1."""
        return self.explained / self.occupied if self.occupied else 1.0


def fidelity(world: World, grid: Grid) -> Fidelity:
    """Return how well a world represents a grid."""
    shape, cell = solid(world), grid.resolution
    close: Cells = cells_of(shape.buffer(TOLERANCE * cell), grid)
    touched: Cells = cells_of(shape.buffer(cell / 2, join_style="mitre"), grid)
    deep: Cells = cells_of(shape.buffer(-MIN_COVERED_DEPTH * cell), grid)
    return Fidelity(
        occupied=int(np.count_nonzero(grid.occupied)),
        explained=int(np.count_nonzero(grid.occupied & close)),
        touched=int(np.count_nonzero(grid.occupied & touched)),
        covered=int(np.count_nonzero(grid.free & deep)),
        solid=int(np.count_nonzero(cells_of(shape, grid))),
        false_walls=_false_share(world, grid),
    )


def _false_share(world: World, grid: Grid) -> float:
    """Return the fraction of the wall length near which the map has no occupied cell, 0 to 1."""
    import cv2

    away = np.asarray(cv2.distanceTransform((~np.pad(grid.occupied, 1)).astype(np.uint8), cv2.DIST_L2, 5), dtype=float)
    length = false = 0.0
    for wall in world.walls:
        reach = wall.thickness / 2 / grid.resolution + TOLERANCE
        for start, end in wall.segments():
            far = _values_along(away, grid, np.array(start), np.array(end)) > reach
            size = float(np.hypot(*np.subtract(end, start)))
            length, false = length + size, false + size * float(far.mean())
    return false / length if length else 0.0


def _values_along(away: Array, grid: Grid, start: Array, end: Array) -> Array:
    """Return values of a padded image along a line in the world, two samples per cell."""
    count = max(2, round(2 * float(np.hypot(*(end - start))) / grid.resolution))
    places = start + np.outer((np.arange(count) + 0.5) / count, end - start)
    cells = np.floor(grid.cells(places)).astype(int) + 1
    rows, columns = away.shape
    cells = cells.clip(0, (columns - 1, rows - 1))
    return np.asarray(away[cells[:, 1], cells[:, 0]])
