"""Data of a run for browsers: collected in the run's thread, sent in the server's thread."""

import json
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from mjsim.geometry import Array, Pose3
from mjsim.interface import CameraFrame, PointCloud, Scan, Sighting
from mjsim.record import Tick
from mjsim.sim import LedPeople, lidar_places
from mjsim.web.run.happenings import Happenings
from mjsim.web.run.history import Past
from mjsim.web.run.measured import SHOWN_FOR, lidar_points, lidar_readings
from mjsim.web.run.news import EventNews, PastNews
from mjsim.web.run.tick_json import mechanisms_json, tick_json
from mjsim.world import World

MAX_TURN = 2.0
"""Longest scan of a lidar including its latency, for which robot poses are kept [s]."""
PACED_OVER = 1.0
"""Minimum time over which the pace is measured [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class Shot:
    """A picture of an onboard camera."""

    frame: CameraFrame
    sightings: tuple[Sighting, ...]
    """What was recognised in it."""


class Feed:
    """The newest tick, the newest pictures, the history and the events of a run. Taking a tick is fast."""

    def __init__(self, wake: Callable[[], None]) -> None:
        """Start empty; `wake` is called from any thread when there is news."""
        self._wake = wake
        self._lock = threading.Lock()
        self.number = 0
        """Number of the newest tick, over all runs."""
        self.run = 0
        """Number of the run, from 1; a restart begins another."""
        self.newest: Tick | None = None
        self.world: World | None = None
        """World of the newest tick."""
        self.shots: dict[str, Shot] = {}
        """Newest picture of each camera, by 'ROBOT/CAMERA'."""
        self._places: dict[str, Array] = {}
        self._tracks: dict[str, deque[tuple[float, Pose3]]] = {}
        self._scans: dict[str, tuple[Sequence[tuple[float, Pose3]], Scan | PointCloud]] = {}
        """For each lidar, by 'ROBOT/LIDAR': the newest reading, and the robot's poses until it arrived, by time [s]."""
        self._led: dict[str, list[str]] = {}
        """Joints led by motions, by mechanism."""
        self._people: LedPeople | None = None
        """Positions of hands."""
        self._tick_json: tuple[int, str] = (0, "")
        self._looking: dict[str, str] = {}
        self._pasts: dict[str, Past] = {}
        self._events = Happenings()
        self._paced: deque[tuple[float, float]] = deque()

    def begin(self, world: World) -> None:
        """Clear the history for a new run of a world."""
        with self._lock:
            self._forget()
            self.world, self._looking, self._places = world, _cameras_of_observers(world), lidar_places(world)
            mechanisms = mechanisms_json(world)
            self._people = LedPeople(world) if world.people else None
            self._led = {each["name"]: [joint["name"] for joint in each["joints"]] for each in mechanisms}
        self._wake()

    def take(self, tick: Tick) -> None:
        """Store a tick; called in the thread of the run."""
        with self._lock:
            if self.newest is not None and tick.time <= self.newest.time:
                self._forget()
            self.number += 1
            self.newest = tick
            for robot in tick.orders:
                self._pasts.setdefault(robot, Past()).take(tick, robot)
                self._take_shots(tick, robot)
                self._take_scans(tick, robot)
            self._events.take(tick)
            self._paced.append((time.perf_counter(), tick.time))
            while self._paced[-1][0] - self._paced[0][0] > PACED_OVER and len(self._paced) > 2:
                self._paced.popleft()
        self._wake()

    @property
    def pace(self) -> float:
        """Simulated seconds per second, over the last second."""
        with self._lock:
            if len(self._paced) < 2:
                return 0.0
            (began, first), (now, last) = self._paced[0], self._paced[-1]
        return (last - first) / max(now - began, 1e-6)

    def tick(self) -> tuple[int, str] | None:
        """Return number and JSON of the newest tick; the JSON is made once for all clients."""
        newest, number, pace = self.newest, self.number, self.pace
        if newest is None:
            return None
        if self._tick_json[0] != number:
            hands = self._people.grips(newest.looks) if self._people is not None else None
            people = self._people.outlines(newest.looks) if self._people is not None else None
            self._tick_json = (
                number,
                json.dumps(
                    tick_json(
                        newest,
                        number=number,
                        pace=pace,
                        scans=self._points(newest),
                        led=self._led,
                        hands=hands,
                        people=people,
                        world=self.world,
                    ),
                    allow_nan=False,
                ),
            )
        return self._tick_json

    def _points(self, tick: Tick) -> dict[str, dict[str, Array]]:
        """Return the latest lidar points of each robot, world frame, shape (n, 3) [m], unless they are old."""
        found: dict[str, dict[str, Array]] = {}
        for name, (track, reading) in self._scans.copy().items():
            robot, _, lidar = name.partition("/")
            if name in self._places and abs(tick.time - reading.stamp) < SHOWN_FOR:
                times, poses = np.array([time for time, _ in track]), np.array([pose.as_array() for _, pose in track])
                points = lidar_points(reading, self._places[name], times=times, poses=poses)
                found.setdefault(robot, {})[lidar] = points
        return found

    def events(self, after: int) -> tuple[int, list[EventNews]]:
        """Return the number of changes of events, and all events that changed after a given number."""
        with self._lock:
            return self._events.count, self._events.after(after)

    def past(self) -> tuple[int, PastNews]:
        """Return the number of events, and the whole history until now."""
        with self._lock:
            pasts = {name: past.copy() for name, past in self._pasts.items()}
            count, events = self._events.count, self._events.all()
        return count, {
            "kind": "past",
            "robots": {name: each.as_json() for name, each in pasts.items()},
            "events": events,
        }

    def _forget(self) -> None:
        self.run += 1
        self.newest = None
        self.shots, self._pasts, self._scans, self._tracks = {}, {}, {}, {}
        self._events.clear()
        self._paced.clear()

    def _take_scans(self, tick: Tick, robot: str) -> None:
        """Store the newest reading of each lidar with the robot's poses during the scan."""
        track = self._tracks.setdefault(robot, deque())
        track.append((tick.time, tick.poses[robot]))
        while track[0][0] < tick.time - MAX_TURN:
            track.popleft()
        for lidar, reading in lidar_readings(tick.seen[robot]).items():
            self._scans[f"{robot}/{lidar}"] = track.copy(), reading

    def _take_shots(self, tick: Tick, robot: str) -> None:
        order, cameras = tick.orders[robot], tick.seen[robot].cameras
        looking = self._looking.get(robot) or next(iter(cameras), None)
        for name, frame in cameras.items():
            recognised = order.sightings if name == looking else ()
            self.shots[f"{robot}/{name}"] = Shot(frame, tuple(recognised))


def _cameras_of_observers(world: World) -> dict[str, str]:
    """Return the camera used by the observer of each robot, where the world names it."""
    observers = {name: modules.observer for name, modules in world.run.drivers.items() if modules.observer is not None}
    cameras = {name: observer.arguments().get("camera") for name, observer in observers.items()}
    return {name: camera for name, camera in cameras.items() if isinstance(camera, str)}
