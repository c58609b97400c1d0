"""Actuation: converts commands to motor inputs, at its own rate."""

from collections.abc import Sequence
from typing import Protocol

import mujoco
import numpy as np

from mjsim.sim.bases import RunningGear


class Actuation(Protocol):
    """Sets motor inputs at its own rate; each is called at the start of a tick.

    The velocity servos of rolling bases get their set-points once per tick; controllers act more often.
    """

    every: int
    """Physics steps from one call to the next; a divisor of those per tick."""

    def act(self, step: int) -> None:
        """Write to `data.ctrl`, before the physics step of that number, counted from 0 at the start of the run."""


class ServoActuation:
    """The set-points of a rolling base's servos, set once per tick."""

    def __init__(self, data: mujoco.MjData, gear: RunningGear, servos: Sequence[int], *, every: int) -> None:
        """Initialise.

        Args:
            data: State of the simulation.
            gear: Running gear whose profile gives the set-points.
            servos: Numbers of its actuators, in the order of those set-points.
            every: Physics steps in a tick.
        """
        self._data, self._gear, self._servos = data, gear, np.array(servos, dtype=int)
        self.every = every

    def act(self, step: int) -> None:
        """Write the set-points of the servos until the next tick."""
        self._data.ctrl[self._servos] = self._gear.profile.advance()
