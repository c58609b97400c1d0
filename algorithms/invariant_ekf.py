"""EKF-SLAM whose errors are measured in the group of poses and landmarks: the right-invariant filter."""

import math

import numpy as np
from numpy.typing import ArrayLike

from mjsim.geometry import Array, wrap_angle

from .ekf_filter import EkfSlamFilter


class InvariantEkfSlamFilter(EkfSlamFilter):
    """The right-invariant EKF: consistent without first estimates, with the newest ones everywhere.

    Pose and landmarks together are an element X of the group SE_(1+n)(2), and the error is e with
    X = exp(e) X_mean, e = (turn, shift, shift of each landmark): the turn is about the world's origin and takes
    robot and landmarks along. In these errors the derivatives of motion and measurement do not depend on where the
    robot believes to be, so nothing can be gained in directions that nobody observes.

    To first order e is a linear map T of the textbook's errors (dx, dy, dheading, dx_1, ...):

        shift = d - J mean * dheading,    J = [[0, -1], [1, 0]]

    which changes with the mean. So this filter keeps P in the textbook's errors, where motion touches three rows
    only, and differs from the standard filter in the correction alone: the mean moves along exp, and P goes from
    the T of the old mean to that of the new, P <- T_new^-1 T_old P (...)^T.

    References:
        Barrau, Bonnabel, An EKF-SLAM Algorithm with Consistency Properties, arXiv:1510.06263, sections 4 and 5.
        Zhang, Wu, Song, Huang, Dissanayake, Convergence and Consistency Analysis for a 3-D Invariant-EKF SLAM,
        IEEE RA-L 2(2), 2017, section II.
    """

    def __init__(self, *, pose: ArrayLike = (0.0, 0.0, 0.0), covariance: ArrayLike | None = None) -> None:
        """Start without landmarks.

        Args:
            pose: Mean of (x, y, heading), shape (3,) [m, m, rad].
            covariance: Of the pose, shape (3, 3); None for zeros, which makes the start the origin of the map.
        """
        super().__init__(jacobians="standard", pose=pose, covariance=covariance)

    def _move(self, step: Array) -> None:
        """Move the mean along the exponential of the correction, and P to the errors about the new mean."""
        size, turn = self._size, float(step[2])
        old = _points(self._mean[:size])
        shifts = _points(step) - turn * _turned_left(old)
        new = old @ _rotation(turn).T + shifts @ _arc(turn).T
        self._mean[2] = wrap_angle(self._mean[2] + turn)
        _set_points(self._mean[:size], new)
        self._shear(_turned_left(new - old))

    def _shear(self, moved: Array) -> None:
        """Add to the error of each point, shape (1 + n, 2) [m/rad] times the error of the heading: P <- S P S^T."""
        size = self._size
        P, column = self._P[:size, :size], np.zeros(size)
        _set_points(column, moved)
        heading = P[2] + 0.5 * P[2, 2] * column
        pair, gain = np.stack([column, heading]), self._spare[: size * size].reshape(size, size)
        P += np.matmul(pair.T, pair[::-1], out=gain)


def _points(state: Array) -> Array:
    """Return the position and the landmarks of (x, y, heading, x_1, y_1, ...), shape (1 + n, 2)."""
    return np.concatenate([state[:2], state[3:]]).reshape(-1, 2)


def _set_points(state: Array, points: Array) -> None:
    state[:2], state[3:] = points[0], points[1:].ravel()


def _turned_left(points: Array) -> Array:
    """Return J times each point, shape (n, 2)."""
    return np.stack([-points[:, 1], points[:, 0]], axis=-1)


def _rotation(turn: float) -> Array:
    c, s = math.cos(turn), math.sin(turn)
    return np.array([[c, -s], [s, c]])


def _arc(turn: float) -> Array:
    """Return the integral of the rotation over the turn, shape (2, 2); Barrau and Bonnabel, appendix A."""
    if abs(turn) < 1e-6:
        along, across = 1.0, turn / 2
    else:
        along, across = math.sin(turn) / turn, (1.0 - math.cos(turn)) / turn
    return np.array([[along, -across], [across, along]])
