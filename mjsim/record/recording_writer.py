"""Writes the file of a recording: head, channels and chunks."""

import functools
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from importlib.metadata import version
from typing import Any

from foxglove import Channel, Context, open_mcap
from foxglove.channels import FrameTransformsChannel, GridChannel, SceneUpdateChannel
from foxglove.mcap import MCAPWriteOptions

from mjsim.closing import Closes
from mjsim.errors import Problem, RecordingError, WorldError
from mjsim.geometry import Array, Pose, Pose3
from mjsim.interface import Estimate, RobotInfo
from mjsim.output import Destination
from mjsim.record.drawn import frames_message, grid_message, looks_update, map_update, mount
from mjsim.record.file import FILES, METADATA_NAME, WORLD_NAME, encodable
from mjsim.record.json_messages import covariance_message, encode
from mjsim.record.json_schema import Schema
from mjsim.record.numbers import Message, nanoseconds
from mjsim.record.readings import CODECS, DrawnTopic
from mjsim.record.recording_name import WholeFile
from mjsim.record.schemas import (
    ARM_TOPICS,
    JOINTED_TOPICS,
    MECHANISM_TOPICS,
    ROBOT_TOPICS,
    SENSOR_TOPICS,
    STREAMS,
    WORLD_TOPICS,
)
from mjsim.sentences import Sentence
from mjsim.world import (
    Looks,
    MechanismModel,
    ModelBody,
    ModelObstacle,
    Source,
    SphereObstacle,
    World,
    escaped,
    is_preset_file,
    needs_expansion,
    parse_world,
    table_files,
)

VERSIONED_PACKAGES = ("mjsim", "mujoco", "numpy", "opencv-python-headless", "foxglove-sdk")
"""Packages whose versions are recorded."""


