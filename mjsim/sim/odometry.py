"""Wheel odometry: motion computed from wheel rotations, with errors and covariance."""

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.random import Generator

from mjsim.geometry import Array
from mjsim.interface import Odometry
from mjsim.world import Slip, WheelOdometry

SMALL_TURN = 1e-4
"""Below this angle, series are exact to the last digit [rad]."""
Twist = tuple[float, float, float]
"""(forward [m/s], left [m/s], turn [rad/s]); of rotations, a small motion [m, m, rad]."""
Steering = tuple[float, float]
"""The steering angle at the start and at the end of a tick [rad]."""
NO_MOTION: Steering = (0.0, 0.0)
WheelMotion = Callable[[Sequence[float], Steering], Twist]
"""Rotations of the wheels [rad], steering -> distance forward [m], distance to the left [m], turn [rad]."""


ARC_TIME = 1.0
"""Time for which a robot is assumed to stay on an arc, with its tyres creeping to the same side [s]."""
SMOOTHING_SECONDS = 0.1
"""Time constant of the two smoothing filters of wheel speeds, before differentiation [s]."""


def arc_end(distance: float, turn: float) -> tuple[float, float]:
    """Return the end of an arc (forward, left) [m] in the frame of its start; exact, so that poses are `start @ end`.

    Args:
        distance: Length of the arc, negative for backward motion [m].
        turn: Change of heading, left positive [rad].

    References:
        Siegwart, Nourbakhsh, Scaramuzza (2nd ed., 2011), section 5.2.4, without its midpoint approximation: the
        chord of an arc is distance * sinc(turn / 2), at half the turn.
    """
    half = turn / 2
    chord = distance * (1.0 - half * half / 6.0 if abs(turn) < SMALL_TURN else math.sin(half) / half)
    return chord * math.cos(half), chord * math.sin(half)


