"""Bases on three omni wheels."""

import math

from mjsim.sim.bases.gear import RunningGear
from mjsim.sim.bases.rollers import RollerKinematics, roller_gear, roller_kinematics
from mjsim.world import OMNI3_BEARINGS, Omni3Drive, Robot


def omni3(drive: Omni3Drive) -> RollerKinematics:
    """Return the kinematics of three wheels that roll along a circle, with rollers across it."""
    circle = drive.wheel_circle
    wheels = [
        (circle * math.cos(b), circle * math.sin(b), b + math.pi / 2, b + math.pi / 2) for b in OMNI3_BEARINGS.values()
    ]
    return roller_kinematics(drive, wheels)


def omni3_gear(robot: Robot, drive: Omni3Drive, *, dt: float, seed: int) -> RunningGear:
    """Return the running gear of a base on three omni wheels."""
    return roller_gear(robot, drive, omni3(drive), dt=dt, seed=seed)
