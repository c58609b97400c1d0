"""Data of a run for browsers: collected in the run's thread, sent in the server's."""

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
from mjsim.web.measured import SHOWN_FOR, lidar_points, lidar_readings
from mjsim.web.news import EventNews, PastNews
from mjsim.web.past import Past
from mjsim.web.telling import events_told, mechanisms_told, tick_told
from mjsim.world import World

EVENTS = 1000
"""So many are kept for who comes late."""
LONGEST_TURN = 2.0
"""Of a lidar, with its latency; so long it is known where robots were [s]."""
PACED_OVER = 1.0
"""Least time over which the pace is measured [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class Shot:
    """A picture that an onboard camera gave."""

    frame: CameraFrame
    sightings: tuple[Sighting, ...]
    """What was recognised in it."""


class Feed:
    """The newest tick, the newest pictures, the past and the events of a run. To take a tick is quick."""

    def __init__(self, wake: Callable[[], None]) -> None:
        """Be empty; `wake` is called from any thread when there is news."""
        self._wake = wake
        self._lock = threading.Lock()
        self.number = 0
        """Of the newest tick, over all runs."""
        self.run = 0
        """Which run it is, counted from 1; a restart begins another."""
        self.newest: Tick | None = None
        self.world: World | None = None
        """Of the newest tick."""
        self.shots: dict[str, Shot] = {}
        """The newest of each camera, by 'ROBOT/CAMERA'."""
        self._places: dict[str, Array] = {}
        self._ways: dict[str, deque[tuple[float, Pose3]]] = {}
        self._scans: dict[str, tuple[Sequence[tuple[float, Pose3]], Scan | PointCloud]] = {}
        """Of each lidar, by 'ROBOT/LIDAR': the newest reading, and where the robot was until it came, by time [s]."""
        self._led: dict[str, list[str]] = {}
        """By mechanism, the joints that motions lead."""
        self._people: LedPeople | None = None
        """Where their hands are."""
        self._told: tuple[int, str] = (0, "")
        self._looking: dict[str, str] = {}
        self._pasts: dict[str, Past] = {}
        self._events: deque[tuple[int, EventNews]] = deque(maxlen=EVENTS)
        self._event_count = 0
        self._paced: deque[tuple[float, float]] = deque()

    def begin(self, world: World) -> None:
        """Forget the past: the run of a world begins."""
        with self._lock:
            self._forget()
            self.world, self._looking, self._places = world, _cameras_of_observers(world), lidar_places(world)
            told = mechanisms_told(world)
            self._people = LedPeople(world) if world.people else None
            self._led = {each["name"]: [joint["name"] for joint in each["joints"]] for each in told}
        self._wake()

    def take(self, tick: Tick) -> None:
        """Take note of a tick; in the thread of the run."""
        with self._lock:
            if self.newest is not None and tick.time <= self.newest.time:
                self._forget()
            self.number += 1
            self.newest = tick
            for robot in tick.orders:
                self._pasts.setdefault(robot, Past()).take(tick, robot)
                self._take_shots(tick, robot)
                self._take_scans(tick, robot)
            for event in events_told(tick):
                self._event_count += 1
                self._events.append((self._event_count, event))
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
        """Return the number of the newest tick and itself as JSON, made once for all who ask."""
        newest, number, pace = self.newest, self.number, self.pace
        if newest is None:
            return None
        if self._told[0] != number:
            hands = self._people.grips(newest.looks) if self._people is not None else None
            people = self._people.outlines(newest.looks) if self._people is not None else None
            self._told = (
                number,
                json.dumps(
                    tick_told(
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
        return self._told

    def _points(self, tick: Tick) -> dict[str, dict[str, Array]]:
        """Return what the lidars of each robot measured last, world frame, unless that is long ago."""
        found: dict[str, dict[str, Array]] = {}
        for name, (way, reading) in self._scans.copy().items():
            robot, _, lidar = name.partition("/")
            if name in self._places and abs(tick.time - reading.stamp) < SHOWN_FOR:
                times, poses = np.array([time for time, _ in way]), np.array([pose.as_array() for _, pose in way])
                points = lidar_points(reading, self._places[name], times=times, poses=poses)
                found.setdefault(robot, {})[lidar] = points
        return found

    def events(self, after: int) -> tuple[int, list[EventNews]]:
        """Return the number of the newest event, and all after one of a number."""
        with self._lock:
            return self._event_count, [event for number, event in self._events if number > after]

    def past(self) -> tuple[int, PastNews]:
        """Return how many events there are, and all that was until now."""
        with self._lock:
            pasts = {name: past.copy() for name, past in self._pasts.items()}
            count, events = self._event_count, [event for _, event in self._events]
        return count, {"kind": "past", "robots": {name: each.told() for name, each in pasts.items()}, "events": events}

    def _forget(self) -> None:
        self.run += 1
        self.newest = None
        self.shots, self._pasts, self._scans, self._ways = {}, {}, {}, {}
        self._events.clear()
        self._paced.clear()

    def _take_scans(self, tick: Tick, robot: str) -> None:
        """Keep the newest reading of each lidar with the way that the robot has gone while it was taken."""
        way = self._ways.setdefault(robot, deque())
        way.append((tick.time, tick.poses[robot]))
        while way[0][0] < tick.time - LONGEST_TURN:
            way.popleft()
        for lidar, reading in lidar_readings(tick.seen[robot]).items():
            self._scans[f"{robot}/{lidar}"] = way.copy(), reading

    def _take_shots(self, tick: Tick, robot: str) -> None:
        order, cameras = tick.orders[robot], tick.seen[robot].cameras
        looking = self._looking.get(robot) or next(iter(cameras), None)
        for name, frame in cameras.items():
            recognised = order.sightings if name == looking else ()
            self.shots[f"{robot}/{name}"] = Shot(frame, tuple(recognised))


def _cameras_of_observers(world: World) -> dict[str, str]:
    """Return which camera the observer of each robot looks at, where the world says so."""
    observers = {name: modules.observer for name, modules in world.run.drivers.items() if modules.observer is not None}
    cameras = {name: observer.arguments().get("camera") for name, observer in observers.items()}
    return {name: camera for name, camera in cameras.items() if isinstance(camera, str)}
