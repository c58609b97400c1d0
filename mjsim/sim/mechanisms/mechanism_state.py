"""Indices of the values of a mechanism in MuJoCo's state, and the forces of its constraints and actuators."""

from collections.abc import Sequence

import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.mechanics import inverted, rotation_vector
from mjsim.models import quaternion_of
from mjsim.sim.mechanisms.followers import Follower
from mjsim.world import Assembly, Mechanism


def equality_forces(data: mujoco.MjData, equality: int) -> Array:
    """Return the forces of an equality constraint, shape (rows,) [N, N m]."""
    count = int(data.ne)
    own = (data.efc_id[:count] == equality) & (data.efc_type[:count] == mujoco.mjtConstraint.mjCNSTR_EQUALITY)
    return np.asarray(data.efc_force[:count][own])


def equality_rows(data: mujoco.MjData, equalities: Array) -> list[int]:
    """Return the rows of equality constraints with these numbers."""
    count = int(data.ne)
    own = np.isin(data.efc_id[:count], equalities)
    own &= data.efc_type[:count] == mujoco.mjtConstraint.mjCNSTR_EQUALITY
    found: list[int] = np.flatnonzero(own).tolist()
    return found


def copy_state(source: mujoco.MjData, target: mujoco.MjData, places: Array, speeds: Array) -> None:
    """Copy everything that forces depend on, with other positions and velocities."""
    target.qpos[:], target.qvel[:], target.time = places, speeds, source.time
    target.ctrl[:], target.act[:] = source.ctrl, source.act
    target.qfrc_applied[:], target.xfrc_applied[:] = source.qfrc_applied, source.xfrc_applied
    target.eq_active[:], target.qacc_warmstart[:] = source.eq_active, source.qacc_warmstart


def placed_bodies(model: mujoco.MjModel, source: mujoco.MjData, target: mujoco.MjData) -> None:
    """Compute the poses of all bodies for the positions of one state in another."""
    target.qpos[:], target.eq_active[:] = source.qpos, source.eq_active
    mujoco.mj_kinematics(model, target)
    mujoco.mj_comPos(model, target)


class Places:
    """Indices of the values of a mechanism in MuJoCo's state."""

    def __init__(self, model: mujoco.MjModel, mechanism: Mechanism) -> None:
        assembly, name = mechanism.assembly, mechanism.name
        columns, qpos, dofs = list[int](), list[int](), list[int]()
        self._balls: list[tuple[int, int, int, int]] = []
        for number, tree in enumerate(assembly.linkage.joints, start=1):
            if not assembly.bodies[number]:
                continue
            for primitive, column in zip(tree.primitives, tree.columns(), strict=True):
                ball = primitive.kind == "ball"
                joint = model.joint(f"{name}/{tree.name if ball else assembly.names[column]}")
                place, dof = int(joint.qposadr[0]), int(joint.dofadr[0])
                if ball:
                    self._balls.append((number, column, place, dof))
                columns += range(column, column + primitive.width)
                qpos += [place] * primitive.width
                dofs += range(dof, dof + primitive.width)
        self.columns, self._qpos = np.array(columns, dtype=int), np.array(qpos, dtype=int)
        self.dofs_by_column = np.array(dofs, dtype=int)
        self.dofs = np.sort(self.dofs_by_column)
        own = [k for k in range(model.neq) if model.equality(k).name.startswith(f"{name}/")]
        self.equalities = np.array(own, dtype=int)
        numbered = list(enumerate(assembly.bodies))
        self._bodies = [model.body(f"{name}/{body}").id if body and place else 0 for place, body in numbered]

    def of(self, column: int) -> tuple[int, int]:
        """Return the indices of a single value in qpos, and of its speed in qvel."""
        (index,) = np.flatnonzero(self.columns == column).tolist()
        return int(self._qpos[index]), int(self.dofs_by_column[index])

    def set_speeds(self, data: mujoco.MjData, assembly: Assembly) -> None:
        """Write the initial velocities."""
        self.write(data, assembly, assembly.start, assembly.speeds)

    def read(self, data: mujoco.MjData, assembly: Assembly) -> tuple[Array, Array, Array]:
        """Return values, speeds and accelerations, each of shape (values,); 0 for those at cuts."""
        size = assembly.linkage.size
        values, speeds, accelerations = np.zeros(size), np.zeros(size), np.zeros(size)
        values[self.columns] = data.qpos[self._qpos]
        speeds[self.columns] = data.qvel[self.dofs_by_column]
        accelerations[self.columns] = data.qacc[self.dofs_by_column]
        for number, column, _, _ in self._balls:
            tree = assembly.linkage.joints[number - 1]
            parent, body = (data.xmat[self._bodies[k]].reshape(3, 3) for k in (tree.parent, number))
            before, after = tree.before[:3, :3], inverted(tree.after)[:3, :3]
            turned = before.T @ parent.T @ body @ after
            values[column : column + 3] = tree.sign * rotation_vector(turned)
        return values, speeds, accelerations

    def write(self, data: mujoco.MjData, assembly: Assembly, values: Array, speeds: Array) -> None:
        """Write values and speeds of all joints in the physics.

        Args:
            data: State to write to.
            assembly: Assembly of the mechanism.
            values: Shape (values,) [rad, m].
            speeds: Shape (values,) [1/s].
        """
        data.qpos[self._qpos], data.qvel[self.dofs_by_column] = values[self.columns], speeds[self.columns]
        if not self._balls:
            return
        now, start = assembly.linkage.place(values), assembly.linkage.place(assembly.start)
        for number, column, place, dof in self._balls:
            parent = assembly.linkage.joints[number - 1].parent
            turned, before = (each.poses[parent, :3, :3].T @ each.poses[number, :3, :3] for each in (now, start))
            data.qpos[place : place + 4] = quaternion_of(before.T @ turned)
            part = slice(column, column + 3)
            data.qvel[dof : dof + 3] = now.poses[number, :3, :3].T @ now.axes[part].T @ speeds[part]


def actuator_forces(data: mujoco.MjData, places: Places, followers: Sequence[Follower], size: int) -> Array:
    """Return torques and forces of the actuators and motions of a mechanism at its joints, shape (size,) [N m, N]."""
    found = np.zeros(size)
    found[places.columns] = data.qfrc_actuator[places.dofs_by_column]
    for follower in followers:
        if follower.drive.column >= 0:
            found[follower.drive.column] += equality_forces(data, follower.equality).sum()
    return found
