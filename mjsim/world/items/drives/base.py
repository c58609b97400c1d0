"""Base class of drives: limits, noise and wheels."""

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from mjsim.world.ground import Deviation, Model
from mjsim.world.items.sensing import Imu

Speed = Annotated[float, Field(gt=0, le=20)]
"""[m/s]"""
TurnRate = Annotated[float, Field(gt=0, le=3600)]
"""[deg/s]"""
Acceleration = Annotated[float, Field(gt=0, le=100)]
"""[m/s^2]"""
TurnAcceleration = Annotated[float, Field(gt=0, le=36000)]
"""[deg/s^2]"""
SIDES = (("left", 1.0), ("right", -1.0))
"""Wheels of an axle: name and sign of y."""
CORNERS = tuple((f"{end}_{side}", x, y) for end, x in (("front", 1.0), ("rear", -1.0)) for side, y in SIDES)
"""Wheels of a rectangle: name and signs of x and y."""


class DriveNoise(Model):
    """White noise on the actual twist, also while the command is zero."""

    speed: Deviation = 0.0
    """[m/sqrt(s)]"""
    turn: Deviation = 0.0
    """[rad/sqrt(s)]"""


class Slip(Model):
    """Slip of tyres on a level floor, as in a data sheet, in addition to the configured noise."""

    forward: Deviation = 0.001
    """Standard deviation along, per square root of a metre [m/sqrt(m)]."""
    left: Deviation = 0.001
    """Standard deviation sideways, per square root of a metre [m/sqrt(m)]."""
    turn: Deviation = 0.002
    """Standard deviation of the heading, per square root of a radian [rad/sqrt(rad)]."""
    outward: Deviation = 0.0076
    """Outward creep of tyres on an arc, in m/s per m/s and rad/s [s]."""
    surge: Deviation = 0.0
    """Slip along while the speed changes, in m/s per m/s^2 [s]."""
    swing: Deviation = 0.0
    """Slip in turn while the turn rate changes, in rad/s per rad/s^2 [s]."""

    def times(self, factor: float) -> "Slip":
        """Return this slip multiplied by a factor."""
        return Slip(**{name: factor * value for name, value in self})


@dataclass(frozen=True, slots=True, kw_only=True)
class Motor:
    """The motor of a driven wheel: a velocity servo."""

    inertia: float
    """Inertia of rotor and gear about the axle, as a multiple of the robot's mass at the wheel's rim."""
    share: float | None
    """Fraction of the robot's mass that its torque has to move; None for an unlimited torque."""
    follows_load: bool = False
    """Whether its lag grows with the load; otherwise it is the same for any load."""


@dataclass(frozen=True, slots=True)
class TorqueMotor:
    """The torque motor of a wheel driven by a controller."""

    torque: float
    """Largest torque in either direction [N m]."""
    inertia: float = 0.0
    """Inertia of rotor and gear about the axle, as a multiple of the robot's mass at the wheel's rim."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Rollers:
    """The rollers of an omnidirectional wheel."""

    angle: float
    """Angle from the wheel's axle to the axis of the lowest roller, about the vertical, left positive [rad]."""
    count: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Wheel:
    """A wheel of a base; its body and hinge are named `ROBOT/wheel_NAME`."""

    name: str
    at: tuple[float, float]
    """Position of its centre, robot frame [m]."""
    radius: float
    """[m]"""
    half_width: float
    """[m]"""
    heading: float = 0.0
    """Rolling direction, robot frame, left positive [rad]."""
    load: Literal["full", "shared", "heavy", "light"] = "full"
    """Its share of the robot's weight, which sets how deep its contact sinks in: less where steered wheels carry some,
    heavy for a single steered and driven wheel; light for one with a mass of its own and no gear."""
    mass: float | None = None
    """Its own mass, as a solid cylinder [kg]; None for a fraction of the robot's mass."""
    motor: Motor | TorqueMotor | None = None
    """None for a passive wheel."""
    steer: str | None = None
    """Name of the hinge that steers it, `ROBOT/steer_...`; None for a fixed wheel."""
    rollers: Rollers | None = None
    """None for a plain tyre."""
    spokes: bool = True
    """Whether its rim is drawn, so that its rotation is visible."""


class AnyDrive(Model):
    """Base class of drives: limits and noise."""

    controller: ClassVar[str | None] = None
    """Default controller of its motors between ticks, as `use`; None where servos drive them."""

    max_speed: Speed = 0.7
    """[m/s]"""
    max_turn_deg: TurnRate = 100.0
    """[deg/s]"""
    max_acceleration: Acceleration = 1.0
    """[m/s^2]"""
    max_turn_acceleration_deg: TurnAcceleration = 300.0
    """[deg/s^2]"""
    noise: DriveNoise = DriveNoise()
    """Noise of the actual motion relative to the command."""

    @property
    def wheels(self) -> tuple[Wheel, ...]:
        """The wheels that carry the base, in the order in which they are built; empty if its own file has them."""
        return ()

    @property
    def driven_wheels(self) -> tuple[str, ...]:
        """Names of the driven wheels, in the order of a command's wheel speeds."""
        return tuple(f"wheel_{wheel.name}" for wheel in self.wheels if wheel.motor is not None)

    @property
    def driven_radius(self) -> float:
        """Radius of the driven wheels [m]; 0 if unknown."""
        return next((wheel.radius for wheel in self.wheels if wheel.motor is not None), 0.0)

    @property
    def steering(self) -> tuple[str, ...]:
        """Names of the steered hinges, in the order of their angles."""
        return tuple(wheel.steer for wheel in self.wheels if wheel.steer is not None)

    @property
    def on_casters(self) -> bool:
        """Whether casters in front and behind keep it upright, so that its centre of mass must lie above its wheels."""
        return False

    @property
    def own_imu(self) -> Imu | None:
        """The inertial sensor that its controller needs; None if it needs none."""
        return None

    @property
    def sideways(self) -> float:
        """Maximum speed sideways [m/s]; 0 if it cannot move sideways."""
        return 0.0

    @property
    def turning_track(self) -> float:
        """Track of the equivalent differential drive, as reported to modules [m]; 0 if unknown."""
        return 0.0

    @property
    def slip(self) -> Slip:
        """Slip assumed in the covariance of odometry.

        Fitted to noise-free drives at changing speeds and turns.
        """
        return Slip()

    @property
    def turn_acceleration(self) -> float:
        """Maximum acceleration of the turn [rad/s^2]."""
        return math.radians(self.max_turn_acceleration_deg)

    @property
    def max_curvature(self) -> float:
        """Curvature of the tightest arc that it can drive [1/m]; infinite if it can turn on the spot."""
        return math.inf


def half_width(width: float | None, *, radius: float, track: float = math.inf) -> float:
    """Return half the width of a wheel; default: a quarter of the radius [m]."""
    return width / 2 if width is not None else min(0.25 * radius, 0.2 * track)


def geared_motor(*, share: float) -> Motor:
    """Return a motor whose lag does not depend on the load and that moves a fraction of the robot."""
    return Motor(inertia=0.3, share=share)
