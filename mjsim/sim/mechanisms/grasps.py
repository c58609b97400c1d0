"""The part of a mechanism that a hand holds: one value of a joint, the rotation of a body, or a point on a curve.

A rotation is that of the second body in the frame of the joint on the first one. It is measured from the orientations
of both bodies, so that it also exists where a loop is cut and the physics has no joint.
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.mechanics import left_jacobian, rotation_of, rotation_vector
from mjsim.sim.mechanisms.mechanism_state import Places, equality_rows
from mjsim.world import Assembly, CurvePoint, Mechanism

if TYPE_CHECKING:  # Imported where it is used: it needs scipy.
    from mjsim.mechanics import SpaceCurve


class Grasp(Protocol):
    """The part that a hand holds: `size` values that move independently, 1 or 3."""

    @property
    def size(self) -> int:
        """Number of its values."""
        ...

    @property
    def period(self) -> float:
        """Period of its value: 2 pi, or the length of a closed curve; otherwise 0."""
        ...

    def now(self, data: mujoco.MjData) -> Array:
        """Return the values, shape (size,) [rad, m]."""
        ...

    def slopes(self, data: mujoco.MjData) -> Array:
        """Return the Jacobian of the motion to which the hand's forces belong, shape (size, nv)."""
        ...

    def missing(self, data: mujoco.MjData, goal: Array, speeds: Array, seconds: float) -> Array:
        """Return the motion that remains to a goal after a time at constant speeds, shape (size,) [rad, m]."""
        ...

    def rates(self, goal: Array, changes: Array) -> Array:
        """Return the speeds of that motion at a goal that changes, shape (size,) [1/s]."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SingleValue:
    """One value of a joint that the physics has."""

    place: int
    """Its index in qpos."""
    dof: int
    size: int = 1
    period: float = 0.0

    def now(self, data: mujoco.MjData) -> Array:
        """Return its value."""
        return np.array([data.qpos[self.place]])

    def slopes(self, data: mujoco.MjData) -> Array:
        """Return the Jacobian, a row of the identity."""
        row = np.zeros((1, len(data.qvel)))
        row[0, self.dof] = 1.0
        return row

    def missing(self, data: mujoco.MjData, goal: Array, speeds: Array, seconds: float) -> Array:
        """Return the remaining motion, a plain difference."""
        return np.asarray(goal - self.now(data) - seconds * speeds)

    def rates(self, goal: Array, changes: Array) -> Array:
        """Return the changes."""
        return changes


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rotation:
    """The rotation of one body relative to another: about an axis, or of a ball by its rotation vector."""

    model: mujoco.MjModel
    bodies: tuple[int, int]
    before: Array
    """first_from_joint: rotation, shape (3, 3)."""
    after: Array
    """body_from_joint, of the second body: rotation, shape (3, 3)."""
    sign: float
    """-1 if the joint is traversed backwards."""
    axis: Array | None
    """Axis in the frame of the joint, shape (3,); None for a ball."""

    @property
    def size(self) -> int:
        """Number of its values."""
        return 3 if self.axis is None else 1

    @property
    def period(self) -> float:
        """Return 2 pi, 0 for a ball [rad]."""
        return 0.0 if self.axis is None else 2.0 * math.pi

    def now(self, data: mujoco.MjData) -> Array:
        """Return the rotation vector, or the angle in [-pi, pi]."""
        vector = self.sign * rotation_vector(self._turned(data))
        return np.asarray(vector if self.axis is None else np.array([self.axis @ vector]))

    def slopes(self, data: mujoco.MjData) -> Array:
        """Return the Jacobian of the angular velocity of the second body relative to the first, frame of the joint."""
        rows = []
        for body in self.bodies:
            found = np.zeros((3, self.model.nv))
            mujoco.mj_jacBody(self.model, data, None, found, body)
            rows.append(found)
        turning = self._frame(data).T @ (rows[1] - rows[0])
        return np.asarray(turning if self.axis is None else self.axis[None] @ turning)

    def missing(self, data: mujoco.MjData, goal: Array, speeds: Array, seconds: float) -> Array:
        """Return the rotation vector from the rotation at that time to the goal; for an angle, the shorter way."""
        if self.axis is not None:
            return shorter(goal - self.now(data) - seconds * speeds, self.period)
        ahead = rotation_of(seconds * speeds) @ self._turned(data)
        return rotation_vector(rotation_of(self.sign * goal) @ ahead.T)

    def rates(self, goal: Array, changes: Array) -> Array:
        """Return the angular velocity."""
        if self.axis is not None:
            return changes
        return np.asarray(left_jacobian(self.sign * goal) @ (self.sign * changes))

    def _frame(self, data: mujoco.MjData) -> Array:
        return np.asarray(data.xmat[self.bodies[0]].reshape(3, 3) @ self.before)

    def _turned(self, data: mujoco.MjData) -> Array:
        return np.asarray(self._frame(data).T @ data.xmat[self.bodies[1]].reshape(3, 3) @ self.after)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Along:
    """The position of a point along a curve of another body."""

    model: mujoco.MjModel
    curve: "SpaceCurve"
    site: int
    """Site of the point."""
    carrier: int
    """Body of the curve."""
    carrier_from_curve: Array
    """Shape (4, 4)."""
    size: int = 1

    @property
    def period(self) -> float:
        """Return the length of a closed curve, 0 for an open one [m]."""
        return self.curve.length if self.curve.closed else 0.0

    def now(self, data: mujoco.MjData) -> Array:
        """Return the arc length at which the curve is closest to the point [m]."""
        return np.array([self.curve.nearest(self._inner(data))])

    def slopes(self, data: mujoco.MjData) -> Array:
        """Return the Jacobian of the velocity along the curve."""
        tangent = self.curve.at(float(self.now(data)[0]))[1]
        turned = data.xmat[self.carrier].reshape(3, 3) @ self.carrier_from_curve[:3, :3] @ tangent
        rows = []
        for body in (int(self.model.site_bodyid[self.site]), self.carrier):
            found = np.zeros((3, self.model.nv))
            mujoco.mj_jac(self.model, data, found, None, data.site_xpos[self.site], body)
            rows.append(found)
        return np.asarray(turned[None] @ (rows[0] - rows[1]) / float(tangent @ tangent))

    def missing(self, data: mujoco.MjData, goal: Array, speeds: Array, seconds: float) -> Array:
        """Return the remaining motion; on a closed curve, the shorter way."""
        return shorter(goal - self.now(data) - seconds * speeds, self.period)

    def rates(self, goal: Array, changes: Array) -> Array:
        """Return the changes."""
        return changes

    def _inner(self, data: mujoco.MjData) -> Array:
        """Return the point in the frame of the curve, shape (3,) [m]."""
        on_carrier = data.xmat[self.carrier].reshape(3, 3).T @ (data.site_xpos[self.site] - data.xpos[self.carrier])
        pose = self.carrier_from_curve
        return np.asarray(pose[:3, :3].T @ (on_carrier - pose[:3, 3]))


def shorter(away: Array, period: float) -> Array:
    """Return a difference without whole periods, 0 for none."""
    return np.asarray(away - period * np.round(away / period) if period else away)


def period_of(assembly: Assembly, column: int) -> float:
    """Return the period of a value where the physics has no joint: 2 pi, or the length of a closed curve; else 0."""
    for track in assembly.tracks:
        if track.column == column:
            curve = track.curve(assembly.linkage)
            return curve.length if curve.closed else 0.0
    return 0.0 if assembly.slides[column] else 2.0 * math.pi


def grasp_of(model: mujoco.MjModel, mechanism: Mechanism, places: Places, name: str) -> tuple[Grasp, tuple[int, ...]]:
    """Return the grasp of a joint's value, and the columns of all its values: three for a ball."""
    found = mechanism.assembly
    column = found.names.index(name)
    for track in found.tracks:
        if track.column == column:
            return _along(model, mechanism, track), (column,)
    joint = next(joint for joint, columns in found.columns.items() if column in columns)
    tree = next(each for each in found.linkage.joints if each.name == joint)
    parts = zip(tree.primitives, tree.columns(), strict=True)
    part, first = next(each for each in parts if each[1] <= column < each[1] + each[0].width)
    ball = part.kind == "ball"
    if not ball and column in places.columns:
        place, dof = places.of(column)
        return SingleValue(place=place, dof=dof), (column,)
    numbers = (tree.parent, found.moved_body(joint))
    bodies = [model.body(f"{mechanism.name}/{found.bodies[number]}").id if number else 0 for number in numbers]
    rotation = Rotation(
        model=model,
        bodies=(bodies[0], bodies[1]),
        before=tree.before[:3, :3],
        after=tree.after[:3, :3].T,
        sign=tree.sign,
        axis=None if ball else np.array(part.axis),
    )
    return rotation, tuple(range(first, first + part.width))


