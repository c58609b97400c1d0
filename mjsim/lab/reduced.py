"""A part of a scene in coordinates that are free: what holds it, joints, contacts and loops, holds exactly.

MuJoCo's constraints yield a little, which adds fast modes that no textbook plant has. Here MuJoCo gives masses, forces
and the Jacobians of constraints; the accelerations are those of the part whose constraints do not yield at all.

References:
    Featherstone, Rigid Body Dynamics Algorithms (2008), section 3.2: N' M N w' = N' f with J N = 0.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.lab.effects import InputEffect

SLIPPERY = 1e-3
"""A contact with less friction holds in its normal alone."""
RANK = 1e-9
"""A constraint that adds less to the others says nothing new."""


@dataclass(frozen=True, slots=True, eq=False)
class Setting:
    """A state at rest, and the input there."""

    qpos: Array
    """Shape (nq,)."""
    act: Array
    """Activations of actuators, shape (na,)."""
    value: float = 0.0
    """Of the input."""


class Reduced:
    """Some degrees of freedom of a model, held by its constraints, about a setting."""

    def __init__(
        self,
        model: mujoco.MjModel,
        setting: Setting,
        *,
        effect: InputEffect,
        dofs: Sequence[int],
        prefer: Sequence[int],
        locked: Sequence[int],
    ) -> None:
        """Find out which degrees of freedom may be chosen freely.

        Args:
            model: The compiled world.
            setting: Where; contacts must be there.
            effect: What the input does.
            dofs: Those of the part.
            prefer: Those of them that shall be chosen as coordinates, the dearest first; the others follow.
            locked: Those of them that stand still.
        """
        self.model, self._data, self._effect = model, mujoco.MjData(model), effect
        self._dofs = np.array(dofs, dtype=int)
        self._locked = np.isin(self._dofs, np.array(locked, dtype=int))
        self._bodies = set(np.flatnonzero(np.isin(model.body_rootid, model.body_rootid[model.dof_bodyid[self._dofs]])))
        order = [*prefer, *(dof for dof in dofs if dof not in set(prefer))]
        self._place(setting)
        J = self._jacobian()
        self._free = self._independent(J, [dofs.index(dof) for dof in order])
        self._held = np.setdiff1d(np.arange(len(self._dofs)), self._free)
        self.coordinates: tuple[int, ...] = tuple(self._dofs[self._free].tolist())
        """The degrees of freedom that are the coordinates."""

    def basis(self, setting: Setting) -> Array:
        """Return N, the velocities of all degrees of freedom of the model for those of the coordinates, (nv, n)."""
        self._place(setting)
        return self._basis()

    def moved(self, setting: Setting, step: Array) -> Setting:
        """Return a setting a small step of the coordinates away, shape (n,)."""
        qpos = setting.qpos.copy()
        mujoco.mj_integratePos(self.model, qpos, self.basis(setting) @ step, 1.0)
        return replace(setting, qpos=qpos)

    def acceleration(self, setting: Setting, rates: Array | None = None) -> Array:
        """Return the accelerations of the coordinates, shape (n,).

        Args:
            setting: Where.
            rates: Of the coordinates, shape (n,); by default at rest. What constraints add with the square of rates
                is left out, so that only differences about rest mean something.
        """
        self._place(setting)
        model, data, N = self.model, self._data, self._basis()
        data.qvel[:] = 0.0 if rates is None else N @ rates
        mujoco.mj_fwdVelocity(model, data)
        mujoco.mj_fwdActuation(model, data)
        force = data.qfrc_passive + data.qfrc_actuator + data.qfrc_applied - data.qfrc_bias
        M = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, M)
        return np.asarray(np.linalg.solve(N.T @ M @ N, N.T @ force))

    def activation_rate(self, setting: Setting) -> Array:
        """Return the rates of the activations, shape (na,)."""
        self._place(setting)
        mujoco.mj_fwdVelocity(self.model, self._data)
        mujoco.mj_fwdActuation(self.model, self._data)
        return np.array(self._data.act_dot)

    def _place(self, setting: Setting) -> None:
        data = self._data
        data.qpos[:], data.qvel[:], data.act[:] = setting.qpos, 0.0, setting.act
        self._effect.write(data, setting.value)
        mujoco.mj_fwdPosition(self.model, data)

    def _basis(self) -> Array:
        J = self._jacobian()
        N = np.zeros((len(self._dofs), len(self._free)))
        N[self._free] = np.eye(len(self._free))
        if len(self._held):
            N[self._held] = -np.linalg.lstsq(J[:, self._held], J[:, self._free], rcond=None)[0]
        whole = np.zeros((self.model.nv, len(self._free)))
        whole[self._dofs] = N
        return whole

    def _jacobian(self) -> Array:
        """Return the rows that must not move: of loops, of contacts that hold, and of what is locked."""
        model, data = self.model, self._data
        rows = np.zeros((data.nefc, model.nv))
        if data.nefc and mujoco.mj_isSparse(model):
            mujoco.mju_sparse2dense(rows, data.efc_J, data.efc_J_rownnz, data.efc_J_rowadr, data.efc_J_colind)
        elif data.nefc:
            rows = np.array(data.efc_J).reshape(data.nefc, model.nv)
        loops = np.flatnonzero(data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY)
        held = [*loops.tolist(), *self._contact_rows()]
        J = rows[held][:, self._dofs]
        locked = np.eye(len(self._dofs))[self._locked]
        return np.concatenate([J[np.abs(J).max(axis=1, initial=0.0) > 0.0], locked])

    def _contact_rows(self) -> list[int]:
        rows: list[int] = []
        geoms = self.model.geom_bodyid
        for contact in self._data.contact:
            ours = geoms[contact.geom1] in self._bodies or geoms[contact.geom2] in self._bodies
            if ours and contact.efc_address >= 0:
                sticks = contact.dim >= 3 and contact.friction[0] > SLIPPERY
                rows += range(contact.efc_address, contact.efc_address + (3 if sticks else 1))
        return rows

    def _independent(self, J: Array, order: Sequence[int]) -> Array:
        """Return which columns may be chosen freely: the first in the order that leave the others determined."""
        dependent: list[int] = []
        rank = np.linalg.matrix_rank(J, tol=RANK * max(1.0, float(np.abs(J).max(initial=0.0)))) if len(J) else 0
        # Gram-Schmidt from the least preferred on: what adds to the span is determined by the constraints.
        span = np.zeros((0, len(J)))
        for column in reversed(order):
            left = J[:, column] - span.T @ (span @ J[:, column])
            left -= span.T @ (span @ left)
            length = float(np.linalg.norm(left))
            if len(dependent) < rank and length > 1e-6:
                dependent.append(column)
                span = np.vstack([span, left / length])
        return np.array([column for column in order if column not in dependent], dtype=int)
