"""A distance grid: distance to the nearest wall, for scan matching and path clearance."""

from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array

FIXED_POINT = 4
"""Number of fractional bits of the coordinates for drawing lines."""


class DistanceGrid:
    """Distance from each cell's centre to the nearest wall.

    The cell of row r and column c has its centre at `lower + cell * (c + 1/2, r + 1/2)`.

    References:
        Felzenszwalb, Huttenlocher, Distance Transforms of Sampled Functions, Theory of Computing 8, 2012.
    """

    def __init__(self, occupied: NDArray[np.bool_], *, lower: Array, cell: float, finer: int = 1) -> None:
        """Compute the distances.

        Args:
            occupied: Occupied cells, shape (finer * rows, finer * columns), the first row at the smallest y.
            lower: Corner of the grid with the smallest x and y, shape (2,) [m].
            cell: Side of a cell [m].
            finer: Number of parts, odd, into which `occupied` divides each side of a cell.
        """
        self.lower, self.cell = np.asarray(lower, dtype=float), cell
        free = np.where(occupied, 0, 255).astype(np.uint8)
        distance = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
        # OpenCV gives a large number where nothing is occupied at all.
        distance = distance[finer // 2 :: finer, finer // 2 :: finer].astype(float)
        self.distance: Array = np.minimum(distance, sum(free.shape)) * (cell / finer)
        """Shape (rows, columns) [m]."""

    @classmethod
    def from_segments(cls, segments: Array, *, cell: float = 0.05, margin: float = 1.0, finer: int = 1) -> Self:
        """Draw walls into a grid that reaches beyond them.

        Args:
            segments: Faces of walls and obstacles, shape (n, 2, 2) [m].
            cell: Side of a cell [m].
            margin: How far the grid reaches beyond the walls [m].
            finer: Walls are drawn at this multiple of the resolution, an odd number: drawn in whole cells, a wall would
                be off by up to half a cell over its whole length.

        Raises:
            ValueError: There are no walls.
        """
        if not len(segments):
            raise ValueError("the map has no walls")
        lower = segments.min(axis=(0, 1)) - margin
        columns, rows = np.ceil((segments.max(axis=(0, 1)) + margin - lower) / cell).astype(int)
        drawn = np.zeros((finer * rows, finer * columns), dtype=np.uint8)
        # For OpenCV a pixel's centre is a whole number.
        corners = np.round(((segments - lower) / (cell / finer) - 0.5) * 2**FIXED_POINT).astype(np.int32)
        for one, other in corners:
            cv2.line(drawn, one.tolist(), other.tolist(), 1, 1, cv2.LINE_8, FIXED_POINT)
        return cls(drawn == 1, lower=lower, cell=cell, finer=finer)

    def cells(self, points: Array) -> NDArray[np.intp]:
        """Return (row, column) of the cells of points (..., 2) [m]; outside the grid those at its edge."""
        rows, columns = self.distance.shape
        index = np.floor((points - self.lower) / self.cell).astype(np.intp)
        return np.asarray(np.clip(index, 0, (columns - 1, rows - 1))[..., ::-1])

    def centres(self, cells: NDArray[np.intp]) -> Array:
        """Return the centres of cells (..., 2), given as (row, column) [m]."""
        return np.asarray(self.lower + (cells[..., ::-1] + 0.5) * self.cell)

    def at(self, points: Array) -> Array:
        """Return the distance to the nearest wall from points (..., 2) [m]; beyond the grid that of its edge."""
        cells = self.cells(points)
        return np.asarray(self.distance[cells[..., 0], cells[..., 1]])

    def is_clear(self, one: Array, other: Array, clearance: float) -> bool:
        """Return whether a robot can go straight from one point to another, each (2,) [m]."""
        steps = 1 + int(np.hypot(*(other - one)) / (0.5 * self.cell))
        return bool((self.at(np.linspace(one, other, steps + 1)) > clearance).all())

    def largest_region(self, clearance: float) -> Array:
        """Return the centres of the cells of the largest region inside the walls, shape (n, 2) [m].

        Args:
            clearance: Minimum distance to any wall [m].

        If the walls enclose nothing, it is the region around them.
        """
        reached = (self.distance > self.cell).astype(np.uint8)
        cv2.floodFill(reached, None, (0, 0), 2)
        clear = self.distance > clearance
        inside = clear & (reached == 1)
        _, region, sizes, _ = cv2.connectedComponentsWithStats((inside if inside.any() else clear).astype(np.uint8))
        return self.centres(np.argwhere(region == 1 + np.argmax(sizes[1:, cv2.CC_STAT_AREA])))