def _along(model: mujoco.MjModel, mechanism: Mechanism, track: CurvePoint) -> Along:
    site = model.site(f"{mechanism.name}/{track.name}.b").id
    joint = mechanism.assembly.linkage.joints[track.ghost - 1]
    name = mechanism.assembly.bodies[joint.parent]
    # The ground of a mechanism is a place in the world.
    pose = joint.before if joint.parent else mechanism.world_from_ground @ joint.before
    return Along(
        model=model,
        curve=track.curve(mechanism.assembly.linkage),
        site=site,
        carrier=model.body(f"{mechanism.name}/{name}").id if joint.parent else 0,
        carrier_from_curve=pose,
    )


def yielding(model: mujoco.MjModel, data: mujoco.MjData, slopes: Array, equalities: Array) -> Array:
    """Return the motion of the held object per unit of each force of the world, with all constraints, shape (rows, nv).

    Args:
        model: The compiled world.
        data: A state for temporary use, with the positions; its constraints are computed.
        slopes: Jacobian of the held object, shape (rows, nv).
        equalities: Numbers of the constraints.
    """
    mujoco.mj_makeM(model, data)
    mujoco.mj_factorM(model, data)
    mujoco.mj_makeConstraint(model, data)
    own = equality_rows(data, equalities)
    held = np.zeros((len(own), model.nv))
    for row, number in zip(held, own, strict=True):
        unit = np.zeros(data.nefc)
        unit[number] = 1.0
        mujoco.mj_mulJacTVec(model, data, row, unit)
    both = np.concatenate([slopes, held])
    answers = np.zeros_like(both)
    mujoco.mj_solveM(model, data, answers, both)
    if not own:
        return answers
    # Gauss's principle: constraints of softness R subtract the motion that they prevent.
    count = len(slopes)
    stiff = answers[count:] @ held.T + np.diag(data.efc_R[own])
    return np.asarray(answers[:count] - (slopes @ answers[count:].T) @ np.linalg.solve(stiff, answers[count:]))
