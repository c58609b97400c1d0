"""Reads a recording's file into arrays, after checking its metadata."""

import math
from array import array
from collections.abc import Callable, Hashable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import JsonValue, TypeAdapter

from mjsim.errors import RecordingError, WorldError
from mjsim.geometry import Array
from mjsim.interface import Shown, Sighting
from mjsim.record.drawn import shown_of
from mjsim.record.file import FILES, METADATA_NAME, WORLD_NAME, Head, RawMessage, raw_messages
from mjsim.record.joint_messages import JointRows
from mjsim.record.json_messages import (
    command_row,
    event_of,
    innovations_of,
    landmarks_of,
    moment_of,
    path_rows,
    pose3_row,
    pose_row,
    things_rows,
    world_event_of,
)
from mjsim.record.mechanism_messages import SensorRows
from mjsim.record.numbers import Message
from mjsim.record.parse import FAULTS, content_of, misfit, unfit
from mjsim.record.readings import SIGHTINGS, identities_of
from mjsim.record.recording import SAME_TIME, Recording
from mjsim.record.schemas import ARM_TOPICS
from mjsim.record.tick import RobotEvent
from mjsim.record.track import Landmarks, Track
from mjsim.sentences import Sentence
from mjsim.world import Source, World, WorldEvent, parse_world

MIN_MEMORY, MEMORY_GROWTH = 1 << 26, 48
"""Limit of the memory that a recording may keep: a constant [bytes] plus a multiple of the size of the file; ours take
at most 10 times. Including temporary data, reading takes at most 0.5 GB plus 64 times the size of the file."""
_TAKES = {"identities": 12, "innovations": 12, "things": 8, "sightings": 8, "events": 4, "timing": 4}
"""Memory per byte of a message that is kept as objects [bytes]; as numbers it takes 2."""
_ROW_BYTES = 8 * (3 * 3 + 7 + 2 * 9 + 3)
"""Memory per robot and tick [bytes]."""
_MESSAGE_BYTES = 64
"""Memory per message kept [bytes]."""


def read_recording(path: str | Path) -> Recording:
    """Read a recording; of a truncated file, all complete ticks.

    Raises:
        UsageError: The file cannot be opened.
        RecordingError: It is not a recording, holds no tick, or was not written by mjsim.
    """
    path = Path(path)
    head = Head()
    run: _Run | None = None
    for message in raw_messages(path, head=head):
        if run is None:
            run = _Run(path, world_in(path, head))
        try:
            run.take(message)
        except FAULTS as error:
            raise misfit(message, error, path=path) from error
    if run is None or not run.time:
        raise RecordingError(
            Sentence("'{path}' holds no tick; the run ended, or the file was cut, before the first one", path)
        )
    try:
        return _recording(path, head, run)
    except FAULTS as error:
        raise unfit(f"'{path}'", error) from error


def _recording(path: Path, head: Head, run: "_Run") -> Recording:
    """Return the data as arrays."""
    seed, metadata = checked_metadata(head.metadata[METADATA_NAME])
    run.check()
    return Recording(
        path=path,
        world=run.world,
        seed=seed,
        metadata=metadata,
        time=np.array(run.time),
        qpos=run.qpos.array(),
        qvel=run.qvel.array(),
        events=tuple(run.events),
        things=run.things(),
        joints={name: rows.track() for name, rows in run.arms.items()},
        readings={name: rows.track() for name, rows in run.sensors.items()},
        robots={name: robot.track(np.array(run.time)) for name, robot in run.robots.items()},
        clock=np.array(run.clock),
        module_seconds=run.module_seconds(),
        whole=head.whole,
    )


def world_in(path: Path, head: Head) -> World:
    """Return the world stored in a recording."""
    if WORLD_NAME not in head.files or "seed" not in head.metadata.get(METADATA_NAME, {}):
        raise RecordingError(Sentence("'{path}' is an MCAP file, but not a recording made by mjsim", path))
    attached = {name.removeprefix(FILES): data for name, data in head.files.items() if name.startswith(FILES)}
    try:
        text = head.files[WORLD_NAME].decode()
        return parse_world(text, source=Source(file=WORLD_NAME, text=text, attached=attached))
    except (WorldError, ValueError) as error:
        reason = str(error).partition("\n")[0]
        raise RecordingError(Sentence("the world in '{path}' cannot be read: {reason}", path, reason)) from error


