"""The velocity profile of bases without steering."""

import math
from collections.abc import Sequence

from numpy.random import Generator

from mjsim.interface import Command, WheelCommand
from mjsim.sim.bases.gear import Kinematics
from mjsim.sim.bases.profile import reach, scaled, within
from mjsim.sim.odometry import Twist
from mjsim.world import AnyDrive, DriveNoise


class TwistProfile:
    """A base without steering: it follows commands within its limits, with noise on the twist.

    A twist beyond the limits is scaled down, so that the robot keeps its path. Then the changes of velocity and turn
    rate are limited by the accelerations. Noise is added last: constant over a tick with standard deviation sigma /
    sqrt(dt), which approximates white noise of density sigma for any tick.

    While the speed changes, the set-points of the servos exceed it, so that their lag is compensated at the end of each
    tick.
    """

    def __init__(
        self, drive: AnyDrive, *, kinematics: Kinematics, dt: float, stream: Generator, lag: float | None = None
    ) -> None:
        """Initialise, standing still.

        Args:
            drive: Limits and noise; sideways commands are ignored if its maximum sideways speed is 0.
            kinematics: Kinematics of its wheels.
            dt: Period of the loop [s].
            stream: Random stream; two numbers are drawn per tick, three if it moves sideways.
            lag: Time constant of the servos of its wheels [s]; None if unknown.
        """
        self._kinematics = kinematics
        self._limits = drive.max_speed, drive.sideways, math.radians(drive.max_turn_deg)
        self._changes = drive.max_acceleration * dt, math.radians(drive.max_turn_acceleration_deg) * dt
        self._root = math.sqrt(dt)
        self.retune(drive.noise)
        self._reach = 1.0 if lag is None else reach(dt, lag)
        self._stream = stream
        self._target: Twist = 0.0, 0.0, 0.0
        self._twist: Twist = 0.0, 0.0, 0.0

    def command(self, command: Command | WheelCommand) -> None:
        """Take a command, held until the next."""
        if isinstance(command, WheelCommand):
            twist = self._kinematics.twist_from_wheels(command.speeds)
        else:
            twist = command.forward, command.left, command.turn
        self._target = scaled(twist, self._limits)

    def retune(self, noise: DriveNoise) -> None:
        """Use this noise from now on."""
        self._noise = noise.speed / self._root, noise.turn / self._root

    def advance(self) -> Sequence[float]:
        """Return the speeds of the wheels to reach in the next tick [rad/s]."""
        forward, left, turn = self._twist
        faster, lateral = self._target[0] - forward, self._target[1] - left
        excess = math.hypot(faster, lateral) / self._changes[0]
        if excess > 1.0:
            faster, lateral = faster / excess, lateral / excess
        sharper = within(self._target[2] - turn, self._changes[1])
        self._twist = forward + faster, left + lateral, turn + sharper
        sideways = self._limits[1] > 0.0
        chance = self._stream.standard_normal(3 if sideways else 2).tolist()
        return self._kinematics.wheels_from_twist(
            forward + self._reach * faster + self._noise[0] * chance[0],
            left + self._reach * lateral + self._noise[0] * chance[2] if sideways else 0.0,
            turn + self._reach * sharper + self._noise[1] * chance[1],
        )
