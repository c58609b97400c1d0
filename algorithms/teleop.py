"""Drive by keyboard: w, a, s, d or the arrows; space stops. For `mjsim run --realtime` in a terminal."""

import os
import select
import sys
import termios
import tty
import weakref
from typing import Any

from numpy.random import Generator

from mjsim.interface import Command, Estimate, Observation, RobotInfo, WorldMap

KEYS = {
    "w": (1, 0), "\x1b[A": (1, 0), "s": (-1, 0), "\x1b[B": (-1, 0),
    "a": (0, 1), "\x1b[D": (0, 1), "d": (0, -1), "\x1b[C": (0, -1),
}  # fmt: skip
"""Key -> steps of speed and of turn rate; arrow keys are three characters."""
STEPS = 5
"""Key presses from standstill to the largest speed."""


class Teleop:
    """Turns key presses into a twist: w and s change the speed by a step, a and d the turn rate."""

    def __init__(self, *, speed: float = 0.5, turn_deg: float = 60.0) -> None:
        """Set the largest speed [m/s] and turn rate [degrees/s], if the robot can."""
        self._speed, self._turn = speed, turn_deg * 3.141592653589793 / 180.0

    def start(self, robot: RobotInfo, map: WorldMap | None, rng: Generator) -> None:
        """Read single key presses; the terminal is restored when the run ends.

        Raises:
            RuntimeError: Standard input is not a terminal.
        """
        if not sys.stdin.isatty():
            raise RuntimeError("teleop listens to the keyboard, and standard input is not a terminal; run it in one")
        self._speed, self._turn = min(self._speed, robot.max_speed), min(self._turn, robot.max_turn)
        self._forward_steps = self._turn_steps = 0
        self._stream = sys.stdin.fileno()
        weakref.finalize(self, _restore, self._stream, termios.tcgetattr(self._stream))
        tty.setcbreak(self._stream)

    def command(self, seen: Observation, belief: Estimate) -> Command:
        """Return the twist that the keys command."""
        while select.select([self._stream], [], [], 0.0)[0]:
            typed = os.read(self._stream, 64).decode(errors="ignore")
            if not typed:
                break  # The terminal was closed.
            self._take(typed)
        return Command(forward=self._speed * self._forward_steps / STEPS, turn=self._turn * self._turn_steps / STEPS)

    def _take(self, typed: str) -> None:
        while typed:
            key = next((key for key in KEYS if typed.startswith(key)), typed[0])
            typed = typed[len(key) :]
            if key == " ":
                self._forward_steps = self._turn_steps = 0
            forward, turn = KEYS.get(key.lower(), (0, 0)) if key not in KEYS else KEYS[key]
            self._forward_steps = max(-STEPS, min(STEPS, self._forward_steps + forward))
            self._turn_steps = max(-STEPS, min(STEPS, self._turn_steps + turn))


def _restore(stream: int, settings: list[Any]) -> None:
    """Restore the settings of the terminal."""
    if os.isatty(stream):
        termios.tcsetattr(stream, termios.TCSADRAIN, settings)
