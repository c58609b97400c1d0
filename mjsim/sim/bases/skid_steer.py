"""Skid-steered bases: a differential one with a wider track and two axles."""

from mjsim.compile import LAG
from mjsim.sim.bases.differential import DifferentialKinematics
from mjsim.sim.bases.gear import RunningGear, motion_of, running_gear
from mjsim.sim.bases.twist_profile import TwistProfile
from mjsim.sim.streams import stream
from mjsim.world import Robot, SkidSteerDrive


def skid_steer_gear(robot: Robot, drive: SkidSteerDrive, *, dt: float, seed: int) -> RunningGear:
    """Return the running gear of a skid-steered base."""
    kinematics = DifferentialKinematics(drive.wheel_radius, drive.turning_track, axles=2)
    source = stream(seed, robot.name, "drive/twist")
    profile = TwistProfile(drive, kinematics=kinematics, dt=dt, stream=source, lag=LAG)
    return running_gear(robot, profile=profile, motion=motion_of(kinematics), dt=dt, seed=seed)
