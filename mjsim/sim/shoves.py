"""Shoves: a force at the centre of mass of a robot or an object, for some time."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.mechanics import Constant, TimeSignal


@dataclass(slots=True, eq=False)
class _Shove:
    body: int
    force: Array
    """World frame, shape (3,) [N]."""
    left: float
    """Physics steps that it still acts for."""
    signal: TimeSignal = Constant(level=1.0)  # noqa: RUF009  # frozen
    """What the force is multiplied by."""
    done: int = 0
    """Physics steps that it acted for."""


class Shoves:
    """The shoves that act now; what they give together is the impulse asked for, exactly."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Start with none."""
        self._model, self._data = model, data
        self._acting: list[_Shove] = []

    def __bool__(self) -> bool:
        """Return whether one acts, or has left its force behind."""
        return bool(self._acting)

    def add(self, body: str, impulse: Sequence[float], seconds: float) -> None:
        """Begin a shove.

        Args:
            body: Its name in MuJoCo.
            impulse: World frame, three numbers [N s].
            seconds: How long; rounded to whole physics steps, at least one.
        """
        step = self._model.opt.timestep
        count = max(round(seconds / step), 1)
        force = np.asarray(impulse, dtype=float) / (count * step)
        self._acting.append(_Shove(self._model.body(body).id, force, count))

    def push_along(self, body: str, signal: TimeSignal, along: Sequence[float], *, seconds: float | None) -> None:
        """Begin a force that changes with time.

        Args:
            body: Its name in MuJoCo.
            signal: The force; its time is counted from now [N].
            along: Direction of a positive force, world frame.
            seconds: How long, rounded to whole physics steps, at least one; None for ever.
        """
        left = math.inf if seconds is None else max(round(seconds / self._model.opt.timestep), 1)
        self._acting.append(_Shove(self._model.body(body).id, np.asarray(along, dtype=float), left, signal))

    def push(self) -> None:
        """Set the forces of the next physics step."""
        forces, step = self._data.xfrc_applied, self._model.opt.timestep
        for shove in self._acting:
            forces[shove.body, :3] = 0.0
        self._acting = [shove for shove in self._acting if shove.left > 0]
        for shove in self._acting:
            forces[shove.body, :3] += shove.force * shove.signal.value(shove.done * step)
            shove.left -= 1
            shove.done += 1
