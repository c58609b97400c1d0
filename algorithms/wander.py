"""Drives to random places, as a robot that explores without a plan."""

import math

import numpy as np
from numpy.random import Generator

from mjsim.interface import Command, Estimate, Observation, RobotInfo, Shown, WorldMap

from .go_to_goal.go_to_goal import GoToGoal

NEAREST = 0.4
"""Smallest distance of a place, as a share of the largest."""
PATIENCE = 20.0
"""Time after which it drives to another place [s]."""


class Wander:
    """Drives by `GoToGoal` to random places, and to another when it is there, gets no nearer, or takes long.

    The ring of proximity rays suffices.
    """

    def __init__(self, *, speed: float = 0.4, distance: float = 5.0) -> None:
        """Set speed and distance.

        Args:
            speed: [m/s], if the robot can.
            distance: Largest distance of a place from the robot [m].
        """
        if speed <= 0 or distance <= 0:
            raise ValueError(f"speed is {speed} and distance {distance}; both must be above 0")
        self._speed, self._distance = speed, distance

    def start(self, robot: RobotInfo, map: WorldMap | None, rng: Generator) -> None:
        """Start without a place to go to."""
        self._rng, self._until = rng, -math.inf
        self._drive = GoToGoal([robot.prior.x, robot.prior.y], speed=self._speed)
        self._drive.start(robot, map, np.random.default_rng(rng.integers(1 << 32)))

    def command(self, seen: Observation, belief: Estimate) -> Command:
        """Return the twist that leads to the current place."""
        if self._drive.is_done or self._drive.blocked() is not None or seen.time >= self._until:
            self._until, pose = seen.time + PATIENCE, self._drive.pose
            bearing, away = self._rng.uniform(-math.pi, math.pi), self._rng.uniform(NEAREST, 1.0) * self._distance
            self._drive.take_goal(pose.x + away * math.cos(bearing), pose.y + away * math.sin(bearing))
        return self._drive.command(seen, belief)

    def show(self) -> tuple[Shown, ...]:
        """Return the planned path, in the frame of the estimate, if there is one."""
        return self._drive.show()
