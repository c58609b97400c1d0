"""Observations as arrays of fixed shapes, clipped to their bounds."""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from mjsim.errors import UsageError, did_you_mean
from mjsim.geometry import wrap_angle
from mjsim.interface import RobotInfo, Sighting
from mjsim.record import Box, codec_of
from mjsim.run import Noticed
from mjsim.world import AnySensor, BeaconSensor, Robot, World, name_of

SECTORS = 16
"""Number of sectors of the ring (proximity and bump), the first ahead, then counter-clockwise."""
ODOMETRY_BOUND_RATIO = 4.0
"""Bound of odometry as a multiple of the robot's limits, since noise and slip can exceed these."""
MAX_COORDINATE = 20_000.0
"""Bound of estimated positions, larger than any world [m]."""
MAX_SIGMAS = 6.0
"""Number of standard deviations at which noise is clipped."""


class Channel:
    """One array of an observation; it keeps its last reading until there is a newer one."""

    def __init__(
        self,
        read: Callable[[Noticed], ArrayLike | None],
        *,
        low: ArrayLike,
        high: ArrayLike,
        shape: tuple[int, ...],
        dtype: DTypeLike = np.float32,
        first: float = 0.0,
    ) -> None:
        """Prepare the array.

        Args:
            read: Returns a reading, or None if there is none at this tick.
            low: Lower bound, to which values are clipped; broadcast to the shape.
            high: Upper bound, to which values are clipped.
            shape: Shape of the array.
            dtype: Type of the array.
            first: Value before the first reading.
        """
        self._read, self._first = read, first
        self.low: NDArray[Any] = np.array(np.broadcast_to(low, shape), dtype=dtype)
        self.high: NDArray[Any] = np.array(np.broadcast_to(high, shape), dtype=dtype)
        self.start()

    def start(self) -> None:
        """Reset to the initial value."""
        self._held = np.full(self.low.shape, self._first, dtype=self.low.dtype)

    def update(self, noticed: Noticed) -> None:
        """Take the reading of this tick; called once per tick."""
        reading = self._read(noticed)
        if reading is not None:
            # Values clipped to bounds of the array's own precision stay within them when rounded.
            self._held = np.clip(np.asarray(reading), self.low, self.high).astype(self.low.dtype)

    def value(self) -> NDArray[Any]:
        """Return a copy of the newest reading."""
        return self._held.copy()


def channels_of(robot: Robot, info: RobotInfo, world: World, chosen: Sequence[str] | None) -> dict[str, Channel]:
    """Return the observations of a robot.

    Args:
        robot: Robot of the world file.
        info: Its data sheet.
        world: Its world.
        chosen: Names of the observations; by default all except its estimate.

    Raises:
        UsageError: It has no such observation, or two with the same name.
    """
    sensors = {name_of(sensor): sensor for sensor in robot.sensors}
    rings = [sensor for sensor in robot.sensors if isinstance(sensor, BeaconSensor)]
    built_in = {"proximity", "bump", "odometry", "sightings", "estimate"}
    if clash := sorted(built_in & set(sensors)):
        raise UsageError(
            f"sensor '{clash[0]}' of robot '{robot.name}' has the name of an observation of all robots; rename it"
        )
    modules = world.run.drivers.get(robot.name)
    observed = modules is not None and modules.observer is not None
    seen = [name for name, sensor in sensors.items() if codec_of(sensor.kind).boxes is not None]
    usual = ["proximity", "bump", "odometry", *(["sightings"] if rings else []), *seen]
    known = [*usual, "estimate", *(["sightings"] if observed and not rings else [])]
    names = usual if chosen is None else list(chosen)
    channels: dict[str, Channel] = {}
    for name in names:
        if name not in known:
            raise UsageError(f"robot '{robot.name}' observes no '{name}'{did_you_mean(name, known)}")
        match name:
            case "proximity":
                channels[name] = _proximity(robot)
            case "bump":
                channels[name] = Channel(_bump, low=0, high=1, shape=(SECTORS,), dtype=np.int8)
            case "odometry":
                channels[name] = _odometry(info)
            case "estimate":
                channels[name] = _estimate()
            case "sightings":
                channels[name] = _sightings(world, rings)
            case _:
                channels |= _of_sensor(sensors[name], info, world)
    return channels


def _of_sensor(sensor: AnySensor, info: RobotInfo, world: World) -> dict[str, Channel]:
    """Return the channels of one sensor: one of its own name, and others whose names start with it."""
    boxes = codec_of(sensor.kind).boxes
    assert boxes is not None
    return {f"{name_of(sensor)}{ending}": _channel(box) for ending, box in boxes(sensor, info, world).items()}


def _channel(box: Box) -> Channel:
    return Channel(
        lambda noticed: box.read(noticed.seen),
        low=box.low,
        high=box.high,
        shape=box.shape,
        dtype=box.dtype,
        first=box.first,
    )


def _proximity(robot: Robot) -> Channel:
    reach = robot.proximity_range
    return Channel(lambda noticed: noticed.seen.proximity, low=0.0, high=reach, shape=(SECTORS,), first=reach)


def _bump(noticed: Noticed) -> ArrayLike:
    """Return 1 for each sector of the ring in contact, shape (16,)."""
    touched = np.zeros(SECTORS, dtype=np.int8)
    for bearing in noticed.seen.bump:
        touched[round(bearing * SECTORS / math.tau) % SECTORS] = 1
    return touched


def _odometry(info: RobotInfo) -> Channel:
    limit = np.array([info.max_speed, max(info.max_left, info.max_speed), info.max_turn]) * (
        ODOMETRY_BOUND_RATIO * info.dt
    )

    def read(noticed: Noticed) -> ArrayLike:
        odometry = noticed.seen.odometry
        return odometry.forward, odometry.left, odometry.turn

    return Channel(read, low=-limit, high=limit, shape=(3,))


def _estimate() -> Channel:
    limit = np.array([MAX_COORDINATE, MAX_COORDINATE, math.pi])

    def read(noticed: Noticed) -> ArrayLike:
        pose = noticed.belief.pose
        return pose.x, pose.y, wrap_angle(pose.heading)

    return Channel(read, low=-limit, high=limit, shape=(3,))


def _sightings(world: World, rings: Sequence[BeaconSensor]) -> Channel:
    """Return the channel of sightings: a row per beacon of the world, in order, then those of anonymous sightings."""
    rows = {beacon.name: row for row, beacon in enumerate(world.beacons)}
    nameless = len(rows) if any(ring.anonymous for ring in rings) else 0
    reach = [ring.range[1] + math.hypot(*ring.at[:2]) + MAX_SIGMAS * ring.noise.range for ring in rings]
    farthest = max(reach, default=MAX_COORDINATE)

    def read(noticed: Noticed) -> ArrayLike:
        table = np.zeros((len(rows) + nameless, 3))
        unnamed: list[Sighting] = []
        for sighting in noticed.seen.sightings:
            row = rows.get(sighting.name) if sighting.name is not None else None
            if row is None:
                unnamed.append(sighting)
            elif not table[row, 0] or sighting.range < table[row, 1]:
                table[row] = 1.0, sighting.range, sighting.bearing
        for row, sighting in enumerate(unnamed[:nameless], start=len(rows)):
            table[row] = 1.0, sighting.range, sighting.bearing
        return table

    low, high = np.array([0.0, 0.0, -math.pi]), np.array([1.0, farthest, math.pi])
    return Channel(read, low=low, high=high, shape=(len(rows) + nameless, 3))
