"""A frame for online estimates that stays where it is while the graph still learns how its map is turned.

A robot that turns in the dark may know the heading of all that it maps afterwards to 20 degrees only, relative to where
it began. When it learns better, all of the map turns, and the robot with it: each estimate is the best at its time, but
yesterday's place on the map is not where it was told to be. What a robot does on its map asks for another thing: that
places stay. So as long as the turn of the map is that unsure, what is told is the solution turned and shifted to where
it fits best what was told before. Once the turn is known, the solution is told as it is.
"""

import math

import numpy as np

from mjsim.geometry import Array, wrap_angle

from .pose_graph import compose
from .relocation import fitted

UNSURE = math.radians(3.0)
"""Standard deviation of the heading from which on the frame is held [rad]. Held below it, small rooms would keep the
errors of their first looks; over 5 m it makes 0.3 m, as far as robots keep away from walls."""
SPREAD = 0.5
"""The way told so far reaches at least so far before a turn is fitted to it [m]."""


class HeldFrame:
    """Tells the poses of a graph in a frame that agrees with what was told of earlier ones."""

    def __init__(self, pose: Array) -> None:
        """Begin with the first pose, shape (3,), told as it is."""
        self._told = np.zeros((64, 2))
        self._told[0] = pose[:2]
        self._count = 1
        self._shift = np.zeros(3)

    def add(self, solved: Array, deviation: float) -> None:
        """Take a solution that has one more pose.

        Args:
            solved: All poses, shape (n, 3), the newest last.
            deviation: Standard deviation of the newest heading, relative to the first pose [rad].
        """
        before = self._told[: self._count]
        if deviation < UNSURE:
            self._shift = np.zeros(3)
        elif np.ptp(before, axis=0).max() > SPREAD:
            self._shift = fitted(solved[: self._count, :2], before)
        if self._count == len(self._told):
            self._told = np.concatenate([self._told, np.zeros_like(self._told)])
        self._told[self._count] = self.pose(solved[-1])[:2]
        self._count += 1

    def pose(self, solved: Array) -> Array:
        """Return a pose as it is told, shape (3,)."""
        return compose(self._shift, solved)

    def pose_covariance(self, solved: Array, covariance: Array) -> Array:
        """Return the covariance of a pose as it is told, shape (3, 3): it is off by as much as it is held too."""
        c, s = math.cos(self._shift[2]), math.sin(self._shift[2])
        R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        off = self.pose(solved) - solved
        off[2] = wrap_angle(float(off[2]))
        return np.asarray(R @ covariance @ R.T + np.outer(off, off))

    def landmark(self, mean: Array, covariance: Array) -> tuple[Array, Array]:
        """Return a landmark (2,) and its covariance (2, 2) as they are told."""
        point = np.array([*mean, 0.0])
        spread = np.zeros((3, 3))
        spread[:2, :2] = covariance
        return self.pose(point)[:2], self.pose_covariance(point, spread)[:2, :2]
