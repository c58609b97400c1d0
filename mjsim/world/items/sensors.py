"""Sensors as a world file describes them: what a robot senses with besides its wheels."""

import math
from typing import Annotated, Any, ClassVar, Literal, Self, get_args

import numpy as np
from pydantic import ConfigDict, Field, model_validator

from mjsim.world.ground import (
    Degrees,
    Deviation,
    Distance,
    Length,
    Model,
    Name,
    OneOf,
    Point3,
    Rate,
    Slider,
    fault,
)
from mjsim.world.items.lenses import Lens
from mjsim.world.items.lidars import Lidar as Lidar
from mjsim.world.items.lidars import Lidar3d as Lidar3d
from mjsim.world.items.lidars import Rosette as Rosette
from mjsim.world.items.sensor_model import Bought, Bounds, Chance, Latency, OnArm, Pitch, SensorModel


class Depth(Model):
    """How a camera measures distances."""

    range: Bounds = (0.0, 100.0)
    """[nearest, farthest] that is measured [m]."""
    noise: Deviation = 0.0
    """Standard deviation at 1 m [m]; it grows with the square of the distance, as that of stereo does."""


class Camera(Bought):
    """A camera on the robot; it looks along the robot's x axis unless yaw and pitch say otherwise."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"camera": "front", "at": [0.1, 0, 0.5]}]})
    kind: ClassVar[str] = "camera"
    noise_keys: ClassVar[tuple[str, ...]] = ("noise", "depth")
    camera: Name
    """Its name."""
    at: Point3 = (0.0, 0.0, 0.3)
    """[x, y, z] in the robot's frame [m]."""
    yaw_deg: Degrees = 0.0
    """To the left."""
    pitch_deg: Pitch = 0.0
    """Up."""
    width: Annotated[int, Field(ge=16, le=4096)] = 640
    """[px]"""
    height: Annotated[int, Field(ge=16, le=4096)] = 480
    """[px]"""
    fov_deg: Annotated[float, Field(ge=5, le=150)] = 60.0
    """Horizontal field of view."""
    rate_hz: Rate = 12.5
    """Pictures a second; it divides the rate of the tick."""
    quality: Literal["normal", "high"] = "normal"
    """High adds shadows, reflections and multisampling."""
    noise: Annotated[float, Field(ge=0, le=100), Slider(0.0, 40.0)] = 0.0
    """Standard deviation of each pixel's value on a 0 to 255 scale."""
    latency: Latency = 0
    """How many ticks a picture comes late."""
    lens: Lens | None = None
    """How the lens bends the picture; straight without. The field of view is that behind the lens."""
    depth: bool | Depth = False
    """Whether it gives the distance of each pixel too: true, or how it is measured."""
    segmentation: bool = False
    """Whether it gives what each pixel shows too."""
    exposure: Annotated[float, Field(gt=0, le=100)] | Literal["auto"] = 1.0
    """Brightness of pictures, of what the lamps give; auto brings the mean of each picture to a middle grey."""
    blur: Annotated[float, Field(ge=0, le=20)] = 0.0
    """Standard deviation of what the lens smears [px]."""
    shutter: Annotated[float, Field(ge=0, le=1)] = 0.0
    """How long the shutter is open [s]; a robot that moves blurs the picture."""
    rolling_shutter: Annotated[float, Field(ge=0, le=1)] = 0.0
    """From the first row to the last [s]; the stamp is that of the middle row."""

    @model_validator(mode="after")
    def _lens_reaches_its_edge(self) -> Self:
        if self.lens is not None:
            edge = np.array([[math.tan(math.radians(self.fov_deg) / 2), 0.0]])
            if not np.allclose(self.lens.straighten(self.lens.bend(edge)), edge, atol=1e-6):
                message = f"fov_deg is {self.fov_deg:g}; the lens folds the picture before it, make one of them smaller"
                raise fault(message, "lens")
        return self


class BeaconNoise(Model):
    """Standard deviations of one sighting."""

    range: Deviation = 0.0
    """[m]"""
    bearing_deg: Annotated[float, Field(ge=0, le=90)] = 0.0
    """[deg]"""


class BeaconSensor(SensorModel):
    """A sensor that tells range and bearing of beacons: those with a face from its front, reflectors from all sides."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"beacons": "ring"}]})
    kind: ClassVar[str] = "beacons"
    noise_keys: ClassVar[tuple[str, ...]] = ("noise", "missed", "false_rate", "outliers", "heavy_tails")
    beacons: Name
    """Its name."""
    at: Point3 = (0.0, 0.0, 0.3)
    """[x, y, z] in the robot's frame [m]; what stands between here and the beacon's middle hides it."""
    yaw_deg: Degrees = 0.0
    """Where the middle of its field of view points, to the left."""
    fov_deg: Annotated[float, Field(gt=0, le=360)] = 360.0
    """Horizontal field of view."""
    range: Bounds = (0.1, 8.0)
    """[nearest, farthest] horizontal distance at which a beacon is seen [m]."""
    rate_hz: Rate = 12.5
    """Looks a second; it divides the rate of the tick."""
    latency: Latency = 0
    """How many ticks sightings come late."""
    noise: BeaconNoise = BeaconNoise()
    """How far a sighting is off."""
    anonymous: bool = False
    """Whether sightings come without the beacon's name."""
    missed: Chance = 0.0
    """Probability that a beacon in sight is not seen at a look."""
    false_rate: Annotated[float, Field(ge=0, le=1000)] = 0.0
    """Sightings of nothing, on average [1/s]."""
    outliers: Chance = 0.0
    """Probability that a sighting is anywhere in the field of view."""
    heavy_tails: Annotated[float, Field(gt=2, le=1000)] | None = None
    """Degrees of freedom of Student's t that the errors follow, at the same standard deviation; normal without."""

    @property
    def housing(self) -> Point3:
        """Where its round housing is, [x, y, z] in the robot's frame [m]."""
        return self.at


