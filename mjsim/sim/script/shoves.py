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
    """Remaining physics steps."""
    signal: TimeSignal = Constant(level=1.0)  # noqa: RUF009  # frozen
    """Factor of the force over time."""
    done: int = 0
    """Physics steps so far."""


class Shoves:
    """Active shoves and forces; the force of a shove adds up over time to exactly the requested impulse."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Start with none."""
        self._model, self._data = model, data
        self._acting: list[_Shove] = []

    def __bool__(self) -> bool:
        """Return whether a shove is active, or its force is still set."""
        return bool(self._acting)

    def add(self, body: str, impulse: Sequence[float], seconds: float) -> None:
        """Start a shove.

        Args:
            body: Its name in MuJoCo.
            impulse: World frame, three numbers [N s].
            seconds: Duration; rounded to whole physics steps, at least one.
        """
        step = self._model.opt.timestep
        count = max(round(seconds / step), 1)
        force = np.asarray(impulse, dtype=float) / (count * step)
        self._acting.append(_Shove(self._model.body(body).id, force, count))

    def push_along(self, body: str, signal: TimeSignal, along: Sequence[float], *, seconds: float | None) -> None:
        """Start a force that changes with time.

        Args:
            body: Its name in MuJoCo.
            signal: The force; its time starts now [N].
            along: Direction of a positive force, world frame.
            seconds: Duration, rounded to whole physics steps, at least one; None for unlimited.
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
