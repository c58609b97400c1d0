"""A constant command."""

import math

from numpy.random import Generator

from mjsim.interface import Command, Estimate, Observation, RobotInfo, WorldMap


class ConstantCommand:
    """Commands the same twist at every tick; the bump reaction and optional avoidance protect the robot."""

    def __init__(self, *, forward: float = 0.0, left: float = 0.0, turn: float = 0.0) -> None:
        """Set the twist, in the robot's frame.

        Args:
            forward: [m/s]
            left: [m/s]
            turn: [rad/s], counter-clockwise positive.

        Raises:
            ValueError: One of them is not finite.
        """
        if not all(map(math.isfinite, (forward, left, turn))):
            raise ValueError(f"forward, left and turn are {forward}, {left} and {turn}; they must be finite")
        self._command = Command(forward, left, turn)

    def start(self, robot: RobotInfo, map: WorldMap | None, rng: Generator) -> None:
        """Do nothing."""

    def command(self, seen: Observation, belief: Estimate) -> Command:
        """Return the twist that was set."""
        return self._command
