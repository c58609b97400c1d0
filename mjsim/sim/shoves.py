"""Shoves: a force at the centre of mass of a robot or a thing, for a while."""

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from mjsim.geometry import Array


@dataclass(slots=True, eq=False)
class _Shove:
    body: int
    force: Array
    """World frame, shape (3,) [N]."""
    left: int
    """Physics steps that it still acts for."""


class Shoves:
    """The shoves that act now; what they give together is the impulse asked for, exactly."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Begin with none."""
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

    def push(self) -> None:
        """Set the forces of the next physics step."""
        forces = self._data.xfrc_applied
        for shove in self._acting:
            forces[shove.body, :3] = 0.0
        self._acting = [shove for shove in self._acting if shove.left > 0]
        for shove in self._acting:
            forces[shove.body, :3] += shove.force
            shove.left -= 1
