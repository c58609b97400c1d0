"""Runs controllers between ticks: each sets the motor torques of one part of a robot."""

import math
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.random import Generator

from mjsim.errors import UsageError
from mjsim.interface import Command, ControlLoop, RobotInfo
from mjsim.modules import CheckedController
from mjsim.sentences import Sentence
from mjsim.sim.fast_senses import FastSenses
from mjsim.world import step_misfit


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DrivenPart:
    """A part of a robot with motors driven by a controller."""

    robot: str
    name: str
    """'drive', or the name of an arm."""
    motors: Sequence[str]
    """Motors in the order of the torques; hinges or slides and their motors are `ROBOT/MOTOR`."""
    wanted: Callable[[float], Command]
    """Gives the set-points for the next time [s]."""
    senses: Callable[[], FastSenses]
    """Gives the inputs of a controller of this part."""
    default: Callable[[], ControlLoop]
    """Creates the default controller of the part."""


class ControlActuation:
    """Calls the controller of a part at its rate, and applies its torques after its latency.

    Torques are on the side of the joint. They are divided by the gear ratio of the motor; MuJoCo applies the limits.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, part: DrivenPart, *, loop: ControlLoop) -> None:
        """Initialise; the controller is first called at the next step that is due.

        Args:
            model: The compiled world.
            data: Its state.
            part: The controlled part.
            loop: The controller, its rate and its latency.

        Raises:
            UsageError: The rate is not a whole number of physics steps, or the latency is negative.
            ModuleFault: The controller lacks a method.
        """
        self._step, self._data, self._part = model.opt.timestep, data, part
        self._period, self._latency = _steps(loop, part, self._step)
        self.every = math.gcd(self._period, self._latency)
        motors = [model.actuator(f"{part.robot}/{name}").id for name in part.motors]
        self._motors = np.array(motors, dtype=int)
        self._gears = model.actuator_gear[self._motors, 0].copy()
        self._senses = part.senses()
        self._coming: deque[tuple[int, tuple[float, ...]]] = deque()
        self._controller = CheckedController(
            loop.controller, robot=part.robot, part=part.name, motors=part.motors, clock=lambda: float(data.time)
        )

    def start(self, robot: RobotInfo, rng: Generator) -> None:
        """Start the controller for a run."""
        self._controller.start(robot, rng)
        self._data.ctrl[self._motors] = 0.0

    def act(self, step: int) -> None:
        """Call the controller when it is due, and apply the torques after the latency."""
        if step % self._period == 0:
            dt = self._period * self._step
            sensed = self._senses.read(step * self._step, dt)
            torques = self._controller.torques(sensed, self._part.wanted(dt))
            self._coming.append((step + self._latency, torques))
        while self._coming and self._coming[0][0] <= step:
            self._data.ctrl[self._motors] = self._coming.popleft()[1] / self._gears

    def seconds(self) -> float:
        """Return the wall-clock time inside the controller since the last call of this method [s]."""
        return self._controller.seconds()


def _steps(loop: ControlLoop, part: DrivenPart, step: float) -> tuple[int, int]:
    """Return period and latency of a controller in physics steps.

    Raises:
        UsageError: They are not integers, or negative.
    """
    rate, latency = loop.rate_hz, loop.latency
    if not (isinstance(rate, int | float) and math.isfinite(rate) and rate > 0):
        raise UsageError(
            Sentence("rate_hz of the controller of '{name}' is {rate}; it must be above 0", part.name, rate)
        )
    if (misfit := step_misfit(f"a period of the controller of '{part.name}'", rate, step)) is not None:
        raise UsageError(misfit)
    if not isinstance(latency, int) or latency < 0:
        raise UsageError(
            Sentence(
                "latency of the controller of '{name}' is {latency}; it is a number of steps from 0", part.name, latency
            )
        )
    return round(1.0 / (rate * step)), latency
