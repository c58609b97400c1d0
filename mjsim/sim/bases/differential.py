"""Differential bases: wheels to the left and to the right that roll ahead."""

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
    """Wheels to the left and to the right that roll ahead; the robot's origin lies midway between them.

    The rim of a wheel runs at v -+ w track / 2 (left, right), and a wheel turns at that speed over its radius. A
    skid-steered robot is one of these with a wider track: the centres about which the floor turns under its left and
    its right wheels lie that far apart.

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
    """Each with a wheel to the left and one to the right."""

    def wheels_from_twist(self, forward: float, left: float, turn: float) -> tuple[float, ...]:
        """Return the speeds of left, right, left, right... [rad/s]; `left` is ignored."""
        half = turn * self.track / 2
        return ((forward - half) / self.wheel_radius, (forward + half) / self.wheel_radius) * self.axles

    def twist_from_wheels(self, speeds: Sequence[float]) -> Twist:
        """Return the twist of the wheels of a side at their mean."""
        left, right = (speeds[0], speeds[1]) if self.axles == 1 else (sum(speeds[k::2]) / self.axles for k in (0, 1))
        return self.wheel_radius * (left + right) / 2, 0.0, self.wheel_radius * (right - left) / self.track


def differential_gear(robot: Robot, drive: DifferentialDrive, *, dt: float, seed: int) -> RunningGear:
    """Return the running gear of a differential base."""
    kinematics = DifferentialKinematics(drive.wheel_radius, drive.track)
    source = stream(seed, robot.name, "drive/twist")
    profile = TwistProfile(drive, kinematics=kinematics, dt=dt, stream=source, lag=RESPONSE)
    return running_gear(robot, profile=profile, motion=motion_of(kinematics), dt=dt, seed=seed)
