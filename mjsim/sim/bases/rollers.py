"""Bases on wheels with rollers."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mjsim.compile import LAG
from mjsim.geometry import Array
from mjsim.sim.bases.gear import RunningGear, motion_of, running_gear
from mjsim.sim.bases.twist_profile import TwistProfile
from mjsim.sim.odometry import Twist
from mjsim.sim.streams import stream
from mjsim.world import AnyDrive, Robot, RollerDrive


@dataclass(frozen=True, slots=True, eq=False)
class RollerKinematics:
    """Wheels with rollers: speeds = matrix @ twist, and the twist that fits speeds best.

    A wheel with its centre at (x, y), rolling direction d and axis a of its lowest roller only transmits force along a.
    The velocity at the contact is v = (forward - w y, left + w x); its component along the roller must equal that of
    the rim: speed * radius * (d . a) = v . a.

    References:
        Siegwart, Nourbakhsh, Scaramuzza, Introduction to Autonomous Mobile Robots (2nd ed., 2011), section 3.2.3.5, for
        the Swedish wheel, of which mecanum and omni wheels are kinds. Taheri, Qiao, Ghaeminezhad, Kinematic Model of a
        Four Mecanum Wheeled Mobile Robot, International Journal of Computer Applications 113(3), 2015, equations 16 to
        22: the same for four wheels with rollers at 45 degrees.
    """

    matrix: Array
    """Speeds [rad/s] of a twist, shape (wheels, 3)."""
    inverse: Array
    """Twist of speeds, by least squares, shape (3, wheels)."""

    def wheels_from_twist(self, forward: float, left: float, turn: float) -> tuple[float, ...]:
        """Return the speeds of the wheels [rad/s]."""
        return tuple((self.matrix @ (forward, left, turn)).tolist())

    def twist_from_wheels(self, speeds: Sequence[float]) -> Twist:
        """Return the twist that fits speeds best."""
        forward, left, turn = (self.inverse @ speeds).tolist()
        return forward, left, turn


def roller_kinematics(drive: RollerDrive, wheels: Sequence[tuple[float, float, float, float]]) -> RollerKinematics:
    """Return the kinematics of wheels with rollers.

    Args:
        drive: Gives the radius over the rollers, and their slip.
        wheels: (x, y, heading, roller) of each: its centre [m], its rolling direction [rad], and the direction of the
            axis of its lowest roller [rad], robot frame.
    """
    rows = []
    for x, y, heading, roller in wheels:
        across, along = math.cos(roller), math.sin(roller)
        share = drive.wheel_radius * math.cos(roller - heading)
        rows.append([across / share, along / share, (x * along - y * across) / share])
    matrix = np.array(rows) / (1.0, drive.strafe, drive.spin)
    return RollerKinematics(matrix, np.asarray(np.linalg.pinv(matrix), dtype=float))


def roller_gear(robot: Robot, drive: AnyDrive, kinematics: RollerKinematics, *, dt: float, seed: int) -> RunningGear:
    """Return the running gear of a base on wheels with rollers."""
    source = stream(seed, robot.name, "drive/twist")
    profile = TwistProfile(drive, kinematics=kinematics, dt=dt, stream=source, lag=LAG)
    return running_gear(robot, profile=profile, motion=motion_of(kinematics), dt=dt, seed=seed)