Drawn = tuple[DrawnTopic, str, str, Any]
"""Topic, robot, sensor, and reading."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Batch:
    """The data that one tick, or one event outside of ticks, adds to the file."""

    time: float
    """Simulated [s]."""
    messages: Sequence[tuple[str, Message]] = ()
    """Topic and JSON message, in the order of the file."""
    joints: Sequence[tuple[str, Estimate, Array]] = ()
    """Topic, estimate, joint covariance."""
    drawn: Sequence[Drawn] = ()
    """Readings that Foxglove draws."""
    frames: Mapping[str, Pose | Pose3] = field(default_factory=dict)
    """Frame -> pose in the world."""
    moments: Mapping[str, float] = field(default_factory=dict)
    """Robot -> when it was at its poses, if not at `time` [s]."""
    looks: Looks | None = None
    """Appearance of the world, if it has changed."""
    closing: Sequence[tuple[str, Message]] = ()
    """As `messages`, but written last: a tick that has them is complete."""
    metadata: Mapping[str, str] = field(default_factory=dict)
    """Added to that at the beginning of the file."""


class Writer:
    """An MCAP file being written; one thread at a time may use it.

    Raises:
        RecordingError: The file cannot be written; every method raises it.
    """

    def __init__(
        self,
        place: Destination,
        *,
        world: World,
        seed: int,
        robots: Mapping[str, RobotInfo],
        metadata: Mapping[str, str],
    ) -> None:
        """Write the head; the file is published with the first complete tick, or not at all.

        Args:
            place: The reserved file; closed with this writer, also if this fails.
            world: The world of the run.
            seed: Seed of the run.
            robots: Data sheet of each robot.
            metadata: Versions, command line and the like.
        """
        self._place, self._world, self._whole_ticks = place, world, False
        with ExitStack() as undo:
            undo.enter_context(place)
            self._file = undo.enter_context(_File(place))
            with self._reporting():
                self._begin(seed, metadata)
            self._open_channels(robots)
            undo.pop_all()

    def _begin(self, seed: int, metadata: Mapping[str, str]) -> None:
        """Open the MCAP file; write its metadata and the world with its files."""
        included = self._world.source.included
        self._files = {name: included.get(name) or self._world.read_asset(name) for name in named_files(self._world)}
        # Its channels are closed when it is deleted.
        self._context = Context()
        # `flush` ends chunks, so that each contains whole ticks. Level 1 of zstd compresses digits better than its
        # default, 3, and faster.
        options = MCAPWriteOptions(chunk_size=None, compression_threads=0, compression_level=1)
        self._mcap = open_mcap(self._file, context=self._context, writer_options=options)
        self._mcap.write_metadata(METADATA_NAME, _versions() | encodable(metadata) | {"seed": str(seed)})
        self._attach(WORLD_NAME, "application/yaml", text_of(self._world, self._files).encode())
        for name, data in self._files.items():
            self._attach(FILES + name, "application/octet-stream", data)

    def _open_channels(self, robots: Mapping[str, RobotInfo]) -> None:
        """Open a channel for each topic, and write the messages that are written once."""
        context = self._context
        schemas = {f"/{robot}/{topic}": schema for robot, info in robots.items() for topic, schema in _topics_of(info)}
        for mechanism in self._world.mechanisms:
            schemas |= {f"/{mechanism.name}/{kind}": schema for kind, schema in MECHANISM_TOPICS.items()}
        # The base class of a channel accepts bytes unchanged.
        self._json = {
            topic: Channel(topic, schema=schema, context=context).base
            for topic, schema in (schemas | WORLD_TOPICS).items()
        }
        self._mounts = [
            mount(f"{robot}/base", f"{robot}/{name}", robots[robot].sensors[name].robot_from_sensor)
            for robot, name in dict.fromkeys([*_streaming(robots), *((r, n) for _, r, n in drawn_sensors(robots))])
        ]
        self._drawings: dict[str, Any] = {}
        self._frames = FrameTransformsChannel("/tf", context=context)
        self._map = SceneUpdateChannel("/map", context=context)
        self._map.log(map_update(self._world, self._files), log_time=0)
        for drawing, robot, name in drawn_sensors(robots):
            topic = drawing.topic(robot, name)
            if topic not in self._drawings:
                self._drawings[topic] = drawing.channel(topic, context=context)
            drawing.begin(context, f"{robot}/{name}", robots[robot].sensors[name])

    def _attach(self, name: str, media_type: str, data: bytes) -> None:
        self._mcap.attach(log_time=0, create_time=0, name=name, media_type=media_type, data=data)

    def draw_floor(self) -> None:
        """Write the map as a grid, unless nothing is solid."""
        message = grid_message(self._world)
        if message is not None:
            GridChannel("/grid", context=self._context).log(message, log_time=0)

    def put(self, batch: Batch) -> None:
        """Add a batch to the current chunk."""
        log_time = nanoseconds(batch.time)
        for topic, message in batch.messages:
            self._log(topic, message, log_time)
        for topic, estimate, joint in batch.joints:
            self._log(topic, covariance_message(batch.time, estimate, joint), log_time)
        for drawing, robot, name, reading in batch.drawn:
            message = drawing.message(reading, f"{robot}/{name}")
            if message is not None:
                self._drawings[drawing.topic(robot, name)].log(message, log_time=log_time)
        if batch.looks is not None:
            self._map.log(looks_update(self._world, self._files, batch.looks, time=batch.time), log_time=log_time)
        if batch.frames:
            frames = frames_message(batch.time, batch.frames, self._mounts, moments=batch.moments)
            self._frames.log(frames, log_time=log_time)
        if batch.metadata:
            self._mcap.write_metadata(METADATA_NAME, encodable(batch.metadata))
        for topic, message in batch.closing:
            self._log(topic, message, log_time)
            self._whole_ticks = True

    def _log(self, topic: str, message: Message, log_time: int) -> None:
        try:
            data = encode(message)
        except ValueError as error:
            raise RecordingError(
                Sentence(
                    "{topic} at {message:.3f} s holds NaN or -infinity: {other_message}",
                    topic,
                    message["time"],
                    message,
                )
            ) from error
        self._json[topic].log(data, log_time)

    def flush(self) -> None:
        """End the current chunk and give it to the operating system."""
        with self._reporting():
            self._mcap.flush()
            self._publish()

    def close(self) -> None:
        """End the file; without a complete tick it is discarded, and an existing file at its path stays."""
        with self._place, self._reporting(), self._file:
            self._mcap.close()
            self._publish()

    def spoil(self) -> None:
        """Mark the file as incomplete, so that a `WholeFile` is discarded."""
        if isinstance(self._place, WholeFile):
            self._place.is_spoilt = True

    def _publish(self) -> None:
        if self._whole_ticks:
            self._place.publish()

    @contextmanager
    def _reporting(self) -> Iterator[None]:
        try:
            yield
        except (OSError, RuntimeError) as error:
            cause = self._file.failure or error
            reason = cause.strerror if isinstance(cause, OSError) and cause.strerror else str(cause)
            raise RecordingError(Sentence("cannot write '{path}': {reason}", self._place.path, reason)) from error


class _File(Closes):
    """The file below the MCAP writer; it keeps the cause of a failure, which the MCAP writer does not report."""

    def __init__(self, place: Destination) -> None:
        # A separate descriptor: what the writer above may still write when it is deleted must not reach another file.
        self._raw = place.opened()
        self.failure: OSError | None = None

    def write(self, data: bytes | bytearray) -> int:
        rest = memoryview(data)
        try:
            while rest:
                rest = rest[self._raw.write(rest) :]
        except OSError as error:
            self.failure = error
            raise
        return len(data)

    def seek(self, offset: int, whence: int = 0) -> int:
        return self._raw.seek(offset, whence)

    def flush(self) -> None:
        """Do nothing: this file has no buffer."""

    def close(self) -> None:
        """Close it; the name stays reserved."""
        self._raw.close()


def _topics_of(robot: RobotInfo) -> Iterator[tuple[str, Schema]]:
    """Yield the JSON topics of a robot, without its name, and their schemas."""
    yield from ROBOT_TOPICS.items()
    for name, sensor in robot.sensors.items():
        if sensor.kind in SENSOR_TOPICS:
            yield SENSOR_TOPICS[sensor.kind]
        if sensor.kind in STREAMS:
            word, schema = STREAMS[sensor.kind]
            yield f"{name}/{word}", schema
    if robot.balancing is not None:
        yield "drive/joints", ARM_TOPICS["joints"]
    yield from ((f"{arm}/{kind}", schema) for arm in robot.arms for kind, schema in ARM_TOPICS.items())
    if robot.arms or robot.balancing is not None:
        yield from JOINTED_TOPICS.items()


def _streaming(robots: Mapping[str, RobotInfo]) -> Iterator[tuple[str, str]]:
    """Yield robot and name of each sensor with a stream of readings."""
    for robot, info in robots.items():
        yield from ((robot, name) for name, sensor in info.sensors.items() if sensor.kind in STREAMS)


def drawn_sensors(robots: Mapping[str, RobotInfo]) -> Iterator[tuple[DrawnTopic, str, str]]:
    """Yield topic, robot and name of each sensor whose readings Foxglove draws."""
    for codec in CODECS:
        for drawing in codec.drawings:
            for robot, info in robots.items():
                found = (name for name, sensor in info.sensors.items() if sensor.kind == codec.sensor)
                yield from ((drawing, robot, name) for name in found)


def named_files(world: World) -> list[str]:
    """Return the files that a world names, including those named by its models and those that its text includes."""
    parts = (body for mechanism in world.mechanisms for body in mechanism.bodies)
    from_files = (item for item in (*world.obstacles, *parts) if isinstance(item, ModelObstacle | MechanismModel))
    shapes = {item.model: item.shape for item in from_files}
    of_models = [path for shape in shapes.values() for path in shape.files.paths]
    bodies = [path for robot in world.robots if isinstance(robot.body, ModelBody) for path in robot.body.files.paths]
    arms = [path for robot in world.robots for arm in robot.arms if arm.model for path in arm.file_arm.files.paths]
    presets = [robot.preset for robot in world.robots if robot.preset is not None and is_preset_file(robot.preset)]
    tables = (*table_files(world.run.events), *table_files(world.mechanisms))
    named = [*named_pictures(world), *of_models, *bodies, *arms, *presets, *tables, *world.source.included]
    return list(dict.fromkeys(named))


def named_pictures(world: World) -> list[str]:
    """Return the pictures that a world names."""
    patches = [patch.texture for patch in world.floor.patches]
    covers = [world.floor.texture, world.ceiling.texture if world.ceiling is not None else None, *patches]
    things = [thing.texture for thing in world.obstacles if not isinstance(thing, SphereObstacle | ModelObstacle)]
    named = [*covers, *things, *(wall.texture for wall in world.walls), *(beacon.image for beacon in world.beacons)]
    return list(dict.fromkeys(name for name in named if name is not None))


@functools.cache  # A fact of the process; each is looked up in the metadata of its package, which takes milliseconds.
def _versions() -> dict[str, str]:
    return {f"{name} version": version(name) for name in VERSIONED_PACKAGES}


def text_of(world: World, files: Mapping[str, bytes]) -> str:
    """Return a text that parses to the world: the original text with its comments, if it does."""
    text, written = world.source.text, world.source.written
    if text is not None:
        # Text without variables and includes was already read; only its values are checked again.
        read: tuple[Any, list[Problem]] | None = None
        if written is not None and not needs_expansion(text):
            read = written, []
        try:
            if parse_world(text, source=Source(text=text, attached=files), read=read) == world:
                return text
        except WorldError:
            pass
    return escaped(world.model_dump_json(exclude_unset=True, indent=1))
