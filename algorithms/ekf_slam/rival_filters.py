"""Runs the same filter under several assumptions on odometry and sensor, weighted by how well they fit the sightings.

Estimating errors that do not exist costs accuracy, and ignoring existing ones costs more. All filters get the same
data, and the belief is their average. The one without errors counts only once the data support it: with little evidence
an average would be no better than its worse half.

Two filters assume errors in proportion to the stated noise, or none. Another assumes that odometry is rougher than
stated, such as with wheels that spin now and then, and another that odometry and sensor err by far more than stated,
each in one way or in all at once (`LargeErrors`). With usual sensors their probabilities remain too small to count.
"""

import copy
import math
from collections.abc import Callable, Hashable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from mjsim.geometry import Array, wrap_angle

from ..estimation.constant_errors import DECIDED, DISPROVED, DOUBTED, KINDS, LARGE_ODDS, POSITIVE
from ..estimation.ekf_models import MotionModel
from .ekf_filter import EkfSlamFilter
from .large_errors import LargeErrors

SMALL = 1e-3
"""Minimum probability that counts."""
PRIOR_ODDS = np.append(0.1, LARGE_ODDS)
"""Prior odds of rough odometry and of each kind of large errors, against errors within the data sheets."""
CAUTION = 5.0
"""How much more probable large errors must be for the mean than for the covariance: effects outside the model, such as
one skid, may look like them for a while."""
ROUGH = 9.0
"""Ratio of the variance of rough odometry to that of its data sheet."""


