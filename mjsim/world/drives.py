"""Drives as a world file describes them: how a robot moves, and what its wheels tell of it."""

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import ConfigDict, Discriminator, Field, Tag, model_validator

from mjsim.world.base import Deviation, Length, Model, fault
from mjsim.world.running import Use

Speed = Annotated[float, Field(gt=0, le=20)]
"""[m/s]"""
TurnRate = Annotated[float, Field(gt=0, le=3600)]
"""[deg/s]"""
Acceleration = Annotated[float, Field(gt=0, le=100)]
"""[m/s^2]"""
TurnAcceleration = Annotated[float, Field(gt=0, le=36000)]
"""[deg/s^2]"""


class DriveNoise(Model):
    """White noise on the twist that is achieved; it acts also when the command is zero."""

    speed: Deviation = 0.0
    """[m/sqrt(s)]"""
    turn: Deviation = 0.0
    """[rad/sqrt(s)]"""


class AnyDrive(Model):
    """What all drives have: limits, and how far they miss them."""

    max_speed: Speed = 0.7
    """[m/s]"""
    max_turn_deg: TurnRate = 100.0
    """[deg/s]"""
    max_acceleration: Acceleration = 1.0
    """[m/s^2]"""
    max_turn_acceleration_deg: TurnAcceleration = 300.0
    """[deg/s^2]"""
    noise: DriveNoise = DriveNoise()
    """How far the motion achieved differs from the one commanded."""


class DifferentialDrive(AnyDrive):
    """Two driven wheels on one axle, and casters that slide."""

    type: Literal["differential"] = "differential"
    """Which kind of drive."""
    wheel_radius: Length = 0.0975
    """[m]"""
    track: Length = 0.33
    """Distance between the wheels [m]."""


class SkidSteerDrive(AnyDrive):
    """Four driven wheels that do not steer, those of a side alike; it turns by letting them slip sideways."""

    type: Literal["skid_steer"]
    """Which kind of drive."""
    wheel_radius: Length = 0.1
    """[m]"""
    wheel_width: Length | None = None
    """[m]; a quarter of the radius to each side unless given."""
    track: Length = 0.4
    """Distance between the wheels of the left and of the right [m]."""
    wheelbase: Length = 0.3
    """Distance between the wheels in front and behind [m]."""
    effective_track: Length | None = None
    """Track of the differential drive that turns alike [m]; follows from wheelbase and track unless given."""

    @property
    def turning_track(self) -> float:
        """Track of the differential drive that turns as this one does [m].

        Four like wheels, which carry the same weight, at (+-a, +-b) from the middle. While the robot turns at w, a
        wheel whose rim runs at u slips by u - w b along and w a aside. Friction acts against the slip; what all four
        give together has no moment when (u - w b) b = w a^2, so u = w (a^2 + b^2) / b: a track of 2 (a^2 + b^2) / b.
        """
        return self.effective_track or self.track * (1.0 + (self.wheelbase / self.track) ** 2)


class AckermannDrive(AnyDrive):
    """A car: two driven wheels behind, and two in front that steer about one common centre of the turn.

    Its origin is midway between the wheels behind. It cannot turn on the spot.
    """

    type: Literal["ackermann"]
    """Which kind of drive."""
    wheel_radius: Length = 0.05
    """[m]"""
    wheel_width: Length | None = None
    """[m]; a quarter of the radius to each side unless given."""
    track: Length = 0.25
    """Distance between the left and the right wheels [m]."""
    wheelbase: Length = 0.33
    """Distance between the axles [m]."""
    max_steer_deg: Annotated[float, Field(gt=0, le=60)] = 24.0
    """How far a wheel midway between the steered ones would turn from straight ahead."""
    max_steer_rate_deg: TurnRate = 180.0
    """How fast it turns [deg/s]."""

    @model_validator(mode="after")
    def _wheels_clear_the_centre(self) -> Self:
        radius = self.wheelbase / math.tan(math.radians(self.max_steer_deg))
        if radius <= 0.55 * self.track:
            raise fault(
                f"max_steer_deg is {self.max_steer_deg:g} deg; the centre of the turn would come {radius:.3g} m near"
                f" with half a track of {self.track / 2:g} m, make it less",
                "max_steer_deg",
            )
        return self


class TricycleDrive(AnyDrive):
    """One wheel that is both driven and steered, and two on a fixed axle; forklifts have it behind.

    Its origin is midway between the wheels of the fixed axle.
    """

    type: Literal["tricycle"]
    """Which kind of drive."""
    wheel_radius: Length = 0.1
    """Of the driven wheel [m]."""
    load_wheel_radius: Length | None = None
    """Of the two wheels on the fixed axle [m]; that of the driven wheel unless given."""
    wheel_width: Length | None = None
    """[m]; a quarter of the radius to each side unless given."""
    track: Length = 0.4
    """Distance between the wheels of the fixed axle [m]."""
    wheelbase: Length = 0.6
    """Distance between the driven wheel and the fixed axle [m]."""
    driven: Literal["front", "rear"] = "rear"
    """Where the driven wheel is."""
    max_steer_deg: Annotated[float, Field(gt=0, le=90)] = 90.0
    """How far the driven wheel turns from straight ahead; with 90 the robot can turn on the spot."""
    max_steer_rate_deg: TurnRate = 180.0
    """How fast it turns [deg/s]."""


