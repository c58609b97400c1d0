"""The recording as a file being written: its head, its channels and its chunks."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Self

from foxglove import Channel, Context, open_mcap
from foxglove.channels import (
    CameraCalibrationChannel,
    CompressedImageChannel,
    FrameTransformsChannel,
    LaserScanChannel,
    SceneUpdateChannel,
)
from foxglove.mcap import MCAPWriteOptions

from mjsim.errors import RecordingError, WorldError
from mjsim.geometry import Array, Pose
from mjsim.interface import CameraFrame, Estimate, RobotInfo, Scan, SensorInfo
from mjsim.record.file import FILES, METADATA_NAME, WORLD_NAME
from mjsim.record.map import looks_update, map_update
from mjsim.record.messages import Message, covariance_message, encode, nanoseconds
from mjsim.record.scene import calibration_message, frames_message, laser_message, mount, picture_message
from mjsim.record.schemas import ROBOT_TOPICS, SENSOR_TOPICS, WORLD_TOPICS
from mjsim.world import World, parse_world
from mjsim.world.bodies import ModelBody
from mjsim.world.layout import escaped
from mjsim.world.looks import Looks
from mjsim.world.source import Source
from mjsim.world.things import ModelObstacle

VERSIONED = ("mjsim", "mujoco", "numpy", "opencv-python-headless", "foxglove-sdk")
"""Packages whose versions are noted."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Job:
    """What one tick, or one event outside of ticks, adds to the file."""

    time: float
    """Simulated [s]."""
    messages: Sequence[tuple[str, Message]]
    """Topic and JSON message, in the order of the file."""
    joints: Sequence[tuple[str, Estimate, Array]] = ()
    """Topic, estimate, joint covariance."""
    pictures: Sequence[tuple[str, CameraFrame]] = ()
    """'ROBOT/CAMERA' and what it gave."""
    scans: Sequence[tuple[str, str, Scan]] = ()
    """Robot, lidar and what it gave."""
    frames: Mapping[str, Pose] = field(default_factory=dict)
    """Frame -> pose in the world."""
    looks: Looks | None = None
    """How the world looks now, when that has changed."""
    closing: Sequence[tuple[str, Message]] = ()
    """As `messages`, but after everything else: a tick that has them is whole."""


