"""Work and losses of a mechanism, integrated over its steps.

Velocities are half a step before positions. The forces of a step, evaluated at its positions, therefore act from half a
step before to half a step after them: their power is force times the mean of both velocities, and at a tick half of the
work of the step is done.
"""

from collections.abc import Sequence

import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.sim.mechanisms.followers import Follower
from mjsim.sim.mechanisms.mechanism_state import equality_forces

RUBBING = mujoco.mjtConstraint.mjCNSTR_FRICTION_DOF


class EnergyCount:
    """Work of the actuators on a mechanism since the start, and losses by damping and friction."""

    def __init__(self, model: mujoco.MjModel, dofs: Array, followers: Sequence[Follower]) -> None:
        """Start at zero.

        Args:
            model: The compiled world.
            dofs: The mechanism's degrees of freedom, shape (n,).
            followers: The motions that it follows.
        """
        self._model, self._dofs, self._followers = model, dofs, followers
        self._h = float(model.opt.timestep)
        self.work, self.lost = 0.0, 0.0
        """[J]"""

    def begin(self, data: mujoco.MjData) -> None:
        """Subtract the half of the first step before the start; all forces must be computed."""
        work, lost = self._powers(data, data.qvel, 0)
        self.work, self.lost = -self._h / 2.0 * work, -self._h / 2.0 * lost

    def add(self, data: mujoco.MjData, before: Array, lag: Array, step: int) -> None:
        """Add the last step.

        Args:
            data: State after the step, with its forces.
            before: Velocities of the entire world before the step, shape (nv,).
            lag: Part of the applied forces that is not from actuators, shape (n,) [N m, N].
            step: Number of the step.
        """
        dofs, middle = self._dofs, (before + data.qvel) / 2.0
        work, lost = self._powers(data, middle, step)
        self.work += self._h * (work - float(lag @ middle[dofs]))
        # MuJoCo reports the damping for the speeds before the step; the actual one is that at its middle.
        slow = self._model.dof_damping[dofs] * (middle - before)[dofs]
        self.lost += self._h * (lost + float(slow @ middle[dofs]))

    def now(self, data: mujoco.MjData, step: int) -> tuple[float, float]:
        """Return work and losses up to the positions of a step, for which all forces must be computed [J]."""
        work, lost = self._powers(data, data.qvel, step)
        return self.work + self._h / 2.0 * work, self.lost + self._h / 2.0 * lost

    def _powers(self, data: mujoco.MjData, speeds: Array, step: int) -> tuple[float, float]:
        """Return the power of applied forces and actuators, and the losses to damping and friction [W]."""
        dofs = self._dofs
        work = float((data.qfrc_actuator[dofs] + data.qfrc_applied[dofs]) @ speeds[dofs])
        for each in self._followers:
            work += float(equality_forces(data, each.equality).sum()) * each.middle_speed(step)
        rows = np.flatnonzero(data.efc_type == RUBBING)
        own = rows[np.isin(data.efc_id[rows], dofs)] if len(rows) else rows
        rubbed = float(data.efc_force[own] @ speeds[data.efc_id[own]])
        return work, -float(data.qfrc_damper[dofs] @ speeds[dofs]) - rubbed
