"""A recording's file to arrays."""

import json
import math
from array import array
from collections.abc import Hashable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mjsim.errors import RecordingError, WorldError
from mjsim.geometry import Array
from mjsim.interface import Sighting
from mjsim.record.file import FILES, METADATA_NAME, WORLD_NAME, Head, RawMessage, raw_messages
from mjsim.record.messages import (
    command_row,
    event_of,
    innovations_of,
    landmarks_of,
    pose_row,
    sightings_of,
    things_rows,
    world_event_of,
)
from mjsim.record.readings import identities_of
from mjsim.record.recording import Landmarks, Recording, Track
from mjsim.record.tick import Event
from mjsim.world import World, parse_world
from mjsim.world.events import Event as WorldEvent
from mjsim.world.source import Source


def read_recording(path: str | Path) -> Recording:
    """Return a recording; of a file that was cut, all whole ticks before the cut.

    Raises:
        UsageError: The file cannot be opened.
        RecordingError: It is not a recording, or holds no tick.
    """
    path = Path(path)
    head = Head()
    run: _Run | None = None
    for message in raw_messages(path, head=head):
        if run is None:
            run = _Run(_world(path, head))
        run.take(message)
    if run is None or not run.time:
        raise RecordingError(f"'{path}' holds no tick; the run ended, or the file was cut, before the first one")
    metadata = dict(head.metadata[METADATA_NAME])
    return Recording(
        path=path,
        world=run.world,
        seed=int(metadata.pop("seed")),
        metadata=metadata,
        time=np.array(run.time),
        qpos=run.qpos.array(),
        qvel=run.qvel.array(),
        events=tuple(run.events),
        things=run.things(),
        robots={name: robot.track(np.array(run.time)) for name, robot in run.robots.items()},
        clock=np.array(run.clock),
        module_seconds=run.module_seconds(),
        whole=head.whole,
    )


def _world(path: Path, head: Head) -> World:
    """Return the world that a recording begins with."""
    if WORLD_NAME not in head.files or "seed" not in head.metadata.get(METADATA_NAME, {}):
        raise RecordingError(f"'{path}' is an MCAP file, but not a recording made by mjsim")
    attached = {name.removeprefix(FILES): data for name, data in head.files.items() if name.startswith(FILES)}
    try:
        text = head.files[WORLD_NAME].decode()
        return parse_world(text, source=Source(file=WORLD_NAME, text=text, attached=attached))
    except (WorldError, UnicodeDecodeError) as error:
        reason = str(error).partition("\n")[0]
        raise RecordingError(f"the world in '{path}' cannot be read: {reason}") from error


class _Rows:
    """Rows of numbers, all of one width; kept as plain doubles while they come."""

    def __init__(self, *shape: int) -> None:
        self._shape = shape
        self._count = 0
        self._values = array("d")

    def add(self, values: Sequence[float | None] | None) -> None:
        """Add a row; None for a number is +infinity, None for all is a row of NaN."""
        if values is None:
            values = [math.nan] * math.prod(self._shape)
        elif None in values:
            values = [math.inf if value is None else value for value in values]
        self._values.extend(values)  # type: ignore[arg-type]
        self._count += 1

    def array(self) -> Array:
        """Return all rows, shape (N, *shape), or (N, width) where no shape was given."""
        return np.frombuffer(self._values, dtype=float).reshape(self._count, *(self._shape or (-1,))).copy()


