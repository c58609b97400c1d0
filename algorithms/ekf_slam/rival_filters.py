"""The same filter with constant errors of odometry and sensor and without: which of the two the sightings support.

Estimating errors that are none costs accuracy, and assuming none where there are some costs more. Both filters get the
same data, and the belief is their average. The one without errors counts only once the data have spoken for it: with
little evidence an average would be no better than its worse half.
"""

import copy
import math
from collections.abc import Callable, Hashable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from mjsim.geometry import Array, wrap_angle

from ..estimation.ekf_models import MotionModel
from .ekf_filter import EkfSlamFilter

POSITIVE = 1.0
"""Logarithm of the Bayes factor from which evidence is positive (Kass, Raftery, Bayes Factors, JASA 90, 1995)."""
DECIDED = 20.0
"""Logarithm of the Bayes factor against the filter without errors after which it is given up."""
SMALL = 1e-3
"""Least probability that counts."""


class RivalFilters:
    """A filter that estimates constant errors of odometry, and perhaps a rival that has none.

    References:
        Magill, Optimal Adaptive Estimation of Sampled Stochastic Processes, IEEE TAC 10(4), 1965: filters in parallel,
        averaged by their likelihoods.
    """

    def __init__(self, leading: EkfSlamFilter, rival: EkfSlamFilter | None) -> None:
        """Start with equal filters; without a rival, `leading` is the belief."""
        self.leading = leading
        self._rival = rival
        self._evidence, self._most = 0.0, 0.0

    def change(self, action: Callable[[EkfSlamFilter], None]) -> None:
        """Change both filters."""
        action(self.leading)
        if self._rival is not None:
            action(self._rival)

    def predict(self, motion: MotionModel, moved: ArrayLike, covariance: Array, *, errors: tuple[Array, ...]) -> None:
        """Move the pose.

        Args:
            motion: As in `EkfSlamFilter.predict`.
            moved: (forward, left, turn) by odometry, shape (3,).
            covariance: Of that, shape (3, 3).
            errors: Result of `OdometryErrors.step`: control, slopes and increase of the variances.
        """
        control, slopes, gained = errors
        self.leading.predict(motion, control, covariance, slopes=slopes, wander=gained)
        if self._rival is not None:
            self._rival.predict(motion, moved, covariance)

    def update(self, names: Sequence[Hashable], measurements: ArrayLike, covariance: ArrayLike) -> None:
        """Correct by simultaneous sightings, as `EkfSlamFilter.update`; they show which filter expected them better."""
        likelihood = self.leading.update(names, measurements, covariance)
        if self._rival is None:
            return
        self._evidence += self._rival.update(names, measurements, covariance) - likelihood
        self._most = max(self._most, self._evidence)
        if self._evidence < -DECIDED:
            self._rival = None

    @property
    def without_errors(self) -> float:
        """Probability that there are no constant errors, if the data have spoken for that; otherwise 0."""
        if self._rival is None or self._most < POSITIVE:
            return 0.0
        return 1.0 / (1.0 + math.exp(-min(self._evidence, 700.0)))

    def believed(self) -> EkfSlamFilter:
        """Return the belief averaged over both filters by their probabilities, to be read only."""
        share = self.without_errors
        if self._rival is None or share < SMALL:
            return self.leading
        return averaged(self.leading, self._rival, share=share)


def averaged(one: EkfSlamFilter, other: EkfSlamFilter, *, share: float) -> EkfSlamFilter:
    """Return mean and covariance of a mixture of two filters with the same landmarks; `share` is that of the other."""
    size = one._size
    apart = other._mean[:size] - one._mean[:size]
    apart[2] = wrap_angle(float(apart[2]))
    average = copy.copy(one)
    average._mean = one._mean[:size] + share * apart
    average._mean[2] = wrap_angle(float(average._mean[2]))
    P = (1.0 - share) * one._P[:size, :size] + share * other._P[:size, :size]
    average._P = P + share * (1.0 - share) * np.outer(apart, apart)
    return average
