"""Relocalization of a robot that is lost on its own map.

A filter with an error far beyond its covariance rejects every correct sighting as an outlier, and stays wrong. If
nearly all recent sightings fail the gate, the pose is wrong: the robot was kidnapped, slipped, or was pushed. The
sightings of the last seconds, propagated by odometry, are then matched with the map.
"""

import itertools
from collections import deque
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.interface import Sighting

from .recent_motion import MEMORY, RecentMotion

COUNTED, FAILING = 12, 9
"""Number of recent sightings of the map, and of failures among them for a lost robot; if half are wrong, fewer fail."""
AGREEING = 0.7
"""Proportion of the sightings that a new pose must explain."""
MIN_DISTANCE = 0.5
"""Least distance between the two sightings that give a pose [m]."""
MAX_SIGHTINGS = 40
"""Most sightings used, the newest ones."""


@dataclass(frozen=True, slots=True, eq=False)
class _Record:
    name: Hashable
    sighting: Sighting


class Relocation:
    """Records which sightings of the map failed, and finds the pose that explains them."""

    def __init__(self) -> None:
        """Start with nothing seen."""
        self._records: deque[_Record] = deque(maxlen=MAX_SIGHTINGS)
        self._failed: deque[bool] = deque(maxlen=COUNTED)

    @property
    def lost(self) -> bool:
        """Whether nearly all of the last sightings failed."""
        return sum(self._failed) >= FAILING

    def record(self, name: Hashable, sighting: Sighting, *, failed: bool) -> None:
        """Record a sighting of a landmark of the map."""
        self._records.append(_Record(name, sighting))
        self._failed.append(failed)

    def found(self) -> None:
        """Reset the record of failures after a new pose."""
        self._failed.clear()

    def recent(self, motion: RecentMotion, time: float) -> tuple[list[Hashable], list[Sighting]]:
        """Return the newest sighting of each landmark of the map, transformed to the current pose."""
        newest = {record.name: record.sighting for record in self._records if time - record.sighting.stamp < MEMORY}
        return list(newest), [motion.to_now(sighting) for sighting in newest.values()]


def pose_from_sightings(
    names: Sequence[Hashable], sightings: Sequence[Sighting], places: Mapping[Hashable, Array]
) -> Array | None:
    """Return the pose with which most sightings agree; None if no pose explains enough of them.

    Every pair of sightings far enough apart gives a pose; the one with most inliers is taken (an exhaustive RANSAC,
    Fischler, Bolles 1981), and fitted to its inliers (Arun, Huang, Blostein 1987, in the plane).

    Args:
        names: Landmark of each sighting.
        sightings: Sightings from the current pose.
        places: Positions of the landmarks of the map, shape (2,) each [m].

    Returns:
        (x, y, heading), shape (3,) [m, m, rad].
    """
    seen = np.array([[k.range * np.cos(k.bearing), k.range * np.sin(k.bearing)] for k in sightings])
    hung = np.array([places[name] for name in names])
    best: NDArray[np.bool_] = np.zeros(len(seen), dtype=bool)
    for i, j in itertools.combinations(range(len(seen)), 2):
        if np.hypot(*(seen[i] - seen[j])) < MIN_DISTANCE:
            continue
        agree = _residuals(fitted(seen[[i, j]], hung[[i, j]]), seen, hung) < _tolerances(sightings)
        if agree[[i, j]].all() and agree.sum() > best.sum():
            best = agree
    enough = max(2, np.ceil(AGREEING * len(seen)))
    return fitted(seen[best], hung[best]) if best.sum() >= enough else None


def fitted(seen: Array, hung: Array) -> Array:
    """Return the pose (3,) that best maps points in the robot's frame (n, 2) to their positions in the world (n, 2)."""
    a, b = seen - seen.mean(axis=0), hung - hung.mean(axis=0)
    heading = np.arctan2(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a * b))
    c, s = np.cos(heading), np.sin(heading)
    position = hung.mean(axis=0) - np.array([[c, -s], [s, c]]) @ seen.mean(axis=0)
    return np.array([*position, heading])


def _residuals(pose: Array, seen: Array, hung: Array) -> Array:
    """Return the distances of mapped points (n, 2) from their positions (n, 2), shape (n,) [m]."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.asarray(np.hypot(*(pose[:2] + seen @ np.array([[c, s], [-s, c]]) - hung).T))


def _tolerances(sightings: Sequence[Sighting]) -> Array:
    """Return three standard deviations of the position of each sighting, shape (n,) [m]."""
    return np.array(
        [3.0 * np.hypot(np.sqrt(k.covariance[0, 0]), k.range * np.sqrt(k.covariance[1, 1])) for k in sightings]
    )