class Writer:
    """An MCAP file being written; one thread at a time may use it.

    Raises:
        RecordingError: The file cannot be written; every method raises it.
    """

    def __init__(
        self, path: Path, *, world: World, seed: int, robots: Mapping[str, RobotInfo], metadata: Mapping[str, str]
    ) -> None:
        self._path = path
        included = world.source.included
        files = {name: included.get(name) or world.read_asset(name) for name in named_files(world)}
        text = text_of(world, files)
        self._file: _File | None = None
        # Its channels close when it goes.
        self._context = context = Context()
        with self._reporting(), ExitStack() as undo:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._file = undo.enter_context(_File(path))
            # Chunks end where `flush` ends them, so that each holds whole ticks.
            options = MCAPWriteOptions(chunk_size=None, compression_threads=0)
            self._mcap = open_mcap(self._file, context=context, writer_options=options)
            versions = {f"{name} version": version(name) for name in VERSIONED}
            self._mcap.write_metadata(METADATA_NAME, versions | dict(metadata) | {"seed": str(seed)})
            self._attach(WORLD_NAME, "application/yaml", text.encode())
            for name, data in files.items():
                self._attach(FILES + name, "application/octet-stream", data)
            undo.pop_all()
        schemas = {f"/{robot}/{kind}": schema for robot in robots for kind, schema in ROBOT_TOPICS.items()}
        for robot, info in robots.items():
            topics = [SENSOR_TOPICS[each.kind] for each in info.sensors.values() if each.kind in SENSOR_TOPICS]
            schemas |= {f"/{robot}/{topic}": schema for topic, schema in topics}
        self._json = {
            topic: Channel(topic, schema=schema, context=context) for topic, schema in (schemas | WORLD_TOPICS).items()
        }
        cameras, lidars = sensors_of(robots, "camera"), sensors_of(robots, "lidar")
        self._mounts = [
            mount(f"{name.rpartition('/')[0]}/base", name, sensor.robot_from_sensor)
            for name, sensor in (cameras | lidars).items()
        ]
        scanning = sorted({name.rpartition("/")[0] for name in lidars})
        self._scans = {robot: LaserScanChannel(f"/{robot}/scan", context=context) for robot in scanning}
        self._pictures = {name: CompressedImageChannel(f"/{name}/image", context=context) for name in cameras}
        self._frames = FrameTransformsChannel("/tf", context=context)
        self._world, self._files = world, files
        self._map = SceneUpdateChannel("/map", context=context)
        self._map.log(map_update(world, files), log_time=0)
        for name, sensor in cameras.items():
            if sensor.intrinsics is not None:
                channel = CameraCalibrationChannel(f"/{name}/calibration", context=context)
                channel.log(calibration_message(sensor.intrinsics, name), log_time=0)

    def _attach(self, name: str, media_type: str, data: bytes) -> None:
        self._mcap.attach(log_time=0, create_time=0, name=name, media_type=media_type, data=data)

    def put(self, job: Job) -> None:
        """Add a job to the chunk at hand."""
        log_time = nanoseconds(job.time)
        for topic, message in job.messages:
            self._log(topic, message, log_time)
        for topic, estimate, joint in job.joints:
            self._log(topic, covariance_message(job.time, estimate, joint), log_time)
        for name, frame in job.pictures:
            self._pictures[name].log(picture_message(frame, name), log_time=log_time)
        for robot, name, scan in job.scans:
            self._scans[robot].log(laser_message(scan, f"{robot}/{name}"), log_time=log_time)
        if job.looks is not None:
            self._map.log(looks_update(self._world, self._files, job.looks, time=job.time), log_time=log_time)
        if job.frames:
            self._frames.log(frames_message(job.time, job.frames, self._mounts), log_time=log_time)
        for topic, message in job.closing:
            self._log(topic, message, log_time)

    def _log(self, topic: str, message: Message, log_time: int) -> None:
        try:
            data = encode(message)
        except ValueError as error:
            raise RecordingError(f"{topic} at {message['time']:.3f} s holds NaN or -infinity: {message}") from error
        self._json[topic].log(data, log_time=log_time)

    def flush(self) -> None:
        """End the chunk at hand and give it to the operating system."""
        with self._reporting():
            self._mcap.flush()

    def close(self) -> None:
        """End the file."""
        try:
            with self._reporting():
                self._mcap.close()
        finally:
            if self._file is not None:
                self._file.close()

    @contextmanager
    def _reporting(self) -> Iterator[None]:
        try:
            yield
        except (OSError, RuntimeError) as error:
            failure = self._file.failure if self._file is not None else None
            cause = failure or error
            reason = cause.strerror if isinstance(cause, OSError) and cause.strerror else str(cause)
            raise RecordingError(f"cannot write '{self._path}': {reason}") from error


class _File:
    """The file below the MCAP writer; it keeps the reason of a failure, which the writer above does not tell."""

    def __init__(self, path: Path) -> None:
        self._raw = path.open("wb", buffering=0)
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
        """Nothing is held back here."""

    def close(self) -> None:
        self._raw.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()


def sensors_of(robots: Mapping[str, RobotInfo], kind: str) -> dict[str, SensorInfo]:
    """Return 'ROBOT/SENSOR' -> its data sheet, of all sensors of a kind."""
    return {
        f"{robot}/{name}": sensor
        for robot, info in robots.items()
        for name, sensor in info.sensors.items()
        if sensor.kind == kind
    }


def named_files(world: World) -> list[str]:
    """Return the files that a world names, with what its models name in turn, and those that its text includes."""
    patches = [patch.texture for patch in world.floor.patches]
    covers = [world.floor.texture, world.ceiling.texture if world.ceiling is not None else None, *patches]
    named = [*covers, *(wall.texture for wall in world.walls), *(beacon.image for beacon in world.beacons)]
    shapes = {item.model: item.shape for item in world.obstacles if isinstance(item, ModelObstacle)}
    of_models = [path for shape in shapes.values() for path in shape.files.paths]
    bodies = [robot.body.model for robot in world.robots if isinstance(robot.body, ModelBody)]
    names = [*(name for name in named if name is not None), *of_models, *bodies, *world.source.included]
    return list(dict.fromkeys(names))


def text_of(world: World, files: Mapping[str, bytes]) -> str:
    """Return a text that gives the world again: as it was written when that does, comments and all."""
    text = world.source.text
    if text is not None:
        try:
            if parse_world(text, source=Source(text=text, attached=files)) == world:
                return text
        except WorldError:
            pass
    return escaped(world.model_dump_json(exclude_unset=True, indent=1))