class _Run:
    """A recording as it is read; a tick counts once its last message, on `/state`, is there."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.robots = {robot.name: _Robot() for robot in world.robots}
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
        _, first, *rest = raw.topic.split("/")
        if raw.topic == "/timing":
            self._timing = json.loads(raw.data)
        elif raw.topic == "/events":
            self.events.append(world_event_of(json.loads(raw.data)))
        elif raw.topic == "/things":
            self._now = things_rows(json.loads(raw.data))
        elif raw.topic == "/state":
            self._end_tick(json.loads(raw.data))
        elif len(rest) == 1 and rest[0] in _READ and first in self.robots:
            self.robots[first].take(rest[0], json.loads(raw.data))

    def _end_tick(self, state: dict[str, Any]) -> None:
        for item in self._timing["parts"]:
            self._seconds.setdefault(item["part"], []).append((len(self.time), item["seconds"]))
        self.clock.append(self._timing["clock"])
        self.time.append(state["time"])
        self.qpos.add(state["qpos"])
        self.qvel.add(state["qvel"])
        self._places.append(self._now)
        self._now = {}
        for robot in self.robots.values():
            robot.end_tick()

    def things(self) -> dict[str, Array]:
        """Return (x, y, heading) of each thing at each tick, NaN where it is not there, shape (N, 3)."""
        nowhere = (math.nan,) * 3
        names = dict.fromkeys(name for places in self._places for name in places)
        return {name: np.array([places.get(name, nowhere) for places in self._places]) for name in names}

    def module_seconds(self) -> dict[str, Array]:
        """Return the cost of each part, NaN where it did not run, shape (N,) [s]."""
        costs = {}
        for part, rows in self._seconds.items():
            costs[part] = np.full(len(self.time), np.nan)
            ticks, seconds = zip(*rows, strict=True)
            costs[part][list(ticks)] = seconds
        return costs


_READ = frozenset(
    {"truth", "odometry", "estimate", "command", "landmarks", "sightings", "identities", "innovations", "events"}
)
"""Topics of a robot that make its track."""


class _Robot:
    """What has been read of one robot."""

    def __init__(self) -> None:
        self._tick: dict[str, Any] = {}
        self._count = 0
        self._poses = {kind: _Rows(3) for kind in ("truth", "odometry", "estimate")}
        self._covariances = {kind: _Rows(3, 3) for kind in ("odometry", "estimate")}
        self._command = _Rows(3)
        self._maps: list[tuple[int, tuple[Hashable, ...], Array, Array]] = []
        self._sightings: list[tuple[Sighting, ...]] = []
        self._identities: list[tuple[str | None, ...]] = []
        self._innovations: list[tuple[tuple[Hashable, Array, Array], ...]] = []
        self._events: list[Event] = []

    def take(self, kind: str, message: dict[str, Any]) -> None:
        """Take a message of the tick at hand."""
        if kind == "events":
            self._events.append(event_of(message))
        else:
            self._tick[kind] = message

    def end_tick(self) -> None:
        """Add a row of everything; NaN for what did not come."""
        tick, self._tick = self._tick, {}
        for kind, rows in self._poses.items():
            rows.add(pose_row(tick[kind]) if kind in tick else None)
        for kind, rows in self._covariances.items():
            rows.add(tick[kind]["covariance"] if kind in tick else None)
        self._command.add(command_row(tick["command"]) if "command" in tick else None)
        if "landmarks" in tick:
            self._maps.append((self._count, *landmarks_of(tick["landmarks"])))
        self._sightings.append(sightings_of(tick["sightings"]) if "sightings" in tick else ())
        self._identities.append(identities_of(tick["identities"]) if "identities" in tick else ())
        self._innovations.append(innovations_of(tick["innovations"]) if "innovations" in tick else ())
        self._count += 1

    def track(self, time: Array) -> Track:
        """Return everything as arrays."""
        return Track(
            time=time,
            truth=self._poses["truth"].array(),
            odometry=self._poses["odometry"].array(),
            odometry_covariance=self._covariances["odometry"].array(),
            estimate=self._poses["estimate"].array(),
            covariance=self._covariances["estimate"].array(),
            command=self._command.array(),
            landmarks=self._landmarks(),
            sightings=tuple(self._sightings),
            identities=tuple(self._identities),
            innovations=tuple(self._innovations),
            events=tuple(self._events),
        )

    def _landmarks(self) -> Landmarks:
        """Hold each map until the next one."""
        columns: dict[Hashable, int] = {}
        for _, names, _, _ in self._maps:
            for name in names:
                columns.setdefault(name, len(columns))
        mean = np.full((self._count, len(columns), 2), np.nan)
        covariance = np.full((self._count, len(columns), 2, 2), np.nan)
        ends = [*(first for first, *_ in self._maps[1:]), self._count]
        for (first, names, means, covariances), end in zip(self._maps, ends, strict=False):
            places = [columns[name] for name in names]
            mean[first:end, places] = means
            covariance[first:end, places] = covariances
        return Landmarks(names=tuple(columns), mean=mean, covariance=covariance)
