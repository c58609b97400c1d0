"""Inputs of a plant: motors, forces at joints, on bodies and between points, and prescribed motions of joints."""

from dataclasses import dataclass
from typing import Protocol

import mujoco
import numpy as np

from mjsim.errors import UsageError
from mjsim.geometry import Array
from mjsim.sim import Push


class InputEffect(Protocol):
    """The effect of an input on the scene."""

    @property
    def unit(self) -> str:
        """Unit of the input."""

    def write(self, data: mujoco.MjData, value: float) -> None:
        """Set controls and applied forces for a value of the input; positions are already set."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ForceEffect:
    """Controls and forces proportional to the input."""

    unit: str
    ctrl: Array
    """Controls for one unit of the input, shape (nu,)."""
    applied: Array
    """Generalised forces for one unit of the input, shape (nv,)."""

    def write(self, data: mujoco.MjData, value: float) -> None:
        """Set controls and applied forces."""
        data.ctrl[:] = value * self.ctrl
        data.qfrc_applied[:] = value * self.applied


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BodyPush:
    """A torque on a body, or a force on a point of it, along a fixed axis."""

    unit: str
    model: mujoco.MjModel
    push: Push
    """The push for a signal of 1."""

    def write(self, data: mujoco.MjData, value: float) -> None:
        """Set the applied forces, which depend on the pose of the body."""
        mujoco.mj_kinematics(self.model, data)
        mujoco.mj_comPos(self.model, data)
        data.ctrl[:], data.qfrc_applied[:] = 0.0, 0.0
        self.push.apply(data, value)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PointsPush:
    """A force between two points that pushes them apart, in place of an actuator that prescribes their distance."""

    unit: str
    model: mujoco.MjModel
    sites: tuple[int, int]
    equality: int
    """Index of the constraint on their distance."""

    def write(self, data: mujoco.MjData, value: float) -> None:
        """Set the applied forces, which depend on the positions of the points."""
        mujoco.mj_kinematics(self.model, data)
        mujoco.mj_comPos(self.model, data)
        data.ctrl[:], data.qfrc_applied[:] = 0.0, 0.0
        ends = data.site_xpos[list(self.sites)]
        force = value * (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        for site, end, sign in zip(self.sites, ends, (-1.0, 1.0), strict=True):
            body = int(self.model.site_bodyid[site])
            mujoco.mj_applyFT(self.model, data, sign * force, np.zeros(3), end, body, data.qfrc_applied)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LedJoint:
    """A joint that follows the input exactly, with whatever force that requires.

    `write` takes this force, so that trimming finds the force that holds the operating point.
    """

    unit: str
    """Unit of the motion."""
    force: ForceEffect
    dof: int
    is_speed: bool
    """Whether the input is the joint's speed instead of its value."""

    def write(self, data: mujoco.MjData, value: float) -> None:
        """Set the force at the joint."""
        self.force.write(data, value)

    def accelerations(self, inputs: Array, dt: float) -> Array:
        """Return the accelerations with which the joint reaches each input at the end of its step, shape (k,)."""
        speeds = inputs if self.is_speed else np.diff(inputs, prepend=0.0) / dt
        return np.asarray(np.diff(speeds, prepend=0.0) / dt)


def led(effect: LedJoint, A: Array, B: Array, Y: Array, m: int, rates: Array) -> tuple[Array, Array, Array, Array]:
    """Return A, B, C, D of a plant in which one coordinate follows the input.

    Args:
        effect: The motion.
        A: System matrix of n coordinates and their rates, with a force at coordinate m as input, shape (2 n, 2 n).
        B: The same, shape (2 n, 1).
        Y: Derivatives by the coordinates of the outputs, or of the values whose rates they are, shape (outputs, n).
        m: Index of the coordinate that follows the input.
        rates: Which outputs are rates, shape (outputs,).

    Returns:
        The states are the other coordinates q and their rates, each minus the direct contribution of the input; if the
        input is the speed of coordinate m, this coordinate precedes them.

    Raises:
        UsageError: A rate among the outputs would be unbounded when the input jumps.

    References:
        Eliminates the force from q'' = r q_m'' + ..., r = B_q / B_m; the form is that of Ogata, Modern Control
        Engineering (5th ed., 2010), section 2.5, for inputs with derivatives.
    """
    n = len(A) // 2
    f = [k for k in range(n) if k != m]
    low = [n + k for k in f]
    r = B[low] / B[n + m]
    rest = A[low] - r * A[n + m]
    a0, a1, k0, k1 = rest[:, f], rest[:, low], rest[:, [m]], rest[:, [n + m]]
    Yf, Ym, eye, none = Y[:, f], Y[:, [m]], np.eye(n - 1), np.zeros((n - 1, 1))
    at_once = Yf @ r + Ym
    zeros, rate = np.zeros_like(Yf), rates[:, None]
    if effect.is_speed:
        A = np.block([[np.zeros((1, 2 * n - 1))], [none, 0 * eye, eye], [k0, a0, a1]])
        B = np.concatenate([[[1.0]], r, k1 + a1 @ r])
        C = np.hstack([np.where(rate, 0.0, Ym), np.where(rate, zeros, Yf), np.where(rate, Yf, zeros)])
        return A, B, C, np.where(rate, at_once, 0.0)
    if (np.abs(at_once[rates]) > 1e-9).any():
        raise UsageError(
            "a rate among the outputs is unbounded when the value of a joint jumps; use its velocity as input"
        )
    b1 = k1 + a1 @ r
    A = np.block([[0 * eye, eye], [a0, a1]])
    B = np.concatenate([b1, k0 + a1 @ b1 + a0 @ r])
    C = np.hstack([np.where(rate, zeros, Yf), np.where(rate, Yf, zeros)])
    return A, B, C, np.where(rate, Yf @ b1, at_once)
