"""Right-invariant EKF-SLAM: errors are defined in the Lie group of pose and landmarks."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mjsim.geometry import Array, wrap_angle

from .ekf_filter import EkfSlamFilter

BLOCK = 64
"""Rows of P that are changed at a time, so that they stay in the processor's cache."""


class InvariantEkfSlamFilter(EkfSlamFilter):
    """The right-invariant EKF: consistent with Jacobians at the newest estimates.

    Pose and landmarks together are an element X of the group SE_(1+n)(2), and the error is e with X = exp(e) X_mean, e
    = (turn, shift, shift of each landmark): the turn is about the world's origin and moves robot and landmarks
    together. For these errors the Jacobians of motion and measurement do not depend on the estimated pose, so the
    filter cannot gain spurious information in unobservable directions.

    To first order e is a linear map T of the textbook's errors (dx, dy, dheading, dx_1, ...):

        shift = d - J mean * dheading,    J = [[0, -1], [1, 0]]

    which changes with the mean. This filter therefore keeps P in the textbook's errors, where motion changes only three
    rows, and differs from the standard filter only in the correction: the mean moves along exp, and P goes from
    the T of the old mean to that of the new, P <- T_new^-1 T_old P (...)^T.

    References:
        Barrau, Bonnabel, An EKF-SLAM Algorithm with Consistency Properties, arXiv:1510.06263, sections 4 and 5.
        Zhang, Wu, Song, Huang, Dissanayake, Convergence and Consistency Analysis for a 3-D Invariant-EKF SLAM,
        IEEE RA-L 2(2), 2017, section II.
    """

    def __init__(
        self,
        *,
        pose: ArrayLike = (0.0, 0.0, 0.0),
        covariance: ArrayLike | None = None,
        parameters: int = 0,
        far: float = math.inf,
    ) -> None:
        """Start without landmarks.

        Args:
            pose: Mean of (x, y, heading), shape (3,) [m, m, rad].
            covariance: Of the pose, shape (3, 3); None for zeros, which makes the start the origin of the map.
            parameters: Number of the motion's constant errors; their errors are differences, as in the textbook.
            far: Limit above which a correction is iterated, as in `EkfSlamFilter` [rad].
        """
        super().__init__(jacobians="standard", pose=pose, covariance=covariance, parameters=parameters, far=far)

    def _apply(self, step: Array, W: Array) -> None:
        """Move the mean along the exponential of the correction, and P to the errors about the new mean."""
        rows, new = self._point_rows(), self._moved(step)
        moved = _turned_left(new[rows] - self._mean[rows])
        self._mean[: self._size] = new
        self._mean[2] = wrap_angle(self._mean[2])
        self._shear(moved, W)

    def _moved(self, step: Array) -> Array:
        """Return the mean after a step along the exponential, shape (3 + p + 2 n,)."""
        turn, rows, new = float(step[2]), self._point_rows(), self._mean[: self._size] + step
        old = self._mean[rows]
        shifts = step[rows] - turn * _turned_left(old)
        new[rows] = old @ _rotation(turn).T + shifts @ _arc(turn).T
        return np.asarray(new)

    def _by_step(self, H_pose: Array, H_landmark: Array, step: Array, columns: NDArray[np.intp]) -> tuple[Array, Array]:
        """Return H times the derivative of R p + V (d - J p turn), to which the step has moved a point p."""
        turn, rows = float(step[2]), np.concatenate([np.arange(2)[None], columns])
        old, V = self._mean[rows], _arc(turn)
        shifts = step[rows] - turn * _turned_left(old)
        by_turn = _turned_left(old) @ (_rotation(turn) - V).T + shifts @ _arc_slope(turn).T
        by_pose = np.array(H_pose)
        by_pose[:, :, :2] = H_pose[:, :, :2] @ V
        by_pose[:, :, 2] += H_pose[:, :, :2] @ by_turn[0] + np.einsum("kij,kj->ki", H_landmark, by_turn[1:])
        return by_pose, H_landmark @ V

    def _point_rows(self) -> NDArray[np.intp]:
        """Return the indices of x and y of the position and the landmarks in the state, shape (1 + n, 2)."""
        return np.concatenate([np.arange(2), np.arange(self._base, self._size)]).reshape(-1, 2)

    def _shear(self, moved: Array, W: Array) -> None:
        """Subtract W^T W from P, then add `moved` times the heading's error to that of each point: P <- S P S^T.

        With c the column of S and h the heading's row of P, S P S^T = P + c h^T + h c^T, with half of its own multiple
        of c included in h. That is P + u u^T - v v^T, which is symmetric to the last bit and takes one pass over P.

        Args:
            moved: Of position and landmarks, shape (1 + n, 2) [m/rad].
            W: Shape (m, 3 + p + 2 n).
        """
        size, column = self._size, np.zeros(self._size)
        column[self._point_rows()] = moved
        P, loss = self._P[:size, :size], self._spare[: size * size].reshape(size, size)
        heading = P[2] - W[:, 2] @ W
        heading += 0.5 * heading[2] * column
        # Brought to one size, so that as little as can be is lost where u u^T and v v^T are nearly alike.
        sizes = float(np.linalg.norm(column)), float(np.linalg.norm(heading))
        scale = math.sqrt(sizes[0] / sizes[1]) if all(sizes) else 1.0
        along, across = column / scale, heading * scale
        u, v = (along + across) / math.sqrt(2.0), (along - across) / math.sqrt(2.0)
        taken = np.vstack([W, v])
        np.matmul(taken.T, taken, out=loss)
        given = np.empty((BLOCK, size))
        for start in range(0, size, BLOCK):
            rows = slice(start, min(start + BLOCK, size))
            block = np.multiply(u[rows, None], u, out=given[: rows.stop - start])
            block -= loss[rows]
            P[rows] += block


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


def _arc_slope(turn: float) -> Array:
    """Return the derivative of `_arc` by the turn, shape (2, 2)."""
    if abs(turn) < 1e-4:
        along, across = -turn / 3, 0.5
    else:
        c, s = math.cos(turn), math.sin(turn)
        along, across = (turn * c - s) / turn**2, (turn * s + c - 1.0) / turn**2
    return np.array([[along, -across], [across, along]])
