"""The YAML file that describes the user's own tables: which file and column contains what."""

import math
import re
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from mjsim.logs.resampling import BEARING, MOTION, RANGE, Mount
from mjsim.world import Model


def _column(value: str | int) -> str | int:
    if isinstance(value, str) and not 0 < len(value) <= MAX_NAME_LENGTH:
        raise ValueError(f"a column name of {len(value)} characters; give its name, or its number, counted from 1")
    if isinstance(value, int) and value < 1:
        raise ValueError(f"there is no column {value}; columns are counted from 1")
    return value


MAX_NAME_LENGTH = 200
"""Maximum length of a column name."""
Column = Annotated[str | int, AfterValidator(_column)]
"""The name of a column, or its number from 1."""
Axes = Annotated[tuple[Column, ...], Field(strict=False, min_length=3, max_length=3)]
"""Columns of x, y and z."""
Quaternion = Annotated[tuple[Column, ...], Field(strict=False, min_length=4, max_length=4)]
"""Columns of x, y, z and w."""
Skip = Annotated[int, Field(ge=0, le=10_000)]
"""Lines before the names of columns."""
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
"""Units of time [s]."""
OURS = re.compile(r"""\s*\{?\s*["']?log["']?\s*:\s*["']?tables["']?\s*([#,}].*)?$""")
"""The line that identifies a description."""
LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
"""Units of columns of lengths and velocities [m]."""


class TimedColumns(Model):
    """One file of the log."""

    file: Annotated[str, Field(min_length=1, max_length=400)]
    """Path from the description."""
    time: Column
    """Column of time, numbers or dates with times (ISO 8601, UTC unless they say otherwise); rows are sorted by it."""
    skip: Skip = 0
    """Number of lines before the names of columns."""


class AngledColumns(TimedColumns):
    """A table with an angle, in radians or in degrees."""

    @model_validator(mode="after")
    def _has_one_angle(self) -> Self:
        choices = {
            "heading": ("heading", "heading_deg", "quaternion"),
            **{name: (name, f"{name}_deg") for name in ("turn", "bearing")},
        }
        for name, keys in choices.items():
            if name in type(self).model_fields and sum(getattr(self, key) is not None for key in keys) != 1:
                raise ValueError(f"name one of {name} [rad], {' and '.join(keys[1:])}")
        return self


class Poses(AngledColumns):
    """Poses in a plane."""

    x: Column
    """[m]"""
    y: Column
    """[m]"""
    heading: Column | None = None
    """Counter-clockwise from x [rad]."""
    heading_deg: Column | None = None
    """The same in degrees."""
    quaternion: Quaternion | None = None
    """Orientation in space, in place of a heading."""


class Twists(AngledColumns):
    """Velocities, each of which holds until the next."""

    forward: Column
    """[m/s]"""
    left: Column | None = None
    """[m/s]"""
    turn: Column | None = None
    """Left positive [rad/s]."""
    turn_deg: Column | None = None
    """The same in degrees."""


class Sightings(AngledColumns):
    """Landmarks seen from the robot's origin."""

    name: Column | None = None
    """Name of the landmark; without this column sightings are anonymous."""
    range: Column
    """[m]"""
    bearing: Column | None = None
    """Left positive [rad]."""
    bearing_deg: Column | None = None
    """The same in degrees."""


class Scans(TimedColumns):
    """Scans of a 2-D lidar, one per row."""

    ranges: Column
    """Prefix of the names of the columns with ranges, or the number of the first of these, up to the last column
    [m]."""
    from_deg: Finite
    """Angle of the first beam, left positive."""
    step_deg: Annotated[float, Field(allow_inf_nan=False, gt=-360, lt=360)]
    """Angle between neighbouring beams; negative if the lidar turns clockwise."""
    range: Annotated[tuple[Positive, ...], Field(strict=False, min_length=2, max_length=2)]
    """[minimum, maximum] range; larger values mean no return [m]."""
    name: Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]{0,39}$")] = "scan"
    """Name of the lidar."""
    at: Annotated[tuple[Finite, ...], Field(strict=False, min_length=3, max_length=3)] = (0.0, 0.0, 0.3)
    """Its position on the robot [m]."""
    yaw_deg: Finite = 0.0
    """Its direction, left positive."""

    @model_validator(mode="after")
    def _is_a_fan(self) -> Self:
        nearest, farthest = self.range
        if not nearest < farthest:
            raise ValueError(f"range is [{nearest:g}, {farthest:g}] m; the nearest must be less than the farthest")
        if self.step_deg == 0.0:
            raise ValueError("step_deg is 0; it is the angle from one beam to the next, below 0 for a clockwise turn")
        return self

    def mount(self) -> Mount:
        """Return its mount."""
        x, y, z = self.at
        return Mount(at=(x, y, z), yaw=math.radians(self.yaw_deg))


class Inertial(AngledColumns):
    """Readings of an inertial sensor in its own frame, z up."""

    acceleration: Axes
    """Specific force along x, y and z [m/s^2]."""
    turn: Axes | None = None
    """Angular velocity about x, y and z [rad/s]."""
    turn_deg: Axes | None = None
    """The same in degrees per second."""


class Marks(Model):
    """Positions of landmarks."""

    file: Annotated[str, Field(min_length=1, max_length=400)]
    """Path from the description."""
    skip: Skip = 0
    """Number of lines before the names of columns."""
    name: Column
    x: Column
    """[m]"""
    y: Column
    """[m]"""


class Noise(Model):
    """Noise of readings, as standard deviations; the defaults are guesses."""

    distance: Annotated[float, Field(ge=0, le=10)] = MOTION.distance
    """Noise of odometry [m/sqrt(m)]."""
    turn: Annotated[float, Field(ge=0, le=10)] = MOTION.turn
    """Noise of odometry [rad/sqrt(rad)]."""
    veer: Annotated[float, Field(ge=0, le=10)] = MOTION.veer
    """Noise of odometry's heading, over distance [rad/sqrt(m)]."""
    range: Annotated[float, Field(gt=0, le=100)] = RANGE
    """Noise of a sighting [m]."""
    bearing_deg: Annotated[float, Field(gt=0, le=180)] = math.degrees(BEARING)
    """Noise of a sighting."""


class Description(Model):
    """Description of the tables of a log."""

    log: Literal["tables"]
    time_unit: Literal["s", "ms", "us", "ns"] = "s"
    """Unit of all columns of time."""
    length_unit: Literal["m", "cm", "mm"] = "m"
    """Unit of all columns of positions, ranges and velocities; values in this file are always in metres."""
    odometry: Poses | None = None
    """Poses by odometry, in a frame that drifts."""
    twist: Twists | None = None
    """Velocities by odometry; the commands if there are also poses."""
    truth: Poses | None = None
    """Ground truth."""
    gap: Positive = 1.0
    """Maximum time between two rows of truth to interpolate [s]."""
    sightings: Sightings | None = None
    landmarks: Marks | None = None
    scans: Annotated[tuple[Scans, ...], Field(strict=False)] = ()
    """One per lidar; ticks are moved to the scans of the first."""
    imu: Inertial | None = None
    noise: Noise = Noise()
