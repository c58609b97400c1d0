"""Systematic errors of ranges, which a filter estimates along with the map.

A data sheet gives one standard deviation. If successive sightings of a landmark scatter by that much, their
errors are noise, which averages out. If they scatter by far less, the rest is a common error: a camera overestimates
distances by 5 %, or a pole is measured at its front. A filter that treats this as noise believes
in a map that is 5 % too large, with a covariance that shrinks with every sighting.
"""

import math
from collections.abc import Hashable, Sequence

import numpy as np

from mjsim.geometry import Array
from mjsim.interface import Sighting

from .recent_motion import MEMORY, RecentMotion, carried

RANGE_ERRORS = 2
"""Number of errors: offset [m] and relative error of the range."""
REACH = 3.5
"""Range at which offset and relative error are assumed to be equal [m]."""
ENOUGH, MAX_SCALE = 30, 300
"""Pairs of sightings after which their scatter counts, and after which no more are needed."""
FAIR = 2.0
"""No common error remains if the scatter has at least 1 / FAIR of the stated variance, which is uncertain too."""
LEFT = 1e-6
"""Part of the variance that stays, so that covariances remain invertible."""
ODD = 13.8
"""Pairs that differ by more than their covariance allows (squared Mahalanobis distance) are outliers."""


class RangeErrors:
    """Bounds the systematic errors of ranges by the scatter of sightings.

    Before the scatter is known, all of the stated variance may be a common error. Then a constraint reduces it to the
    part that is common, as if that part had been the prior.
    """

    def __init__(self, *, scale: float) -> None:
        """Start without sightings; `scale` is a factor on the stated standard deviation."""
        self._scale = scale
        self._newest: dict[Hashable, Sighting] = {}
        self._scatter, self._stated, self._pairs = 0.0, 0.0, 0
        self._prior, self._part = np.zeros(RANGE_ERRORS), 1.0

    @property
    def variances(self) -> Array:
        """Variances of offset [m] and relative error, shape (2,); zeros before the first sighting."""
        return np.asarray(self._part * self._prior)

    def begin(self, sightings: Sequence[Sighting]) -> Array:
        """Return the prior variances, shape (2,), at the first sightings; before and after that zeros."""
        if self._prior.any() or not sightings:
            return np.zeros(RANGE_ERRORS)
        half = 0.5 * self._scale**2 * float(np.mean([sighting.covariance[0, 0] for sighting in sightings]))
        self._prior = np.array([half, half / REACH**2])
        return self._prior

    def constraint(self, sightings: Sequence[Sighting], recent: RecentMotion) -> Array | None:
        """Return the variances, shape (2,), of a pseudo-measurement that both errors are zero; None if none is due."""
        if self._part <= LEFT or self._pairs >= MAX_SCALE or not self._prior.any():
            return None
        self._compare(sightings, recent)
        if any(sighting.corners is not None for sighting in sightings):
            part = LEFT  # Errors of pictures are modelled elsewhere.
        elif self._pairs < ENOUGH:
            return None
        else:
            part = max(1.0 - FAIR * self._scatter / self._stated, LEFT)
        if part > 0.95 * self._part:
            return None
        variances = self._prior / (1.0 / part - 1.0 / self._part)
        self._part = part
        return np.asarray(variances)

    def _compare(self, sightings: Sequence[Sighting], recent: RecentMotion) -> None:
        """Compare each sighting with the one before of its landmark, if odometry adds less than their own noise."""
        for sighting in sightings:
            before, self._newest[sighting.name] = self._newest.get(sighting.name), sighting
            if before is None or sighting.stamp - before.stamp > MEMORY:
                continue
            then, now = carried(before, *recent.since(before.stamp)), recent.to_now(sighting)
            stated = self._scale**2 * float(before.covariance[0, 0] + sighting.covariance[0, 0])
            added = float(then.covariance[0, 0] + now.covariance[0, 0] - before.covariance[0, 0])
            added -= float(sighting.covariance[0, 0])
            squared = (now.range - then.range) ** 2
            if added < stated and squared < ODD * (stated + added) and math.isfinite(squared):
                self._scatter += squared - added
                self._stated += stated
                self._pairs += 1
