"""Relocalization of a robot that is lost on its own map.

A filter with an error far beyond its covariance rejects every correct sighting as an outlier, and stays wrong. If
nearly all recent sightings of named landmarks fail the gate, they are evidence about the robot, not about the
landmarks: it was kidnapped, slipped, or was pushed. From then on no sighting corrects the map, and the covariance is
that of a robot that may be anywhere, until two landmarks, seen in sequence, give the pose, or sightings agree again.
The same holds while landmarks that should be in view are not seen; then one sighting that fails is enough.
"""

import itertools
from collections import deque
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from mjsim.geometry import Array
from mjsim.interface import Estimate, Observation, Sighting

from .ekf_models import innovation
from .recent_motion import MEMORY, RecentMotion
from .unseen_landmarks import UnseenLandmarks

COUNTED, FAILING = 12, 9
"""Number of recent sightings of the map, and of failures among them by which a robot is lost; with half of the
sightings wrong, fewer fail."""
AGREES, AGAIN = 6.0, 3
"""A robot is no longer lost if nearly all of its last sightings agree with its pose as if it were not lost: squared
Mahalanobis distance of one that agrees (chi-square, 2 degrees of freedom: 95 %), and maximum number that do not."""
ROW, ROW_SECONDS = 5, 1.0
"""Failures in a row, over at least this time [s], that suffice as well."""
CARRIED = 1e-4
"""Prior odds, whenever landmarks are expected, that the robot is elsewhere."""
WRONG = 1, 100
"""Prior number of ticks whose sightings fail although the pose is correct, and of all with sightings. Those of one tick
fail together: all share the tilt of the robot."""
FAR = 4.0
"""A tick that misses by less than this times the gate is not evidence: errors may be twice as large as stated."""
RARE = 0.02
"""Times without an expected sighting are evidence if at most this proportion of harmless ones was as long."""
TRIAL = 3
"""Failures, with no agreement between, after which a robot that was found is lost again."""
ANY_HEADING = np.pi**2 / 3.0
"""Variance of an unknown heading [rad^2]."""
STEADY, STEADY_GATE = 1.0, 9.2
"""Sightings of a landmark up to this long apart [s] agree if their squared Mahalanobis distance is below the gate
(chi-square, 2 degrees of freedom: 99 %)."""
ANYWHERE = (10.0, 10.0, 1.0)
"""Standard deviations of the pose of a relocated robot, before its sightings are used [m, m, rad]."""
AGREEING = 0.7
"""Proportion of the sightings that a new pose must explain."""
MIN_DISTANCE = 0.5
"""Minimum distance between the two sightings that give a pose [m]."""
MAX_SIGHTINGS = 200
"""Maximum number of sightings used, the newest ones."""

Places = Mapping[Any, Array]
"""Positions of landmarks by their names, shape (2,) each [m]."""


class Refound(NamedTuple):
    """Where a robot is found."""

    pose: Array
    """(x, y, heading), shape (3,) [m, m, rad]."""
    sightings: dict[Any, Sighting]
    """Those that agree with it, by landmark, as if taken from there."""


def _same(sighting: Sighting) -> Sighting:
    return sighting


