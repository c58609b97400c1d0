"""Right-invariant EKF-SLAM: errors are defined in the Lie group of pose and landmarks."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mjsim.geometry import Array, wrap_angle

from .ekf_filter import EkfSlamFilter
from .ekf_group import derivatives_by_step, moved_along, shear, turned_left


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
        sensor: int = 0,
        far: float = math.inf,
    ) -> None:
        """Start without landmarks.

        Args:
            pose: Mean of (x, y, heading), shape (3,) [m, m, rad].
            covariance: Covariance of the pose (3, 3); None for zeros, which makes the start the origin of the map.
            parameters: Number of the motion's constant errors; their errors are differences, as in the textbook.
            sensor: Number of errors of sightings, as in `EkfSlamFilter`.
            far: Limit above which a correction is iterated, as in `EkfSlamFilter` [rad].
        """
        super().__init__(
            jacobians="standard", pose=pose, covariance=covariance, parameters=parameters, sensor=sensor, far=far
        )

    def _apply(self, step: Array, W: Array) -> None:
        """Move the mean along the exponential of the correction, and P to the errors about the new mean."""
        rows, new = self._point_rows(), self._moved(step)
        moved = turned_left(new[rows] - self._mean[rows])
        self._mean[: self._size] = new
        self._mean[2] = wrap_angle(self._mean[2])
        shear(self._P[: self._size, : self._size], moved, rows, W, self._spare)

    def _moved(self, step: Array) -> Array:
        """Return the mean after a step along the exponential, shape (3 + p + 2 n,)."""
        return moved_along(self._mean[: self._size], step, self._point_rows())

    def _by_step(self, H_pose: Array, H_landmark: Array, step: Array, columns: NDArray[np.intp]) -> tuple[Array, Array]:
        """Return derivatives by the step that has led here."""
        return derivatives_by_step(self._mean, step, columns, H_pose, H_landmark)
