"""Drives from point to point without turning, for robots that can move sideways."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.random import Generator

from mjsim.interface import Command, Estimate, Observation, RobotInfo, WorldMap


class Crab:
    """Drives straight to each point in turn with constant heading; stops at the last one.

    The velocity points at the goal, decreases before it so that half of the maximum acceleration suffices to brake, and
    is rotated into the robot's frame; a proportional law holds the heading.
    """

    def __init__(self, points: Sequence[Sequence[float]], *, speed: float = 0.4, tolerance: float = 0.05) -> None:
        """Set the points.

        Args:
            points: Where to go, each (x, y) [m], in the frame of the estimate.
            speed: [m/s]
            tolerance: How near a point counts as reached [m].
        """
        self._points = np.asarray(points, dtype=float)
        if self._points.ndim != 2 or self._points.shape[1] != 2 or not len(self._points):
            raise ValueError(f"points has shape {self._points.shape}; give at least one [x, y]")
        self._speed, self._tolerance = speed, tolerance

    def start(self, robot: RobotInfo, map: WorldMap | None, rng: Generator) -> None:
        """Start with the first point.

        Raises:
            ValueError: The robot cannot move sideways.
        """
        if robot.max_left == 0.0:
            raise ValueError(f"robot '{robot.name}' with its {robot.drive} drive cannot move sideways; use Waypoints")
        self._robot, self._heading, self._next = robot, robot.prior.heading, 0

    def command(self, seen: Observation, belief: Estimate) -> Command:
        """Return the twist toward the next point; zero once the last is reached."""
        while self._next < len(self._points):
            x, y = self._points[self._next]
            ahead, left = belief.pose.inverse().transform(np.array([x, y])).tolist()
            distance = math.hypot(ahead, left)
            if distance > self._tolerance:
                return self._toward(ahead / distance, left / distance, distance, belief.pose.heading)
            self._next += 1
        return Command()

    def _toward(self, ahead: float, left: float, distance: float, heading: float) -> Command:
        """Return the twist in a direction of the robot's frame, with a distance left [m]."""
        heading_error = (self._heading - heading + math.pi) % (2.0 * math.pi) - math.pi
        speed = min(self._speed, math.sqrt(self._robot.max_acceleration * distance), 2.0 * distance + 0.02)
        return Command(speed * ahead, left=speed * left, turn=1.5 * heading_error)