class RivalFilters:
    """A filter that estimates constant errors of odometry, and perhaps others with other assumptions.

    References:
        Magill, Optimal Adaptive Estimation of Sampled Stochastic Processes, IEEE TAC 10(4), 1965: filters in parallel,
        averaged by their likelihoods.
    """

    def __init__(
        self,
        leading: EkfSlamFilter,
        rival: EkfSlamFilter | None,
        wide: EkfSlamFilter | None = None,
        rough: EkfSlamFilter | None = None,
    ) -> None:
        """Start with equal filters; without a rival, `leading` is the belief.

        Args:
            leading: Filter with errors of odometry.
            rival: The filter without them.
            wide: With `LARGE_MOTION` and `LARGE_SENSOR` errors.
            rough: Filter with odometry noise beyond its data sheet.
        """
        self.usual = leading
        """The filter with errors in proportion to the stated noise."""
        self._rival, self._rough = rival, rough
        self._wide = None if wide is None else LargeErrors(wide)
        self._evidence, self._most, self._roughness = 0.0, 0.0, 0.0
        self._odds = np.zeros(1 + len(KINDS))
        """Odds of rough odometry and of large errors; 0 as long as there are no sightings."""

    @property
    def leading(self) -> EkfSlamFilter:
        """The most probable filter, ignoring the average."""
        rough, large = self._odds[0], self._odds[1:].sum()
        if self._rough is not None and rough > max(large, 1.0):
            return self._rough
        return self._wide.slam if self._wide is not None and large > 1.0 else self.usual

    def change(self, action: Callable[[EkfSlamFilter], None]) -> None:
        """Change all filters."""
        self._change_usual(action)
        if self._wide is not None:
            action(self._wide.slam)

    def _change_usual(self, action: Callable[[EkfSlamFilter], None]) -> None:
        for slam in (self.usual, self._rival, self._rough):
            if slam is not None:
                action(slam)

    def assume_ranges(self, variances: Array) -> None:
        """Add variances to those of usual errors of ranges, before the first landmark."""
        self._change_usual(lambda slam: slam.assume(variances))

    def constrain_ranges(self, variances: Array) -> None:
        """Correct by a measurement with variances (2,) that usual errors of ranges are zero."""
        self._change_usual(lambda slam: slam.constrain(variances))

    def expect_ranges(self, variances: Array) -> None:
        """Set the variances (2,) that usual errors of ranges have before the sightings."""
        if self._wide is not None:
            self._wide.expect_ranges(variances)

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
            motion: Motion as in `EkfSlamFilter.predict`.
            moved: (forward, left, turn) by odometry, shape (3,).
            covariance: Covariance of that, shape (3, 3).
            errors: Result of `OdometryErrors.step`: control, slopes and increase of the variances.
            seconds: Period [s].
        """
        control, slopes, gained = errors
        self.usual.predict(motion, control, covariance, slopes=slopes, wander=gained)
        if self._rival is not None:
            self._rival.predict(motion, moved, covariance)
        if self._rough is not None:
            self._rough.predict(motion, control, ROUGH * covariance, slopes=slopes, wander=gained)
        if self._wide is not None:
            self._wide.gain(gained)
            large = np.column_stack([slopes, [0.0, 0.0, seconds]])
            self._wide.slam.predict(motion, control, covariance, slopes=large, wander=self._wide.begin())

    def update(self, names: Sequence[Hashable], measurements: ArrayLike, covariance: ArrayLike) -> None:
        """Correct by simultaneous sightings, as `EkfSlamFilter.update`; they show which filter expected them better."""
        likelihood = self.usual.update(names, measurements, covariance)
        if self._rival is not None:
            self._evidence += self._rival.update(names, measurements, covariance) - likelihood
            self._most = max(self._most, self._evidence)
            if self._evidence < -DECIDED:
                self._rival = None
        evidence = np.full(len(self._odds), -math.inf)
        if self._rough is not None:
            self._roughness += self._rough.update(names, measurements, covariance) - likelihood
            evidence[0] = self._roughness
            if self._roughness < -DECIDED:
                self._rough = None
        if self._wide is not None:
            self._wide.compare(self._wide.slam.update(names, measurements, covariance), likelihood)
            evidence[1:] = self._wide.evidence
        prior = DOUBTED * PRIOR_ODDS if self._evidence < -DISPROVED else PRIOR_ODDS
        self._odds = prior * np.exp(np.minimum(evidence - max(self._evidence, 0.0), DECIDED))

    @property
    def without_errors(self) -> float:
        """Probability that there are no constant errors, once the data support that; before that 0."""
        if self._rival is None or self._most < POSITIVE:
            return 0.0
        return 1.0 / (1.0 + math.exp(-min(self._evidence, 700.0)))

    def believed(self) -> EkfSlamFilter:
        """Return the belief averaged over all filters by their probabilities, to be read only."""
        share, believed = self.without_errors, self.usual
        if self._rival is not None and share >= SMALL:
            believed = averaged(self.usual, self._rival, share=share)
        odds = np.cumsum(self._odds)
        if self._rough is not None and odds[0] > SMALL:
            believed = averaged(believed, self._rough, share=odds[0] / (1.0 + odds[0]))
        beyond = odds[-1] - odds[0]
        if self._wide is None or beyond < SMALL:
            return believed
        large = copy.copy(self._wide.slam)
        large._mean, large._P = self._wide.averaged(self._odds[1:] / beyond)
        share, followed = (float(beyond / (beyond + rest)) for rest in (1.0 + odds[0], CAUTION * (1.0 + odds[0])))
        return averaged(believed, large, share=share, followed=followed)


def averaged(one: EkfSlamFilter, other: EkfSlamFilter, *, share: float, followed: float | None = None) -> EkfSlamFilter:
    """Return mean and covariance of a mixture of two filters with the same landmarks.

    Args:
        one: First filter.
        other: Second filter.
        share: Probability of the other.
        followed: Weight of the other in the mean, if not its probability; the covariance is about this mean.
    """
    rows, others = one.shared_rows(other)
    size = one._size
    apart = other._mean[others] - one._mean[rows]
    apart[2] = wrap_angle(float(apart[2]))
    gone = share if followed is None else followed
    average = copy.copy(one)
    average._mean, average._P = one._mean[:size].copy(), one._P[:size, :size].copy()
    average._mean[rows] += gone * apart
    average._mean[2] = wrap_angle(float(average._mean[2]))
    P = (1.0 - share) * one._P[rows[:, None], rows] + share * other._P[others[:, None], others]
    spread = share * (1.0 - share) + (share - gone) ** 2
    average._P[rows[:, None], rows] = P + spread * np.outer(apart, apart)
    return average
