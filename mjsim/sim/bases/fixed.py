"""Fixed bases, without motion and wheels."""

from collections.abc import Sequence

from mjsim.interface import Command, WheelCommand
from mjsim.sim.bases.gear import RunningGear, running_gear
from mjsim.sim.odometry import Steering, Twist
from mjsim.world import DriveNoise, FixedDrive, Robot


class _Standing:
    """The profile of a base without motors: it ignores commands."""

    def command(self, command: Command | WheelCommand) -> None:
        """Ignore a command."""

    def advance(self) -> Sequence[float]:
        """Return an empty list of set-points."""
        return ()

    def retune(self, noise: DriveNoise) -> None:
        """Do nothing: a fixed base has no noise."""


def _motion(rotations: Sequence[float], steering: Steering) -> Twist:
    return 0.0, 0.0, 0.0


def fixed_gear(robot: Robot, drive: FixedDrive, *, dt: float, seed: int) -> RunningGear:
    """Return the running gear of a base that has none."""
    return running_gear(robot, profile=_Standing(), motion=_motion, dt=dt, seed=seed)
