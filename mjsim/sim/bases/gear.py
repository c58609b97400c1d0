"""The running gear of a base: its kinematics, the profile of its servos, and its odometer."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from mjsim.geometry import Array
from mjsim.interface import Command
from mjsim.sim.bases.profile import VelocityProfile
from mjsim.sim.odometry import NO_MOTION, Steering, Twist, WheelMotion, WheelOdometer
from mjsim.sim.streams import stream
from mjsim.world import Robot


class Kinematics(Protocol):
    """Conversion between the twist of a base and its wheel speeds; linear, so it also applies to small motions."""

    def wheels_from_twist(self, forward: float, left: float, turn: float) -> Sequence[float]:
        """Return the speeds of the driven wheels [rad/s]."""

    def twist_from_wheels(self, speeds: Sequence[float]) -> Twist:
        """Return the twist of the speeds of the driven wheels [rad/s]."""


@dataclass(frozen=True, slots=True, eq=False)
class RunningGear:
    """The running gear of a base: motors and odometry."""

    wheels: tuple[str, ...]
    """Driven wheels, in the order of their speeds; each has an encoder."""
    steering: tuple[str, ...]
    """Steered joints, in the order of their angles, which follow the wheel speeds."""
    profile: VelocityProfile
    odometer: WheelOdometer
    motion: WheelMotion
    wanted: Callable[[float], Command] | None = None
    """Returns the set-points of its controller for a period [s]; None for bases with servos."""
    goal: Callable[[], Sequence[float]] | None = None
    """Returns the rotations of the driven wheels that follow from these set-points [rad]."""

    def twist_from_wheels(self) -> Array:
        """Return the twist (forward, left, turn) of wheel speeds, steering straight ahead, shape (3, wheels)."""
        count = len(self.wheels)
        columns = [self.motion([float(k == wheel) for k in range(count)], NO_MOTION) for wheel in range(count)]
        return np.array(columns, dtype=float).reshape(count, 3).T


def running_gear(
    robot: Robot,
    *,
    profile: VelocityProfile,
    motion: WheelMotion,
    dt: float,
    seed: int,
    wheels: Sequence[str] = (),
    wanted: Callable[[float], Command] | None = None,
    goal: Callable[[], Sequence[float]] | None = None,
) -> RunningGear:
    """Return the running gear of a robot.

    Args:
        robot: Robot of the world file.
        profile: Profile of its servos.
        motion: Motion for rotations of the wheels.
        dt: Period of the loop [s].
        seed: Seed of the run.
        wheels: Driven ones; by default those of the drive.
        wanted: Gives the set-points of its controller, if it has one.
        goal: Gives the wheel rotations from these set-points.
    """
    drive, names = robot.drive, tuple(wheels) or robot.drive.driven_wheels
    odometer = WheelOdometer(
        robot.odometry,
        motion=motion,
        wheels=len(names),
        slip=(robot.odometry.tyres or drive.slip).times(robot.odometry.slip),
        sideways=drive.sideways > 0.0,
        dt=dt,
        stream=stream(seed, robot.name, "odometry/increments"),
    )
    return RunningGear(
        wheels=names,
        steering=drive.steering,
        profile=profile,
        odometer=odometer,
        motion=motion,
        wanted=wanted,
        goal=goal,
    )


def motion_of(kinematics: Kinematics) -> WheelMotion:
    """Return the motion for wheel rotations of a base without steering."""

    def motion(rotations: Sequence[float], steering: Steering) -> Twist:
        forward, left, turn = kinematics.twist_from_wheels(rotations)
        return forward, left, turn

    return motion
