"""Undoes the motion of the robot in scans of a lidar that measures while it rotates."""

from collections import deque

import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.interface import Observation, Scan, swept

from ..estimation.pose_graph import compose

LATE = 1.0
"""Age of a scan up to which its motion is known [s]."""


class MovingLidar:
    """Corrects the scans of a lidar for the robot's motion, as if measured from its pose at the stamp."""

    def __init__(self, *, rate_hz: float) -> None:
        """Start at rest.

        Args:
            rate_hz: Revolutions of the lidar per second.
        """
        self._memory = 1.0 / rate_hz + LATE
        self._track: deque[Array] = deque()

    def move(self, seen: Observation) -> None:
        """Add the motion of a tick; call it at every tick."""
        step, moment = seen.odometry, seen.moment
        if not self._track:
            self._track.append(np.array([moment - seen.dt, 0.0, 0.0, 0.0]))
        pose = compose(self._track[-1][1:], np.array([step.forward, step.left, step.turn]))
        self._track.append(np.array([moment, *pose]))
        while self._track[1][0] < moment - self._memory:
            self._track.popleft()

    def still(self, scan: Scan, robot_from_lidar: Pose) -> Scan:
        """Return a scan as from one place.

        Args:
            scan: The measured scan.
            robot_from_lidar: Where the lidar is mounted.
        """
        return swept(scan, scan.times(), np.array(self._track), robot_from_lidar)
