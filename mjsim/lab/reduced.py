"""A part of a scene in independent coordinates: joints, contacts and loops constrain it exactly.

MuJoCo's constraints are slightly soft, which adds fast modes that no textbook plant has. Here MuJoCo provides masses,
forces and the Jacobians of constraints; the accelerations are those of a part with rigid constraints.

References:
    Featherstone, Rigid Body Dynamics Algorithms (2008), section 3.2: N' M N w' = N' f with J N = 0.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.lab.effects import InputEffect

MIN_FRICTION = 1e-3
"""A contact with less friction constrains only its normal direction."""
RANK_TOLERANCE = 1e-9
"""A constraint that adds less than this to the others is redundant."""


@dataclass(frozen=True, slots=True, eq=False)
class Setting:
    """An equilibrium state, and its input."""

    qpos: Array
    """Shape (nq,)."""
    act: Array
    """Activations of actuators, shape (na,)."""
    value: float = 0.0
    """Value of the input."""


class Reduced:
    """Some degrees of freedom of a model under its constraints, about a setting."""

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
        """Determine the independent degrees of freedom.

        Args:
            model: The compiled world.
            setting: The operating point; contacts must be closed.
            effect: Effect of the input.
            dofs: Degrees of freedom of the part.
            prefer: Degrees of freedom preferred as coordinates, in order of preference; the others follow.
            locked: Locked degrees of freedom.
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
        """The degrees of freedom used as coordinates."""

    def basis(self, setting: Setting) -> Array:
        """Return N, the velocities of all degrees of freedom of the model per velocity of the coordinates, (nv, n)."""
        self._place(setting)
        return self._basis()

    def moved(self, setting: Setting, step: Array) -> Setting:
        """Return a setting displaced by a small step of the coordinates, shape (n,)."""
        qpos = setting.qpos.copy()
        mujoco.mj_integratePos(self.model, qpos, self.basis(setting) @ step, 1.0)
        return replace(setting, qpos=qpos)

    def acceleration(self, setting: Setting, rates: Array | None = None) -> Array:
        """Return the accelerations of the coordinates, shape (n,).

        Args:
            setting: The state.
            rates: Rates of the coordinates, shape (n,); by default at rest. Constraint terms quadratic in the rates are
                omitted, so that only differences about rest are meaningful.
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
        """Return the rows of constrained velocities: of loops, closed contacts, and locked joints."""
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
                sticks = contact.dim >= 3 and contact.friction[0] > MIN_FRICTION
                rows += range(contact.efc_address, contact.efc_address + (3 if sticks else 1))
        return rows

    def _independent(self, J: Array, order: Sequence[int]) -> Array:
        """Return the columns that can be chosen independently: the first in order that determine the others."""
        dependent: list[int] = []
        rank = (
            np.linalg.matrix_rank(J, tol=RANK_TOLERANCE * max(1.0, float(np.abs(J).max(initial=0.0)))) if len(J) else 0
        )
        # Gram-Schmidt from the least preferred: a column that adds to the span is determined by the constraints.
        span = np.zeros((0, len(J)))
        for column in reversed(order):
            left = J[:, column] - span.T @ (span @ J[:, column])
            left -= span.T @ (span @ left)
            length = float(np.linalg.norm(left))
            if len(dependent) < rank and length > 1e-6:
                dependent.append(column)
                span = np.vstack([span, left / length])
        return np.array([column for column in order if column not in dependent], dtype=int)