class _OmniDrive(AnyDrive):
    """What drives have in common that go in any direction, on wheels with rollers."""

    wheel_radius: Length = 0.05
    """Over the rollers [m]."""
    wheel_width: Length | None = None
    """[m]; follows from the rollers unless given."""
    rollers: Annotated[int, Field(ge=6, le=24)] = 12
    """How many a wheel has."""
    max_left: Speed = 0.7
    """Largest speed sideways [m/s]."""


class Omni3Drive(_OmniDrive):
    """Three wheels with rollers across, on a circle: in front to the left, behind, and in front to the right."""

    type: Literal["omni3"]
    """Which kind of drive."""
    wheel_circle: Length = 0.15
    """Radius of the circle that the wheels stand on [m]."""


class MecanumDrive(_OmniDrive):
    """Four wheels with rollers at 45 degrees."""

    type: Literal["mecanum"]
    """Which kind of drive."""
    track: Length = 0.3
    """Distance between the left and the right wheels [m]."""
    wheelbase: Length = 0.47
    """Distance between the wheels in front and behind [m]."""


class UserDrive(AnyDrive, Use):
    """A drive of the user's own: a class that knows how twist and wheels belong together (`mjsim.DriveModel`).

    Its body is a `model`. The keys beside those named here are keyword arguments of the class.
    """

    model_config = ConfigDict(extra="allow")

    max_left: Annotated[float, Field(ge=0, le=20)] = 0.0
    """Largest speed sideways [m/s]."""

    @property
    def type(self) -> str:
        """What modules are told: the name of the class."""
        return self.use.rpartition(":")[2]


KINDS: Mapping[str, type[AnyDrive]] = {
    "differential": DifferentialDrive,
    "skid_steer": SkidSteerDrive,
    "ackermann": AckermannDrive,
    "tricycle": TricycleDrive,
    "omni3": Omni3Drive,
    "mecanum": MecanumDrive,
}
"""Drives by their `type`."""


def _kind_of_drive(item: Any) -> str | None:
    if isinstance(item, UserDrive) or (isinstance(item, dict) and "use" in item):
        return "<use>"
    kind = item.get("type", "differential") if isinstance(item, dict) else getattr(item, "type", None)
    return f"<{kind}>" if isinstance(kind, str) and kind in KINDS else None


Drive = Annotated[
    Annotated[DifferentialDrive, Tag("<differential>")]
    | Annotated[SkidSteerDrive, Tag("<skid_steer>")]
    | Annotated[AckermannDrive, Tag("<ackermann>")]
    | Annotated[TricycleDrive, Tag("<tricycle>")]
    | Annotated[Omni3Drive, Tag("<omni3>")]
    | Annotated[MecanumDrive, Tag("<mecanum>")]
    | Annotated[UserDrive, Tag("<use>")],
    Discriminator(
        _kind_of_drive,
        custom_error_type="kind",
        custom_error_message="a drive has a type: differential, skid_steer, ackermann, tricycle, omni3 or mecanum;"
        ' or a class of your own, {use: "my_drive.py:MyDrive"}',
    ),
]


class OdometryNoise(Model):
    """Independent increments with variance distance^2 |d| and turn^2 |turn|."""

    distance: Deviation = 0.0
    """[m/sqrt(m)]"""
    turn: Deviation = 0.0
    """[rad/sqrt(rad)]"""


class WheelOdometry(Model):
    """What the wheels tell of the motion. The constant errors are not told to the modules."""

    noise: OdometryNoise = OdometryNoise()
    """How far the motion told differs from the one driven."""
    scale: Annotated[float, Field(gt=0, le=10)] = 1.0
    """Distance told for one metre driven."""
    track_error: Annotated[float, Field(gt=-0.9, le=10)] = 0.0
    """Relative error of the track, or of the wheelbase of a tricycle, that turns are computed with."""
    ticks: Annotated[int, Field(ge=4, le=10_000_000)] | None = None
    """Steps that an encoder counts in one turn of its wheel; as fine as can be unless given."""
    wheel_errors: Annotated[
        tuple[Annotated[float, Field(gt=-0.9, le=10)], ...], Field(strict=False, max_length=16)
    ] = ()
    """Relative error of the radius of each driven wheel that ways are computed with; none unless given."""
