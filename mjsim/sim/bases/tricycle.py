"""Bases with one wheel that is driven and steered."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from numpy.random import Generator

from mjsim.interface import Command, WheelCommand
from mjsim.sim.bases.gear import RunningGear, running_gear
from mjsim.sim.bases.profile import MIN_STEERING_SPEED, scaled, within
from mjsim.sim.bases.steered import SteeredProfile
from mjsim.sim.odometry import Steering, Twist
from mjsim.sim.streams import stream
from mjsim.world import Robot, TricycleDrive


@dataclass(frozen=True, slots=True)
class TricycleKinematics:
    """One driven and steered wheel at (x, 0), and a fixed axle under the origin.

    With the rim at u and the steering at s, forward is u cos(s) and the turn rate is u sin(s) / x.

    References:
        Siegwart, Nourbakhsh, Scaramuzza, Introduction to Autonomous Mobile Robots (2nd ed., 2011), section 3.2.3, for
        the steered standard wheel.
    """

    wheel_radius: float
    """[m]"""
    place: float
    """Position of the driven wheel ahead of the origin, negative behind [m]."""

    def twist(self, speed: float, steer: float) -> Twist:
        """Return the twist of the wheel's speed [rad/s] at a steering angle [rad]."""
        rim = self.wheel_radius * speed
        return rim * math.cos(steer), 0.0, rim * math.sin(steer) / self.place

    def mean_twist(self, speed: float, before: float, after: float) -> Twist:
        """Return the mean twist of the wheel's speed [rad/s] while its angle changes steadily [rad].

        The means of cosine and sine over a change are the values at its middle times sinc of half the change.
        """
        half = (after - before) / 2
        share = math.sin(half) / half if abs(half) > 1e-4 else 1.0 - half * half / 6.0
        return self.twist(speed * share, (before + after) / 2)

    def wheel(self, forward: float, turn: float) -> tuple[float, float]:
        """Return the speed of the rim [m/s] and the steering angle in [-pi/2, pi/2] [rad] of a twist."""
        lateral = turn * self.place
        sign = -1.0 if forward < 0.0 else 1.0
        return sign * math.hypot(forward, lateral), math.atan2(sign * lateral, sign * forward)


class TricycleProfile(SteeredProfile):
    """A base with one driven and steered wheel: converts a twist to its speed and angle.

    While the wheel turns to its angle, its speed is proportional to the cosine of the remaining angle.
    Noise of the turn rate acts through the steering.
    """

    def __init__(self, drive: TricycleDrive, *, kinematics: TricycleKinematics, dt: float, stream: Generator) -> None:
        """Initialise, standing still, steering straight ahead; two random numbers are drawn per tick."""
        self._kinematics = kinematics
        super().__init__(drive, dt=dt, stream=stream)

    def command(self, command: Command | WheelCommand) -> None:
        """Take a command, held until the next; a wheel speed does not change the steering."""
        if isinstance(command, WheelCommand):
            twist = self._kinematics.twist(command.speeds[0], self._target[1])
        else:
            twist = command.forward, 0.0, command.turn
        forward, _, turn = scaled(twist, self._limits)
        rim, steer = self._kinematics.wheel(forward, turn)
        if rim == 0.0:
            self._target = 0.0, self._target[1]
        elif abs(steer) > self._max_steer:
            # It cannot turn as sharply: it keeps its forward speed and turns as sharply as possible.
            steer = math.copysign(self._max_steer, steer)
            self._target = forward / math.cos(steer), steer
        else:
            self._target = rim, steer

    def advance(self) -> Sequence[float]:
        """Return the speed of the driven wheel [rad/s] and its angle [rad]."""
        rim, steer = self._state
        sharper = within(self._target[1] - steer, self._changes[1])
        aligned = max(0.0, math.cos(self._target[1] - steer - sharper))
        faster = within(self._target[0] * aligned - rim, self._changes[0])
        self._state = rim + faster, steer + sharper
        chance = self._stream.standard_normal(2).tolist()
        noisy_speed = rim + self._reach * faster + self._noise[0] * chance[0]
        angle = steer + self._reach * sharper
        if abs(rim) >= MIN_STEERING_SPEED:
            angle += self._noise[1] * chance[1] * self._kinematics.place / rim
        return noisy_speed / self._kinematics.wheel_radius, within(angle, self._max_steer)


def tricycle_gear(robot: Robot, drive: TricycleDrive, *, dt: float, seed: int) -> RunningGear:
    """Return the running gear of a tricycle."""
    kinematics = TricycleKinematics(drive.wheel_radius, drive.driven_x)
    profile = TricycleProfile(drive, kinematics=kinematics, dt=dt, stream=stream(seed, robot.name, "drive/twist"))

    def motion(rotations: Sequence[float], steering: Steering) -> Twist:
        return kinematics.mean_twist(rotations[0], *steering)

    return running_gear(robot, profile=profile, motion=motion, dt=dt, seed=seed)
