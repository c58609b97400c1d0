"""How the twist of a robot and the speeds of its wheels belong together, for each kind of drive without slip.

A twist is (forward [m/s], left [m/s], turn [rad/s]) of the robot's origin, in its frame. All of this is linear in the
speeds, so the same functions serve small rotations and small motions.

References:
    Siegwart, Nourbakhsh, Scaramuzza, Introduction to Autonomous Mobile Robots (2nd ed., 2011), chapter 3.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from mjsim.compile.running_gear import CORNERS, OMNI3_BEARINGS, SIDES
from mjsim.geometry import Array
from mjsim.world import drives

Twist = tuple[float, float, float]
"""(forward [m/s], left [m/s], turn [rad/s])."""


class Kinematics(Protocol):
    """What every drive can be asked."""

    def wheels_from_twist(self, forward: float, left: float, turn: float) -> Sequence[float]:
        """Return the speeds of the driven wheels [rad/s]."""

    def twist_from_wheels(self, speeds: Sequence[float]) -> Twist:
        """Return the twist of the speeds of the driven wheels [rad/s]."""


@dataclass(frozen=True, slots=True)
class DifferentialKinematics:
    """Wheels to the left and to the right that roll ahead; the robot's origin lies midway between them.

    The rim of a wheel runs at v -+ w track / 2 (left, right), and a wheel turns at that speed over its radius. A
    skid-steered robot is one of these with a wider track: the centres about which the floor turns under its left and
    its right wheels lie that far apart.

    References:
        Siegwart et al., section 3.2.3. Mandow, Martinez, Morales, Blanco, Garcia-Cerezo, Gonzalez, Experimental
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


@dataclass(frozen=True, slots=True, eq=False)
class OmniKinematics:
    """Wheels with rollers: speeds = matrix @ twist, and the twist that fits speeds best.

    A wheel whose middle is at (x, y), which rolls along the direction d and whose lowest roller lies along a, is
    pushed along its roller alone. Where it touches, the floor passes with v = (forward - w y, left + w x); what of it
    goes along the roller must come from the wheel: speed * radius * (d . a) = v . a.

    References:
        Siegwart et al., section 3.2.3.5, for the Swedish wheel, of which mecanum and omni wheels are kinds. Taheri,
        Qiao, Ghaeminezhad, Kinematic Model of a Four Mecanum Wheeled Mobile Robot, International Journal of Computer
        Applications 113(3), 2015, equations 16 to 22: the same for four wheels with rollers at 45 degrees.
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


def omni_kinematics(wheels: Sequence[tuple[float, float, float, float]], *, radius: float) -> OmniKinematics:
    """Return the kinematics of wheels with rollers.

    Args:
        wheels: (x, y, heading, roller) of each: its middle [m], the direction in which it rolls [rad], and that of
            the axis of its lowest roller [rad], robot frame.
        radius: Over the rollers [m].
    """
    rows = []
    for x, y, heading, roller in wheels:
        across, along = math.cos(roller), math.sin(roller)
        share = radius * math.cos(roller - heading)
        rows.append([across / share, along / share, (x * along - y * across) / share])
    matrix = np.array(rows)
    return OmniKinematics(matrix, np.asarray(np.linalg.pinv(matrix), dtype=float))


@dataclass(frozen=True, slots=True)
class AckermannSteering:
    """Two steered wheels ahead of a fixed axle, which point across one centre of the turn.

    A wheel midway between them at s makes the curvature tan(s) / wheelbase; the others point at the same centre.

    References:
        Siegwart et al., section 3.3.1; Rajamani, Vehicle Dynamics and Control (2nd ed., 2012), section 2.2.
    """

    track: float
    """[m]"""
    wheelbase: float
    """[m]"""

    def angles(self, steer: float) -> tuple[float, float]:
        """Return the angles of the left and the right wheel for one of the wheel midway between them [rad]."""
        rise = math.tan(steer)
        half = rise * self.track / (2 * self.wheelbase)
        return math.atan(rise / (1.0 - half)), math.atan(rise / (1.0 + half))


@dataclass(frozen=True, slots=True)
class TricycleKinematics:
    """One driven and steered wheel at (x, 0), and a fixed axle under the origin.

    With the rim at u and the steering at s, forward is u cos(s) and the turn rate is u sin(s) / x.

    References:
        Siegwart et al., section 3.2.3, for the steered standard wheel.
    """

    wheel_radius: float
    """[m]"""
    place: float
    """Of the driven wheel ahead of the origin, negative behind [m]."""

    def twist(self, speed: float, steer: float) -> Twist:
        """Return the twist of the wheel's speed [rad/s] at a steering angle [rad]."""
        rim = self.wheel_radius * speed
        return rim * math.cos(steer), 0.0, rim * math.sin(steer) / self.place

    def mean_twist(self, speed: float, before: float, after: float) -> Twist:
        """Return the mean twist of the wheel's speed [rad/s] while its angle changes steadily [rad].

        The means of cosine and sine over a change are those of its middle, times the sine of its half over that half.
        """
        half = (after - before) / 2
        share = math.sin(half) / half if abs(half) > 1e-4 else 1.0 - half * half / 6.0
        return self.twist(speed * share, (before + after) / 2)

    def wheel(self, forward: float, turn: float) -> tuple[float, float]:
        """Return the speed of the rim [m/s] and the steering angle in [-pi/2, pi/2] [rad] of a twist."""
        aside = turn * self.place
        sign = -1.0 if forward < 0.0 else 1.0
        return sign * math.hypot(forward, aside), math.atan2(sign * aside, sign * forward)


def omni3(drive: drives.Omni3Drive) -> OmniKinematics:
    """Return the kinematics of three wheels on a circle, which roll along it; their rollers lie across it."""
    circle = drive.wheel_circle
    wheels = [
        (circle * math.cos(b), circle * math.sin(b), b + math.pi / 2, b + math.pi / 2) for b in OMNI3_BEARINGS.values()
    ]
    return omni_kinematics(wheels, radius=drive.wheel_radius)


def mecanum(drive: drives.MecanumDrive) -> OmniKinematics:
    """Return the kinematics of four mecanum wheels."""
    wheels = [
        (x * drive.wheelbase / 2, y * drive.track / 2, 0.0, math.pi / 2 + x * y * math.pi / 4) for _, x, y in CORNERS
    ]
    return omni_kinematics(wheels, radius=drive.wheel_radius)


def wheel_names(drive: drives.Drive) -> tuple[str, ...]:
    """Return the names of the driven wheels."""
    if isinstance(drive, drives.SkidSteerDrive | drives.MecanumDrive):
        return tuple(f"wheel_{name}" for name, _, _ in CORNERS)
    if isinstance(drive, drives.Omni3Drive):
        return tuple(f"wheel_{name}" for name in OMNI3_BEARINGS)
    if isinstance(drive, drives.TricycleDrive):
        return ("wheel_drive",)
    between = "rear_" if isinstance(drive, drives.AckermannDrive) else ""
    return tuple(f"wheel_{between}{side}" for side, _ in SIDES)


def steering_names(drive: drives.Drive) -> tuple[str, ...]:
    """Return the names of what is steered."""
    if isinstance(drive, drives.AckermannDrive):
        return tuple(f"steer_front_{side}" for side, _ in SIDES)
    return ("steer",) if isinstance(drive, drives.TricycleDrive) else ()
