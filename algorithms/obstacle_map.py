"""Distances to the obstacles around a robot."""

import math

import cv2
import numpy as np

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
        count = len(self.distance) - 1
        i = np.clip(((x - self.lower[0]) / self.cell).astype(np.int32), 0, count)
        j = np.clip(((y - self.lower[1]) / self.cell).astype(np.int32), 0, count)
        return np.asarray(self.distance.ravel()[j * (count + 1) + i])

    def slope(self, points: Array) -> tuple[Array, Array]:
        """Return the distances at points (n, 2) [m], and their derivatives by x and y, shape (n, 2)."""
        x, y = points.T
        by_x = self.at(x + self.cell, y) - self.at(x - self.cell, y)
        by_y = self.at(x, y + self.cell) - self.at(x, y - self.cell)
        return self.at(x, y), np.stack([by_x, by_y], axis=-1) / (2.0 * self.cell)
