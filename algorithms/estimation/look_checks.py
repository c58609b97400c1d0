"""Decides which sightings enter a graph at once, and which wait until others agree with them.

A graph keeps its sightings for good. A wrong one that comes after a minute without landmarks turns the whole map, since
a robust loss helps only where other sightings contradict. So a sighting of a mapped landmark is used at once only if it
agrees with the map and with the motion since the last sightings. Any other waits until a few of the same landmark agree
with each other. Sightings with a wrong name seldom agree.
"""

from collections import Counter, deque
from dataclasses import replace

import numpy as np

from mjsim.geometry import Array
from mjsim.interface import Sighting

from .ekf_models import innovation, range_bearing
from .recent_motion import MEMORY, RecentMotion

GATE = 13.8
"""Largest squared Mahalanobis distance of sightings that agree: 99.9 % of correct ones (chi-square, 2 degrees of
freedom)."""
NEEDED = 3
"""Number of waiting sightings of a landmark that must agree; fewer if fewer support its present position."""

PosedSighting = tuple[int, Sighting]
"""The index of a pose, and a sighting from it."""


class LookChecks:
    """Checks sightings against the uncertainty of the robot's pose relative to its map.

    Each landmark has the uncertainty, relative to the rest of the map, that the pose had when it entered the map; no
    sighting of it can make the pose more certain than that, until the landmark is seen from a better known pose.
    """

    def __init__(self) -> None:
        """Start where the map begins."""
        self._covariance = np.zeros((3, 3))
        self._entered: dict[str, Array] = {}
        self._waiting: dict[str, deque[PosedSighting]] = {}
        self._counted: Counter[str] = Counter()

    def move(self, F: Array, covariance: Array) -> None:
        """Propagate through a step: Jacobian of the new pose by the old one and the added covariance, (3, 3) each."""
        self._covariance = F @ self._covariance @ F.T + covariance

    def begin(self, name: str) -> None:
        """Register the first sighting of a landmark."""
        self._counted[name], self._entered[name] = 1, self._covariance

    def is_young(self, name: str) -> bool:
        """Return whether so few sightings support a landmark that the first one may have been wrong."""
        return self._counted[name] < NEEDED

    def agrees(self, pose: Array, landmark: Array, sighting: Sighting) -> bool:
        """Return whether a sighting agrees with the map; if so, reduce the uncertainty of the pose.

        Args:
            pose: Pose of the robot at the sighting, map frame, shape (3,).
            landmark: Its position in the map, shape (2,) [m].
            sighting: The sighting of this landmark.
        """
        distance, H, S = self._compared(pose, landmark, sighting, self._covariance)
        if distance > GATE:
            return False
        name = sighting.name or ""
        by_landmark = self._covariance - self._covariance @ H.T @ np.linalg.solve(S, H @ self._covariance)
        self._covariance = _lesser(self._covariance, by_landmark + self._entered[name])
        self._entered[name] = _lesser(self._entered[name], self._covariance)
        self._counted[name] += 1
        return True

    def distance(self, pose: Array, landmark: Array, sighting: Sighting, *, moved: Array) -> float:
        """Return the squared Mahalanobis distance of a sighting from what the map and the motion predict.

        Args:
            pose: Pose of the robot at the sighting, map frame, shape (3,).
            landmark: Its position in the map, shape (2,) [m].
            sighting: The sighting of this landmark.
            moved: Covariance of the motion since the last call of `move`, map frame, shape (3, 3).
        """
        return self._compared(pose, landmark, sighting, self._covariance + moved)[0]

    def _compared(
        self, pose: Array, landmark: Array, sighting: Sighting, covariance: Array
    ) -> tuple[float, Array, Array]:
        """Return the squared Mahalanobis distance of a sighting, its derivative by the pose and its covariance."""
        expected, H_pose, _ = range_bearing(pose, landmark[None])
        nu, H = innovation(np.array([[sighting.range, sighting.bearing]]), expected)[0], H_pose[0]
        # A landmark is about as uncertain as a single sighting of it.
        S = H @ covariance @ H.T + 2.0 * sighting.covariance
        return float(nu @ np.linalg.solve(S, nu)), H, S

    def wait(self, number: int, sighting: Sighting, recent: RecentMotion, time: float) -> list[PosedSighting]:
        """Add a sighting to those that wait; return all that agree with it, including itself, if there are enough.

        Args:
            number: Index of the pose that it was taken from.
            sighting: The sighting from that pose.
            recent: Motion of the last seconds.
            time: Current time [s].
        """
        name, sighting = sighting.name or "", replace(sighting, stamp=time)
        waiting = self._waiting.setdefault(name, deque())
        while waiting and waiting[0][1].stamp < time - MEMORY:
            waiting.popleft()
        waiting.append((number, sighting))
        agreeing = [each for each in waiting if _same(sighting, recent.to_now(each[1]))]
        if len(agreeing) < min(self._counted[name] + 1, NEEDED):
            return []
        del self._waiting[name]
        return agreeing


def _lesser(one: Array, other: Array) -> Array:
    """Return the smaller of two covariances of a pose, where an error of one radian counts as one metre."""
    return one if np.trace(one) <= np.trace(other) else other


def _same(one: Sighting, other: Sighting) -> bool:
    """Return whether two sightings from the same pose may be of the same landmark."""
    nu = innovation(np.array([[one.range, one.bearing]]), np.array([[other.range, other.bearing]]))[0]
    return bool(nu @ np.linalg.solve(one.covariance + other.covariance, nu) < GATE)
