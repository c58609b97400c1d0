"""The running gear of a robot at work: which hinges and servos it has, its drive and its odometer."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mjsim.errors import UsageError
from mjsim.geometry import Array
from mjsim.interface import DriveModel
from mjsim.sim.drive import CarDrive, Drive, TricycleDrive, TwistDrive
from mjsim.sim.kinematics import (
    DifferentialKinematics,
    Kinematics,
    TricycleKinematics,
    Twist,
    mecanum,
    omni3,
    steering_names,
    wheel_names,
)
from mjsim.sim.odometry import (
    OMNI_SLIP,
    ROLLER_SLIP,
    SKID_SLIP,
    STEERED_SLIP,
    STRAIGHT,
    Motion,
    Slip,
    Steering,
    WheelOdometer,
)
from mjsim.sim.streams import stream
from mjsim.world import drives
from mjsim.world.robots import Robot
from mjsim.world.source import Source
from mjsim.world.use import make_module


@dataclass(frozen=True, slots=True, eq=False)
class RunningGear:
    """What moves a robot and what its wheels tell."""

    wheels: tuple[str, ...]
    """Driven wheels, in the order of their speeds; each has an encoder."""
    steering: tuple[str, ...]
    """What is steered, in the order of its angles, which follow those speeds."""
    drive: Drive
    odometer: WheelOdometer
    motion: Motion
    track: float
    """Distance between the wheels of the left and of the right, as kinematics have it [m]."""
    max_left: float = 0.0
    """Largest speed sideways [m/s]."""
    max_curvature: float = math.inf
    """Of the sharpest arc that it can drive [1/m]; infinite when it can turn on the spot."""

    def twist_from_wheels(self) -> Array:
        """Return the twist (forward, left, turn) of wheel speeds, steering straight ahead, shape (3, wheels)."""
        count = len(self.wheels)
        return np.array([self.motion([float(k == wheel) for k in range(count)], STRAIGHT) for wheel in range(count)]).T


def running_gear(robot: Robot, *, dt: float, seed: int, source: Source) -> RunningGear:
    """Return the running gear of a robot.

    Args:
        robot: As the world file has it.
        dt: Period of the loop [s].
        seed: Of the run.
        source: Where the world was written, for a drive of the user's own.

    Raises:
        UsageError: The user's drive cannot be made, or does not say which wheels it has.
    """
    match robot.drive:
        case drives.UserDrive():
            return _users(robot, robot.drive, dt, seed, source)
        case drives.AckermannDrive():
            return _car(robot, robot.drive, dt, seed)
        case drives.TricycleDrive():
            return _tricycle(robot, robot.drive, dt, seed)
        case drives.Omni3Drive():
            return _turning(robot, omni3(robot.drive), dt, seed, track=2.0 * robot.drive.wheel_circle)
        case drives.MecanumDrive():
            return _turning(robot, mecanum(robot.drive), dt, seed, track=robot.drive.track)
        case drives.SkidSteerDrive(wheel_radius=radius, turning_track=track):
            return _turning(robot, DifferentialKinematics(radius, track, axles=2), dt, seed, track=track)
        case drives.DifferentialDrive(wheel_radius=radius, track=track):
            return _turning(robot, DifferentialKinematics(radius, track), dt, seed, track=track)


def _users(robot: Robot, drive: drives.UserDrive, dt: float, seed: int, source: Source) -> RunningGear:
    model = make_module(drive, source)
    if not isinstance(model, DriveModel):
        raise UsageError(f"{drive.use} is no drive; it needs wheels, wheels_from_twist and twist_from_wheels")

    def motion(rotations: Sequence[float], steering: Steering) -> Twist:
        forward, left, turn = model.twist_from_wheels(rotations)
        return forward, left, turn

    twist_stream = stream(seed, robot.name, "drive/twist")
    return RunningGear(
        wheels=tuple(model.wheels),
        steering=(),
        drive=TwistDrive(drive, kinematics=model, dt=dt, stream=twist_stream, max_left=drive.max_left),
        odometer=WheelOdometer(
            robot.odometry,
            motion=motion,
            wheels=len(model.wheels),
            slip=slip_of(drive),
            sideways=drive.max_left > 0.0,
            dt=dt,
            stream=stream(seed, robot.name, "odometry/increments"),
        ),
        motion=motion,
        track=0.0,
        max_left=drive.max_left,
    )


def _turning(robot: Robot, kinematics: Kinematics, dt: float, seed: int, *, track: float) -> RunningGear:
    """Return the running gear of a robot that can turn on the spot."""
    max_left = robot.drive.max_left if isinstance(robot.drive, drives.Omni3Drive | drives.MecanumDrive) else 0.0
    source = stream(seed, robot.name, "drive/twist")

    def motion(rotations: Sequence[float], steering: Steering) -> Twist:
        return kinematics.twist_from_wheels(rotations)

    drive = TwistDrive(robot.drive, kinematics=kinematics, dt=dt, stream=source, max_left=max_left)
    return RunningGear(
        wheels=wheel_names(robot.drive),
        steering=(),
        drive=drive,
        odometer=_odometer(robot, motion, dt, seed),
        motion=motion,
        track=track,
        max_left=max_left,
    )


def _car(robot: Robot, drive: drives.AckermannDrive, dt: float, seed: int) -> RunningGear:
    wheels = DifferentialKinematics(drive.wheel_radius, drive.track)

    def motion(rotations: Sequence[float], steering: Steering) -> Twist:
        return wheels.twist_from_wheels(rotations)

    return RunningGear(
        wheels=wheel_names(drive),
        steering=steering_names(drive),
        drive=CarDrive(drive, dt=dt, stream=stream(seed, robot.name, "drive/twist")),
        odometer=_odometer(robot, motion, dt, seed),
        motion=motion,
        track=drive.track,
        max_curvature=math.tan(math.radians(drive.max_steer_deg)) / drive.wheelbase,
    )


def _tricycle(robot: Robot, drive: drives.TricycleDrive, dt: float, seed: int) -> RunningGear:
    place = drive.wheelbase if drive.driven == "front" else -drive.wheelbase
    kinematics = TricycleKinematics(drive.wheel_radius, place)
    source = stream(seed, robot.name, "drive/twist")
    steep = drive.max_steer_deg >= 90.0

    def motion(rotations: Sequence[float], steering: Steering) -> Twist:
        return kinematics.mean_twist(rotations[0], *steering)

    return RunningGear(
        wheels=wheel_names(drive),
        steering=steering_names(drive),
        drive=TricycleDrive(drive, kinematics=kinematics, dt=dt, stream=source),
        odometer=_odometer(robot, motion, dt, seed),
        motion=motion,
        track=drive.track,
        max_curvature=math.inf if steep else math.tan(math.radians(drive.max_steer_deg)) / drive.wheelbase,
    )


def _odometer(robot: Robot, motion: Motion, dt: float, seed: int) -> WheelOdometer:
    sideways = isinstance(robot.drive, drives.Omni3Drive | drives.MecanumDrive)
    return WheelOdometer(
        robot.odometry,
        motion=motion,
        wheels=len(wheel_names(robot.drive)),
        slip=slip_of(robot.drive),
        sideways=sideways,
        dt=dt,
        stream=stream(seed, robot.name, "odometry/increments"),
    )


def slip_of(drive: drives.AnyDrive) -> Slip:
    """Return what the odometry of a drive allows for slip."""
    match drive:
        case drives.SkidSteerDrive():
            return SKID_SLIP
        case drives.MecanumDrive():
            return ROLLER_SLIP
        case drives.Omni3Drive():
            return OMNI_SLIP
        case drives.TricycleDrive():
            return STEERED_SLIP
        case _:
            return Slip()
