"""A frame for online estimates that stays fixed while the rotation of the map is still uncertain.

After a long turn without landmarks, the heading of everything mapped later may be uncertain by 20 degrees relative to
the start. When the graph learns that heading, it turns the whole map and the robot with it. Each estimate is then the
best one at its time, but places on the map no longer have the coordinates that earlier estimates gave them. A robot
that acts on its map needs fixed coordinates. So while the heading is that uncertain, the solution is reported after the
rigid transform that fits it best to the positions reported before. Once the heading is known, the solution is reported
unchanged.
"""

import math

import numpy as np

from mjsim.geometry import Array, wrap_angle

from .pose_graph import compose
from .relocation import fitted

UNSURE = math.radians(3.0)
"""The frame is held while the standard deviation of the heading exceeds this [rad]. With less, small rooms would keep
the errors of their first sightings; at 5 m it amounts to 0.3 m, the distance that robots keep from walls."""
SPREAD = 0.5
"""Extent that the reported positions must have before a rotation is fitted to them [m]."""


class HeldFrame:
    """Reports poses of a graph in a frame that agrees with earlier reports."""

    def __init__(self, pose: Array) -> None:
        """Begin with the first pose, shape (3,), reported unchanged."""
        self._reported = np.zeros((64, 2))
        self._reported[0] = pose[:2]
        self._count = 1
        self._shift = np.zeros(3)

    def add(self, solved: Array, deviation: float) -> None:
        """Update the frame with a solution that has one more pose.

        Args:
            solved: All poses, shape (n, 3), the newest last.
            deviation: Standard deviation of the newest heading, relative to the first pose [rad].
        """
        before = self._reported[: self._count]
        if deviation < UNSURE:
            self._shift = np.zeros(3)
        elif np.ptp(before, axis=0).max() > SPREAD:
            self._shift = fitted(solved[: self._count, :2], before)
        if self._count == len(self._reported):
            self._reported = np.concatenate([self._reported, np.zeros_like(self._reported)])
        self._reported[self._count] = self.pose(solved[-1])[:2]
        self._count += 1

    def pose(self, solved: Array) -> Array:
        """Return a pose in the held frame, shape (3,)."""
        return compose(self._shift, solved)

    def pose_covariance(self, solved: Array, covariance: Array) -> Array:
        """Return the covariance of a pose in the held frame, including the difference to the solution, shape (3, 3)."""
        c, s = math.cos(self._shift[2]), math.sin(self._shift[2])
        R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        off = self.pose(solved) - solved
        off[2] = wrap_angle(float(off[2]))
        return np.asarray(R @ covariance @ R.T + np.outer(off, off))

    def landmark(self, mean: Array, covariance: Array) -> tuple[Array, Array]:
        """Return a landmark (2,) and its covariance (2, 2) in the held frame."""
        point = np.array([*mean, 0.0])
        spread = np.zeros((3, 3))
        spread[:2, :2] = covariance
        return self.pose(point)[:2], self.pose_covariance(point, spread)[:2, :2]
