"""Factors of a gtsam graph: odometry with systematic errors, sightings, and priors."""

from typing import Any

import numpy as np

from mjsim.geometry import Array, wrap_angle
from mjsim.interface import Sighting


def leg_factor(gtsam: Any, keys: tuple[int, int, int], step: Array, covariance: Array, slopes: Array) -> Any:
    """Return the odometry factor between two poses, as a function of its systematic errors.

    Args:
        gtsam: The module.
        keys: Keys of the first pose, the second pose, and the systematic errors (4,).
        step: Second pose in the frame of the first if there are no such errors, shape (3,) [m, m, rad].
        covariance: Of the step, in the frame of the first pose, shape (3, 3).
        slopes: Jacobian of the step by the errors, shape (3, 4).
    """
    one, other, common = keys

    def error(_: Any, values: Any, jacobians: list[Array] | None) -> Array:
        first, second = values.atPose2(one), values.atPose2(other)
        x, y, heading = first.x(), first.y(), first.theta()
        dx, dy, turn = second.x() - x, second.y() - y, second.theta() - heading
        c, s = np.cos(heading), np.sin(heading)
        forward, left = c * dx + s * dy, c * dy - s * dx
        apart = np.array([forward, left, turn]) - step - slopes @ values.atVector(common)
        apart[2] = wrap_angle(float(apart[2]))
        if jacobians is not None:
            # gtsam's increments of a pose are in the frame of that pose.
            c, s = np.cos(turn), np.sin(turn)
            jacobians[0] = np.array([[-1.0, 0.0, left], [0.0, -1.0, -forward], [0.0, 0.0, -1.0]])
            jacobians[1] = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
            jacobians[2] = -slopes
        return np.asarray(apart)

    return gtsam.CustomFactor(gtsam.noiseModel.Gaussian.Covariance(covariance), list(keys), error)


def look_factor(gtsam: Any, keys: tuple[int, int], look: Sighting, covariance: Array, loss: Any) -> Any:
    """Return the factor of a sighting from a pose to a landmark.

    Args:
        gtsam: The module.
        keys: Keys of the pose and the landmark.
        look: The measurement.
        covariance: Of range and bearing, shape (2, 2).
        loss: A robust loss of gtsam's `noiseModel.mEstimator`.
    """
    noise = gtsam.noiseModel
    # gtsam puts bearing before range.
    robust = noise.Robust.Create(loss, noise.Gaussian.Covariance(np.asarray(covariance)[::-1, ::-1]))
    return gtsam.BearingRangeFactor2D(*keys, gtsam.Rot2(look.bearing), look.range, robust)


def prior_factor(gtsam: Any, key: int, pose: Array, covariance: Array) -> Any:
    """Return the prior of a pose (3,) with a covariance (3, 3) in the world frame."""
    noise = gtsam.noiseModel.Gaussian.Covariance(turned_covariance(covariance, -float(pose[2])))
    return gtsam.PriorFactorPose2(key, gtsam.Pose2(*pose), noise)


def turned_covariance(covariance: Array, angle: float) -> Array:
    """Return a covariance (3, 3) of (x, y, heading), rotated by an angle [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(R @ covariance @ R.T)
