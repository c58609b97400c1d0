"""Sensors as a world file describes them: what a robot senses with besides its wheels."""

import math
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import AfterValidator, Discriminator, Field, Tag, model_validator

from mjsim.world.base import PHYSICS_STEP, Degrees, Deviation, Distance, Length, Model, Name, Point3, Rate, fault
from mjsim.world.lenses import Lens
from mjsim.world.running import nearest_divisor, whole_steps
from mjsim.world.sensor_presets import over_sensor


def _ascending(bounds: tuple[float, ...]) -> tuple[float, ...]:
    if bounds[0] >= bounds[1]:
        raise ValueError(f"range is {list(bounds)} m; the nearest must be less than the farthest")
    return bounds


Latency = Annotated[int, Field(ge=0, le=1000)]
"""Whole ticks."""
Chance = Annotated[float, Field(ge=0, le=1)]
"""A probability."""
Bounds = Annotated[tuple[Distance, ...], Field(strict=False, min_length=2, max_length=2), AfterValidator(_ascending)]
"""[nearest, farthest] [m]."""
Pitch = Annotated[float, Field(ge=-89, le=89)]


class _Bought(Model):
    """A sensor of which there are known makes."""

    preset: Name | None = None
    """A sensor of `assets/sensors`; keys beside this one override it."""

    @model_validator(mode="before")
    @classmethod
    def _over_preset(cls, keys: Any) -> Any:
        if isinstance(keys, dict) and isinstance(keys.get("preset"), str):
            try:
                return over_sensor(cls.__name__.lower(), keys["preset"], keys)
            except ValueError as error:
                raise fault(str(error), "preset") from None
        return keys


class Depth(Model):
    """How a camera measures distances."""

    range: Bounds = (0.0, 100.0)
    """[nearest, farthest] that is measured [m]."""
    noise: Deviation = 0.0
    """Standard deviation at 1 m [m]; it grows with the square of the distance, as that of stereo does."""


class Camera(_Bought):
    """A camera on the robot; it looks along the robot's x axis unless yaw and pitch say otherwise."""

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
    noise: Annotated[float, Field(ge=0, le=100)] = 0.0
    """Standard deviation of each pixel's value, of 255."""
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


class LidarNoise(Model):
    """Standard deviations of one beam's reading."""

    range: Deviation = 0.0
    """[m]"""


class Lidar(_Bought):
    """A level fan of laser beams, as a 2-D lidar has them; what it gives is one scan."""

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


class BeaconNoise(Model):
    """Standard deviations of one sighting."""

    range: Deviation = 0.0
    """[m]"""
    bearing_deg: Annotated[float, Field(ge=0, le=90)] = 0.0
    """[deg]"""


class BeaconSensor(Model):
    """A sensor that tells range and bearing of beacons: those with a face from its front, reflectors from all sides."""

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


class Imu(Model):
    """An inertial sensor: an accelerometer, which feels gravity too, and a gyroscope."""

    imu: Name
    """Its name."""
    at: Point3 = (0.0, 0.0, 0.1)
    """[x, y, z] in the robot's frame [m]."""
    yaw_deg: Degrees = 0.0
    """Where its x axis points, to the left."""
    pitch_deg: Pitch = 0.0
    """Up."""
    rate_hz: Annotated[float, Field(gt=0, le=250)] = 125.0
    """Readings a second, each the mean over a whole number of 4 ms physics steps; all since the last tick come at
    once."""
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

    @model_validator(mode="after")
    def _period_is_whole(self) -> Self:
        if not whole_steps(self.rate_hz):
            nearest = nearest_divisor(1.0 / PHYSICS_STEP, self.rate_hz)
            raise fault(
                f"rate_hz is {self.rate_hz:g} Hz; a period must be a whole number of {PHYSICS_STEP * 1e3:g} ms steps,"
                f" the nearest rate is {nearest:g} Hz",
                "rate_hz",
            )
        return self


AnySensor = Camera | Lidar | BeaconSensor | Imu
KINDS: dict[str, type[AnySensor]] = {"camera": Camera, "lidar": Lidar, "beacons": BeaconSensor, "imu": Imu}
"""Sensors by the key that names them."""


def kind_of(sensor: AnySensor) -> str:
    """Return the key that names a sensor: 'camera', 'lidar' and so on."""
    return next(kind for kind, model in KINDS.items() if isinstance(sensor, model))


def name_of(sensor: AnySensor) -> str:
    """Return the name of a sensor."""
    return str(getattr(sensor, kind_of(sensor)))


def _tag(item: object) -> str | None:
    if isinstance(item, dict):
        return next((f"<{kind}>" for kind in KINDS if kind in item), None)
    return next((f"<{kind}>" for kind, model in KINDS.items() if isinstance(item, model)), None)


Sensor = Annotated[
    Annotated[Camera, Tag("<camera>")]
    | Annotated[Lidar, Tag("<lidar>")]
    | Annotated[BeaconSensor, Tag("<beacons>")]
    | Annotated[Imu, Tag("<imu>")],
    Discriminator(
        _tag,
        custom_error_type="kind",
        custom_error_message="a sensor needs its kind; write camera: NAME, lidar: NAME, beacons: NAME or imu: NAME",
    ),
]
