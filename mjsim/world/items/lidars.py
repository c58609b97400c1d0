"""Lidars as a world file describes them: a level fan of beams, and many rings or a rosette of them in space."""

from itertools import pairwise
from typing import Annotated, ClassVar, Self

import numpy as np
from pydantic import ConfigDict, Field, model_validator

from mjsim.world.ground import Degrees, Deviation, Model, Name, Point3, Rate, fault
from mjsim.world.items.sensor_model import Bought, Bounds, Chance, Latency, Pitch


class LidarNoise(Model):
    """Standard deviations of one beam's reading."""

    range: Deviation = 0.0
    """[m]"""


class Lidar(Bought):
    """A level fan of laser beams, as a 2-D lidar has them; what it gives is one scan."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"lidar": "scan"}]})
    kind: ClassVar[str] = "lidar"
    noise_keys: ClassVar[tuple[str, ...]] = ("noise", "missed", "mixed_pixels")
    lidar: Name
    """Its name."""
    at: Point3 = (0.0, 0.0, 0.3)
    """[x, y, z] in the robot's frame [m]."""
    yaw_deg: Degrees = 0.0
    """Where the middle of the fan points, to the left."""
    pitch_deg: Pitch = 0.0
    """Up."""
    beams: Annotated[int, Field(ge=2, le=10_000)] = 180
    """How many, evenly spread from the right to the left."""
    fov_deg: Annotated[float, Field(gt=0, le=360)] = 180.0
    """From the first beam to the last; all around with 360, the first beam behind."""
    range: Bounds = (0.05, 10.0)
    """[nearest, farthest] that is measured [m]."""
    rate_hz: Rate = 12.5
    """Scans a second; it divides the rate of the tick."""
    latency: Latency = 0
    """How many ticks a scan comes late."""
    noise: LidarNoise = LidarNoise()
    """How far a reading is off."""
    missed: Chance = 0.0
    """Probability that a beam gets no return although it meets something."""
    mixed_pixels: Chance = 0.0
    """Probability that a beam whose spot lies on an edge reads some distance between the two surfaces."""
    spot_deg: Annotated[float, Field(gt=0, le=10)] = 0.5
    """Angle across the spot of a beam; it matters with mixed_pixels."""
    intensity: bool = False
    """Whether the strength of each return is given too."""

    @property
    def housing(self) -> Point3:
        """Where its round housing is, [x, y, z] in the robot's frame [m]."""
        return self.at


MOST_RAYS = 300_000
"""In one turn of a lidar."""
Elevation = Annotated[float, Field(ge=-90, le=90)]
Speed = Annotated[float, Field(ge=-100_000, le=100_000)]


class Rosette(Model):
    """A beam that two turning prisms bend: it draws petals in a cone, others at each turn."""

    fov_deg: Annotated[float, Field(gt=0, le=120)] = 38.4
    """Across the cone."""
    points: Annotated[int, Field(ge=2, le=MOST_RAYS)] = 8_000
    """Beams in one reading, evenly spread in time."""
    rpm: Annotated[tuple[Speed, ...], Field(strict=False, min_length=2, max_length=2)] = (7294.0, -4664.0)
    """How fast the prisms turn, to the left [1/min]."""


class Lidar3d(Bought):
    """A lidar in space: a stack of beams that turns, or a rosette; what it gives is a cloud of points.

    It measures while it turns and the robot drives: each point has a time of its own, and lies in the frame of the
    sensor as it was then.
    """

    model_config = ConfigDict(json_schema_extra={"examples": [{"lidar3d": "top", "rings": 16}]})
    kind: ClassVar[str] = "lidar3d"
    noise_keys: ClassVar[tuple[str, ...]] = ("noise", "missed")
    lidar3d: Name
    """Its name."""
    at: Point3 = (0.0, 0.0, 0.5)
    """[x, y, z] in the robot's frame [m]."""
    yaw_deg: Degrees = 0.0
    """Where the middle of a turn points, to the left; a turn begins on the right of that."""
    pitch_deg: Pitch = 0.0
    """Up."""
    rings: Annotated[int, Field(ge=1, le=256)] = 16
    """How many beams are stacked."""
    elevation_deg: Annotated[tuple[Elevation, ...], Field(strict=False, min_length=1, max_length=256)] = (-15.0, 15.0)
    """[lowest, highest] beam, the others evenly between; or the elevation of each, from the lowest up."""
    columns: Annotated[int, Field(ge=2, le=36_000)] = 1440
    """How often the stack fires in one turn."""
    fov_deg: Annotated[float, Field(gt=0, le=360)] = 360.0
    """From the first column to the last; all around with 360."""
    rosette: Rosette | None = None
    """Beams in a rosette instead of rings and columns."""
    range: Bounds = (0.3, 100.0)
    """[nearest, farthest] that is measured [m]."""
    rate_hz: Rate = 12.5
    """Turns a second; it divides the rate of the tick."""
    latency: Latency = 0
    """How many ticks a cloud comes late."""
    noise: LidarNoise = LidarNoise()
    """How far a range is off."""
    missed: Chance = 0.0
    """Probability that a beam gets no return although it meets something."""

    @property
    def housing(self) -> Point3:
        """Where its round housing is, [x, y, z] in the robot's frame [m]."""
        return self.at

    @property
    def elevations_deg(self) -> tuple[float, ...]:
        """Of each ring, from the lowest up [deg]."""
        given = self.elevation_deg
        return given if len(given) == self.rings else tuple(np.linspace(given[0], given[-1], self.rings).tolist())

    @property
    def rays(self) -> int:
        """How many beams one turn has."""
        return self.rosette.points if self.rosette is not None else self.columns * len(self.elevations_deg)

    @model_validator(mode="after")
    def _stacked(self) -> Self:
        given = self.elevation_deg
        if len(given) not in (2, self.rings):
            right = f"give [lowest, highest], or {self.rings} as there are rings"
            raise fault(f"elevation_deg has {len(given)} elevations; {right}", "elevation_deg")
        if any(low >= high for low, high in pairwise(given)):
            raise fault("each elevation must be above the one before", "elevation_deg")
        if self.rays > MOST_RAYS:
            raise fault(
                f"a turn has {self.rays:,} beams; at most {MOST_RAYS:,}, make columns or rings fewer", "columns"
            )
        return self
