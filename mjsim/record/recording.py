"""A recording in memory: arrays by robot, one row per tick."""

import json
import math
import weakref
from collections.abc import Collection, Hashable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from mjsim.errors import UsageError, did_you_mean
from mjsim.geometry import Array
from mjsim.interface import Observation, Picture
from mjsim.models import picture_size
from mjsim.record.drawn import decode_picture, depth_pixels
from mjsim.record.file import RawMessage, picture_of, raw_messages, timestamp_of
from mjsim.record.joint_messages import JointTrack
from mjsim.record.json_messages import covariance_of, event_of, names_of, observation_of
from mjsim.record.mechanism_messages import SensorTrack
from mjsim.record.numbers import Message, nanoseconds
from mjsim.record.parse import content_of, reading, value_of
from mjsim.record.readings import CODECS
from mjsim.record.tick import RobotEvent
from mjsim.record.track import Track, span_of
from mjsim.sentences import Sentence
from mjsim.views import Viewed
from mjsim.world import AnySensor, Camera, Lidar, Looks, World, WorldEvent, looks_after, name_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from pandas import DataFrame

T = TypeVar("T")

INCOMPLETE = "the recording is incomplete: the run was killed, or the file was cut"
"""Message about a recording without an end."""
SAME_TIME = 1e-6
"""Times that differ by less are equal [s]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False, weakref_slot=True)
class Recording(Viewed):
    """A recorded run; it needs only its file."""

    path: Path
    """File of the recording."""
    world: World
    """The world at the start of the run."""
    seed: int
    """Seed of all random numbers."""
    metadata: Mapping[str, str]
    """Versions and command line."""
    time: Array
    """Shape (N,) [s]."""
    qpos: Array
    """Shape (N, nq)."""
    qvel: Array
    """Shape (N, nv)."""
    robots: Mapping[str, Track]
    """Recorded data of each robot, by name."""
    events: tuple[WorldEvent, ...] = ()
    """Events of the world, each with the time of the first tick that shows it."""
    things: Mapping[str, Array] = field(default_factory=dict)
    """Pose (x, y, heading) of each movable thing except robots, shape (N, 3) [m, m, rad], by its name in the scene; NaN
    after its removal. For a door, the position of the hinge and the heading of the leaf."""
    joints: Mapping[str, JointTrack] = field(default_factory=dict)
    """Motion of the joints of each arm, by 'robot/arm'; of the wheels of a balancing base by 'robot/drive', of a
    mechanism by its name."""
    readings: Mapping[str, SensorTrack] = field(default_factory=dict)
    """Sensor readings of each mechanism, by its name."""
    clock: Array
    """Wall-clock time of each tick since the start of the recording, shape (N,) [s]."""
    module_seconds: Mapping[str, Array]
    """Wall-clock time by 'robot/module' or 'loop/part', shape (N,) [s]; NaN where a part did not run."""
    whole: bool = True
    """False if the file is incomplete: the run was killed, or the file was truncated."""

    def __repr__(self) -> str:
        """Return its world, span, seed and robots."""
        robots = ", ".join(self.robots) or "no robots"
        return f"<Recording of '{self.world.name}': {span_of(self.time)}, seed {self.seed}; {robots}>"

    def plot(self, kind: str = "path", *, robot: str | None = None) -> "Axes | NDArray[Any]":
        """Draw a plot of a report with pyplot, so that notebooks show it; savefig of `.figure` writes it to a file.

        Args:
            kind: 'path', 'error', 'bounds' (errors between 3-sigma bounds), 'nees' or 'landmarks'.
            robot: By default the first one.

        Returns:
            The axes, or an array of them if the plot has several panels.

        Raises:
            UsageError: There is no such plot or robot, or nothing to draw.
        """
        axes: Axes | NDArray[Any] = self._views().plotted(self, kind, robot=robot)
        return axes

    def frame(self, table: str | None = None) -> "DataFrame":
        """Return a table of `mjsim export --csv` for pandas.

        Args:
            table: Its file without suffix, such as 'scout_track', 'scout_sightings' or 'events'; the name of a robot
                stands for its track; by default that of the first robot.

        Raises:
            UsageError: There is no such table, or pandas is not installed.
        """
        frame: DataFrame = self._views().frame_of(self, table)
        return frame

    @property
    def wall_seconds(self) -> float:
        """Wall-clock time from the first tick to the last [s]."""
        return float(self.clock[-1] - self.clock[0])

    def between(self, begin: float | None = None, end: float | None = None) -> "Recording":
        """Return the section between two times, for statistics and plots.

        It has the robots' events of the section; earlier events of the world are kept, because they determine how it
        looks. Data that is read from the file on request, such as `pictures` and `observations`, is not cut.

        Args:
            begin: Start of the section [s]; by default that of the run.
            end: End of the section [s]; by default that of the run.

        Raises:
            UsageError: No tick is between them.
        """
        first = self.time[0] if begin is None else begin
        last = self.time[-1] if end is None else end
        rows = np.flatnonzero((self.time >= first - SAME_TIME) & (self.time <= last + SAME_TIME))
        if not len(rows):
            span = f"{self.time[0]:g} to {self.time[-1]:g} s"
            raise UsageError(
                Sentence(
                    "no tick is between {first:g} and {last:g} s; the recording has ticks from {span}",
                    first,
                    last,
                    span,
                )
            )
        if len(rows) == len(self.time):
            return self
        until = float(self.time[rows[-1]]) + SAME_TIME
        since = float(self.time[rows[0]]) - SAME_TIME
        section = replace(
            self,
            metadata={key: value for key, value in self.metadata.items() if key != "seconds"},
            time=self.time[rows],
            qpos=self.qpos[rows],
            qvel=self.qvel[rows],
            robots={
                name: replace(
                    track.at(rows),
                    events=tuple(e for e in track.events if since <= e.time <= until),
                    path=track.path[(track.path[:, 0] >= since) & (track.path[:, 0] <= until)],
                )
                for name, track in self.robots.items()
            },
            events=tuple(event for event in self.events if event.time <= until),
            things={name: places[rows] for name, places in self.things.items()},
            joints={name: track.at(rows) for name, track in self.joints.items()},
            readings={name: track.at(rows) for name, track in self.readings.items()},
            clock=self.clock[rows],
            module_seconds={part: seconds[rows] for part, seconds in self.module_seconds.items()},
        )
        weakref.finalize(section, id, self)  # a temporary file goes with the last recording that reads it
        return section

    def cameras(self) -> tuple[tuple[str, str], ...]:
        """Return (robot, camera) of each onboard camera of the world."""
        return tuple(
            (robot.name, sensor.camera)
            for robot in self.world.robots
            for sensor in robot.sensors
            if isinstance(sensor, Camera)
        )

    def looks(self, row: int) -> Looks:
        """Return the appearance of the world at a row: its light, and removed things."""
        time = float(self.time[row])
        return looks_after(self.world, (event for event in self.events if event.time <= time), time=time)

    def has_estimator(self, robot: str) -> bool:
        """Return whether a module estimated the pose of a robot; without one the estimate is dead reckoning."""
        return bool(self.estimator_of(robot))

    def estimator_of(self, robot: str) -> str:
        """Return the class that estimated the pose of a robot; empty for dead reckoning."""
        if robot == self.metadata.get("replayed robot"):
            return self.metadata.get("replayed estimator", "replay")
        if "modules" in self.metadata:
            return str(json.loads(self.metadata["modules"]).get(robot, {}).get("estimator", ""))
        driver = self.world.run.drivers.get(robot)
        return "" if driver is None or driver.estimator is None else driver.estimator.use.rpartition(":")[2]

    def messages(self, topic: str) -> Iterator[bytes]:
        """Yield the messages of a topic as stored in the file; none for a missing topic."""
        for message in raw_messages(self.path, topics={topic}):
            yield message.data

    def pictures(self, robot: str, camera: str) -> Iterator[tuple[float, bytes, str]]:
        """Yield stamp [s], file contents and format ('jpeg') of each picture of a camera.

        Raises:
            UsageError: There is no such robot or camera.
            RecordingError: A picture is not as mjsim writes it.
        """
        for _, stamp, data, form in self._pictures(robot, camera):
            yield stamp, data, form

    def images(self, robot: str, camera: str) -> Iterator[tuple[float, Picture]]:
        """Yield stamp [s] and RGB picture, shape (height, width, 3), of a camera, reading one at a time.

        Raises:
            UsageError: There is no such robot or camera.
            RecordingError: A picture was not written by mjsim, or does not have the camera's size.
        """
        cameras = [sensor for sensor in self._sensors(robot) if isinstance(sensor, Camera)]
        sizes = {sensor.camera: (sensor.width, sensor.height) for sensor in cameras}
        for message, stamp, data, _ in self._pictures(robot, camera):
            with reading(message, path=self.path):
                if picture_size(data) != sizes[camera]:
                    raise ValueError("a picture of another size than the camera's")
                picture = decode_picture(data)
            yield stamp, picture

    def depths(self, robot: str, camera: str) -> Iterator[tuple[float, NDArray[Any]]]:
        """Yield the depth of each picture of a camera that has one: its stamp [s], and depths, shape (height, width).

        Depth is uint16 in millimetres, 0 for none; or, if a log has finer or larger depth, float32 in metres, infinite
        for none. Depth of a run is rounded; `mjsim export --redraw` gives it as received by modules.

        Raises:
            UsageError: There is no such robot or camera.
            RecordingError: A message is not as mjsim writes it.
        """
        for message, stamp in self._taken(robot, camera, "depth"):
            with reading(message, path=self.path):
                pixels, timestamp = depth_pixels(message.data), timestamp_of(message.data)
            yield stamp if timestamp == nanoseconds(stamp) else timestamp * 1e-9, pixels

    def observations(self, robot: str) -> Iterator[Observation]:
        """Yield the exact observations that a robot's modules received, without pictures; none without a driver.

        Raises:
            UsageError: There is no such robot.
            RecordingError: One is not as mjsim writes it.
        """
        for seen, _ in self.observed(robot):
            yield seen

    def observed(self, robot: str) -> Iterator[tuple[Observation, dict[str, float]]]:
        """Yield each observation of a robot, and camera -> stamp of each of its pictures [s].

        Raises:
            UsageError: There is no such robot.
            RecordingError: One is not as mjsim writes it.
        """
        if robot not in self.robots:
            raise UsageError(
                Sentence(
                    "no robot '{robot}' in '{path}'{did_you_mean}", robot, self.path, did_you_mean(robot, self.robots)
                )
            )
        for message in raw_messages(self.path, topics={f"/{robot}/observation"}):
            yield self.observation_in(message)

    def observation_in(self, message: RawMessage) -> tuple[Observation, dict[str, float]]:
        """Return the observation in a message, and camera -> stamp of each of its pictures [s].

        Raises:
            RecordingError: It is not as mjsim writes it, or of sensors that the robot does not have.
        """
        robot = message.topic.split("/")[1]
        content = content_of(message, path=self.path)
        with reading(message, path=self.path):
            seen = observation_of(content)
            stamps = {item["name"]: item["stamp"] for item in content["cameras"]}
            check_fit(seen, self._sensors(robot))
            if unknown := stamps.keys() - {name for of, name in self.cameras() if of == robot}:
                raise ValueError(
                    Sentence("a picture of '{smallest:.40}', which is not a camera of the robot", min(unknown))
                )
        return seen, stamps

    def event_in(self, message: RawMessage) -> RobotEvent:
        """Return the event in a message on '/R/events'; raises RecordingError when it is not as mjsim writes it."""
        return value_of(message, event_of, path=self.path)

    def is_observed(self, robot: str) -> bool:
        """Return whether there are observations of a robot, that is, whether it had a driver."""
        return next(self.messages(f"/{robot}/observation"), None) is not None

    def joint_covariances(self, robot: str) -> Iterator[tuple[float, tuple[Hashable, ...], Array]]:
        """Yield time [s], names of n landmarks and joint covariance (3 + 2 n, 3 + 2 n), where a tick has one.

        Raises:
            RecordingError: One is not as mjsim writes it.
        """
        for message in raw_messages(self.path, topics={f"/{robot}/covariance"}):
            yield value_of(message, _joint_covariance, path=self.path)

    def _pictures(self, robot: str, camera: str) -> Iterator[tuple[RawMessage, float, bytes, str]]:
        """Yield message, stamp [s], file contents and format of each picture of a camera."""
        for message, stamp in self._taken(robot, camera, "image"):
            with reading(message, path=self.path):
                data, form = picture_of(message.data)
            yield message, stamp, data, form

    def _taken(self, robot: str, camera: str, kind: str) -> Iterator[tuple[RawMessage, float]]:
        """Yield message and stamp [s] of the output of a camera on the topic '/R/CAMERA/KIND'."""
        name = f"{robot}/{camera}"
        if (robot, camera) not in self.cameras():
            known = did_you_mean(name, ("/".join(pair) for pair in self.cameras()))
            raise UsageError(Sentence("no camera '{name}' in '{path}'{known}", name, self.path, known))
        # The stamp in the picture is rounded to a nanosecond; the observation has it exactly.
        observed, picture = f"/{robot}/observation", f"/{name}/{kind}"
        stamp = math.nan
        for message in raw_messages(self.path, topics={observed, picture}):
            if message.topic == observed:
                given = content_of(message, path=self.path)["cameras"]
                stamp = next((item["stamp"] for item in given if item["name"] == camera), math.nan)
            else:
                yield message, stamp

    def _sensors(self, robot: str) -> tuple[AnySensor, ...]:
        """Return the sensors of a robot in the world; none for an unknown robot."""
        return next((each.sensors for each in self.world.robots if each.name == robot), ())


def check_fit(seen: Observation, sensors: Collection[AnySensor]) -> None:
    """Check that readings are of sensors that the robot has in the world; raises ValueError otherwise."""
    names = {name_of(sensor) for sensor in sensors}
    beams = {sensor.lidar: sensor.beams for sensor in sensors if isinstance(sensor, Lidar)}
    for codec in CODECS:
        if codec.tables is not None:
            value = getattr(seen, codec.field)
            for name in value if isinstance(value, Mapping) else (reading.name for reading in value):
                if name not in names:
                    raise ValueError(Sentence("a reading of '{name:.40}', which is not a sensor of the robot", name))
    for name, scan in seen.scans.items():
        if {len(scan.ranges), len(scan.ranges if scan.intensities is None else scan.intensities)} != {beams.get(name)}:
            raise ValueError(
                Sentence(
                    "a scan of {count} beams; '{name:.40}' has {value}", len(scan.ranges), name, beams.get(name, 0)
                )
            )


def _joint_covariance(message: Message) -> tuple[float, tuple[Hashable, ...], Array]:
    names, size = names_of(message), message["size"]
    if size != 3 + 2 * len(names) or len(message["lower"]) < size * (size + 1) // 2 * 8:
        raise ValueError(Sentence("a covariance of {size} rows for {count} landmarks", size, len(names)))
    return message["time"], names, covariance_of(message)
