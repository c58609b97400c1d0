"""Merging of unnamed landmarks that were mapped twice.

A robot that returns with a wrong pose estimate takes known landmarks for new ones and maps them twice. As the map
converges, the duplicates move to the same place. Two facts distinguish them from neighbours: their distance is within
the errors of sightings, and they were never seen in the same tick. The covariance of their positions is not used: a
filter that created duplicates is overconfident, and an uncertain one would merge neighbours.
"""

from collections import defaultdict
from collections.abc import Hashable, Sequence

import numpy as np

from mjsim.interface import Sighting

from .ekf_filter import EkfSlamFilter


class DuplicateLandmarks:
    """Finds pairs of landmarks that are the same.

    References:
        Dissanayake, Newman, Clark, Durrant-Whyte, Csorba, A Solution to the Simultaneous Localization and Map Building
        (SLAM) Problem, IEEE T-RA 17(3), 2001, section V: selection of landmarks by quality.
    """

    def __init__(self, *, gate: float, scale: float) -> None:
        """Start with nothing seen.

        Args:
            gate: Maximum squared distance of two landmarks to merge, relative to the variance of its coordinates.
            scale: Factor on the standard deviation of sightings.
        """
        self._gate, self._scale = gate, scale
        self._beside: dict[Hashable, set[Hashable]] = defaultdict(set)
        """By landmark: those seen simultaneously with it."""

    def record(self, names: Sequence[Hashable]) -> None:
        """Store the landmarks seen simultaneously."""
        for name in names:
            self._beside[name].update(names)

    def find(
        self, slam: EkfSlamFilter, seen: Sequence[tuple[Hashable, Sighting]], among: Sequence[Hashable]
    ) -> tuple[Hashable, Hashable, float] | None:
        """Return two landmarks to merge, the older first, and the variance of each coordinate of their distance [m^2].

        Args:
            slam: The belief.
            seen: Landmarks seen now, with their sightings: one of the two is among them.
            among: Candidates, oldest first.

        Returns:
            None if there are no such landmarks.
        """
        if not seen:
            return None
        rows = {name: row for row, name in enumerate(among)}
        variances = 2.0 * self._scale**2 * np.array([_variance(sighting) for _, sighting in seen])
        places = slam.positions(among)
        gaps = slam.positions([name for name, _ in seen])[:, None] - places
        in_gate = np.einsum("kni,kni->kn", gaps, gaps) < self._gate * variances[:, None]
        for k, row in np.argwhere(in_gate).tolist():
            name = seen[k][0]
            if among[row] not in self._beside[name]:
                first, second = sorted((row, rows[name]))
                return among[first], among[second], float(variances[k])
        return None

    def unite(self, first: Hashable, second: Hashable) -> None:
        """Treat two landmarks as one from now on."""
        beside = self._beside.pop(second, set()) - {second}
        self._beside[first] |= beside | {first}
        for other in beside:
            self._beside[other] = self._beside[other] - {second} | {first}


def _variance(sighting: Sighting) -> float:
    """Return the largest variance in any direction of a position from a sighting [m^2]."""
    along, across = float(sighting.covariance[0][0]), sighting.range**2 * float(sighting.covariance[1][1])
    return max(along, across)
