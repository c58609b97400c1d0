"""Distances to the obstacles around a robot."""

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array


class ObstacleMap:
    """Distances to obstacles in a square around the robot, in the frame of the estimate."""

    def __init__(self, place: Array, points: Array, *, cell: float, half: float) -> None:
        """Compute the distances.

        Args:
            place: Centre, shape (2,) [m].
            points: Obstacles, shape (n, 2) [m].
            cell: Side of a cell [m].
            half: Half a side of the square [m].
        """
        count = 2 * math.ceil(half / cell) + 1
        self.lower, self.cell = place - 0.5 * count * cell, cell
        i, j = ((points - self.lower) / cell).astype(int).T if len(points) else np.zeros((2, 0), dtype=int)
        inside = (i >= 0) & (i < count) & (j >= 0) & (j < count)
        free = np.full((count, count), 255, dtype=np.uint8)
        free[j[inside], i[inside]] = 0
        far = np.float32(2.0 * half)
        distance = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_5) * np.float32(cell)
        self.distance = np.minimum(distance, far)

    def at(self, x: Array, y: Array) -> Array:
        """Return the distances at points; beyond the square that of its edge [m]."""
        return np.asarray(self.distance.ravel()[self._cells(x, y, 0)])

    def slope(self, points: Array) -> tuple[Array, Array]:
        """Return the distances at points (n, 2) [m], and their derivatives by x and y, shape (n, 2)."""
        flat, cells = self.distance.ravel(), self._cells(points[:, 0], points[:, 1], 1)
        row = len(self.distance)
        by_x, by_y = flat[cells + 1] - flat[cells - 1], flat[cells + row] - flat[cells - row]
        return flat[cells], np.stack([by_x, by_y], axis=-1) / (2.0 * self.cell)

    def _cells(self, x: Array, y: Array, edge: int) -> NDArray[np.int32]:
        """Return the flat indices of points; beyond the square less an edge [cells] those of its rim."""
        most = len(self.distance) - 1 - edge
        left, bottom = self.lower.tolist()
        i, j = ((x - left) / self.cell).astype(np.int32), ((y - bottom) / self.cell).astype(np.int32)
        # The two ufuncs are several times faster than np.clip on small arrays.
        i, j = np.minimum(np.maximum(i, edge), most), np.minimum(np.maximum(j, edge), most)
        return np.asarray(j * len(self.distance) + i)


def sampled(segments: Array, *, cell: float) -> Array:
    """Return points on segments (n, 2, 2), in every cell of a side, shape (k, 2) [m]."""
    counts = 1 + np.ceil(np.hypot(*(segments[:, 1] - segments[:, 0]).T) / cell).astype(int)
    which = np.repeat(np.arange(len(segments)), counts)
    share = np.concatenate([np.linspace(0.0, 1.0, count) for count in counts.tolist()]) if len(counts) else np.zeros(0)
    return np.asarray(segments[which, 0] + share[:, None] * (segments[which, 1] - segments[which, 0]))
