"""Rigid parts of a model: bodies that no joint separates, their mass and inertia, and the joints between them."""

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.models.reader import corners_of

SINGLE = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
"""Joints of one degree of freedom; ball joints and free joints part nothing here."""


@dataclass(frozen=True, slots=True, eq=False)
class Rigid:
    """Bodies of a model that move as one, in the frame of the file, joints at rest."""

    root: int
    """Number of the body that carries the others; 0 for what no joint moves."""
    parent: int
    """Root of the rigid part that carries this one; -1 for the base."""
    bodies: tuple[int, ...]
    joints: tuple[int, ...]
    """Numbers of the joints between the parent and this one."""
    place: Array
    """Origin of the root body, shape (3,)."""
    turn: Array
    """Its axes as columns, shape (3, 3)."""
    mass: float
    """[kg]"""
    center: Array
    """Of mass, shape (3,)."""
    inertia: Array
    """About that centre, axes of the file, shape (3, 3) [kg m^2]."""


@dataclass(frozen=True, slots=True, eq=False)
class AtRest:
    """A model as it stands when all joints are at rest."""

    model: mujoco.MjModel
    data: mujoco.MjData
    rest: Array
    """Value of each joint at rest, within its limits, shape (njnt,) [m] or [rad]."""
    parts: tuple[Rigid, ...]
    """The base first; a part stands after the one that carries it."""

    def axis(self, joint: int) -> tuple[Array, Array]:
        """Return a point on the axis of a joint and its direction, file frame, shapes (3,)."""
        return self.data.xanchor[joint].copy(), self.data.xaxis[joint].copy()

    def points(self, geom: int) -> Array:
        """Return points whose hull is a geom, file frame, shape (n, 3)."""
        corners = corners_of(self.model, geom)
        return np.asarray(corners @ self.data.geom_xmat[geom].reshape(3, 3).T + self.data.geom_xpos[geom])

    def geoms(self, part: Rigid) -> list[int]:
        """Return the numbers of the geoms of a part."""
        return np.flatnonzero(np.isin(self.model.geom_bodyid, part.bodies)).tolist()


def at_rest(model: mujoco.MjModel) -> AtRest:
    """Return a model at rest: every joint at its reference, or at the limit next to that."""
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
    """Return mass, centre of mass and inertia about it of some bodies, by the theorem of Huygens and Steiner."""
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
