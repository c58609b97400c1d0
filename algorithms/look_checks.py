"""Which sightings a graph takes at once, and which wait for others that agree with them.

A graph has all sightings for good, and a wrong one that comes when the robot has seen nothing for a minute turns all
of its map: a loss that is robust helps where others contradict. So a sighting of a landmark of the map counts at once
only if it is about where the map and the way since the last ones have it. Any other waits; a few of one landmark that
agree with each other are believed. Names that were misread seldom agree.
"""

from collections import Counter, deque
from dataclasses import replace

import numpy as np

from mjsim.geometry import Array
from mjsim.interface import Sighting

from .ekf_models import apart, range_bearing
from .recent_motion import MEMORY, RecentMotion

GATE = 13.8
"""Largest squared Mahalanobis distance of what agrees: 99.9 % of good ones (chi-square, 2 degrees of freedom)."""
NEEDED = 3
"""So many sightings of a landmark that wait must agree; fewer if still fewer have spoken for its place."""

Look = tuple[int, Sighting]
"""The number of a pose, and what was seen from it."""


class LookChecks:
    """Sorts sightings by how unsure the robot is of its pose relative to its map, the map being taken for right."""

    def __init__(self) -> None:
        """Start where the map begins."""
        self._spread = np.zeros((3, 3))
        self._waiting: dict[str, deque[Look]] = {}
        self._counted: Counter[str] = Counter()

    def move(self, F: Array, covariance: Array) -> None:
        """Take a step: the derivative of the new pose by the old one, and the covariance that it adds, (3, 3) each."""
        self._spread = F @ self._spread @ F.T + covariance

    def begin(self, name: str) -> None:
        """Take the first look at a landmark."""
        self._counted[name] = 1

    def is_young(self, name: str) -> bool:
        """Return whether so few looks agree about where a landmark is that its first one may have been wrong."""
        return self._counted[name] < NEEDED

    def agrees(self, pose: Array, landmark: Array, look: Sighting) -> bool:
        """Return whether a sighting is where it is expected; if so the pose is known better from now on.

        Args:
            pose: From where, shape (3,).
            landmark: As the map has it, shape (2,) [m].
            look: Of this landmark.
        """
        expected, H_pose, _ = range_bearing(pose, landmark[None])
        nu, H = apart(np.array([[look.range, look.bearing]]), expected)[0], H_pose[0]
        # A landmark is known about as well as one look at it tells.
        S = H @ self._spread @ H.T + 2.0 * look.covariance
        if nu @ np.linalg.solve(S, nu) > GATE:
            return False
        self._spread = self._spread - self._spread @ H.T @ np.linalg.solve(S, H @ self._spread)
        self._counted[look.name or ""] += 1
        return True

    def wait(self, number: int, look: Sighting, recent: RecentMotion, time: float) -> list[Look]:
        """Let a sighting wait; return those that waited and agree with it, itself among them, if they are enough.

        Args:
            number: Of the pose that it was taken from.
            look: As it is seen from there.
            recent: The way of the last seconds, until now.
            time: Now [s].
        """
        name, look = look.name or "", replace(look, stamp=time)
        waiting = self._waiting.setdefault(name, deque())
        while waiting and waiting[0][1].stamp < time - MEMORY:
            waiting.popleft()
        waiting.append((number, look))
        agreeing = [each for each in waiting if _same(look, recent.to_now(each[1]))]
        if len(agreeing) < min(self._counted[name] + 1, NEEDED):
            return []
        del self._waiting[name]
        return agreeing


def _same(one: Sighting, other: Sighting) -> bool:
    """Return whether two looks from the same place may be at the same thing."""
    nu = apart(np.array([[one.range, one.bearing]]), np.array([[other.range, other.bearing]]))[0]
    return bool(nu @ np.linalg.solve(one.covariance + other.covariance, nu) < GATE)
