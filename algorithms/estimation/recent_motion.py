"""Recent poses of the robot by odometry, and past sightings transformed to the current pose.

Images have latency: a sighting is older than the tick in which it arrives. And a lost robot needs the sightings of the
last seconds together, as if all were taken from its current pose.
"""

import math
from collections import deque
from dataclasses import replace

import numpy as np

from mjsim.geometry import Array, wrap_angle
from mjsim.interface import Odometry, Sighting

from .ekf_models import landmark_from, odometry_motion, range_bearing

MEMORY = 10.0
"""Time for which the motion is kept [s]."""
SAME = 1e-6
"""A sighting of at most this age counts as current [s]."""


class RecentMotion:
    """The motion of the last seconds by odometry alone."""

    def __init__(self) -> None:
        """Start at rest."""
        self._motion = odometry_motion()
        start = (-math.inf, np.zeros(3), np.zeros((3, 3)))
        self._track: deque[tuple[float, Array, Array]] = deque([start])  # time, pose, sum of the steps' covariances

    def move(self, step: Odometry, time: float) -> None:
        """Add the motion since the previous tick; `time` is that of this tick [s]."""
        _, pose, total = self._track[-1]
        pose, _, _ = self._motion(pose, np.array([step.forward, step.left, step.turn]))
        self._track.append((time, pose, total + step.covariance))
        while len(self._track) > 2 and self._track[1][0] < time - MEMORY:
            self._track.popleft()

    def spread(self, begin: float) -> None:
        """Spread all motion since a time evenly over it."""
        pose, total = self.at(begin)
        self._track = deque(entry for entry in self._track if entry[0] <= begin) + deque([self._track[-1]])
        if self._track[-2][0] < begin:
            self._track.insert(-1, (begin, pose, total))

    def since(self, time: float) -> tuple[Array, Array]:
        """Return the step from the pose at a time to the newest one, shape (3,), and its covariance (3, 3).

        Motion between two ticks is interpolated linearly; before the first tick the robot was at rest. The covariance
        is the sum of those of odometry, which is valid while the robot turns little.
        """
        _, pose, total = self._track[-1]
        then, known = self.at(time)
        c, s = math.cos(then[2]), math.sin(then[2])
        dx, dy = pose[:2] - then[:2]
        turn = wrap_angle(float(pose[2] - then[2]))
        return np.array([c * dx + s * dy, c * dy - s * dx, turn]), total - known

    def velocity(self, window: float) -> Array:
        """Return the mean velocity over the last seconds, in the robot's frame, shape (3,) [m/s, m/s, rad/s].

        Args:
            window: How many seconds.
        """
        (x, y, turn), _ = self.since(self._track[-1][0] - window)
        # On an arc, the chord deviates from the final heading by half of the turn.
        c, s = math.cos(0.5 * turn), math.sin(0.5 * turn)
        return np.array([c * x + s * y, c * y - s * x, turn]) / window

    def to_now(self, sighting: Sighting) -> Sighting:
        """Return a sighting transformed to the newest pose; a current one is returned unchanged."""
        if sighting.stamp >= self._track[-1][0] - SAME:
            return sighting
        return carried(sighting, *self.since(sighting.stamp))

    def at(self, time: float) -> tuple[Array, Array]:
        """Return the pose by odometry at a time, shape (3,), and the sum of the covariances up to then (3, 3)."""
        later = None
        for entry in reversed(self._track):
            if entry[0] <= time:
                break
            later = entry
        begin, before, known = entry
        # The newest tick is not later than `time`, or the oldest stored one is; before the first, the robot was at
        # rest.
        if later is None or later is entry or not math.isfinite(begin):
            return before, known
        end, pose, total = later
        share = (time - begin) / (end - begin)
        displacement = pose - before
        displacement[2] = wrap_angle(float(displacement[2]))
        return before + share * displacement, known + share * (total - known)


def carried(sighting: Sighting, step: Array, covariance: Array) -> Sighting:
    """Return a sighting transformed to the pose after a step of the robot.

    Args:
        sighting: Taken before the step.
        step: (forward, left, turn) in the robot's frame before it, shape (3,) [m, m, rad].
        covariance: Covariance of the step, shape (3, 3).
    """
    place, J = landmark_from(np.zeros(3), np.array([sighting.range, sighting.bearing]))
    Z, H_step, H_place = range_bearing(step, place[None])
    J_sighting = H_place[0] @ J
    total = J_sighting @ sighting.covariance @ J_sighting.T + H_step[0] @ covariance @ H_step[0].T
    distance, bearing = Z[0].tolist()
    return replace(sighting, range=distance, bearing=bearing, covariance=0.5 * (total + total.T))
