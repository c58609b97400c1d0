"""Sensors as described in a world file, other than wheel odometry."""

from typing import Annotated, Any, ClassVar, get_args

from pydantic import ConfigDict, Field

from mjsim.sentences import Sentence
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
)
from mjsim.world.items.sensing.cameras import Camera as Camera
from mjsim.world.items.sensing.lidars import Lidar as Lidar
from mjsim.world.items.sensing.lidars import Lidar3d as Lidar3d
from mjsim.world.items.sensing.lidars import Rosette as Rosette
from mjsim.world.items.sensing.sensor_model import Bounds, Chance, Latency, OnArm, Pitch, SensorModel


class BeaconNoise(Model):
    """Standard deviations of one sighting."""

    range: Deviation = 0.0
    """[m]"""
    bearing_deg: Annotated[float, Field(ge=0, le=90)] = 0.0
    """[deg]"""


class BeaconSensor(SensorModel):
    """A sensor for range and bearing of beacons: pictures and markers from the front, reflectors from all sides."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"beacons": "ring"}]})
    kind: ClassVar[str] = "beacons"
    is_housed: ClassVar[bool] = True
    reading: ClassVar[str] = "sightings"
    noise_keys: ClassVar[tuple[str, ...]] = ("noise", "missed", "false_rate", "outliers", "heavy_tails")
    beacons: Name
    """Its name."""
    at: Point3 = (0.0, 0.0, 0.3)
    """Position [x, y, z] in the robot frame [m]; objects between here and the centre of a beacon occlude it."""
    yaw_deg: Degrees = 0.0
    """Direction of the centre of its field of view, to the left."""
    fov_deg: Annotated[float, Field(gt=0, le=360)] = 360.0
    """Horizontal field of view."""
    range: Bounds = (0.1, 8.0)
    """[minimum, maximum] horizontal distance of a visible beacon [m]."""
    rate_hz: Rate = 12.5
    """Measurements per second; must divide the tick rate."""
    latency: Latency = 0
    """Delay of sightings, in ticks."""
    noise: BeaconNoise = BeaconNoise()
    """Noise of a sighting."""
    anonymous: bool = False
    """Whether sightings have no names."""
    missed: Chance = 0.0
    """Probability that a visible beacon is missed."""
    false_rate: Annotated[float, Field(ge=0, le=1000)] = 0.0
    """Mean rate of false sightings [1/s]."""
    outliers: Chance = 0.0
    """Probability that a sighting is an outlier, uniform in the field of view."""
    heavy_tails: Annotated[float, Field(gt=2, le=1000)] | None = None
    """Degrees of freedom of Student's t for the errors, with the same standard deviation; default: normal."""


class ImuError(Model):
    """Standard deviations, equal for the three axes of each part."""

    acceleration: Deviation = 0.0
    """[m/s^2], and [m/s^2/sqrt(s)] for a random walk."""
    turn: Deviation = 0.0
    """[rad/s], and [rad/s/sqrt(s)] for a random walk."""


class ImuRange(Model):
    """Measurement range in both directions."""

    acceleration: Length = 157.0
    """[m/s^2]; default: 16 times gravity."""
    turn: Length = 34.9
    """[rad/s]; default: 2000 deg/s."""


class Imu(OnArm):
    """An inertial sensor: an accelerometer (specific force, including gravity) and a gyroscope."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"imu": "imu"}]})
    kind: ClassVar[str] = "imu"
    reading: ClassVar[str] = "imu"
    noise_keys: ClassVar[tuple[str, ...]] = ("noise", "walk")
    between_ticks: ClassVar[bool] = True
    imu: Name
    """Its name."""
    at: Point3 = (0.0, 0.0, 0.1)
    """Position [x, y, z] in the robot frame [m]."""
    yaw_deg: Degrees = 0.0
    """Direction of its x axis, to the left."""
    pitch_deg: Pitch = 0.0
    """Pitch, positive up."""
    rate_hz: Rate = 125.0
    """Readings per second, each a mean over a whole number of physics steps; a tick gets all since the last one."""
    latency: Latency = 0
    """Delay of readings, in ticks."""
    range: ImuRange = ImuRange()
    """Measurement range; readings saturate beyond it."""
    noise: ImuError = ImuError()
    """White noise of each reading (standard deviation)."""
    bias: ImuError = ImuError()
    """Standard deviation of the constant bias, drawn once per run."""
    walk: ImuError = ImuError()
    """Random walk of the bias."""

    def misfit(self, robot: Any) -> str | None:
        """Return why a robot cannot carry it: the controller of a balancing robot needs all readings."""
        if self.on is not None and robot.drive.own_imu is not None:
            return "the inertial sensors of a balancing base must be on its body; leave out 'on'"
        return super().misfit(robot)


class Encoders(SensorModel):
    """Encoders on the driven wheels, with `odometry.ticks` counts per revolution; odometry uses these counts."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"encoders": "wheels"}]})
    kind: ClassVar[str] = "encoders"
    reading: ClassVar[str] = "encoders"
    noise_keys: ClassVar[tuple[str, ...]] = ()
    encoders: Name
    """Its name."""
    rate_hz: Rate = 25.0
    """Readings per second; must divide the tick rate."""
    latency: Latency = 0
    """Delay of a reading, in ticks."""
    bits: Annotated[int, Field(ge=8, le=32)] = 32
    """Width of the counters, which wrap from 2^(bits - 1) - 1 to -2^(bits - 1)."""

    def misfit(self, robot: Any) -> str | None:
        """Return why a robot cannot carry it: it has no encoder counts."""
        if robot.odometry.ticks is None:
            return "encoders need the counts per revolution of a wheel, such as odometry: {ticks: 2048}"
        return None


