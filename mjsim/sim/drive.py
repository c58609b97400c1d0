"""Drives: what a command becomes when it meets the limits of a robot, and the noise of its motors."""

import math
from dataclasses import dataclass

from numpy.random import Generator

from mjsim.compile.wheels import RESPONSE
from mjsim.interface import Command, WheelCommand
from mjsim.world import drives as models


@dataclass(frozen=True, slots=True)
class DifferentialKinematics:
    """Two driven wheels on one axle that roll without slip; the robot's origin lies midway between them.

    The rim of a wheel runs at v -+ w track / 2 (left, right), and a wheel turns at that speed over its radius.

    References:
        Siegwart, Nourbakhsh, Scaramuzza, Introduction to Autonomous Mobile Robots (2nd ed., 2011), section 3.2.3.
    """

    wheel_radius: float
    """[m]"""
    track: float
    """[m]"""

    def wheels_from_twist(self, forward: float, turn: float) -> tuple[float, float]:
        """Return what the left and the right wheel do [rad/s] for a twist [m/s, rad/s]; also for small motions."""
        half = turn * self.track / 2
        return (forward - half) / self.wheel_radius, (forward + half) / self.wheel_radius

    def twist_from_wheels(self, left: float, right: float) -> tuple[float, float]:
        """Return the twist (forward [m/s], turn [rad/s]) of wheel speeds [rad/s]; also for small rotations."""
        return self.wheel_radius * (left + right) / 2, self.wheel_radius * (right - left) / self.track


class DifferentialDrive:
    """A drive at work: it follows commands within its limits, with noise on the twist.

    A twist beyond the limits is scaled as a whole, so that the robot keeps its path and only goes slower. Then
    speed and turn rate change by no more than their accelerations allow. The noise comes last: piecewise constant
    over a tick with standard deviation sigma / sqrt(dt), which is white noise of density sigma for all that is
    slower than a tick, whatever the tick.

    While speed changes, the servos are told to reach for more, so that their lag is made up at the end of each tick.
    """

    def __init__(self, drive: models.DifferentialDrive, *, dt: float, stream: Generator) -> None:
        """Get ready, standing still.

        Args:
            drive: Sizes, limits and noise.
            dt: Period of the loop [s].
            stream: Source of chance; two numbers are drawn a tick.
        """
        self.kinematics = DifferentialKinematics(drive.wheel_radius, drive.track)
        self._limits = drive.max_speed, math.radians(drive.max_turn_deg)
        self._changes = drive.max_acceleration * dt, math.radians(drive.max_turn_acceleration_deg) * dt
        self._noise = drive.noise.speed / math.sqrt(dt), drive.noise.turn / math.sqrt(dt)
        # A servo comes 1 - exp(-dt / response) of the way in one tick.
        self._reach = 1.0 / -math.expm1(-dt / RESPONSE)
        self._stream = stream
        self._target = 0.0, 0.0
        self._twist = 0.0, 0.0

    def command(self, command: Command | WheelCommand) -> None:
        """Take a command, held until the next; `left` is ignored, as this drive cannot move sideways."""
        if isinstance(command, WheelCommand):
            twist = self.kinematics.twist_from_wheels(*command.speeds)
        else:
            twist = command.forward, command.turn
        self._target = _scaled(twist, self._limits)

    def advance(self) -> tuple[float, float]:
        """Return the speeds of the left and the right wheel to reach in the next tick [rad/s]."""
        speed, turn = self._twist
        faster = _within(self._target[0] - speed, self._changes[0])
        sharper = _within(self._target[1] - turn, self._changes[1])
        self._twist = speed + faster, turn + sharper
        chance = self._stream.standard_normal(2)
        return self.kinematics.wheels_from_twist(
            speed + self._reach * faster + self._noise[0] * float(chance[0]),
            turn + self._reach * sharper + self._noise[1] * float(chance[1]),
        )


def _within(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)


def _scaled(twist: tuple[float, float], limits: tuple[float, float]) -> tuple[float, float]:
    """Return the twist, made slower as a whole until both parts keep their limits."""
    excess = max(1.0, abs(twist[0]) / limits[0], abs(twist[1]) / limits[1])
    return twist[0] / excess, twist[1] / excess
