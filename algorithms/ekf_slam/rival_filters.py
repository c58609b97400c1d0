"""The same filter with constant errors of odometry and sensor and without: which of the two the sightings support.

Estimating errors that are none costs accuracy, and assuming none where there are some costs more. Both filters get the
same data, and the belief is their average. The one without errors counts only once the data have spoken for it: with
little evidence an average would be no better than its worse half.

Both assume errors in proportion to the stated noise. A third filter assumes that odometry and sensor may err by far
more than their data sheets say. As long as the sightings do not contradict it, the covariance of the belief includes
it; the mean is that of this filter only once the sightings have disproved the data sheets.
"""

import copy
import math
from collections.abc import Callable, Hashable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from mjsim.geometry import Array, wrap_angle

from ..estimation.ekf_models import MotionModel
from ..estimation.odometry_errors import DELAY
from .ekf_filter import EkfSlamFilter

POSITIVE = 1.0
"""Logarithm of the Bayes factor from which evidence is positive (Kass, Raftery, Bayes Factors, JASA 90, 1995)."""
DECIDED = 20.0
"""Logarithm of the Bayes factor against the filter without errors after which it is given up."""
SMALL = 1e-3
"""Least probability that counts."""
PROVEN = 7.0
"""Logarithm of the Bayes factor that disproves a filter. If it is right, it is ever exceeded in one of exp(7) = 1100
runs at most (Ville's inequality)."""
CAPPED = 1.0
"""Most that one look adds to that: constant errors show in every look, but wheels that spin once in a few."""
SUSPECTED = 0.05
"""Prior odds of large errors; even once the sightings have disproved that there are none."""
LARGE_MOTION = 0.05, 0.05, 0.1, DELAY, math.radians(0.5)
"""Standard deviations of large errors of odometry: those of `OdometryErrors`, and a turn at rest [rad/s]."""
LARGE_SENSOR = 0.1, 0.04, math.radians(2.0)
"""Those of large errors of sightings: offset [m] and relative error of ranges, and offset of bearings [rad]."""


class RivalFilters:
    """A filter that estimates constant errors of odometry, and perhaps a rival that has none.

    References:
        Magill, Optimal Adaptive Estimation of Sampled Stochastic Processes, IEEE TAC 10(4), 1965: filters in parallel,
        averaged by their likelihoods.
    """

    def __init__(self, leading: EkfSlamFilter, rival: EkfSlamFilter | None, wide: EkfSlamFilter | None = None) -> None:
        """Start with equal filters; without a rival, `leading` is the belief.

        Args:
            leading: With errors of odometry.
            rival: Without them.
            wide: With `LARGE_MOTION` and `LARGE_SENSOR` errors.
        """
        self._sheet, self._rival, self._wide = leading, rival, wide
        self._evidence, self._most, self._doubt, self._against = 0.0, 0.0, 0.0, 0.0
        self.is_wide, self._fresh = False, True
        """Whether the belief has large errors."""
        if wide is not None:
            wide.assume(np.array(LARGE_SENSOR) ** 2)

    @property
    def leading(self) -> EkfSlamFilter:
        """The filter that is believed, but for the average."""
        return self._wide if self.is_wide and self._wide is not None else self._sheet

    def change(self, action: Callable[[EkfSlamFilter], None]) -> None:
        """Change all filters."""
        self.change_usual(action)
        if self._wide is not None:
            action(self._wide)

    def change_usual(self, action: Callable[[EkfSlamFilter], None]) -> None:
        """Change those without large errors."""
        action(self._sheet)
        if self._rival is not None:
            action(self._rival)

    def predict(
        self,
        motion: MotionModel,
        moved: ArrayLike,
        covariance: Array,
        *,
        errors: tuple[Array, ...],
        seconds: float = 0.0,
    ) -> None:
        """Move the pose.

        Args:
            motion: As in `EkfSlamFilter.predict`.
            moved: (forward, left, turn) by odometry, shape (3,).
            covariance: Of that, shape (3, 3).
            errors: Result of `OdometryErrors.step`: control, slopes and increase of the variances.
            seconds: Period [s].
        """
        control, slopes, gained = errors
        self._sheet.predict(motion, control, covariance, slopes=slopes, wander=gained)
        if self._rival is not None:
            self._rival.predict(motion, moved, covariance)
        if self._wide is not None:
            wander = np.array(LARGE_MOTION) ** 2 if self._fresh else None
            large = np.column_stack([slopes, [0.0, 0.0, seconds]])
            self._wide.predict(motion, control, covariance, slopes=large, wander=wander)
            self._fresh = False

    def update(self, names: Sequence[Hashable], measurements: ArrayLike, covariance: ArrayLike) -> None:
        """Correct by simultaneous sightings, as `EkfSlamFilter.update`; they show which filter expected them better."""
        likelihood = self._sheet.update(names, measurements, covariance)
        if self._rival is not None:
            better = self._rival.update(names, measurements, covariance) - likelihood
            self._evidence += better
            self._against -= max(better, -CAPPED)
            self._most = max(self._most, self._evidence)
            if self._evidence < -DECIDED:
                self._rival = None
        if self._wide is not None:
            self._doubt += min(self._wide.update(names, measurements, covariance) - likelihood, CAPPED)
            self._choose()

    def _choose(self) -> None:
        """Decide whether large errors are believed."""
        if self._doubt < -DECIDED:
            self._wide = None
        better = self._doubt - max(self._evidence, 0.0)
        self.is_wide = self._wide is not None and better > (0.0 if self.is_wide else PROVEN)

    @property
    def without_errors(self) -> float:
        """Probability that there are no constant errors, if the data have spoken for that; otherwise 0."""
        if self._rival is None or self._most < POSITIVE or self.is_wide:
            return 0.0
        return 1.0 / (1.0 + math.exp(-min(self._evidence, 700.0)))

    def believed(self) -> EkfSlamFilter:
        """Return the belief averaged over both filters by their probabilities, to be read only."""
        share = self.without_errors
        if self._rival is None or share < SMALL:
            return self.leading
        return averaged(self.leading, self._rival, share=share)

    def suspected(self, believed: EkfSlamFilter) -> EkfSlamFilter:
        """Return the belief with the covariance that it has if errors may be large, or usual; to be read only."""
        odds = 1.0 if self._against > PROVEN and not self.is_wide else SUSPECTED
        better = self._doubt - max(self._evidence, 0.0)
        odds *= math.exp(min(-better if self.is_wide else better, 20.0))
        other = self._sheet if self.is_wide else self._wide
        if other is None or odds < SMALL or not self._doubt:  # Without sightings, nothing is doubted.
            return believed
        rows, own = (np.concatenate([np.arange(3), np.arange(slam._base, slam._size)]) for slam in (other, believed))
        apart = other._mean[rows] - believed._mean[own]
        apart[2] = wrap_angle(float(apart[2]))
        doubted = copy.copy(believed)
        doubted._P = believed._P[: believed._size, : believed._size].copy()
        doubted._P[np.ix_(own, own)] += odds / (1.0 + odds) * (other._P[np.ix_(rows, rows)] + np.outer(apart, apart))
        return doubted


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