class RangeNoise(Model):
    """Standard deviation of one range."""

    range: Deviation = 0.0
    """[m]"""


class Nlos(Model):
    """Ranges without line of sight, with walls or objects between tag and anchor."""

    bias: Distance = 0.0
    """Mean of the positive range error, exponentially distributed [m]."""
    missed: Chance = 0.0
    """Probability that there is no range."""


class Uwb(SensorModel):
    """An ultra-wideband tag that measures the 3-D distance to anchors in all directions."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"uwb": "tag", "noise": {"range": 0.1}}]})
    kind: ClassVar[str] = "uwb"
    is_housed: ClassVar[bool] = True
    reading: ClassVar[str] = "ranges"
    noise_keys: ClassVar[tuple[str, ...]] = ("noise", "nlos", "missed")
    uwb: Name
    """Its name."""
    at: Point3 = (0.0, 0.0, 0.3)
    """Position [x, y, z] of its antenna in the robot frame [m]."""
    range: Bounds = (0.0, 40.0)
    """[minimum, maximum] distance of an anchor in range [m]."""
    rate_hz: Rate = 12.5
    """Readings per second; must divide the tick rate."""
    latency: Latency = 0
    """Delay of a reading, in ticks."""
    noise: RangeNoise = RangeNoise()
    """White noise of each range (standard deviation)."""
    bias: Deviation = 0.0
    """Standard deviation of the constant bias of each anchor, drawn once per run [m]."""
    nlos: Nlos = Nlos()
    """Errors without line of sight."""
    missed: Chance = 0.0
    """Probability that the reading of an anchor in range is missed."""


class HeadingNoise(Model):
    """Standard deviation of one heading."""

    heading_deg: Annotated[float, Field(ge=0, le=90)] = 0.0
    """[deg]"""


class HeadingBias(Model):
    """A smooth random bias by place, such as steel in a building causes in the earth's magnetic field."""

    amplitude_deg: Annotated[float, Field(ge=0, le=90)] = 0.0
    """Standard deviation over all places [deg]."""
    length: Length = 2.0
    """Correlation length: biases of places much nearer to each other are nearly equal [m]."""
    seed: Annotated[int, Field(ge=0, le=2**32 - 1)] = 0
    """Seed of the field; compasses with the same seed and length are in the same field, in each run."""


class Compass(SensorModel):
    """A compass: the heading of the robot from magnetic east, counter-clockwise."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"compass": "compass", "noise": {"heading_deg": 2}}]})
    kind: ClassVar[str] = "compass"
    is_housed: ClassVar[bool] = True
    reading: ClassVar[str] = "compasses"
    compass: Name
    """Its name."""
    at: Point3 = (0.0, 0.0, 0.3)
    """Position [x, y, z] in the robot frame [m]."""
    rate_hz: Rate = 12.5
    """Readings per second; must divide the tick rate."""
    latency: Latency = 0
    """Delay of a reading, in ticks."""
    noise: HeadingNoise = HeadingNoise()
    """White noise of each heading (standard deviation)."""
    bias: HeadingBias = HeadingBias()
    """Bias by place."""
    declination_deg: Degrees = 0.0
    """Magnetic north, clockwise from the world's y axis; not given to modules."""


AnySensor = Camera | Lidar | BeaconSensor | Imu | Encoders | Uwb | Lidar3d | Compass
SENSOR_KINDS: dict[str, type[AnySensor]] = {model.kind: model for model in get_args(AnySensor)}
"""Sensor models by the key of their name."""


def name_of(sensor: AnySensor) -> str:
    """Return the name of a sensor."""
    return str(getattr(sensor, sensor.kind))


_WRITTEN = [f"{kind}: NAME" for kind in SENSOR_KINDS]
Sensor = Annotated[
    AnySensor,
    OneOf(
        SENSOR_KINDS,
        Sentence("a sensor needs a kind as a key; write {kinds} or {last}", ", ".join(_WRITTEN[:-1]), _WRITTEN[-1]),
    ),
]
