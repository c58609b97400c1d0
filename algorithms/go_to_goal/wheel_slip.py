"""Detects wheels that turn without moving the robot: scans do not change."""

import math

import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.interface import Odometry

from .obstacle_map import ObstacleMap
from .range_views import RangeView

DRIVEN, TURNED = 0.15, 0.25
"""Motion of the wheels after which scans are compared [m, rad]."""
RANGE, CELL = 5.0, 0.05
"""Range of the points that are compared, and side of the cells [m]."""
FEWEST = 8
"""Minimum number of points for a comparison."""
FAR = 0.2
"""Largest distance of a point from those of the other scan that counts [m]."""
CHANGED = 0.05
"""Mean distance of the points of two scans from different places [m]."""

SLIPPING = 4.0
"""Time after which slip is reported; the robot has stood for up to a second longer [s]."""


class WheelSlip:
    """Compares scans before and after the wheels turn.

    The wheels slip if a scan fits an earlier one unmoved, and does not fit if moved by odometry. Where it
    fits both ways, as in a long corridor, nothing is known.
    """

    def __init__(self) -> None:
        """Start without a scan."""
        self._moved, self._start, self._since = Pose(0.0, 0.0, 0.0), Pose(0.0, 0.0, 0.0), 0.0
        self._before: ObstacleMap | None = None
        self.held: Pose | None = None
        """Estimate of the pose where the wheels began to slip; None while they do not."""

    def lasts(self, now: float) -> float:
        """Return how long the wheels have slipped until a time [s]."""
        return 0.0 if self.held is None else now - self._since

    def update(self, pose: Pose, odometry: Odometry, views: list[RangeView], now: float) -> None:
        """Add the motion of a tick, and its scan if there is one.

        Args:
            pose: Pose of the robot, as estimated.
            odometry: Motion of the tick.
            views: What it sees.
            now: [s]
        """
        self._moved = self._moved @ Pose(odometry.forward, odometry.left, odometry.turn)
        driven = math.hypot(self._moved.x, self._moved.y) > DRIVEN or abs(self._moved.heading) > TURNED
        if not views or not (driven or self._before is None):
            return
        points = np.concatenate([view.points() for view in views])
        points, still, moved = points[np.abs(points).max(axis=1, initial=0.0) < RANGE], 0.0, 0.0
        if self._before is not None and len(points) >= FEWEST:
            still, moved = _misfit(points, self._before), _misfit(self._moved.transform(points), self._before)
            if moved > CHANGED > still and still < 0.5 * moved:
                self.held = self._start
            elif still > CHANGED:
                self.held = None
        if self.held is None:
            # The body may rock before scans stay the same: the wheels slip since odometry fits the scans worse than
            # standing still.
            self._since = self._since if moved > max(CHANGED, still) else now
            self._moved, self._start = Pose(0.0, 0.0, 0.0), pose
            self._before = ObstacleMap(np.zeros(2), points, cell=CELL, half=RANGE + FAR) if len(points) else None


def _misfit(points: Array, before: ObstacleMap) -> float:
    """Return the mean distance of points (n, 2) from those of a scan before [m]."""
    return float(np.minimum(before.at(points[:, 0], points[:, 1]), FAR).mean())
