"""Bases with Ackermann steering: cars."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from numpy.random import Generator

from mjsim.interface import Command, WheelCommand
from mjsim.sim.bases.differential import DifferentialKinematics
from mjsim.sim.bases.gear import RunningGear, motion_of, running_gear
from mjsim.sim.bases.profile import MIN_STEERING_SPEED, scaled, within
from mjsim.sim.bases.steered import SteeredProfile
from mjsim.sim.streams import stream
from mjsim.world import AckermannDrive, Robot


@dataclass(frozen=True, slots=True)
class AckermannSteering:
    """Two steered wheels ahead of a fixed axle, with a common centre of rotation.

    A virtual wheel midway between them at angle s gives the curvature tan(s) / wheelbase; the wheels have the same
    centre.

    References:
        Siegwart, Nourbakhsh, Scaramuzza, Introduction to Autonomous Mobile Robots (2nd ed., 2011), section 3.3.1;
        Rajamani, Vehicle Dynamics and Control (2nd ed., 2012), section 2.2.
    """

    track: float
    """[m]"""
    wheelbase: float
    """[m]"""

    def angles(self, steer: float) -> tuple[float, float]:
        """Return the angles of the left and the right wheel for an angle of the virtual middle wheel [rad]."""
        rise = math.tan(steer)
        half = rise * self.track / (2 * self.wheelbase)
        return math.atan(rise / (1.0 - half)), math.atan(rise / (1.0 + half))


class CarProfile(SteeredProfile):
    """A base with Ackermann steering: converts a twist to a speed and a steering angle, each with a rate limit.

    The commanded angle follows from the curvature (turn rate divided by speed), limited to the maximum. The driven
    wheels follow the current steering angle. Noise of the turn rate acts through the steering, so it has no effect on a
    standing car.
    """

    def __init__(self, drive: AckermannDrive, *, dt: float, stream: Generator) -> None:
        """Initialise, standing still, steering straight ahead; two random numbers are drawn per tick."""
        self._wheels = DifferentialKinematics(drive.wheel_radius, drive.track)
        self._steering = AckermannSteering(drive.track, drive.wheelbase)
        self._wheelbase = drive.wheelbase
        super().__init__(drive, dt=dt, stream=stream)

    def command(self, command: Command | WheelCommand) -> None:
        """Take a command, held until the next; wheel speeds are converted to their twist."""
        if isinstance(command, WheelCommand):
            twist = self._wheels.twist_from_wheels(command.speeds)
        else:
            twist = command.forward, 0.0, command.turn
        speed, _, turn = scaled(twist, self._limits)
        if abs(speed) < MIN_STEERING_SPEED:
            self._target = 0.0, self._target[1]
        else:
            self._target = speed, self._steer(turn / speed)

    def advance(self) -> Sequence[float]:
        """Return the speeds of the driven wheels [rad/s], then the angles of the steered ones [rad]."""
        speed, steer = self._state
        faster = within(self._target[0] - speed, self._changes[0])
        sharper = within(self._target[1] - steer, self._changes[1])
        self._state = speed + faster, steer + sharper
        chance = self._stream.standard_normal(2).tolist()
        noisy_speed = speed + self._reach * faster + self._noise[0] * chance[0]
        angle = within(steer + self._reach * sharper, self._max_steer)
        if abs(speed) >= MIN_STEERING_SPEED:
            angle = self._steer(math.tan(angle) / self._wheelbase + self._noise[1] * chance[1] / speed)
        wheels = self._wheels.wheels_from_twist(noisy_speed, 0.0, noisy_speed * math.tan(angle) / self._wheelbase)
        return *wheels, *self._steering.angles(angle)

    def _steer(self, curvature: float) -> float:
        return within(math.atan(self._wheelbase * curvature), self._max_steer)


def ackermann_gear(robot: Robot, drive: AckermannDrive, *, dt: float, seed: int) -> RunningGear:
    """Return the running gear of a car; its odometry comes from the driven wheels alone."""
    profile = CarProfile(drive, dt=dt, stream=stream(seed, robot.name, "drive/twist"))
    motion = motion_of(DifferentialKinematics(drive.wheel_radius, drive.track))
    return running_gear(robot, profile=profile, motion=motion, dt=dt, seed=seed)
