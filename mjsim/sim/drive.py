"""Drives at work: what a command becomes when it meets the limits of a robot, and the noise of its motors."""

import math
from collections.abc import Sequence
from typing import Protocol

from numpy.random import Generator

from mjsim.compile.wheels import LAG, RESPONSE
from mjsim.interface import Command, WheelCommand
from mjsim.sim.kinematics import AckermannSteering, DifferentialKinematics, Kinematics, TricycleKinematics, Twist
from mjsim.world import drives as models

STANDSTILL = 1e-3
"""A car that is slower cannot turn; its steering stays as it is [m/s]."""


class Drive(Protocol):
    """What is asked of every drive at work."""

    def command(self, command: Command | WheelCommand) -> None:
        """Take a command, held until the next."""

    def advance(self) -> Sequence[float]:
        """Return what the servos are told to reach in the next tick: wheels [rad/s], then steering [rad]."""

    def retune(self, noise: models.DriveNoise) -> None:
        """Err as far as said from now on."""


class TwistDrive:
    """A drive without steering: it follows commands within its limits, with noise on the twist.

    A twist beyond the limits is scaled as a whole, so that the robot keeps its path and only goes slower. Then
    velocity and turn rate change by no more than their accelerations allow. The noise comes last: piecewise constant
    over a tick with standard deviation sigma / sqrt(dt), which is white noise of density sigma for all that is
    slower than a tick, whatever the tick.

    While speed changes, the servos are told to reach for more, so that their lag is made up at the end of each tick.
    """

    def __init__(
        self, drive: models.AnyDrive, *, kinematics: Kinematics, dt: float, stream: Generator, max_left: float = 0.0
    ) -> None:
        """Get ready, standing still.

        Args:
            drive: Limits and noise.
            kinematics: Of its wheels.
            dt: Period of the loop [s].
            stream: Source of chance; two numbers are drawn a tick, three when it moves sideways.
            max_left: Largest speed sideways [m/s]; commands sideways are ignored when it is 0.
        """
        self._kinematics = kinematics
        self._limits = drive.max_speed, max_left, math.radians(drive.max_turn_deg)
        self._changes = drive.max_acceleration * dt, math.radians(drive.max_turn_acceleration_deg) * dt
        self._root = math.sqrt(dt)
        self.retune(drive.noise)
        # What lag the servos of a user's own robot have is not known here.
        lag = RESPONSE if isinstance(drive, models.DifferentialDrive) else LAG
        self._reach = 1.0 if isinstance(drive, models.UserDrive) else _reach(dt, lag)
        self._stream = stream
        self._target: Twist = 0.0, 0.0, 0.0
        self._twist: Twist = 0.0, 0.0, 0.0

    def command(self, command: Command | WheelCommand) -> None:
        """Take a command, held until the next."""
        if isinstance(command, WheelCommand):
            twist = self._kinematics.twist_from_wheels(command.speeds)
        else:
            twist = command.forward, command.left, command.turn
        self._target = _scaled(twist, self._limits)

    def retune(self, noise: models.DriveNoise) -> None:
        """Err as far as said from now on."""
        self._noise = noise.speed / self._root, noise.turn / self._root

    def advance(self) -> Sequence[float]:
        """Return the speeds of the wheels to reach in the next tick [rad/s]."""
        forward, left, turn = self._twist
        faster, aside = self._target[0] - forward, self._target[1] - left
        excess = math.hypot(faster, aside) / self._changes[0]
        if excess > 1.0:
            faster, aside = faster / excess, aside / excess
        sharper = _within(self._target[2] - turn, self._changes[1])
        self._twist = forward + faster, left + aside, turn + sharper
        sideways = self._limits[1] > 0.0
        chance = self._stream.standard_normal(3 if sideways else 2).tolist()
        return self._kinematics.wheels_from_twist(
            forward + self._reach * faster + self._noise[0] * chance[0],
            left + self._reach * aside + self._noise[0] * chance[2] if sideways else 0.0,
            turn + self._reach * sharper + self._noise[1] * chance[1],
        )


