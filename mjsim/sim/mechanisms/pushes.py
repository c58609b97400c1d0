"""Torques and forces on the bodies of mechanisms."""

from collections.abc import Callable

import mujoco
import numpy as np
from numpy.random import Generator

from mjsim.mechanics import Constant, TimeSignal
from mjsim.world import GROUND, Actuator, Assembly, ForceActuator, Mechanism, TorqueActuator, place_of


def effort_signal(
    assembly: Assembly, number: int, actuator: Actuator, read: Callable[[str], bytes], rng: Generator
) -> TimeSignal:
    """Return a torque or force over time; a trimmed one is constant.

    Args:
        assembly: Assembly of the mechanism.
        number: Number of the actuator.
        actuator: Actuator of the world file.
        read: Returns the content of a file named in the world.
        rng: Generator of a random signal.
    """
    if number in assembly.found:
        return Constant(level=assembly.found[number])
    assert actuator.signal is not None, "checked when it was read"
    return actuator.signal.made(read, rng)


def around(signal: TimeSignal, step: int, h: float) -> float:
    """Return the mean of a signal over a period of the physics centered at a step, without any part before step 0.

    Velocities are half a period off positions, so a jump at a step is in the middle of the period.

    Args:
        signal: Signal of a torque or force [N m, N].
        step: Number of the step, counted from 0 at the start of the run.
        h: Period of the physics [s].
    """
    return float(signal.value(max(step - 0.25, 0.0) * h) + signal.value((step + 0.25) * h)) / 2.0


class Push:
    """A torque on a body, or a force on a point of it, along an axis of the mechanism's frame."""

    def __init__(
        self,
        model: mujoco.MjModel,
        mechanism: Mechanism,
        actuator: TorqueActuator | ForceActuator,
        signal: TimeSignal,
    ) -> None:
        """Find the body.

        Args:
            model: The compiled world.
            mechanism: Mechanism of the body.
            actuator: Actuator of the world file.
            signal: The torque or force [N m, N].
        """
        points = {GROUND: dict[str, tuple[float, ...]](), **{body.name: body.points() for body in mechanism.bodies}}
        place = place_of(actuator.target, points)
        self.signal = signal
        """The torque or force [N m, N]."""
        self._model, self._at = model, np.array(place.at)
        self._body = model.body(f"{mechanism.name}/{place.body}").id
        axis = np.array(actuator.axis, dtype=float) / np.linalg.norm(actuator.axis or (0.0, 0.0, 1.0))
        self._axis = mechanism.world_from_ground[:3, :3] @ axis
        self._is_force = isinstance(actuator, ForceActuator)

    def apply(self, data: mujoco.MjData, size: float) -> None:
        """Add a torque or force [N m, N] to the generalized forces."""
        effort = size * self._axis
        force, torque = (effort, np.zeros(3)) if self._is_force else (np.zeros(3), effort)
        point = data.xmat[self._body].reshape(3, 3) @ self._at + data.xpos[self._body]
        mujoco.mj_applyFT(self._model, data, force, torque, point, self._body, data.qfrc_applied)
