"""A recording in memory: arrays by robot, one row a tick."""

import json
import math
from collections.abc import Hashable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np

from mjsim.errors import UsageError, did_you_mean
from mjsim.geometry import Array
from mjsim.interface import Observation, Picture, Sighting
from mjsim.record.file import picture_of, raw_messages
from mjsim.record.messages import covariance_of, names_of, observation_of
from mjsim.record.tick import Event
from mjsim.world import World
from mjsim.world.events import Event as WorldEvent
from mjsim.world.looks import Looks, looks_after
from mjsim.world.sensors import Camera


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Landmarks:
    """The estimated map over time; NaN before a landmark is in it. One row a tick, N in all."""

    names: tuple[Hashable, ...]
    """K landmarks, in the order in which they came."""
    mean: Array
    """Shape (N, K, 2) [m]."""
    covariance: Array
    """Shape (N, K, 2, 2) [m^2]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Track:
    """Everything recorded of one robot. One row a tick, N in all; poses are (x, y, heading) [m, m, rad].

    A robot without a driver has its truth, and NaN elsewhere.
    """

    time: Array
    """Shape (N,) [s]."""
    truth: Array
    """Shape (N, 3), world frame."""
    odometry: Array
    """Dead reckoning, shape (N, 3)."""
    odometry_covariance: Array
    """Shape (N, 3, 3)."""
    estimate: Array
    """Shape (N, 3)."""
    covariance: Array
    """Shape (N, 3, 3)."""
    command: Array
    """(forward, left, turn) told to the drive, shape (N, 3) [m/s, m/s, rad/s]; NaN rows for wheel commands."""
    landmarks: Landmarks
    sightings: tuple[tuple[Sighting, ...], ...]
    """One tuple a tick."""
    identities: tuple[tuple[str | None, ...], ...] = ()
    """One tuple a tick: which beacon each of its first sightings, those of the beacon sensors, is of; None for one of
    nothing."""
    innovations: tuple[tuple[tuple[Hashable, Array, Array], ...], ...]
    """One tuple a tick: name, nu (2,), S (2, 2)."""
    events: tuple[Event, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, weakref_slot=True)
class Recording:
    """A run that was recorded; it needs nothing but its file."""

    path: Path
    world: World
    seed: int
    metadata: Mapping[str, str]
    """Versions and command line."""
    time: Array
    """Shape (N,) [s]."""
    qpos: Array
    """Shape (N, nq)."""
    qvel: Array
    """Shape (N, nv)."""
    robots: Mapping[str, Track]
    events: tuple[WorldEvent, ...] = ()
    """What happened to the world, each with the time of the first tick that shows it."""
    things: Mapping[str, Array] = field(default_factory=dict)
    """Where each thing was that can move but robots, (x, y, heading), shape (N, 3) [m, m, rad], by its name in the
    scene; NaN once it was taken away. Of a door the hinge, and the heading of its leaf."""
    wall_seconds: float
    """Time on the clock from the first tick to the last."""
    module_seconds: Mapping[str, Array]
    """Wall-clock time by 'robot/module' or 'loop/part', shape (N,) [s]; NaN where a part did not run."""
    whole: bool = True
    """False when the file does not end as it should: the run was killed, or the file was cut."""

    def cameras(self) -> tuple[tuple[str, str], ...]:
        """Return (robot, camera) of each onboard camera of the world."""
        return tuple(
            (robot.name, sensor.camera)
            for robot in self.world.robots
            for sensor in robot.sensors
            if isinstance(sensor, Camera)
        )

    def looks(self, row: int) -> Looks:
        """Return how the world looks at a row: its light, and what is no longer there."""
        return looks_after(self.world, (event for event in self.events if event.time <= self.time[row]))

    def messages(self, topic: str) -> Iterator[bytes]:
        """Yield the messages of a topic as they stand in the file; none for a topic that is not there."""
        for message in raw_messages(self.path, topics={topic}):
            yield message.data

    def pictures(self, robot: str, camera: str) -> Iterator[tuple[float, bytes, str]]:
        """Yield stamp [s], file contents and format ('jpeg') of each picture of a camera.

        Raises:
            UsageError: There is no such robot or camera.
        """
        name = f"{robot}/{camera}"
        if (robot, camera) not in self.cameras():
            known = did_you_mean(name, ("/".join(pair) for pair in self.cameras()))
            raise UsageError(f"no camera '{name}' in '{self.path}'{known}")
        # The stamp in the picture is rounded to a nanosecond; the observation has it exactly.
        observed, picture = f"/{robot}/observation", f"/{name}/image"
        stamp = math.nan
        for message in raw_messages(self.path, topics={observed, picture}):
            if message.topic == observed:
                given = json.loads(message.data)["cameras"]
                stamp = next((item["stamp"] for item in given if item["name"] == camera), math.nan)
            else:
                yield (stamp, *picture_of(message.data))

    def images(self, robot: str, camera: str) -> Iterator[tuple[float, Picture]]:
        """Yield stamp [s] and RGB picture, shape (height, width, 3), of a camera, read one after the other.

        Raises:
            UsageError: There is no such robot or camera.
        """
        for stamp, data, _ in self.pictures(robot, camera):
            yield stamp, decode_picture(data)

    def observations(self, robot: str) -> Iterator[Observation]:
        """Yield the observations that a robot's modules were given, exactly, but without pictures."""
        for data in self.messages(f"/{robot}/observation"):
            yield observation_of(json.loads(data))

    def joint_covariances(self, robot: str) -> Iterator[tuple[float, tuple[Hashable, ...], Array]]:
        """Yield time [s], names of n landmarks and joint covariance (3 + 2 n, 3 + 2 n), where a tick has one."""
        for data in self.messages(f"/{robot}/covariance"):
            message = json.loads(data)
            yield message["time"], names_of(message), covariance_of(message)


def decode_picture(data: bytes) -> Picture:
    """Return the RGB picture of a JPEG or PNG file's contents, shape (height, width, 3)."""
    picture = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), cv2.IMREAD_COLOR_RGB)
    return np.asarray(picture, dtype=np.uint8)
