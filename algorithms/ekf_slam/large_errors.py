"""Constant errors far beyond a data sheet, one at a time or all at once: a filter that estimates them all."""

import numpy as np

from mjsim.geometry import Array

from ..estimation.constant_errors import (
    CAPPED,
    KINDS,
    LARGE,
    LARGE_MOTION,
    LARGE_SENSOR,
    OFFSET,
    averaged,
    reweighted,
    with_large,
)
from ..estimation.odometry_errors import COUNT
from ..estimation.range_errors import RANGE_ERRORS
from .ekf_filter import EkfSlamFilter


class LargeErrors:
    """A filter with large errors, and the beliefs if only some of them are large (`constant_errors`)."""

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
        """Update the evidence with the log-likelihoods of an update by this filter and by one with usual errors."""
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
        step, P = averaged(slam._P[:size, :size], slam._P[:size, errors], slam._mean[errors], weights, shares)
        return slam._mean[:size] + step, P

    def _conditions(self) -> tuple[Array, Array]:
        """Return how the belief changes if the other errors are of usual size, for each of `KINDS`."""
        errors = slice(3, self.slam._base)
        return reweighted(self.slam._mean[errors], self.slam._P[errors, errors], LARGE, with_large(self._usual))
