"""Constant errors far beyond a data sheet, one at a time or all at once: how well each explains the sightings.

One filter estimates all of them, with large priors. The belief under any other prior follows from it, since errors are
constant: it is the belief after a measurement, by that prior, that the other errors are almost zero. How well the prior
explains the sightings is the ratio of the densities of that measurement after them and before (Savage and Dickey).

References:
    Verdinelli, Wasserman, Computing Bayes Factors Using a Generalization of the Savage-Dickey Density Ratio,
    JASA 90(430), 1995.
"""

import math

import numpy as np

from mjsim.geometry import Array

from ..estimation.odometry_errors import COUNT, DELAY
from ..estimation.range_errors import RANGE_ERRORS
from .ekf_filter import EkfSlamFilter

LARGE_MOTION = 0.05, 0.05, 0.1, DELAY, math.radians(0.5)
"""Standard deviations of large errors of odometry: those of `OdometryErrors`, and a turn at rest [rad/s]."""
LARGE_SENSOR = 0.1, 0.04, math.radians(2.0)
"""Those of large errors of sightings: offset [m] and relative error of ranges, and offset of bearings [rad]."""
LARGE = np.array(LARGE_MOTION + LARGE_SENSOR) ** 2
DISTANCE, VEER, TURN, DELAYED, DRIFT, OFFSET, SCALE, BEARING = range(len(LARGE))
KINDS = ((DISTANCE,), (VEER,), (TURN,), (DRIFT,), (OFFSET, SCALE), (BEARING,), tuple(range(len(LARGE))))
"""Which errors are large together: one of odometry, those of ranges, that of bearings, or all."""
NEGLIGIBLE = 1e-6
"""Minimum variance of an error that is not large, in proportion to a large one."""
CAPPED = 1.0
"""Maximum evidence from one update: constant errors show in every update, spinning wheels only in a few."""


class LargeErrors:
    """A filter with large errors, from which the beliefs for only some large errors follow."""

    def __init__(self, slam: EkfSlamFilter) -> None:
        """Begin with a filter that has parameters for `LARGE_MOTION` and `LARGE_SENSOR`, and no landmarks."""
        self.slam = slam
        self.evidence = np.zeros(len(KINDS))
        """Logarithm of the Bayes factor of each of `KINDS` against a filter with usual errors; at most 1 per update."""
        self._usual = np.zeros(len(LARGE))
        self._likelihood, self._before, self._begun = 0.0, np.zeros(len(KINDS)), False
        slam.assume(np.array(LARGE_SENSOR) ** 2)

    def begin(self) -> Array | None:
        """Return the prior variances of the motion's errors at the first call, later None."""
        begun, self._begun = self._begun, True
        return None if begun else np.array(LARGE_MOTION) ** 2

    def gain(self, variances: Array) -> None:
        """Add to the variances of usual errors of odometry, shape (4,)."""
        self._usual[:COUNT] += variances

    def expect_ranges(self, variances: Array) -> None:
        """Set the prior variances of usual errors of ranges, shape (2,)."""
        self._usual[OFFSET : OFFSET + RANGE_ERRORS] = variances

    def compare(self, likelihood: float, usual: float) -> None:
        """Take the log-likelihoods of an update by this filter and by one with usual errors."""
        self._likelihood += likelihood - usual
        _, ratios = self._conditions()
        explained = self._likelihood + ratios
        self.evidence += np.minimum(explained - self._before, CAPPED)
        self._before = explained

    def averaged(self, shares: Array) -> tuple[Array, Array]:
        """Return mean (m,) and covariance (m, m) of pose, errors and landmarks over `KINDS`, by their shares."""
        slam, size = self.slam, self.slam._size
        errors = slice(3, slam._base)
        weights, _ = self._conditions()
        across = slam._P[:size, errors]
        steps = -across @ (weights @ slam._mean[errors]).T  # (m, kinds)
        step = steps @ shares
        apart = steps - step[:, None]
        P = slam._P[:size, :size] - across @ np.tensordot(shares, weights, 1) @ across.T
        return slam._mean[:size] + step, P + (apart * shares) @ apart.T

    def _conditions(self) -> tuple[Array, Array]:
        """Return the pseudo-measurement that the other errors are of usual size, for each of `KINDS`.

        Returns:
            A: The mean changes by -P_e A e and the covariance by -P_e A P_e^T, with P_e the covariance of
                everything with the errors e; shape (kinds, 8, 8).
            ratios: Logarithm of the density of the measurement after the sightings over that before, shape (kinds,).
        """
        errors = slice(3, self.slam._base)
        mean, P = self.slam._mean[errors], self.slam._P[errors, errors]
        information = np.maximum(1.0 / np.maximum(self._usual, NEGLIGIBLE * LARGE) - 1.0 / LARGE, 0.0)
        added = np.where(_IS_LARGE, 0.0, information)
        grown = np.eye(len(LARGE)) + P * added[:, None, :]
        A = added[:, :, None] * np.linalg.inv(grown)
        ratios = -np.einsum("i,kij,j->k", mean, A, mean) - np.linalg.slogdet(grown)[1]
        return A, 0.5 * (ratios + np.log1p(LARGE * added).sum(axis=1))


_IS_LARGE = np.array([[error in kind for error in range(len(LARGE))] for kind in KINDS])