class CarDrive:
    """A drive with Ackermann steering: a twist becomes a speed and a steering angle, each with its own limit of rate.

    The angle that is asked for follows from the curvature, turn over speed, and ends at the largest one. The driven
    wheels follow the angle that the steering has come to. Noise of the turn rate acts through the steering, so it does
    nothing to a car that stands.
    """

    def __init__(self, drive: models.AckermannDrive, *, dt: float, stream: Generator) -> None:
        """Get ready, standing still, steering straight ahead; two numbers are drawn from the stream a tick."""
        self._wheels = DifferentialKinematics(drive.wheel_radius, drive.track)
        self._steering = AckermannSteering(drive.track, drive.wheelbase)
        self._wheelbase = drive.wheelbase
        self._limits = drive.max_speed, 0.0, math.radians(drive.max_turn_deg)
        self._most = math.radians(drive.max_steer_deg)
        self._changes = drive.max_acceleration * dt, math.radians(drive.max_steer_rate_deg) * dt
        self._root = math.sqrt(dt)
        self.retune(drive.noise)
        self._reach = _reach(dt, LAG)
        self._stream = stream
        self._target = self._state = 0.0, 0.0

    def command(self, command: Command | WheelCommand) -> None:
        """Take a command, held until the next; the speeds of driven wheels stand for the twist that they give."""
        if isinstance(command, WheelCommand):
            twist = self._wheels.twist_from_wheels(command.speeds)
        else:
            twist = command.forward, 0.0, command.turn
        speed, _, turn = _scaled(twist, self._limits)
        if abs(speed) < STANDSTILL:
            self._target = 0.0, self._target[1]
        else:
            self._target = speed, self._steer(turn / speed)

    def retune(self, noise: models.DriveNoise) -> None:
        """Err as far as said from now on."""
        self._noise = noise.speed / self._root, noise.turn / self._root

    def advance(self) -> Sequence[float]:
        """Return the speeds of the driven wheels [rad/s], then the angles of the steered ones [rad]."""
        speed, steer = self._state
        faster = _within(self._target[0] - speed, self._changes[0])
        sharper = _within(self._target[1] - steer, self._changes[1])
        self._state = speed + faster, steer + sharper
        chance = self._stream.standard_normal(2).tolist()
        told = speed + self._reach * faster + self._noise[0] * chance[0]
        angle = _within(steer + self._reach * sharper, self._most)
        if abs(speed) >= STANDSTILL:
            angle = self._steer(math.tan(angle) / self._wheelbase + self._noise[1] * chance[1] / speed)
        wheels = self._wheels.wheels_from_twist(told, 0.0, told * math.tan(angle) / self._wheelbase)
        return *wheels, *self._steering.angles(angle)

    def _steer(self, curvature: float) -> float:
        return _within(math.atan(self._wheelbase * curvature), self._most)


class TricycleDrive:
    """A drive with one wheel that is driven and steered: a twist becomes its speed and its angle.

    While the wheel is still turning to its angle it drives only as fast as it already points there, and not at all
    across. Noise of the turn rate acts through the steering.
    """

    def __init__(
        self, drive: models.TricycleDrive, *, kinematics: TricycleKinematics, dt: float, stream: Generator
    ) -> None:
        """Get ready, standing still, steering straight ahead; two numbers are drawn from the stream a tick."""
        self._kinematics = kinematics
        self._limits = drive.max_speed, 0.0, math.radians(drive.max_turn_deg)
        self._most = math.radians(drive.max_steer_deg)
        self._changes = drive.max_acceleration * dt, math.radians(drive.max_steer_rate_deg) * dt
        self._root = math.sqrt(dt)
        self.retune(drive.noise)
        self._reach = _reach(dt, LAG)
        self._stream = stream
        self._target = self._state = 0.0, 0.0

    def command(self, command: Command | WheelCommand) -> None:
        """Take a command, held until the next; the speed of the driven wheel alone leaves the steering as it is."""
        if isinstance(command, WheelCommand):
            twist = self._kinematics.twist(command.speeds[0], self._target[1])
        else:
            twist = command.forward, 0.0, command.turn
        forward, _, turn = _scaled(twist, self._limits)
        rim, steer = self._kinematics.wheel(forward, turn)
        if rim == 0.0:
            self._target = 0.0, self._target[1]
        elif abs(steer) > self._most:
            # It cannot turn as sharply: it keeps its speed ahead and turns as it can.
            steer = math.copysign(self._most, steer)
            self._target = forward / math.cos(steer), steer
        else:
            self._target = rim, steer

    def retune(self, noise: models.DriveNoise) -> None:
        """Err as far as said from now on."""
        self._noise = noise.speed / self._root, noise.turn / self._root

    def advance(self) -> Sequence[float]:
        """Return the speed of the driven wheel [rad/s] and its angle [rad]."""
        rim, steer = self._state
        sharper = _within(self._target[1] - steer, self._changes[1])
        aligned = max(0.0, math.cos(self._target[1] - steer - sharper))
        faster = _within(self._target[0] * aligned - rim, self._changes[0])
        self._state = rim + faster, steer + sharper
        chance = self._stream.standard_normal(2).tolist()
        told = rim + self._reach * faster + self._noise[0] * chance[0]
        angle = steer + self._reach * sharper
        if abs(rim) >= STANDSTILL:
            angle += self._noise[1] * chance[1] * self._kinematics.place / rim
        return told / self._kinematics.wheel_radius, _within(angle, self._most)


def _reach(dt: float, lag: float) -> float:
    """Return by how much more than a change to ask for; a servo comes 1 - exp(-dt / lag) of the way in one tick."""
    return 1.0 / -math.expm1(-dt / lag)


def _within(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)


def _scaled(twist: Twist, limits: Twist) -> Twist:
    """Return the twist, made slower as a whole until all parts keep their limits."""
    forward, left, turn = twist
    if limits[1] == 0.0:
        excess = max(1.0, abs(forward) / limits[0], abs(turn) / limits[2])
        return forward / excess, 0.0, turn / excess
    excess = max(1.0, abs(forward) / limits[0], abs(left) / limits[1], abs(turn) / limits[2])
    return forward / excess, left / excess, turn / excess