class Relocation:
    """Records which sightings of the map failed, decides whether the robot is lost, and gives its covariance then."""

    def __init__(self) -> None:
        """Start without sightings."""
        self._records: deque[tuple[Hashable, Sighting]] = deque(maxlen=MAX_SIGHTINGS)
        self._failed: deque[bool] = deque(maxlen=COUNTED)
        self._row: deque[float] = deque(maxlen=MAX_SIGHTINGS)
        self._wrong, self._compared = WRONG
        self._agreed, self._far = -np.inf, False
        self._agreeing: set[Hashable] = set()
        self._lost = False
        self._unseen = UnseenLandmarks()

    @property
    def lost(self) -> bool:
        """Whether nearly all of the last sightings failed."""
        return self._lost

    @property
    def doubted(self) -> bool:
        """Whether the robot is lost, or sees none of the landmarks that should be in view."""
        return self._lost or self._unseen.suspicious

    @property
    def elsewhere(self) -> float:
        """Probability that the robot is elsewhere, from consecutive sightings that fail or are missing."""
        if self.doubted:
            return 1.0
        chance = (self._wrong / self._compared) ** max(self._failed_looks() - (not self._far), 0)
        if self._unseen.rarity < RARE:
            chance *= self._unseen.rarity
        return CARRIED / (CARRIED + chance) if chance < 1.0 else 0.0

    def record(self, name: Hashable, sighting: Sighting, distance: float, *, gate: float) -> None:
        """Record a sighting of a landmark of the map.

        Args:
            name: Name of the landmark.
            sighting: As it came.
            distance: Its squared Mahalanobis distance from what was expected.
            gate: The distance above which it fails.
        """
        failed = distance > (AGREES if self._lost else gate)
        if failed or self._lost:
            self._records.append((name, sighting))
        if failed:
            self._row.append(sighting.stamp)
            self._far |= distance > FAR * gate and sighting.stamp != self._agreed
        else:
            if not self._lost:
                looks = self._failed_looks()
                self._wrong, self._compared = self._wrong + looks, self._compared + looks
                self._compared += sighting.stamp != self._agreed
            self._clear_row()
            self._agreed = sighting.stamp
            self._agreeing.add(name)
            if not self._lost:
                self._records.clear()
                self._unseen.agree()
        self._failed.append(failed)
        failures = sum(self._failed)
        if not self._lost:
            self._lost = failures >= FAILING or self._is_row() or (failed and self._unseen.suspicious)
            self._agreeing.clear()
        elif failures <= AGAIN and len(self._agreeing) > 1:
            self._lost = False

    def _failed_looks(self) -> int:
        """Return the number of ticks whose sightings failed since one agreed."""
        return len({*self._row} - {self._agreed})

    def _clear_row(self) -> None:
        self._row.clear()
        self._far = False

    def _is_row(self) -> bool:
        return len(self._row) >= ROW and self._row[-1] - self._row[0] >= ROW_SECONDS

    def find(
        self, motion: RecentMotion, time: float, places: Places, *, corrected: Callable[[Sighting], Sighting] = _same
    ) -> Refound | None:
        """Return the pose that explains the newest sighting of each landmark since they fail; None if none does.

        A landmark whose last sightings disagree with each other, given odometry, was seen while the robot was pushed or
        slipped; it is not evidence of where the robot is now.

        Args:
            motion: Motion of the last seconds.
            time: Current time [s].
            places: Positions of the landmarks of the map, shape (2,) each [m].
            corrected: Removes known errors from a sighting; the sightings that are returned still have them.
        """
        by_name: dict[Hashable, list[Sighting]] = {}
        for name, sighting in self._records:
            if time - sighting.stamp < MEMORY and name in places:
                by_name.setdefault(name, []).append(sighting)
        steady = {name: motion.to_now(looks[-1]) for name, looks in by_name.items() if _agree(looks, motion)}
        found = pose_from_sightings(list(steady), [corrected(each) for each in steady.values()], places)
        if found is None:
            return None
        self._found()
        return Refound(found.pose, {name: steady[name] for name in found.sightings})

    def _found(self) -> None:
        """Forget earlier failures; the new pose is on probation."""
        self._records.clear()
        self._clear_row()
        self._failed = deque([True] * (FAILING - TRIAL), maxlen=COUNTED)
        self._lost = False

    def reported(self, belief: Estimate, seen: Observation) -> Estimate:
        """Return a belief after an observation; its covariance is averaged over being there and being elsewhere."""
        if self._lost:
            self._unseen.forget()
        else:
            self._unseen.look(belief, seen)
        share = self.elsewhere
        if not share:
            return belief
        lost = self.covariance(belief.pose.as_array(), {name: at for name, (at, _) in belief.landmarks.items()})
        joint = belief.joint_covariance
        if joint is not None:
            joint = (1.0 - share) * joint + share * block_diag(lost, joint[3:, 3:])
        covariance = (1.0 - share) * np.asarray(belief.covariance) + share * lost
        return replace(belief, covariance=covariance, joint_covariance=joint)

    def covariance(self, pose: Array, places: Places) -> Array:
        """Return the covariance of the pose of a lost robot, shape (3, 3).

        The robot is assumed on a circle about the landmark that it saw last, with any heading; the variance is the mean
        square distance from there to the given pose.

        Args:
            pose: Mean, shape (3,).
            places: Positions of the landmarks of the map, shape (2,) each [m].
        """
        seen = [(places[name], sighting.range) for name, sighting in self._records if name in places]
        if not seen:
            return np.diag([ANYWHERE[0] ** 2, ANYWHERE[1] ** 2, ANY_HEADING])
        place, distance = seen[-1]
        squared = 0.5 * (float(np.sum((place - pose[:2]) ** 2)) + distance**2)
        return np.diag([squared, squared, ANY_HEADING])


def _agree(looks: Sequence[Sighting], motion: RecentMotion) -> bool:
    """Return whether the newest sighting of a landmark agrees with one of about a second before, given odometry."""
    last = motion.to_now(looks[-1])
    first = motion.to_now(next(look for look in looks if look.stamp >= looks[-1].stamp - STEADY))
    nu = innovation(np.array([[last.range, last.bearing]]), np.array([[first.range, first.bearing]]))[0]
    return bool(nu @ np.linalg.solve(first.covariance + last.covariance, nu) < STEADY_GATE)


def pose_from_sightings(names: Sequence[Hashable], sightings: Sequence[Sighting], places: Places) -> Refound | None:
    """Return the pose with which most sightings agree, and these; None if no pose explains enough of them.

    Every pair of sightings far enough apart gives a pose; the one with most inliers is taken (an exhaustive RANSAC,
    Fischler, Bolles 1981), and fitted to its inliers (Arun, Huang, Blostein 1987, in the plane).

    Args:
        names: Landmark of each sighting.
        sightings: Sightings from the current pose.
        places: Positions of the landmarks of the map, shape (2,) each [m].
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
    if best.sum() < enough:
        return None
    return Refound(fitted(seen[best], hung[best]), {names[i]: sightings[i] for i in np.flatnonzero(best).tolist()})


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
