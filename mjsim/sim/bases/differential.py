"""Differential bases: wheels on the left and on the right."""

from collections.abc import Sequence
from dataclasses import dataclass

from mjsim.compile import RESPONSE
from mjsim.sim.bases.gear import RunningGear, motion_of, running_gear
from mjsim.sim.bases.twist_profile import TwistProfile
from mjsim.sim.odometry import Twist
from mjsim.sim.streams import stream
from mjsim.world import DifferentialDrive, Robot


@dataclass(frozen=True, slots=True)
class DifferentialKinematics:
    """Wheels on the left and on the right; the robot's origin is midway between them.

    The rim speed of a wheel is v -+ w track / 2 (left, right), its angular speed that divided by its radius. A
    skid-steered robot is the same with a wider track: the distance between the centres of rotation of the floor under
    its left and right wheels.

    References:
        Siegwart, Nourbakhsh, Scaramuzza, Introduction to Autonomous Mobile Robots (2nd ed., 2011), section 3.2.3.
        Mandow, Martinez, Morales, Blanco, Garcia-Cerezo, Gonzalez, Experimental
        Kinematics for Wheeled Skid-Steer Mobile Robots, IROS 2007, for the wider track.
    """

    wheel_radius: float
    """[m]"""
    track: float
    """[m]"""
    axles: int = 1
    """Number of axles, each with a left and a right wheel."""

    def wheels_from_twist(self, forward: float, left: float, turn: float) -> tuple[float, ...]:
        """Return the speeds of left, right, left, right... [rad/s]; `left` is ignored."""
        half = turn * self.track / 2
        return ((forward - half) / self.wheel_radius, (forward + half) / self.wheel_radius) * self.axles

    def twist_from_wheels(self, speeds: Sequence[float]) -> Twist:
        """Return the twist for the mean speed of the wheels on each side."""
        left, right = (speeds[0], speeds[1]) if self.axles == 1 else (sum(speeds[k::2]) / self.axles for k in (0, 1))
        return self.wheel_radius * (left + right) / 2, 0.0, self.wheel_radius * (right - left) / self.track


def differential_gear(robot: Robot, drive: DifferentialDrive, *, dt: float, seed: int) -> RunningGear:
    """Return the running gear of a differential base."""
    kinematics = DifferentialKinematics(drive.wheel_radius, drive.track)
    source = stream(seed, robot.name, "drive/twist")
    profile = TwistProfile(drive, kinematics=kinematics, dt=dt, stream=source, lag=RESPONSE)
    return running_gear(robot, profile=profile, motion=motion_of(kinematics), dt=dt, seed=seed)
