"""Bases with a user-defined drive."""

from collections.abc import Callable

from mjsim.modules import CheckedDrive, make_module
from mjsim.sim.bases.gear import RunningGear, motion_of, running_gear
from mjsim.sim.bases.twist_profile import TwistProfile
from mjsim.sim.streams import stream
from mjsim.world import Robot, Source, UserDrive


def user_gear(
    robot: Robot, drive: UserDrive, *, dt: float, seed: int, source: Source, clock: Callable[[], float]
) -> RunningGear:
    """Return the running gear of a base with a user-defined drive.

    Raises:
        UsageError: The class cannot be instantiated.
        ModuleFault: It lacks a method, or does not name its wheels; later, it raises or returns an invalid value.
    """
    made = make_module(drive, source.for_run(), role="drive", robot=robot.name)
    model = CheckedDrive(made, robot=robot.name, clock=clock)
    profile = TwistProfile(drive, kinematics=model, dt=dt, stream=stream(seed, robot.name, "drive/twist"))
    return running_gear(robot, profile=profile, motion=motion_of(model), dt=dt, seed=seed, wheels=model.wheels)
