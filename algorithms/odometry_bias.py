"""What odometry errs by all the time, in length and in heading, learnt from how scans lie on one another."""

import numpy as np

from mjsim.geometry import Array

PRIOR = np.array([0.05, 0.05, 0.01, 0.005])
"""Standard deviations of what a robot's odometry errs by: share of the way, share of the turn, turn for each metre
[rad/m], turn for each second that it moves [rad/s]."""
DRIFT = 0.01
"""Of those standard deviations, by what share they may change from one scan to the next; tyres and floors do."""
GATE = 9.0
"""A step that is farther off, in units squared, is a slip and teaches nothing."""


class OdometryBias:
    """Estimates what odometry errs by, a Kalman filter of four states that changes slowly.

    References:
        Martinelli, Tomatis, Siegwart, Simultaneous Localization and Odometry Self Calibration for Mobile Robot,
        Autonomous Robots 22, 2007.
    """

    def __init__(self) -> None:
        """Begin with odometry that is right."""
        self._drift = np.diag((DRIFT * PRIOR) ** 2)
        self.errors: Array = np.zeros(4)
        """Share of the way, share of the turn, turn for each metre [rad/m] and for each second [rad/s], shape (4,)."""
        self.covariance: Array = np.diag(PRIOR**2)
        """Of them, shape (4, 4)."""

    def corrected(self, told: Array, seconds: float) -> Array:
        """Return the motion of a tick without what odometry errs by, shape (3,) [m, m, rad].

        Args:
            told: By odometry, shape (3,).
            seconds: How long the robot moved [s].
        """
        return told - _effects(told, float(np.hypot(told[0], told[1])), seconds) @ self.errors

    def learn(self, told: Array, way: float, seconds: float, off: Array, before: Array, after: Array) -> None:
        """Take a step that scans have measured.

        Args:
            told: The step by odometry alone, without corrections, shape (3,) [m, m, rad].
            way: How far the robot drove on it [m].
            seconds: How long it moved [s].
            off: The step by scans and corrected odometry together less that by the latter, shape (3,).
            before: Covariance of the step by corrected odometry, shape (3, 3).
            after: Covariance of the step by both, shape (3, 3).
        """
        self.covariance = self.covariance + self._drift
        by_odometry = np.asarray(np.linalg.inv(before), dtype=float)
        # Information of the difference between scans alone and odometry: (before + scans^-1)^-1.
        information = by_odometry - by_odometry @ after @ by_odometry
        if off @ by_odometry @ off > GATE or np.linalg.eigvalsh(information)[0] < -1e-6 * np.trace(information):
            return
        H = -_effects(told, way, seconds)
        self.covariance = np.asarray(np.linalg.inv(np.linalg.inv(self.covariance) + H.T @ information @ H), dtype=float)
        # The information times the difference, which is larger than `off` where scans tell little.
        self.errors = self.errors + self.covariance @ H.T @ by_odometry @ off


def _effects(step: Array, way: float, seconds: float) -> Array:
    """Return how a step as odometry tells it changes with what that errs by, shape (3, 4)."""
    forward, left, turn = step.tolist()
    effects = np.zeros((3, 4))
    effects[:, 0] = forward, left, 0.0
    effects[2, 1:] = turn, way, seconds
    # A turn that comes evenly moves the end of the step aside by half of it.
    effects[0, 1:], effects[1, 1:] = -0.5 * left * effects[2, 1:], 0.5 * forward * effects[2, 1:]
    return effects
