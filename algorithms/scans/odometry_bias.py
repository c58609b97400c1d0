"""Systematic errors of odometry, in distance, heading and centre of rotation, estimated from scan matches."""

import math

import numpy as np

from mjsim.geometry import Array

from ..estimation.pose_matrices import inverse

PRIOR = np.array([0.05, 0.05, 0.01, 0.02, 0.1, 0.05])
"""Prior standard deviations of the errors of odometry: relative error of distance, relative error of turn, turn per
metre [rad/m], turn per second of motion [rad/s], and position of the origin of the robot's frame relative to the centre
of its rotation, ahead and to the left [m]: many logs do not state where the lidar is mounted."""
COUNT = len(PRIOR)
"""Number of the errors."""
DRIFT = 0.01
"""Random walk of the errors per scan, relative to those standard deviations, because tyres and floors change."""
CLEAR = 0.1
"""Directions with less than this ratio of the largest information are ignored when learning."""
GATE = 9.0
"""Normalised squared error above which a step is a slip and is ignored."""


class OdometryBias:
    """Estimates the errors of odometry, a Kalman filter of six states that changes slowly.

    References:
        Martinelli, Tomatis, Siegwart, Simultaneous Localization and Odometry Self Calibration for Mobile Robot,
        Autonomous Robots 22, 2007.
    """

    def __init__(self) -> None:
        """Start without errors."""
        self._drift = np.diag((DRIFT * PRIOR) ** 2)
        self.errors: Array = np.zeros(COUNT)
        """In the order of `PRIOR`, shape (6,)."""
        self.covariance: Array = np.diag(PRIOR**2)
        """Covariance of the errors, shape (6, 6)."""

    def corrected(self, step: Array, seconds: float) -> Array:
        """Return the motion of a tick without the errors of odometry, shape (3,) [m, m, rad].

        Args:
            step: Motion by odometry, shape (3,).
            seconds: How long the robot moved [s].
        """
        return step - _effects(step, float(np.hypot(step[0], step[1])), seconds) @ self.errors

    def slopes(self, step: Array, distance: float, seconds: float) -> Array:
        """Return the derivative of a corrected step by the errors of odometry, shape (3, 6).

        Args:
            step: The step by odometry alone, shape (3,) [m, m, rad].
            distance: How far the robot drove on it [m].
            seconds: How long it moved [s].
        """
        return -_effects(step, distance, seconds)

    def step_covariance(self, step: Array, distance: float, seconds: float) -> Array:
        """Return the covariance of a step from the uncertainty of the systematic errors, shape (3, 3).

        Args:
            step: The step by odometry alone, shape (3,) [m, m, rad].
            distance: How far the robot drove on it [m].
            seconds: How long it moved [s].
        """
        H = _effects(step, distance, seconds)
        return np.asarray(H @ self.covariance @ H.T)

    def learn(
        self, step: Array, distance: float, seconds: float, correction: Array, noise: Array, after: Array
    ) -> None:
        """Update the errors with a step measured by scans.

        Args:
            step: The step by odometry alone, without corrections, shape (3,) [m, m, rad].
            distance: How far the robot drove on it [m].
            seconds: How long it moved [s].
            correction: The step by scans and corrected odometry together less that by the latter, shape (3,).
            noise: Covariance of the step by corrected odometry, `step_covariance` left out, shape (3, 3).
            after: Covariance of the step by scans and odometry, `step_covariance` included, shape (3, 3).
        """
        H = -_effects(step, distance, seconds)
        by_odometry = inverse(noise + H @ self.covariance @ H.T)
        by_both = inverse(after)
        scan_information = by_both - by_odometry
        if correction @ by_odometry @ correction <= GATE and np.linalg.eigvalsh(scan_information)[0] >= 0.0:
            # Errors are relative to the measured step. The step by odometry contains its noise: a turn that is only
            # noise on a straight path would make all turns seem overestimated.
            H = -_effects(step + H @ self.errors + correction, distance, seconds)
            clear = _clear(scan_information)
            # Between scans alone and odometry: information of the difference, and that times the difference itself,
            # which is larger than `correction` where scans have little information.
            both = np.eye(3) + clear @ scan_information @ clear @ noise
            information = np.linalg.solve(both, clear @ scan_information @ clear)
            known = np.linalg.inv(self.covariance) + H.T @ information @ H
            self.covariance = np.asarray(np.linalg.inv(known), dtype=float)
            self.errors = self.errors + self.covariance @ H.T @ np.linalg.solve(both, clear @ by_both @ correction)
        self.covariance = self.covariance + self._drift


def _clear(information: Array) -> Array:
    """Return the projection on directions clearly measured by scans, shape (3, 3); others are noise."""
    values, vectors = np.linalg.eigh(information[:2, :2])
    clear_directions = vectors[:, values >= CLEAR * values[1]]
    clear: Array = np.eye(3)
    clear[:2, :2] = clear_directions @ clear_directions.T
    return clear


def _effects(step: Array, distance: float, seconds: float) -> Array:
    """Return the derivative of a step of odometry by the errors, shape (3, 6)."""
    forward, left, turn = step.tolist()
    c, s = math.cos(turn), math.sin(turn)
    # A turn spread evenly over the step shifts its end sideways by half the turn.
    aside, ahead = -0.5 * left, 0.5 * forward
    # Odometry measures the motion of the centre of rotation: that of the origin less R - I times the arm.
    return np.array(
        [
            [forward, aside * turn, aside * distance, aside * seconds, 1.0 - c, s],
            [left, ahead * turn, ahead * distance, ahead * seconds, -s, 1.0 - c],
            [0.0, turn, distance, seconds, 0.0, 0.0],
        ]
    )
