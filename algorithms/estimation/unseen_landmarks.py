"""Landmarks that should be in view and are not: evidence that the robot is elsewhere, before it sees anything again.

Which landmarks are seen from where is learnt in the run, without a data sheet: a landmark should be in view near the
places from which it was seen, at ranges and bearings at which sightings came. The longest normal time without a
sighting is learnt as well, because people pass, detectors miss, and beacons are removed.
"""

import bisect
import math
from collections.abc import Hashable

from mjsim.geometry import wrap_angle
from mjsim.interface import Estimate, Observation

CELL = 0.5
"""Size of the cells from which a landmark was seen; it should be seen from those around them too [m]."""
MIN_UNSEEN_SECONDS, LONGER, ENOUGH = 0.6, 2.0, 50
"""Minimum time without an expected sighting that is evidence [s], its minimum ratio to the longest harmless one, and
minimum number of agreeing sightings before."""
INNER = 0.8
"""Part of the ranges and of the field of view in which a landmark is surely visible: nearby pictures are cut off."""
CERTAIN = 3.0
"""Number of standard deviations of the heading by which bearings may be off."""


class UnseenLandmarks:
    """Measures the time for which landmarks should have been in view but none was seen."""

    def __init__(self) -> None:
        """Start without sightings."""
        self._seen_from: set[tuple[Hashable, int, int]] = set()
        self._right, self._left = math.inf, -math.inf
        self._nearest, self._farthest = math.inf, 0.0
        self._blank, self._agreed = 0.0, 0
        self._innocent: list[float] = []  # earlier times with another reason, sorted [s]

    @property
    def suspicious(self) -> bool:
        """Whether that time is longer than any for which there was another reason."""
        longest = self._innocent[-1] if self._innocent else 0.0
        return self._agreed >= ENOUGH and self._blank > max(MIN_UNSEEN_SECONDS, LONGER * longest)

    @property
    def rarity(self) -> float:
        """Proportion of earlier times with another reason that were as long, at most 1; 1 until there are enough."""
        if self._agreed < ENOUGH:
            return 1.0
        as_long = len(self._innocent) - bisect.bisect_left(self._innocent, self._blank)
        return (1 + as_long) / (1 + len(self._innocent))

    def agree(self) -> None:
        """Record a sighting that agrees with the map: that time had another reason."""
        if self._blank:
            bisect.insort(self._innocent, self._blank)
        self._blank, self._agreed = 0.0, self._agreed + 1

    def forget(self) -> None:
        """Discard that time."""
        self._blank = 0.0

    def look(self, belief: Estimate, seen: Observation) -> None:
        """Record the sightings of a tick, with the pose of the robot and its map in one frame."""
        row, column = math.floor(belief.pose.x / CELL), math.floor(belief.pose.y / CELL)
        named = [sighting for sighting in seen.sightings if sighting.name is not None]
        for sighting in named:
            self._right, self._left = min(self._right, sighting.bearing), max(self._left, sighting.bearing)
            self._nearest, self._farthest = min(self._nearest, sighting.range), max(self._farthest, sighting.range)
            if sighting.name in belief.landmarks:
                around = ((row + i, column + j) for i in (-1, 0, 1) for j in (-1, 0, 1))
                self._seen_from.update((sighting.name, *cell) for cell in around)
        if named:
            self.forget()  # Sightings that disagree are counted elsewhere.
            return
        near = (name for name in belief.landmarks if (name, row, column) in self._seen_from)
        if any(self._is_in_view(belief, name) for name in near):
            self._blank += seen.dt

    def _is_in_view(self, belief: Estimate, name: Hashable) -> bool:
        """Return whether a landmark is well within the ranges and bearings of all sightings."""
        x, y = belief.landmarks[name][0] - belief.pose.as_array()[:2]
        bearing = wrap_angle(math.atan2(y, x) - belief.pose.heading)
        off = abs(bearing - 0.5 * (self._left + self._right)) + CERTAIN * math.sqrt(belief.covariance[2, 2])
        is_in_range = self._nearest / INNER < math.hypot(x, y) < self._farthest * INNER
        return is_in_range and off < 0.5 * INNER * (self._left - self._right)
