"""Controllers designed by `mjsim lab`, as modules: state feedback and transfer functions."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.random import Generator
from scipy.signal import cont2discrete, tf2ss

from mjsim import (
    BalancingInfo,
    Command,
    Estimate,
    FastReading,
    JointState,
    Observation,
    RobotInfo,
    WorldMap,
    signal_of,
)
from mjsim.geometry import Array

from .arm_control import PdGravity
from .balance import Lqr


class TransferLaw:
    """A transfer function of s, discretised by Tustin's rule.

    References:
        Franklin, Powell, Workman, Digital Control of Dynamic Systems (3rd ed., 1998), section 6.1.
    """

    def __init__(self, num: Sequence[float], den: Sequence[float]) -> None:
        """Store the coefficients, the highest power of s first.

        Raises:
            ValueError: It is improper, or not finite.
        """
        top, bottom = np.trim_zeros(np.asarray(num, dtype=float), "f"), np.trim_zeros(np.asarray(den, dtype=float), "f")
        if not len(bottom) or not len(top) or len(top) > len(bottom):
            raise ValueError(
                f"num is {list(num)}, den {list(den)}; num must not have a higher degree than den, and neither may be 0"
            )
        if not (np.isfinite(top).all() and np.isfinite(bottom).all()):
            raise ValueError("num and den must be finite")
        self._law = tf2ss(top, bottom)
        self.reset()

    def reset(self) -> None:
        """Reset to rest."""
        self._sampled: tuple[Array, ...] | None = None

    def output(self, value: float, dt: float) -> float:
        """Return the output for the input of this sample, dt after the last one [s]."""
        if self._sampled is None:
            self._sampled = cont2discrete(self._law, dt, "bilinear")[:4]
            self._state = np.zeros((len(self._sampled[0]), 1))
        A, B, C, D = self._sampled
        found = float((C @ self._state + D * value).item())
        self._state = A @ self._state + B * value
        return found


class StateFeedback(Lqr):
    """Balances a base with given feedback of the distance of the axle, the pitch, and their rates."""

    def __init__(self, gain: Sequence[float]) -> None:
        """Set the feedback.

        Args:
            gain: K of u = -K x, the torque of both motors for the distance [m], the pitch [rad], and their rates.
        """
        if len(gain) != 4 or not np.isfinite(gain).all():
            raise ValueError(f"gain is {list(gain)}; give four finite numbers, for distance, lean, and their rates")
        super().__init__()
        self._gain = tuple(float(value) for value in gain)

    def design(self, masses: BalancingInfo, *, wheel_radius: float, dt: float) -> tuple[float, ...]:
        """Return the given feedback."""
        return self._gain


class JointLoop(PdGravity):
    """Controls one joint of an arm by its own law and the others by PD, all with gravity compensation."""

    def __init__(
        self,
        joint: str,
        *,
        num: Sequence[float] | None = None,
        den: Sequence[float] | None = None,
        gain: Sequence[float] | None = None,
        frequency: float = 25.0,
    ) -> None:
        """Set the law.

        Args:
            joint: The controlled joint, such as `joint3`.
            num: Numerator of the torque's transfer function from the error, the highest power of s first.
            den: Its denominator.
            gain: Instead of these, state feedback of the value and the rate, two numbers.
            frequency: Frequency of the errors of the other joints [rad/s].
        """
        super().__init__(frequency=frequency)
        if (gain is None) == (num is None or den is None):
            raise ValueError("give num and den, or gain")
        if gain is not None and len(gain) != 2:
            raise ValueError(f"gain is {list(gain)}; give two numbers, for the value and the rate")
        self._joint, self._gain = joint, gain
        self._transfer = None if num is None or den is None else TransferLaw(num, den)

    def start(self, robot: RobotInfo, part: str, rng: Generator) -> None:
        """Find the joint.

        Raises:
            ValueError: It has no such joint.
        """
        super().start(robot, part, rng)
        names = self._info.joints
        if self._joint not in names:
            raise ValueError(f"arm '{part}' has no joint '{self._joint}'; its joints are {', '.join(names)}")
        self._number = names.index(self._joint)
        if self._transfer is not None:
            self._transfer.reset()

    def _law(self, state: JointState, q: Array, qd: Array, qdd: Array, dt: float) -> Array:
        """Return the torques for a goal, shape (joints,)."""
        torques, k = np.array(super()._law(state, q, qd, qdd, dt)), self._number
        error, rate = float(q[k] - state.positions[k]), float(qd[k] - state.velocities[k])
        held = float(self._arm.gravload(q)[k])
        if self._gain is not None:
            torques[k] = held + self._gain[0] * error + self._gain[1] * rate
        else:
            assert self._transfer is not None
            torques[k] = held + self._transfer.output(error, dt)
        return torques


class MechanismLoop:
    """Controls a joint of a mechanism by a transfer function of its error, or by feedback of several joints."""

    def __init__(
        self,
        *,
        num: Sequence[float] | None = None,
        den: Sequence[float] | None = None,
        gain: Mapping[str, Sequence[float]] | None = None,
        about: Mapping[str, float] | None = None,
        about_deg: Mapping[str, float] | None = None,
    ) -> None:
        """Set the law.

        Args:
            num: Numerator of the effort's transfer function from the error, the highest power of s first.
            den: Its denominator.
            gain: Instead of these, K of u = -K x by joint, two numbers: for the deviation from the set-point, and for
                the rate; the set-point is the goal for a joint that has one.
            about: Set-points of prismatic joints; default 0 [m].
            about_deg: Set-points of revolute joints; default 0.
        """
        if (gain is None) == (num is None or den is None):
            raise ValueError("give num and den, or gain")
        for joint, pair in (gain or {}).items():
            if len(pair) != 2 or not np.isfinite(pair).all():
                raise ValueError(
                    f"gain of '{joint}' is {list(pair)}; give two finite numbers, for the value and the rate"
                )
        self._gain, self._about = gain or {}, {**(about or {})}
        self._about |= {joint: float(np.radians(angle)) for joint, angle in (about_deg or {}).items()}
        self._transfer = None if num is None or den is None else TransferLaw(num, den)

    def start(self, robot: RobotInfo, part: str, rng: Generator) -> None:
        """Start at rest, for the joint `part`."""
        self._part = part
        if self._transfer is not None:
            self._transfer.reset()

    def torques(self, sensed: FastReading, wanted: Command) -> list[float]:
        """Return the torque or force.

        Raises:
            ValueError: A joint of the gains does not exist.
        """
        goal = wanted.joints[self._part]
        if self._transfer is not None:
            return [self._transfer.output(goal.positions[0] - float(sensed.joints[self._part].positions[0]), sensed.dt)]
        effort = 0.0
        for joint, (of_value, of_rate) in self._gain.items():
            if joint not in sensed.joints:
                raise ValueError(f"no joint '{joint}' in this mechanism; there are {', '.join(sensed.joints)}")
            state, own = sensed.joints[joint], joint == self._part and joint not in self._about
            value, rate = (
                (goal.positions[0], (goal.velocities or (0.0,))[0]) if own else (self._about.get(joint, 0.0), 0.0)
            )
            effort -= of_value * (float(state.positions[0]) - value) + of_rate * (float(state.velocities[0]) - rate)
        return [effort]


class SpeedLoop:
    """Controls the speed of a base to follow a signal, by a transfer function of the error."""

    def __init__(
        self,
        *,
        num: Sequence[float],
        den: Sequence[float],
        reference: Mapping[str, Any],
        of: Literal["forward", "turn"] = "forward",
    ) -> None:
        """Set the law and the reference.

        Args:
            num: Numerator of the law, the highest power of s first.
            den: Its denominator.
            reference: A signal of the speed [m/s], or of the turn rate, in keys that end in `_deg`.
            of: Which of the two.

        Raises:
            ValueError: An argument is invalid.
        """
        if of not in ("forward", "turn"):
            raise ValueError(f"of is '{of}'; it must be forward or turn")
        self._law, self._of, self._keys = TransferLaw(num, den), of, reference
        signal_of(reference, angle=of == "turn")

    def start(self, robot: RobotInfo, map: WorldMap | None, rng: Generator) -> None:
        """Begin at rest."""
        self._reference = signal_of(self._keys, angle=self._of == "turn", rng=rng)
        self._law.reset()
        self._began: float | None = None

    def command(self, seen: Observation, belief: Estimate) -> Command:
        """Return the command for the error of the speed measured by odometry over the last tick."""
        if self._began is None:
            self._began = seen.time
        moved = seen.odometry.forward if self._of == "forward" else seen.odometry.turn
        error = float(self._reference.value(seen.time - self._began)) - moved / seen.dt
        value = self._law.output(error, seen.dt)
        return Command(forward=value) if self._of == "forward" else Command(turn=value)
