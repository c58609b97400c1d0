"""Factories of the running gear of each drive."""

from collections.abc import Callable, Mapping

from mjsim.sim.bases.ackermann import ackermann_gear
from mjsim.sim.bases.balancing import balancing_gear
from mjsim.sim.bases.differential import differential_gear
from mjsim.sim.bases.fixed import fixed_gear
from mjsim.sim.bases.gear import RunningGear
from mjsim.sim.bases.mecanum import mecanum_gear
from mjsim.sim.bases.omni3 import omni3_gear
from mjsim.sim.bases.skid_steer import skid_steer_gear
from mjsim.sim.bases.tricycle import tricycle_gear
from mjsim.sim.bases.user import user_gear
from mjsim.world import (
    AckermannDrive,
    AnyDrive,
    BalancingDrive,
    DifferentialDrive,
    FixedDrive,
    MecanumDrive,
    Omni3Drive,
    Robot,
    SkidSteerDrive,
    Source,
    TricycleDrive,
    UserDrive,
)

MAKERS: Mapping[type[AnyDrive], Callable[..., RunningGear]] = {
    AckermannDrive: ackermann_gear,
    BalancingDrive: balancing_gear,
    DifferentialDrive: differential_gear,
    FixedDrive: fixed_gear,
    MecanumDrive: mecanum_gear,
    Omni3Drive: omni3_gear,
    SkidSteerDrive: skid_steer_gear,
    TricycleDrive: tricycle_gear,
}
"""Factory of the running gear of each drive that comes with mjsim."""


def gear_of(robot: Robot, *, dt: float, seed: int, source: Source, clock: Callable[[], float]) -> RunningGear:
    """Return the running gear of a robot.

    Args:
        robot: Robot of the world file.
        dt: Period of the loop [s].
        seed: Seed of the run.
        source: Location of the world file, for a user-defined drive.
        clock: Gives the simulated time, for errors of such a drive [s].

    Raises:
        MjsimError: As `user_gear`.
    """
    if isinstance(robot.drive, UserDrive):
        return user_gear(robot, robot.drive, dt=dt, seed=seed, source=source, clock=clock)
    return MAKERS[type(robot.drive)](robot, robot.drive, dt=dt, seed=seed)