class ImuError(Model):
    """A standard deviation for each of the three axes of both parts."""

    acceleration: Deviation = 0.0
    """[m/s^2], and over a root of a second for a walk."""
    turn: Deviation = 0.0
    """[rad/s], and over a root of a second for a walk."""


class ImuRange(Model):
    """The most that is measured, either way."""

    acceleration: Length = 157.0
    """[m/s^2]; 16 times gravity unless given."""
    turn: Length = 34.9
    """[rad/s]; 2000 degrees a second unless given."""


class Imu(OnArm):
    """An inertial sensor: an accelerometer, which feels gravity too, and a gyroscope."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"imu": "imu"}]})
    kind: ClassVar[str] = "imu"
    noise_keys: ClassVar[tuple[str, ...]] = ("noise", "walk")
    between_ticks: ClassVar[bool] = True
    imu: Name
    """Its name."""
    at: Point3 = (0.0, 0.0, 0.1)
    """[x, y, z] in the robot's frame [m]."""
    yaw_deg: Degrees = 0.0
    """Where its x axis points, to the left."""
    pitch_deg: Pitch = 0.0
    """Up."""
    rate_hz: Rate = 125.0
    """Readings a second, each the mean over a whole number of physics steps; all since the last tick come at once."""
    latency: Latency = 0
    """How many ticks readings come late."""
    range: ImuRange = ImuRange()
    """What is beyond reads as the end of the range."""
    noise: ImuError = ImuError()
    """White noise of each reading."""
    bias: ImuError = ImuError()
    """Of the constant error, drawn once a run."""
    walk: ImuError = ImuError()
    """How fast the error wanders, as a random walk."""

    def misfit(self, robot: Any) -> str | None:
        """Return why a robot cannot carry it: one that balances feels its lean with all it has."""
        if self.on is not None and robot.drive.own_imu is not None:
            return "a balancing base tells how it leans by its inertial sensors; leave out 'on'"
        return super().misfit(robot)


class Encoders(SensorModel):
    """Counters on the driven wheels: the whole steps that odometry is computed from, `odometry.ticks` in a turn."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"encoders": "wheels"}]})
    kind: ClassVar[str] = "encoders"
    noise_keys: ClassVar[tuple[str, ...]] = ()
    encoders: Name
    """Its name."""
    rate_hz: Rate = 25.0
    """Readings a second; it divides the rate of the tick."""
    latency: Latency = 0
    """How many ticks a reading comes late."""
    bits: Annotated[int, Field(ge=8, le=32)] = 32
    """Width of the counters, which wrap around: after 2^(bits - 1) - 1 comes -2^(bits - 1)."""

    def misfit(self, robot: Any) -> str | None:
        """Return why a robot cannot carry it: its wheels tell of no steps."""
        if robot.odometry.ticks is None:
            return "encoders count steps; say how many a turn of a wheel has, such as odometry: {ticks: 2048}"
        return None


class RangeNoise(Model):
    """Standard deviation of one range."""

    range: Deviation = 0.0
    """[m]"""


class Nlos(Model):
    """What happens to a range without line of sight: walls and things stand between tag and anchor."""

    bias: Distance = 0.0
    """Mean of what the range is too long, exponentially distributed [m]."""
    missed: Chance = 0.0
    """Probability that there is no range at all."""


class Uwb(SensorModel):
    """A radio tag that measures how far it is to anchors, in space, all around: ultra-wideband, range only."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"uwb": "tag", "noise": {"range": 0.1}}]})
    kind: ClassVar[str] = "uwb"
    noise_keys: ClassVar[tuple[str, ...]] = ("noise", "nlos", "missed")
    uwb: Name
    """Its name."""
    at: Point3 = (0.0, 0.0, 0.3)
    """[x, y, z] of its antenna in the robot's frame [m]."""
    range: Bounds = (0.0, 40.0)
    """[nearest, farthest] distance at which an anchor is heard [m]."""
    rate_hz: Rate = 12.5
    """Readings a second; it divides the rate of the tick."""
    latency: Latency = 0
    """How many ticks a reading comes late."""
    noise: RangeNoise = RangeNoise()
    """White noise of each range."""
    bias: Deviation = 0.0
    """Standard deviation of the constant error of each anchor's ranges, drawn once a run [m]."""
    nlos: Nlos = Nlos()
    """Without line of sight."""
    missed: Chance = 0.0
    """Probability that an anchor in reach is not heard at a reading."""

    @property
    def housing(self) -> Point3:
        """Where its round housing is, [x, y, z] in the robot's frame [m]."""
        return self.at


AnySensor = Camera | Lidar | BeaconSensor | Imu | Encoders | Uwb | Lidar3d
SENSOR_KINDS: dict[str, type[AnySensor]] = {model.kind: model for model in get_args(AnySensor)}
"""Sensors by the key that names them."""


def name_of(sensor: AnySensor) -> str:
    """Return the name of a sensor."""
    return str(getattr(sensor, sensor.kind))


_WRITTEN = [f"{kind}: NAME" for kind in SENSOR_KINDS]
Sensor = Annotated[
    AnySensor, OneOf(SENSOR_KINDS, f"a sensor needs its kind; write {', '.join(_WRITTEN[:-1])} or {_WRITTEN[-1]}")
]
