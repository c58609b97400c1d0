"""Wheel odometry: what the rotation of the wheels tells of the motion, with its errors and their covariance."""

import math

import numpy as np
from numpy.random import Generator

from mjsim.geometry import Array
from mjsim.interface import Odometry
from mjsim.sim.drive import DifferentialKinematics
from mjsim.world.drives import WheelOdometry

SMALL_TURN = 1e-4
"""Below it series are exact to the last digit [rad]."""
SLIP_FORWARD, SLIP_LEFT, SLIP_TURN = 0.001, 0.001, 0.002
"""What tyres slip on a level floor, as a data sheet would give it, beside the configured noise: standard deviations
for one metre driven [m/sqrt(m)], aside [m/sqrt(m)], and for one radian turned [rad/sqrt(rad)]."""


def arc_end(distance: float, turn: float) -> tuple[float, float]:
    """Return where an arc ends (forward, left) [m], seen from its start; exact, so that poses are `start @ end`.

    Args:
        distance: Along the arc, negative when driven backwards [m].
        turn: Change of heading on the way, left positive [rad].

    References:
        Siegwart, Nourbakhsh, Scaramuzza (2nd ed., 2011), section 5.2.4, without its midpoint approximation: the
        chord of an arc is distance * sinc(turn / 2), at half the turn.
    """
    half = turn / 2
    chord = distance * (1.0 - half * half / 6.0 if abs(turn) < SMALL_TURN else math.sin(half) / half)
    return chord * math.cos(half), chord * math.sin(half)


def arc_end_slopes(distance: float, turn: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return how the end of an arc changes: forward by (distance, turn), then left by (distance, turn)."""
    if abs(turn) < SMALL_TURN:
        return (1.0, -distance * turn / 3.0), (turn / 2.0, distance / 2.0)
    s, c = math.sin(turn), math.cos(turn)
    forward = s / turn, distance * (c * turn - s) / turn**2
    left = (1.0 - c) / turn, distance * (s * turn - (1.0 - c)) / turn**2
    return forward, left


class DifferentialOdometry:
    """Motion from tick to tick as the wheels of a differential drive tell it.

    The distance d is the mean of both rims and the turn their difference over the track. Then come the constant
    errors, of which no module is told: d times `scale`, the turn over 1 + `track_error`. Then noise with variances
    a^2 |d| and b^2 |turn|. The increment that is told is the end of the arc of that length and turn, so that
    `pose @ Pose(forward, left, turn)` is exact for a robot that keeps its curvature during a tick. Its covariance is
    that of (d, turn), carried over to first order, and an allowance for slip.

    References:
        Thrun, Burgard, Fox, Probabilistic Robotics (2005), section 5.4, for variances that grow with the motion.
    """

    def __init__(self, errors: WheelOdometry, *, kinematics: DifferentialKinematics, stream: Generator) -> None:
        """Get ready.

        Args:
            errors: Noise and constant errors.
            kinematics: Sizes of the drive as they are.
            stream: Source of chance; two numbers are drawn a tick.
        """
        self._kinematics = kinematics
        self._scale, self._track = errors.scale, 1.0 + errors.track_error
        self._noise = errors.noise.distance, errors.noise.turn
        self._variance = errors.noise.distance**2, errors.noise.turn**2
        self._stream = stream

    def at_rest(self) -> Odometry:
        """Return the increment of a robot that has not moved yet."""
        return Odometry(0.0, 0.0, 0.0, np.zeros((3, 3)))

    def increment(self, left: float, right: float) -> Odometry:
        """Return what is told of rotations of the left and the right wheel since the last tick [rad]."""
        distance, turn = self._kinematics.twist_from_wheels(left, right)
        distance, turn = distance * self._scale, turn / self._track
        chance = self._stream.standard_normal(2)
        distance += self._noise[0] * math.sqrt(abs(distance)) * float(chance[0])
        turn += self._noise[1] * math.sqrt(abs(turn)) * float(chance[1])
        forward, aside = arc_end(distance, turn)
        return Odometry(forward, aside, turn, self._covariance(distance, turn))

    def _covariance(self, distance: float, turn: float) -> Array:
        along, around = self._variance[0] * abs(distance), self._variance[1] * abs(turn)
        (f_d, f_t), (l_d, l_t) = arc_end_slopes(distance, turn)
        forward = f_d * f_d * along + f_t * f_t * around + SLIP_FORWARD**2 * abs(distance)
        left = l_d * l_d * along + l_t * l_t * around + SLIP_LEFT**2 * abs(distance)
        heading = around + SLIP_TURN**2 * abs(turn)
        across, f_around, l_around = f_d * l_d * along + f_t * l_t * around, f_t * around, l_t * around
        return np.array([[forward, across, f_around], [across, left, l_around], [f_around, l_around, heading]])