class _Rows:
    """Rows of numbers of the same width, collected as plain doubles."""

    def __init__(self, *shape: int) -> None:
        self._shape = shape
        self._count = 0
        self._values = array("d")

    def add(self, values: Sequence[float | None] | None) -> None:
        """Add a row; a number None is +infinity, and None instead of the row is a row of NaN."""
        if values is None:
            values = [math.nan] * math.prod(self._shape)
        elif not self._shape:
            self._shape = (len(values),)
        elif None in values:
            values = [math.inf if value is None else value for value in values]
        if len(values) != math.prod(self._shape):
            raise ValueError(
                Sentence("a row has {count} numbers, others have {wanted}", len(values), math.prod(self._shape))
            )
        self._values.extend(values)  # type: ignore[arg-type]
        self._count += 1

    def array(self) -> Array:
        """Return all rows, shape (N, *shape), or (N, width) where no shape was given."""
        return np.frombuffer(self._values, dtype=float).reshape(self._count, *self._shape).copy()


class _Run:
    """A recording being read; a tick is complete once its last message, on `/state`, is read."""

    def __init__(self, path: Path, world: World) -> None:
        self._path, self.world = path, world
        self._left = MIN_MEMORY + MEMORY_GROWTH * path.stat().st_size
        self.robots = {robot.name: _Robot() for robot in world.robots}
        self.arms = {
            f"{robot.name}/{item.name}": JointRows(tuple(f"joint{k + 1}" for k in range(item.arm.n)))
            for robot in world.robots
            for item in robot.arms
        }
        balancing = (robot for robot in world.robots if robot.drive.controller is not None)
        self.arms |= {f"{robot.name}/drive": JointRows(robot.drive.driven_wheels) for robot in balancing}
        self.arms |= {each.name: JointRows(each.assembly.names) for each in world.mechanisms}
        self.sensors = {each.name: SensorRows() for each in world.mechanisms}
        self.time: list[float] = []
        self.clock: list[float] = []
        self.qpos, self.qvel = _Rows(), _Rows()
        self.events: list[WorldEvent] = []
        self._places: list[dict[str, tuple[float, float, float]]] = []
        self._now: dict[str, tuple[float, float, float]] = {}
        self._timing: dict[str, Any] = {"clock": 0.0, "parts": []}
        self._seconds: dict[str, list[tuple[int, float]]] = {}

    def take(self, raw: RawMessage) -> None:
        """Take the next message of the file."""
        if raw.topic == "/state":
            self._end_tick(self._content(raw))
        elif raw.topic == "/timing":
            self._timing = self._content(raw)
        elif raw.topic == "/events":
            self.events.append(world_event_of(self._content(raw)))
        elif raw.topic == "/things":
            self._now = things_rows(self._content(raw))
        else:
            robot, _, kind = raw.topic[1:].partition("/")
            if kind in _READ and robot in self.robots:
                self.robots[robot].take(kind, self._content(raw))
            elif self.arms:
                arm, _, kind = raw.topic[1:].rpartition("/")
                if arm in self.arms and kind in ARM_TOPICS:
                    self.arms[arm].take(kind, self._content(raw))
                elif arm in self.sensors and kind == "sensors":
                    self.sensors[arm].take(self._content(raw))

    def _content(self, raw: RawMessage) -> Message:
        self._take_bytes(_MESSAGE_BYTES + len(raw.data) * _TAKES.get(raw.topic.rpartition("/")[2], 2))
        return content_of(raw, path=self._path)

    def _end_tick(self, state: Message) -> None:
        for item in self._timing["parts"]:
            self._seconds.setdefault(item["part"], []).append((len(self.time), item["seconds"]))
        # They belong to one tick; the clock continues.
        self._timing = {**self._timing, "parts": []}
        self.clock.append(self._timing["clock"])
        self.time.append(state["time"])
        self.qpos.add(state["qpos"])
        self.qvel.add(state["qvel"])
        self._places.append(self._now)
        self._now = {}
        numbers = sum(rows.width for rows in self.arms.values()) + sum(rows.width for rows in self.sensors.values())
        self._take_bytes(_ROW_BYTES * len(self.robots) + 8 * numbers)
        for robot in self.robots.values():
            robot.end_tick()
        for rows in self.arms.values():
            rows.end_tick()
        for sensors in self.sensors.values():
            sensors.end_tick()

    def _take_bytes(self, size: int) -> None:
        """Count memory that is kept.

        Raises:
            ValueError: It exceeds the limit for a file of this size.
        """
        self._left -= size
        if self._left < 0:
            raise ValueError(Sentence("with {count} ticks it would take far more memory than its size", len(self.time)))

    def check(self) -> None:
        """Check the complete data.

        Raises:
            ValueError: The ticks are not as far apart as in this world, or arrays would take too much memory.
        """
        period = 1.0 / self.world.run.rate_hz
        if self.time[0] < 0.0 or (np.abs(np.diff(self.time) - period) > 0.01 * period).any():
            raise ValueError(Sentence("its ticks are not {period:g} s apart", period))
        names = len(self._thing_names()) * 24 + len(self._seconds) * 8
        self._take_bytes(len(self.time) * (names + sum(robot.map_bytes() for robot in self.robots.values())))

    def _thing_names(self) -> dict[str, None]:
        return dict.fromkeys(name for places in self._places for name in places)

    def things(self) -> dict[str, Array]:
        """Return (x, y, heading) of each thing at each tick, NaN while it does not exist, shape (N, 3)."""
        nowhere = (math.nan,) * 3
        return {name: np.array([places.get(name, nowhere) for places in self._places]) for name in self._thing_names()}

    def module_seconds(self) -> dict[str, Array]:
        """Return the computing time of each part, NaN where it did not run, shape (N,) [s]."""
        costs = {}
        for part, rows in self._seconds.items():
            costs[part] = np.full(len(self.time), np.nan)
            ticks, seconds = zip(*rows, strict=True)
            costs[part][list(ticks)] = seconds
        return costs


