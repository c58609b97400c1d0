"""Rigid parts of a model: bodies without joints between them, their masses and inertias, and the connecting joints."""

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.models.model_reader import corners_of

SINGLE = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
"""Joints with one degree of freedom; ball joints and free joints are treated as rigid here."""


@dataclass(frozen=True, slots=True, eq=False)
class Rigid:
    """Bodies of a model that move as one, in the file frame, with joints at rest."""

    root: int
    """Id of the body that carries the others; 0 for the base, which no joint moves."""
    parent: int
    """Root of the rigid part that carries this one; -1 for the base."""
    bodies: tuple[int, ...]
    joints: tuple[int, ...]
    """Ids of the joints between the parent and this one."""
    place: Array
    """Origin of the root body, shape (3,) [m]."""
    turn: Array
    """Axes of the root body as columns, shape (3, 3)."""
    mass: float
    """[kg]"""
    center: Array
    """Centre of mass, shape (3,) [m]."""
    inertia: Array
    """Inertia about the centre of mass, axes of the file, shape (3, 3) [kg m^2]."""


@dataclass(frozen=True, slots=True, eq=False)
class AtRest:
    """A model with all joints at rest."""

    model: mujoco.MjModel
    data: mujoco.MjData
    rest: Array
    """Rest position of each joint, within its limits, shape (njnt,) [m] or [rad]."""
    parts: tuple[Rigid, ...]
    """All parts, the base first, each after its carrier."""

    def axis(self, joint: int) -> tuple[Array, Array]:
        """Return a point on the axis of a joint and the axis' unit vector, file frame, shape (3,) each."""
        return self.data.xanchor[joint].copy(), self.data.xaxis[joint].copy()

    def points(self, geom: int) -> Array:
        """Return points whose convex hull is a geom, file frame, shape (n, 3) [m]."""
        corners = corners_of(self.model, geom)
        return np.asarray(corners @ self.data.geom_xmat[geom].reshape(3, 3).T + self.data.geom_xpos[geom])

    def geoms(self, part: Rigid) -> list[int]:
        """Return the ids of the geoms of a part."""
        return np.flatnonzero(np.isin(self.model.geom_bodyid, part.bodies)).tolist()


def at_rest(model: mujoco.MjModel) -> AtRest:
    """Return a model at rest: every joint at its reference, or at the nearest limit."""
    data = mujoco.MjData(model)
    rest = np.zeros(model.njnt)
    for joint in range(model.njnt):
        if int(model.jnt_type[joint]) in SINGLE:
            address = model.jnt_qposadr[joint]
            value = float(model.qpos0[address])
            if model.jnt_limited[joint]:
                value = float(np.clip(value, *model.jnt_range[joint]))
            rest[joint] = data.qpos[address] = value
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    return AtRest(model, data, rest, tuple(_parts(model, data)))


def _parts(model: mujoco.MjModel, data: mujoco.MjData) -> list[Rigid]:
    roots = [0]
    for body in range(1, model.nbody):
        first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
        moves = any(int(model.jnt_type[joint]) in SINGLE for joint in range(first, first + count))
        roots.append(body if moves else roots[int(model.body_parentid[body])])
    parts = []
    for root in dict.fromkeys(roots):
        bodies = tuple(body for body, of in enumerate(roots) if of == root)
        first, count = int(model.body_jntadr[root]), int(model.body_jntnum[root])
        joints = tuple(joint for joint in range(first, first + count) if int(model.jnt_type[joint]) in SINGLE)
        mass, center, inertia = weighed(model, data, bodies)
        parts.append(
            Rigid(
                root=root,
                parent=roots[int(model.body_parentid[root])] if root else -1,
                bodies=bodies,
                joints=joints if root else (),
                place=data.xpos[root].copy(),
                turn=data.xmat[root].reshape(3, 3).copy(),
                mass=mass,
                center=center,
                inertia=inertia,
            )
        )
    return parts


def weighed(model: mujoco.MjModel, data: mujoco.MjData, bodies: Sequence[int]) -> tuple[float, Array, Array]:
    """Return mass [kg], centre of mass [m] and inertia about it [kg m^2] of bodies, by the parallel axis theorem."""
    numbers = [body for body in bodies if body and model.body_mass[body] > 0.0]
    if not numbers:
        return 0.0, data.xpos[bodies[0]].copy(), np.zeros((3, 3))
    masses = model.body_mass[numbers]
    mass = float(masses.sum())
    center = masses @ data.xipos[numbers] / mass
    inertia = np.zeros((3, 3))
    for body, own in zip(numbers, masses, strict=True):
        axes = data.ximat[body].reshape(3, 3)
        offset = data.xipos[body] - center
        inertia += axes @ np.diag(model.body_inertia[body]) @ axes.T
        inertia += own * (offset @ offset * np.eye(3) - np.outer(offset, offset))
    return mass, center, inertia
