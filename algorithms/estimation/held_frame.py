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
import scipy.linalg

from mjsim.geometry import Array, wrap_angle

from .pose_graph import compose
from .relocation import fitted

UNSURE = math.radians(3.0)
"""The frame is held while the standard deviation of the heading exceeds this [rad]. With less, small rooms would keep
the errors of their first sightings; at 5 m it amounts to 0.3 m, the distance that robots keep from walls."""
MIN_EXTENT = 0.5
"""Extent that the reported positions must have before a rotation is fitted to them [m]."""


class HeldFrame:
    """Reports poses of a map in a frame that agrees with earlier reports."""

    def __init__(self, pose: Array, *, release: bool = True) -> None:
        """Begin with the first pose, shape (3,), reported unchanged.

        Args:
            pose: First pose.
            release: Whether the frame is given up, with a jump, once the heading is known.
        """
        self._reported = np.zeros((64, 2))
        self._reported[0] = pose[:2]
        self._count = 1
        self._shift = np.zeros(3)
        self._release, self._held = release, False

    @property
    def is_shifted(self) -> bool:
        """Whether reports differ from the solution."""
        return bool(self._shift.any())

    def add(self, solved: Array, deviation: float) -> None:
        """Update the frame with a solution that has one more pose.

        Args:
            solved: All poses, shape (n, 3), the newest last.
            deviation: Standard deviation of the newest heading, relative to the first pose [rad].
        """
        self.hold(solved[:-1, :2], deviation)
        self.report(solved[-1])

    def hold(self, solved: Array, deviation: float) -> None:
        """Fit the frame to the positions reported before.

        Args:
            solved: The same positions in the newest solution, shape (n, 2).
            deviation: Standard deviation of the newest heading, relative to the first pose [rad].
        """
        before = self._reported[: self._count]
        self._held = deviation >= UNSURE or (self._held and not self._release)
        if not self._held:
            self._shift = np.zeros(3)
        elif np.ptp(before, axis=0).max() > MIN_EXTENT:
            self._shift = fitted(solved, before)

    def report(self, solved: Array) -> None:
        """Remember where a pose (3,) of the solution is reported."""
        if self._count == len(self._reported):
            self._reported = np.concatenate([self._reported, np.zeros_like(self._reported)])
        self._reported[self._count] = self.pose(solved)[:2]
        self._count += 1

    def thin(self) -> None:
        """Forget every other reported position, but not the first."""
        remaining = self._reported[: self._count : 2]
        self._count = len(remaining)
        self._reported[: self._count] = remaining

    def pose(self, solved: Array) -> Array:
        """Return a pose in the held frame, shape (3,)."""
        return compose(self._shift, solved)

    def pose_covariance(self, solved: Array, covariance: Array) -> Array:
        """Return the covariance of a pose in the held frame, including the difference to the solution, shape (3, 3)."""
        R, offset = self._rotation(), self._offset(solved)
        return np.asarray(R @ covariance @ R.T + np.outer(offset, offset))

    def landmark(self, mean: Array, covariance: Array) -> tuple[Array, Array]:
        """Return a landmark (2,) and its covariance (2, 2) in the held frame."""
        point = np.array([*mean, 0.0])
        padded = np.zeros((3, 3))
        padded[:2, :2] = covariance
        return self.pose(point)[:2], self.pose_covariance(point, padded)[:2, :2]

    def places(self, means: Array, covariances: Array) -> tuple[Array, Array]:
        """Return landmarks (n, 2) and their covariances (n, 2, 2) in the held frame, as `landmark` has each."""
        R = self._rotation()[:2, :2]
        held = means @ R.T + self._shift[:2]
        offsets = held - means
        return held, R @ covariances @ R.T + offsets[:, :, None] * offsets[:, None, :]

    def joint_covariance(self, pose: Array, points: Array, covariance: Array) -> Array:
        """Return the covariance of a pose (3,) and points (n, 2) together in the held frame, shape (3 + 2 n, 3 + 2 n).

        The differences to the solution are included, as in that of each.
        """
        R = self._rotation()
        turned = scipy.linalg.block_diag(R, np.kron(np.eye(len(points)), R[:2, :2]))
        offsets = np.concatenate([self._offset(pose), (points @ R[:2, :2].T + self._shift[:2] - points).ravel()])
        return np.asarray(turned @ covariance @ turned.T + np.outer(offsets, offsets))

    def _offset(self, solved: Array) -> Array:
        """Return the offset of a reported pose, shape (3,)."""
        offset = self.pose(solved) - solved
        offset[2] = wrap_angle(float(offset[2]))
        return np.asarray(offset)

    def _rotation(self) -> Array:
        c, s = math.cos(self._shift[2]), math.sin(self._shift[2])
        return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
