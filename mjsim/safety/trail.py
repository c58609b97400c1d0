"""Recent places of a robot, so that it can prefer new directions."""

import math

import numpy as np

from mjsim.geometry import Array


class Trail:
    """Places where the robot has been, some decimetres apart, in the frame of odometry."""

    CAPACITY = 512
    STEP = 0.3
    """Distance between two places [m]."""
    SIGHT = 4.0
    """Places farther than this are ignored [m]."""
    WIDTH = 0.4
    """Half width of a sector in which places are counted [rad]."""

    def __init__(self) -> None:
        """Start without places."""
        self._places = np.full((self.CAPACITY, 2), np.inf)
        self._count = 0
        self._last = (math.inf, math.inf)

    def add(self, x: float, y: float) -> None:
        """Store the position of the robot [m], if it is far enough from the last one."""
        if math.dist((x, y), self._last) >= self.STEP:
            self._last = (x, y)
            self._places[self._count % self.CAPACITY] = x, y
            self._count += 1

    def worn(self, x: float, y: float, headings: Array) -> Array:
        """Return how often it has been in each direction from a place, weighted by proximity, shape (k,), in [0, 1].

        Args:
            x: Of the place, frame of odometry [m].
            y: Of the place [m].
            headings: Directions, frame of odometry, shape (k,) [rad].
        """
        places = self._places[: self._count]
        dx, dy = places[:, 0] - x, places[:, 1] - y
        distance = np.hypot(dx, dy)
        ahead = (np.cos(headings)[:, None] * dx + np.sin(headings)[:, None] * dy) / np.maximum(distance, 1e-9)
        weight = np.where((distance > self.STEP) & (distance < self.SIGHT), 1.0 / np.maximum(distance, self.STEP), 0.0)
        often = np.asarray((ahead > math.cos(self.WIDTH)) @ weight, dtype=float)
        return often / max(float(np.max(often)), 1.0)
