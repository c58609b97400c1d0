"""The interface between simulation and sensors: a `Device`, created from a model and a `Mounting`."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import mujoco

from mjsim.compile import carrier_of, robot_from_carrier, robot_from_sensor
from mjsim.geometry import Array
from mjsim.interface import ImuReading, SensorInfo, Sighting
from mjsim.modules import Sealed
from mjsim.sim.bases import RunningGear
from mjsim.sim.rendering import Canvas, Quality
from mjsim.sim.streams import Streams
from mjsim.world import AnySensor, Beacon, Robot, name_of, sensors


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CarriedSensor:
    """The carrier of a sensor, and the pose of the sensor on it."""

    carrier: str
    """A body below the robot's name: its base, or a link of an arm."""
    carrier_from_sensor: Array
    """Shape (4, 4) [m]."""
    robot_from_sensor: Array
    """Pose in the robot frame at the start, shape (4, 4) [m]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Mounting:
    """The mounting of a sensor, and the resources that it may use."""

    model: mujoco.MjModel
    """The compiled world."""
    data: mujoco.MjData
    """Its state, read at each measurement."""
    robot: Robot
    """The robot of the world file."""
    gear: RunningGear
    """Its wheels and their encoders."""
    beacons: Sequence[Beacon]
    """All beacons of the world."""
    streams: Streams
    """Purpose -> random stream of this sensor; the same stream on each call."""
    canvas: Callable[[Quality], Canvas]
    """Returns the canvas for cameras of a quality; the caller closes it."""

    def mount(self, sensor: sensors.Lidar | sensors.Lidar3d | sensors.Imu) -> CarriedSensor:
        """Return the mount of a sensor with an orientation."""
        frame_from_sensor = robot_from_sensor(sensor.at, yaw_deg=sensor.yaw_deg, pitch_deg=sensor.pitch_deg)
        carrier, carrier_from_frame = carrier_of(self.robot, sensor)
        return CarriedSensor(
            carrier=carrier,
            carrier_from_sensor=carrier_from_frame @ frame_from_sensor,
            robot_from_sensor=robot_from_carrier(self.robot, sensor) @ frame_from_sensor,
        )


@dataclass(frozen=True, slots=True, eq=False)
class BeaconReading:
    """One reading of a beacon sensor."""

    sightings: tuple[Sighting, ...]
    """For modules, from right to left, so that the order does not reveal identities."""
    identities: tuple[str | None, ...]
    """For the recording: the true beacon of each sighting, None for a false sighting."""


class Sensed:
    """The readings of all sensors of a robot at one tick."""

    def __init__(self) -> None:
        """Start empty."""
        self._by_name: dict[str, dict[str, object]] = {}
        self._batches: dict[str, tuple[object, ...]] = {}
        self.identities: tuple[str | None, ...] = ()
        """True beacon of each sighting, None for a false sighting; never for modules."""

    def add(self, sensor: AnySensor, reading: Any) -> None:
        """Add a reading to the field of its kind: under the sensor's name, or after the others in a common sequence."""
        if isinstance(reading, BeaconReading):
            self.identities += reading.identities
            reading = reading.sightings
        if isinstance(reading, tuple):
            self._batches[sensor.reading] = (*self._batches.get(sensor.reading, ()), *reading)
        else:
            self._by_name.setdefault(sensor.reading, {})[name_of(sensor)] = reading

    def fields(self) -> dict[str, Any]:
        """Return fields of `Observation`; dicts are made read-only here, which would be expensive later."""
        return {**self._batches, **{field: Sealed(readings) for field, readings in self._by_name.items()}}


class Device(Protocol):
    """A sensor in a running simulation.

    When it is due at a tick, it takes a reading, or skips it if none is requested; both draw the same number of random
    values. A reading is delivered at the same tick, or later if the sensor has latency.
    """

    def info(self) -> SensorInfo:
        """Return its data sheet."""

    def retune(self, sensor: Any) -> None:
        """Use the noise of this model from now on; random streams continue."""

    def take(self, stamp: float) -> Any:
        """Return a current reading, or a tuple of several; `stamp` is the simulated time [s]."""

    def pass_over(self) -> None:
        """Draw the random numbers of a reading that was not requested."""


@runtime_checkable
class StepDevice(Device, Protocol):
    """A sensor that also measures between ticks."""

    def after_step(self) -> None:
        """Store a measurement; called after each step of the physics."""


@runtime_checkable
class FastDevice(StepDevice, Protocol):
    """A sensor that controllers read between ticks: an inertial one."""

    def pull(self, stamp: float) -> tuple[ImuReading, ...]:
        """Return the readings since the last call; `take` returns them again at the next tick."""

    def at_rest(self, stamp: float) -> ImuReading:
        """Return the reading of a robot held at rest in its current pose."""


Maker = Callable[[Any, Mounting], Device]
"""Model of a sensor and its mounting -> device."""
Makers = Mapping[type[Any], Maker]
