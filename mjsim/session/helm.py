"""The latest manual command of each robot."""

import math
import threading
from collections.abc import Iterable

from mjsim.errors import UsageError, did_you_mean
from mjsim.interface import Command
from mjsim.sentences import Sentence


class Helm:
    """Holds manual commands until they expire; set from any thread, read by the run."""

    def __init__(self, robots: Iterable[str]) -> None:
        """Start without manual control."""
        self._robots = tuple(robots)
        self._lock = threading.Lock()
        self._new: dict[str, tuple[Command, float]] = {}
        self._until: dict[str, tuple[Command, float]] = {}

    def take(self, robot: str, command: Command | None, *, hold: float) -> None:
        """Drive a robot manually from its next tick on, for a simulated time [s]; None returns control.

        Raises:
            UsageError: The robot does not exist, or a number is not finite.
        """
        if robot not in self._robots:
            raise UsageError(
                Sentence("no robot '{robot}' to drive in this world{meant}", robot, did_you_mean(robot, self._robots))
            )
        if command is not None and not all(map(math.isfinite, (command.forward, command.left, command.turn, hold))):
            raise UsageError(
                Sentence("the command for robot '{robot}' is {command}; its numbers must be finite", robot, command)
            )
        with self._lock:
            self._until.pop(robot, None)
            self._new.pop(robot, None)
            if command is not None:
                self._new[robot] = command, hold

    def let_go(self) -> None:
        """End manual control of all robots."""
        with self._lock:
            self._new.clear()
            self._until.clear()

    def command(self, robot: str, now: float) -> Command | None:
        """Return the manual command of a robot at a simulated time [s], or None."""
        with self._lock:
            if robot in self._new:
                command, hold = self._new.pop(robot)
                self._until[robot] = command, now + hold
            held = self._until.get(robot)
            if held is None or now > held[1]:
                self._until.pop(robot, None)
                return None
            return held[0]