_READ: dict[str, Callable[[Message], Any]] = {
    "truth": lambda message: (pose_row(message), pose3_row(message)),
    "odometry": lambda message: (pose_row(message), message["covariance"], moment_of(message)),
    "estimate": lambda message: (pose_row(message), message["covariance"]),
    "command": command_row,
    "landmarks": landmarks_of,
    "sightings": lambda message: SIGHTINGS.decode(message["sightings"]),
    "identities": identities_of,
    "innovations": innovations_of,
    "events": event_of,
    "path": path_rows,
    "show": shown_of,
}
"""Topics of a robot that make up its track, and their decoders."""


class _Robot:
    """Collects the data of one robot."""

    def __init__(self) -> None:
        self._tick: dict[str, Any] = {}
        self._count = 0
        self._poses = {kind: _Rows(3) for kind in ("truth", "odometry", "estimate")}
        self._truth_pose = _Rows(7)
        self._covariances = {kind: _Rows(3, 3) for kind in ("odometry", "estimate")}
        self._command = _Rows(3)
        self._moments = array("d")
        self._maps: list[tuple[int, tuple[Hashable, ...], Array, Array]] = []
        self._sightings: list[tuple[Sighting, ...]] = []
        self._identities: list[tuple[str | None, ...]] = []
        self._innovations: list[tuple[tuple[Hashable, Array, Array], ...]] = []
        self._shown: list[tuple[Shown, ...]] = []
        self._events: list[RobotEvent] = []
        self._path: Array = np.zeros((0, 4))

    def take(self, kind: str, message: Message) -> None:
        """Take a message of the current tick."""
        value = _READ[kind](message)
        if kind == "events":
            self._events.append(value)
        elif kind == "path":
            self._path = value
        else:
            self._tick[kind] = value

    def end_tick(self) -> None:
        """Add a row to everything; NaN for missing messages."""
        tick, self._tick = self._tick, {}
        nothing = (None, None, math.nan)
        for kind, rows in self._poses.items():
            rows.add(tick.get(kind, nothing)[0])
        self._truth_pose.add(tick.get("truth", nothing)[1])
        for kind, rows in self._covariances.items():
            rows.add(tick.get(kind, nothing)[1])
        self._command.add(tick.get("command"))
        self._moments.append(tick.get("odometry", nothing)[2])
        if "landmarks" in tick:
            self._maps.append((self._count, *tick["landmarks"]))
        self._sightings.append(tick.get("sightings", ()))
        self._identities.append(tick.get("identities", ()))
        self._innovations.append(tick.get("innovations", ()))
        # Items stay shown until others replace them.
        self._shown.append(tick["show"] if "show" in tick else self._shown[-1] if self._shown else ())
        self._count += 1

    def track(self, time: Array) -> Track:
        """Return everything as arrays."""
        moments = np.array(self._moments)
        return Track(
            time=time,
            moment=np.where(np.abs(moments - time) > SAME_TIME, moments, time),
            truth=self._poses["truth"].array(),
            truth_pose=self._truth_pose.array(),
            odometry=self._poses["odometry"].array(),
            odometry_covariance=self._covariances["odometry"].array(),
            estimate=self._poses["estimate"].array(),
            covariance=self._covariances["estimate"].array(),
            command=self._command.array(),
            landmarks=self._landmarks(),
            sightings=tuple(self._sightings),
            identities=tuple(self._identities),
            innovations=tuple(self._innovations),
            shown=tuple(self._shown),
            events=tuple(self._events),
            path=self._path,
        )

    def map_bytes(self) -> int:
        """Return the size of the map of one tick as an array [bytes]."""
        return 48 * len(self._columns())

    def _columns(self) -> dict[Hashable, int]:
        """Return the column of each landmark, in order of first appearance."""
        columns: dict[Hashable, int] = {}
        for _, names, _, _ in self._maps:
            for name in names:
                columns.setdefault(name, len(columns))
        return columns

    def _landmarks(self) -> Landmarks:
        """Repeat each map until the next one."""
        columns = self._columns()
        mean = np.full((self._count, len(columns), 2), np.nan)
        covariance = np.full((self._count, len(columns), 2, 2), np.nan)
        ends = [*(first for first, *_ in self._maps[1:]), self._count]
        for (first, names, means, covariances), end in zip(self._maps, ends, strict=False):
            places = [columns[name] for name in names]
            mean[first:end, places] = means
            covariance[first:end, places] = covariances
        return Landmarks(names=tuple(columns), mean=mean, covariance=covariance)


MAX_SEED = 2**63 - 1
_MODULES: TypeAdapter[dict[str, dict[str, str]]] = TypeAdapter(dict[str, dict[str, str]])
_USES: TypeAdapter[dict[str, dict[str, JsonValue]]] = TypeAdapter(dict[str, dict[str, JsonValue]])


def checked_metadata(metadata: Mapping[str, str]) -> tuple[int, dict[str, str]]:
    """Return the seed, and all other metadata.

    Raises:
        ValueError: The seed is invalid, or an entry that other parts rely on is.
    """
    others = dict(metadata)
    seed = int(others.pop("seed"))
    if not 0 <= seed <= MAX_SEED:
        raise ValueError(Sentence("its seed is {seed:.3g}; it must be between 0 and {max_seed}", seed, MAX_SEED))
    if not math.isfinite(float(others.get("seconds", "0"))):
        raise ValueError("its duration is not finite")
    # Its exceptions are ValueErrors as well.
    _MODULES.validate_json(others.get("modules", "{}"))
    _USES.validate_json(others.get("replayed modules", "{}"))
    if any(key.startswith("replayed ") for key in others) and "replayed robot" not in others:
        raise ValueError("it does not name the robot that was replayed")
    return seed, others
