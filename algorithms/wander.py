"""Drives at random: exploration without a plan."""

import math

import numpy as np
from numpy.random import Generator

from mjsim.interface import Command, Estimate, Observation, RobotInfo, WorldMap

AHEAD = (15, 0, 1)
"""Rays of the ring in the driving direction."""


class Wander:
    """Drives straight ahead; before an obstacle it turns on the spot by a random angle.

    It needs only the ring of proximity rays; with `avoidance: true` it also avoids corners of obstacles between two
    rays.
    """

    def __init__(self, *, speed: float = 0.4, distance: float = 0.5) -> None:
        """Set speed and distance.

        Args:
            speed: Speed, limited by that of the robot [m/s].
            distance: Distance to an obstacle ahead at which the robot turns [m].
        """
        if speed <= 0 or distance <= 0:
            raise ValueError(f"speed is {speed} and distance {distance}; both must be above 0")
        self._speed, self._distance = speed, distance

    def start(self, robot: RobotInfo, map: WorldMap | None, rng: Generator) -> None:
        """Start by driving ahead."""
        self._robot, self._rng = robot, rng
        self._left_to_turn = 0.0

    def command(self, seen: Observation, belief: Estimate) -> Command:
        """Return the twist: ahead, or the current turn."""
        self._left_to_turn -= math.copysign(min(abs(seen.odometry.turn), abs(self._left_to_turn)), self._left_to_turn)
        blocked = bool(np.min(seen.proximity[list(AHEAD)]) < self._distance) or bool(seen.bump)
        if blocked and abs(self._left_to_turn) < 0.05:
            # Away from the nearer side, by 45 to 150 degrees.
            side = -1.0 if np.min(seen.proximity[1:8]) < np.min(seen.proximity[9:16]) else 1.0
            self._left_to_turn = side * self._rng.uniform(math.pi / 4, 5 * math.pi / 6)
        if abs(self._left_to_turn) >= 0.05:
            fastest = min(1.0, 0.6 * self._robot.max_turn, 2.0 * abs(self._left_to_turn))
            return Command(turn=math.copysign(fastest, self._left_to_turn))
        return Command(forward=min(self._speed, self._robot.max_speed))
