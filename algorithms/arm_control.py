"""Controllers of arms, which compute torques that make the joints follow their goals.

They share one design: joint errors decay like those of a critically damped oscillator with `frequency`. They know the
arm from its data sheet, `RobotInfo.arms`; `mass_scale` makes them assume other masses.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.random import Generator

from mjsim.geometry import Array
from mjsim.interface import ArmInfo, Command, FastReading, JointState, RobotInfo
from mjsim.mechanics import Arm, with_links

from .estimation.parameter_learning import ParameterLearner, steady_inertia

STILL = 1e-4
"""Goals slower than this count as at rest [rad/s, m/s]."""
LAG = 0.5
"""Time constant of the filter of `Adaptive`, as a multiple of 1 / frequency."""
TRACKING = 10.0
"""k of `Adaptive` [1/(N m s)]."""


def believed(arm: Arm, mass_scale: float) -> Arm:
    """Return an arm with link masses multiplied by a factor; motors and friction are unchanged."""
    if mass_scale == 1.0:
        return arm
    links = [
        replace(
            link,
            mass=mass_scale * link.mass,
            inertia=tuple(mass_scale * value for value in link.inertia),  # type: ignore[arg-type]
        )
        for link in arm.links
    ]
    return with_links(arm, links)


class _ArmController(ABC):
    """Base class of arm controllers: the arm, its goal, and the limits of its motors."""

    def __init__(self, *, frequency: float = 25.0, mass_scale: float = 1.0) -> None:
        """Set the gains.

        Args:
            frequency: Natural frequency at which errors decay [rad/s].
            mass_scale: Assumed masses, as a multiple of those of the data sheet.

        Raises:
            ValueError: One of them is not above 0.
        """
        for name, value in (("frequency", frequency), ("mass_scale", mass_scale)):
            if not value > 0.0:
                raise ValueError(f"{name} is {value}; it must be above 0")
        self._frequency, self._mass_scale = frequency, mass_scale

    def start(self, robot: RobotInfo, part: str, rng: Generator) -> None:
        """Store the data sheet of the arm."""
        self._part, self._info = part, robot.arms[part]
        self._arm = believed(self._info.model, self._mass_scale)
        slow = np.full(len(self._info.joints), STILL)
        self._at_rest = 0.5 * (self._arm.friction(slow) + self._arm.friction(-slow))

    def torques(self, sensed: FastReading, wanted: Command) -> Sequence[float]:
        """Return the torque of each joint [N m, N]."""
        goal = wanted.joints[self._part]
        q = np.array(goal.positions)
        none = np.zeros_like(q)
        qd, qdd, more = (
            none if part is None else np.array(part) for part in (goal.velocities, goal.accelerations, goal.torques)
        )
        found: Array = self._law(sensed.joints[self._part], q, qd, qdd, sensed.dt) + more
        return tuple(within_limits(found, self._info).tolist())

    @abstractmethod
    def _law(self, state: JointState, q: Array, qd: Array, qdd: Array, dt: float) -> Array:
        """Return the torques for a goal, shape (joints,)."""

    def _friction(self, qd: Array) -> Array:
        """Return the friction torques at the rates of a goal, shape (joints,).

        At rest, dry friction can have any value between its limits in the two directions; the mean is the best
        estimate.
        """
        return np.where(np.abs(qd) < STILL, self._at_rest, self._arm.friction(qd))


def within_limits(torques: Array, arm: ArmInfo) -> Array:
    """Return torques within the limits of the motors, shape (joints,)."""
    return np.asarray(np.clip(torques, -arm.max_torque, arm.max_torque))


class PdGravity(_ArmController):
    """PD control of joints with gravity compensation, the default controller of arms.

    tau = Kp (q_goal - q) + Kd (qd_goal - qd) + g(q), with Kp = w^2 m and Kd = 2 w m for the largest inertia m of each
    joint. m is smaller where joints are so strongly coupled that these gains would be unstable at the rate of the
    controller, as in serial links without rotors. Friction and inertia are not compensated, so it lags during
    motion.

    References:
        Takegaki and Arimoto, A new feedback method for dynamic control of manipulators, ASME J. Dynamic Systems 103,
        1981; Spong, Hutchinson, Vidyasagar, Robot Modeling and Control (2006), section 8.1.
    """

    def start(self, robot: RobotInfo, part: str, rng: Generator) -> None:
        """Forget the gains of another run."""
        super().start(robot, part, rng)
        self._inertia = np.zeros(0)

    def _law(self, state: JointState, q: Array, qd: Array, qdd: Array, dt: float) -> Array:
        if not len(self._inertia):
            self._inertia = steady_inertia(self._arm, self._info, self._frequency * dt)
        stiffness, damping = self._frequency**2 * self._inertia, 2.0 * self._frequency * self._inertia
        spring = stiffness * (q - state.positions) + damping * (qd - state.velocities)
        return np.asarray(spring + self._arm.gravload(state.positions))


class ComputedTorque(_ArmController):
    """Inverse dynamics of the arm, so that the error of each joint becomes that of a separate linear oscillator.

    tau = M(q) (qdd_goal + 2 w e' + w^2 e) + C(q, qd) qd + g(q) + friction(qd_goal), with e = q_goal - q.

    References:
        Luh, Walker, Paul, Resolved-acceleration control of mechanical manipulators, IEEE Trans. Automatic Control
        25(3), 1980; Spong, Hutchinson, Vidyasagar, Robot Modeling and Control (2006), section 8.3.
    """

    def _law(self, state: JointState, q: Array, qd: Array, qdd: Array, dt: float) -> Array:
        error, rate = q - state.positions, qd - state.velocities
        pulled = qdd + 2.0 * self._frequency * rate + self._frequency**2 * error
        rigid = self._arm.rne_nofriction(state.positions, state.velocities, pulled)
        return rigid + self._friction(qd)


class Adaptive(_ArmController):
    """Computed torque control that estimates the link masses online.

    With the reference rate v = qd_goal + w e and s = v - qd it gives tau = Y(q, qd, v, v') a + J v' + friction(qd_goal)
    + w M(q) s. Y is the regressor of the links, J the inertia of the rotors, and a has ten parameters per link,
    initially those of the data sheet. They are adapted by the tracking error and the prediction error, a' = P (k Y^T s
    + W^T R^-1 (y - W a)). P comes from least squares (`ParameterLearner`).

    References:
        Slotine and Li, On the adaptive control of robot manipulators, Int. J. of Robotics Research 6(3), 1987, and
        Composite adaptive control of robot manipulators, Automatica 25(4), 1989; Spong, Hutchinson, Vidyasagar, Robot
        Modeling and Control (2006), section 8.5.
    """

    def __init__(self, *, frequency: float = 25.0, mass_scale: float = 1.0, adaptation: float = 1.0) -> None:
        """Set the gains.

        Args:
            frequency: Natural frequency at which errors decay [rad/s].
            mass_scale: Initial masses, as a multiple of those of the data sheet.
            adaptation: Factor on the initial P, which assumes errors of 20 %; a larger one adapts faster.

        Raises:
            ValueError: One of them is not above 0.
        """
        super().__init__(frequency=frequency, mass_scale=mass_scale)
        if not adaptation > 0.0:
            raise ValueError(f"adaptation is {adaptation}; it must be above 0")
        self._adaptation = adaptation

    def start(self, robot: RobotInfo, part: str, rng: Generator) -> None:
        """Start with the parameters of the data sheet."""
        super().start(robot, part, rng)
        self._learner = ParameterLearner(self._arm, self._info, lag=LAG / self._frequency, adaptation=self._adaptation)
        self._rotors = self._arm.armature()

    @property
    def parameters(self) -> Array:
        """The current parameters, as in `Arm.parameters`, shape (10 joints,)."""
        return np.array(self._learner.parameters)

    def _law(self, state: JointState, q: Array, qd: Array, qdd: Array, dt: float) -> Array:
        error, rate = q - state.positions, qd - state.velocities
        reference, reference_rate = qd + self._frequency * error, qdd + self._frequency * rate
        s = reference - state.velocities
        Y = self._regressor(state, reference, reference_rate, dt)
        self._learner.correct(dt * TRACKING * (Y.T @ s))
        torques = Y @ self._learner.parameters + self._rotors * reference_rate + self._friction(qd)
        return np.asarray(torques + self._frequency * self._arm.inertia(state.positions) @ s)

    def _regressor(self, state: JointState, reference: Array, reference_rate: Array, dt: float) -> Array:
        """Return the regressor of the law, shape (joints, 10 joints), and learn from the last motion."""
        now = state.positions, state.velocities, reference, reference_rate
        if (motion := self._learner.motion(state, dt)) is None:
            return self._arm.regressor(*now)
        then, rates, accelerations = motion
        both = zip(now, (then, rates, rates, accelerations), strict=True)
        Y, W = self._arm.regressor(*(np.stack(pair) for pair in both))
        halfway = 0.5 * (rates + state.velocities)
        self._learner.learn(W, halfway, accelerations, torques=state.torques, dt=dt)
        return np.asarray(Y)
