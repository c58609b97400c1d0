"""Health checks of the simulation state, from MuJoCo's warnings and from its values."""

from collections.abc import Iterator
from contextlib import contextmanager

import mujoco
import numpy as np

from mjsim.compile import likely_cause
from mjsim.world import World

MAX_SPEED = 100.0
"""Speed above which the physics must have failed [m/s]."""


@contextmanager
def collected_warnings() -> Iterator[list[str]]:
    """Yield a list that collects MuJoCo's warnings, which it otherwise prints and writes to a file."""
    messages: list[str] = []
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(messages.append)
    try:
        yield messages
    finally:
        mujoco.set_mju_user_warning(before)


class Health:
    """Reports failures in the state of a compiled world."""

    def __init__(self, model: mujoco.MjModel, world: World) -> None:
        """Find the velocities to check: those of free bases."""
        starts = [model.joint(f"{robot.name}/free").dofadr[0] for robot in world.robots if robot.base != "fixed"]
        self._model, self._world = model, world
        self._speeds = np.array([start + axis for start in starts for axis in range(3)], dtype=int)

    def fault(self, data: mujoco.MjData, messages: list[str], *, loop: str | None) -> str | None:
        """Return the failure and its likely cause; None without a failure.

        Args:
            data: The state.
            messages: Warnings of its last steps.
            loop: Description of mechanisms that failed, which is preferred to MuJoCo's own warning.
        """
        warning, speeds = data.warning, data.qvel[self._speeds]
        if warning.number.any():
            kind = int(np.flatnonzero(warning.number)[0])
            text = messages[0] if messages else mujoco.mju_warningText(kind, int(warning.lastinfo[kind]))
            failure = loop or text.partition(" Time = ")[0]
        elif loop:
            failure = loop
        elif not np.isfinite(data.qpos).all() or not (np.abs(speeds) < MAX_SPEED).all():
            failure = f"a robot moves at {np.abs(speeds).max():g} m/s"
        else:
            return None
        from mjsim.world import diverging_springs  # this loads the code of mechanisms

        cause = next((text for text, _ in diverging_springs(self._world)), "") or likely_cause(self._model)
        return f"{failure}; likely cause: {cause}" if cause else failure
