"""Lidars as described in a world file: 2-D, and 3-D with rings or a rosette."""

from itertools import pairwise
from typing import Annotated, ClassVar, Self

import numpy as np
from pydantic import ConfigDict, Field, model_validator

from mjsim.sentences import Sentence
from mjsim.world.ground import Degrees, Deviation, Model, Name, Point3, Rate, fault
from mjsim.world.items.sensing.sensor_model import Bought, Bounds, Chance, Latency, Pitch


class LidarNoise(Model):
    """Standard deviation of one beam's range."""

    range: Deviation = 0.0
    """[m]"""


class Lidar(Bought):
    """A 2-D lidar: a horizontal fan of beams; each reading is a scan."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"lidar": "scan"}]})
    kind: ClassVar[str] = "lidar"
    is_housed: ClassVar[bool] = True
    reading: ClassVar[str] = "scans"
    noise_keys: ClassVar[tuple[str, ...]] = ("noise", "missed", "mixed_pixels")
    lidar: Name
    """Its name."""
    at: Point3 = (0.0, 0.0, 0.3)
    """Position [x, y, z] in the robot frame [m]."""
    yaw_deg: Degrees = 0.0
    """Direction of the middle of the fan, to the left."""
    pitch_deg: Pitch = 0.0
    """Pitch, positive up."""
    beams: Annotated[int, Field(ge=2, le=10_000)] = 180
    """Number of beams, evenly spaced from right to left."""
    fov_deg: Annotated[float, Field(gt=0, le=360)] = 180.0
    """Angle from the first beam to the last; with 360 all around, the first beam to the rear."""
    range: Bounds = (0.05, 10.0)
    """[minimum, maximum] range [m]."""
    rate_hz: Rate = 12.5
    """Scans per second; must divide the tick rate."""
    rotating: bool = False
    """Whether it measures while it rotates and the robot moves: each beam has its own time; otherwise all have one."""
    latency: Latency = 0
    """Delay of a scan, in ticks."""
    noise: LidarNoise = LidarNoise()
    """Noise of a reading."""
    missed: Chance = 0.0
    """Probability that a beam gets no return although it hits something."""
    mixed_pixels: Chance = 0.0
    """Probability that a beam with its spot on an edge measures a range between the two surfaces."""
    spot_deg: Annotated[float, Field(gt=0, le=10)] = 0.5
    """Divergence: angle across the spot of a beam; used for mixed_pixels."""
    intensity: bool = False
    """Whether it also measures the intensity of each return."""


MAX_RAYS = 300_000
"""Largest number of points in one turn of a lidar."""
Elevation = Annotated[float, Field(ge=-90, le=90)]
Speed = Annotated[float, Field(ge=-100_000, le=100_000)]


class Rosette(Model):
    """A rosette scan by two rotating prisms: petals in a cone, different at each revolution."""

    fov_deg: Annotated[float, Field(gt=0, le=120)] = 38.4
    """Full angle of the cone."""
    points: Annotated[int, Field(ge=2, le=MAX_RAYS)] = 8_000
    """Beams per reading, evenly spaced in time."""
    rpm: Annotated[tuple[Speed, ...], Field(strict=False, min_length=2, max_length=2)] = (7294.0, -4664.0)
    """Speeds of the prisms, to the left [1/min]."""


class Lidar3d(Bought):
    """A 3-D lidar: a rotating stack of beams, or a rosette; each reading is a point cloud.

    It measures while it rotates and the robot moves: each point has its own time, and is in the sensor frame at that
    time.
    """

    model_config = ConfigDict(json_schema_extra={"examples": [{"lidar3d": "top", "rings": 16}]})
    kind: ClassVar[str] = "lidar3d"
    is_housed: ClassVar[bool] = True
    reading: ClassVar[str] = "clouds"
    noise_keys: ClassVar[tuple[str, ...]] = ("noise", "missed")
    lidar3d: Name
    """Its name."""
    at: Point3 = (0.0, 0.0, 0.5)
    """Position [x, y, z] in the robot frame [m]."""
    yaw_deg: Degrees = 0.0
    """Direction of the middle of a revolution, to the left; a revolution starts on the right of it."""
    pitch_deg: Pitch = 0.0
    """Pitch, positive up."""
    rings: Annotated[int, Field(ge=1, le=256)] = 16
    """Number of rings."""
    elevation_deg: Annotated[tuple[Elevation, ...], Field(strict=False, min_length=1, max_length=256)] = (-15.0, 15.0)
    """Elevation of the [lowest, highest] ring, with even spacing; or of each ring, from the lowest up."""
    columns: Annotated[int, Field(ge=2, le=36_000)] = 1440
    """Number of firings per revolution."""
    fov_deg: Annotated[float, Field(gt=0, le=360)] = 360.0
    """Angle from the first column to the last; 360 for all around."""
    rosette: Rosette | None = None
    """A rosette pattern instead of rings and columns."""
    range: Bounds = (0.3, 100.0)
    """[minimum, maximum] range [m]."""
    rate_hz: Rate = 12.5
    """Revolutions per second; must divide the tick rate."""
    latency: Latency = 0
    """Delay of a cloud, in ticks."""
    noise: LidarNoise = LidarNoise()
    """Noise of a range."""
    missed: Chance = 0.0
    """Probability that a beam gets no return although it hits something."""

    @property
    def elevations_deg(self) -> tuple[float, ...]:
        """Elevation of each ring, from the lowest up [deg]."""
        given = self.elevation_deg
        return given if len(given) == self.rings else tuple(np.linspace(given[0], given[-1], self.rings).tolist())

    @property
    def rays(self) -> int:
        """Number of beams per turn."""
        return self.rosette.points if self.rosette is not None else self.columns * len(self.elevations_deg)

    @model_validator(mode="after")
    def _stacked(self) -> Self:
        given = self.elevation_deg
        if len(given) not in (2, self.rings):
            right = Sentence("give [lowest, highest], or {rings} values, one for each ring", self.rings)
            raise fault(Sentence("elevation_deg has {given} elevations; {right}", len(given), right), "elevation_deg")
        if any(low >= high for low, high in pairwise(given)):
            raise fault("each elevation must be above the one before", "elevation_deg")
        if self.rays > MAX_RAYS:
            raise fault(
                Sentence(
                    "a revolution has {rays:,} beams; at most {max_rays:,}, reduce columns or rings",
                    self.rays,
                    MAX_RAYS,
                ),
                "columns",
            )
        return self