def arc_end_slopes(distance: float, turn: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the derivatives of the end of an arc: of forward by (distance, turn), then of left by (distance, turn)."""
    if abs(turn) < SMALL_TURN:
        return (1.0, -distance * turn / 3.0), (turn / 2.0, distance / 2.0)
    s, c = math.sin(turn), math.cos(turn)
    forward = s / turn, distance * (c * turn - s) / turn**2
    left = (1.0 - c) / turn, distance * (s * turn - (1.0 - c)) / turn**2
    return forward, left


class SmoothedAcceleration:
    """The derivative of a speed smoothed twice; its mean square hardly depends on the period of the loop."""

    def __init__(self, dt: float) -> None:
        """Start at rest, with the period of the loop [s]."""
        self._dt, self._gain = dt, -math.expm1(-dt / SMOOTHING_SECONDS)
        self._once, self._twice = 0.0, 0.0

    def add(self, distance: float) -> float:
        """Return the acceleration after a further distance per tick [distance/s^2]."""
        self._once += self._gain * (distance / self._dt - self._once)
        step = self._gain * (self._once - self._twice)
        self._twice += step
        return step / self._dt


class WheelOdometer:
    """Motion from tick to tick measured by the wheels.

    If the world sets the resolution of encoders, they count whole steps; the remainder counts in the next tick. The
    drive's kinematics convert rotations to the distance d forward, the distance l to the left (if the drive can move
    sideways) and the turn. Then constant errors are applied, which modules are not given: `wheel_errors` of each wheel,
    `scale` for distances, and 1 + `track_error` as divisor of the turn. Then noise is added with variances a^2 |d|, a^2
    |l| and b^2 |turn|. The reported increment is the end of the arc with this length and turn, so that `pose @
    Pose(forward, left, turn)` is exact for a constant twist during a tick. Its covariance is that of (d, l, turn),
    propagated to first order, plus an allowance for slip. Outward creep is proportional to speed times turn rate and
    keeps its direction for a while: an error of c in each tick for a time T has the variance c^2 T / dt per tick,
    whatever the tick; the same holds for slip of tyres while speeds change. The covariance does not include the
    quantisation of encoders, whose error never exceeds one step.

    References:
        Thrun, Burgard, Fox, Probabilistic Robotics (2005), section 5.4, for variances that grow with the motion.
    """

    def __init__(
        self,
        errors: WheelOdometry,
        *,
        motion: WheelMotion,
        wheels: int,
        slip: Slip,
        sideways: bool,
        dt: float,
        stream: Generator,
    ) -> None:
        """Initialise.

        Args:
            errors: Noise and constant errors.
            motion: Gives the small motion for rotations and steering.
            wheels: Number of wheels with encoders.
            slip: Slip of the tyres.
            sideways: Whether the drive moves sideways.
            dt: Period of the loop [s].
            stream: Random stream; two numbers are drawn per tick, three for a drive that moves sideways.
        """
        self._motion, self._slip, self._sideways, self._stream = motion, slip, sideways, stream
        self._creep = slip.outward**2 * ARC_TIME / dt**3
        self._changes = (SmoothedAcceleration(dt), SmoothedAcceleration(dt)) if slip.surge or slip.swing else None
        self._lurch = slip.surge**2 * ARC_TIME * dt, slip.swing**2 * ARC_TIME * dt
        self._step = 2.0 * math.pi / errors.ticks if errors.ticks is not None else None
        self._uncounted = [0.0] * wheels
        self.counts = [0] * wheels
        """Encoder counts of each driven wheel since the start, forward positive."""
        self.retune(errors)

    def retune(self, errors: WheelOdometry) -> None:
        """Use this noise from now on; the counts of the encoders stay."""
        self._scale, self._track = errors.scale, 1.0 + errors.track_error
        self._noise = errors.noise.distance, errors.noise.turn
        self._variance = errors.noise.distance**2, errors.noise.turn**2
        self._radii = [1.0 + error for error in errors.wheel_errors] if errors.wheel_errors else None

    def at_rest(self) -> Odometry:
        """Return the increment at the first tick, without motion."""
        return Odometry(0.0, 0.0, 0.0, np.zeros((3, 3)))

    def increment(
        self, rotations: Sequence[float], steering: Steering = NO_MOTION, *, pitched: float = 0.0
    ) -> Odometry:
        """Return the odometry for wheel rotations since the last tick.

        Args:
            rotations: Rotations of each driven wheel, relative to the body [rad].
            steering: Steering angles before and after.
            pitched: Forward pitch of the body since then, which is added to the rotations [rad].
        """
        if self._step is not None:
            rotations = self._counted(rotations, self._step)
        if pitched:
            rotations = [rotation + pitched for rotation in rotations]
        if self._radii is not None:
            rotations = [rotation * radius for rotation, radius in zip(rotations, self._radii, strict=True)]
        distance, left, turn = self._motion(rotations, steering)
        distance, left, turn = distance * self._scale, left * self._scale, turn / self._track
        unsteady = self._unsteady(distance, turn)
        chance = self._stream.standard_normal(3 if self._sideways else 2).tolist()
        distance += self._noise[0] * math.sqrt(abs(distance)) * chance[0]
        turn += self._noise[1] * math.sqrt(abs(turn)) * chance[1]
        forward, lateral = arc_end(distance, turn)
        if self._sideways:
            left += self._noise[0] * math.sqrt(abs(left)) * chance[2]
            sideways, back = arc_end(left, turn)
            forward, lateral = forward - back, lateral + sideways
        return Odometry(forward, lateral, turn, self._covariance(distance, left, turn, unsteady))

    def _unsteady(self, distance: float, turn: float) -> tuple[float, float]:
        """Return the variances along [m^2] and of the heading [rad^2] for slip while speeds change."""
        if self._changes is None:
            return 0.0, 0.0
        surge, swing = self._changes[0].add(distance), self._changes[1].add(turn)
        return self._lurch[0] * surge * surge, self._lurch[1] * swing * swing

    def _counted(self, rotations: Sequence[float], step: float) -> list[float]:
        """Return the rotations in whole steps of the encoders, and keep the remainder."""
        counted = []
        for wheel, rotation in enumerate(rotations):
            whole = self._uncounted[wheel] + rotation
            steps = math.floor(whole / step)
            self.counts[wheel] += steps
            counted.append(steps * step)
            self._uncounted[wheel] = whole - counted[-1]
        return counted

    def _covariance(self, distance: float, lateral: float, turn: float, unsteady: tuple[float, float]) -> Array:
        """Return the covariance of (forward, left, turn), shape (3, 3)."""
        along, around = self._variance[0] * abs(distance), self._variance[1] * abs(turn)
        (f_d, f_t), (l_d, l_t) = arc_end_slopes(distance, turn)
        length = abs(distance)
        across = 0.0
        creep = self._creep * turn * turn
        if self._sideways:
            # The part driven sideways is the same arc, rotated by 90 degrees to the left.
            (_, s_t), (_, b_t) = arc_end_slopes(lateral, turn)
            f_t, l_t, across = f_t - b_t, l_t + s_t, self._variance[0] * abs(lateral)
            length = math.hypot(distance, lateral)
        forward = f_d * f_d * along + l_d * l_d * across + f_t * f_t * around
        forward += self._slip.forward**2 * length + creep * lateral * lateral + unsteady[0]
        left = l_d * l_d * along + f_d * f_d * across + l_t * l_t * around
        left += self._slip.left**2 * length + creep * distance * distance
        heading = around + self._slip.turn**2 * abs(turn) + unsteady[1]
        both = f_d * l_d * (along - across) + f_t * l_t * around
        f_around, l_around = f_t * around, l_t * around
        return np.array([[forward, both, f_around], [both, left, l_around], [f_around, l_around, heading]])
