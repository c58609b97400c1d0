"""Bases on four mecanum wheels."""

import math

from mjsim.sim.bases.gear import RunningGear
from mjsim.sim.bases.rollers import RollerKinematics, roller_gear, roller_kinematics
from mjsim.world import CORNERS, MecanumDrive, Robot


def mecanum(drive: MecanumDrive) -> RollerKinematics:
    """Return the kinematics of four mecanum wheels."""
    wheels = [
        (x * drive.wheelbase / 2, y * drive.track / 2, 0.0, math.pi / 2 + x * y * math.pi / 4) for _, x, y in CORNERS
    ]
    return roller_kinematics(drive, wheels)


def mecanum_gear(robot: Robot, drive: MecanumDrive, *, dt: float, seed: int) -> RunningGear:
    """Return the running gear of a base on mecanum wheels."""
    return roller_gear(robot, drive, mecanum(drive), dt=dt, seed=seed)
