"""Lidar points in the world frame for the page; those of recordings are read once, in the background."""

import contextlib
import threading
from bisect import bisect_right
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from mjsim.closing import join
from mjsim.errors import MjsimError
from mjsim.geometry import Array
from mjsim.interface import Observation, PointCloud, Scan
from mjsim.record import Recording
from mjsim.sim import lidar_places
from mjsim.web.run.history import plain
from mjsim.web.run.news import RobotTick

SAME_TIME = 1e-6
"""Times that differ by less are equal [s]."""
MAX_POINTS = 1500
"""Maximum number of points drawn per reading; more are sampled evenly."""
MAX_BYTES = 1 << 28
"""Memory limit for the points of one recording [bytes]; later readings are not drawn."""
SHOWN_FOR = 0.5
"""Time for which a reading is drawn [s]."""


def lidar_points(reading: Scan | PointCloud, robot_from_sensor: Array, *, times: Array, poses: Array) -> Array:
    """Return the points that beams hit, each from the robot's pose when it was fired, world frame, shape (n, 3) [m].

    Args:
        reading: One scan; the beams of a 2-D scan are fired at the same time.
        robot_from_sensor: Shape (4, 4) [m].
        times: Times of the known poses, ascending, shape (k,) with k > 0 [s].
        poses: Poses of the robot at these times: x, y, z [m], qx, qy, qz, qw, world frame, shape (k, 7).

    Returns:
        At most `MAX_POINTS`; empty if a required pose is not finite.
    """
    points = np.asarray(reading.points() if isinstance(reading, Scan) else reading.points, dtype=float)
    every = slice(None, None, -(-len(points) // MAX_POINTS) or 1)
    fired = reading.stamp + (np.zeros(1) if isinstance(reading, Scan) else reading.times[every].astype(float))
    points = points[every]
    if not len(points):
        return np.empty((0, 3))
    p_robot = points @ robot_from_sensor[:3, : points.shape[1]].T + robot_from_sensor[:3, 3]
    first, last = row_of(times, fired.min()), row_of(times, fired.max()) + 2
    return _in_world(p_robot, fired, times[first:last], poses[first:last])


def _in_world(p_robot: Array, when: Array, times: Array, poses: Array) -> Array:
    """Return points of the robot's frame, shape (n, 3) [m], in the world; `when` has one time, or one per point [s]."""
    if not np.isfinite(poses).all():
        return np.empty((0, 3))
    turns, places = Rotation.from_quat(poses[:, 3:]), poses[:, :3]
    if len(times) == 1:
        return np.asarray(turns[0].apply(p_robot) + places[0], dtype=float)
    when = when.clip(times[0], times[-1])
    place = np.column_stack([np.interp(when, times, column) for column in places.T])
    return np.asarray(Slerp(times, turns)(when).apply(p_robot) + place, dtype=float)


def flat_points(points: NDArray[Any]) -> list[float]:
    """Return points in JSON form: x, y, z of each in sequence, rounded to the millimetre [m]."""
    rows: list[float] = np.round(points, 3).ravel().tolist()
    return rows


def lidar_readings(seen: Observation) -> dict[str, Scan | PointCloud]:
    """Return the lidar readings in an observation, by name."""
    return {**seen.scans, **seen.clouds}


_Row = tuple[float, Mapping[str, NDArray[np.float32]], Array, tuple[float, ...]]
"""Time [s], points of each lidar in the world [m], proximity ranges [m], bearings of contacts [rad]."""


class SensorPast:
    """Sensor readings of a recording at each tick, as far as it has been read."""

    def __init__(self, recording: Recording) -> None:
        """Start reading, in a separate thread."""
        self._recording, self._places = recording, lidar_places(recording.world)
        self._robots: dict[str, list[_Row]] = {robot: [] for robot in recording.robots}
        self._ended = threading.Event()
        self.whole = threading.Event()
        """Set once everything has been read."""
        self._thread = threading.Thread(target=self._read, name="mjsim-measured", daemon=True)
        self._thread.start()

    def add_to(self, robot_tick: RobotTick, robot: str, row: int) -> None:
        """Add readings to a tick: proximity ranges, contacts, and the newest reading of each lidar."""
        rows, now = self._robots[robot], float(self._recording.time[row])
        last = bisect_right(rows, now + SAME_TIME, key=_time_of) - 1
        if last < 0 or rows[last][0] < now - SAME_TIME:
            return
        _, _, ring, bump = rows[last]
        robot_tick["proximity"], robot_tick["bump"] = plain(ring, 3), plain(bump, 3)
        first = bisect_right(rows, now - SHOWN_FOR, key=_time_of)
        recent = {name: points for _, clouds, _, _ in rows[first : last + 1] for name, points in clouds.items()}
        robot_tick["scans"] = {name: flat_points(points) for name, points in recent.items()}

    def close(self) -> None:
        """Stop reading."""
        self._ended.set()
        join(self._thread)

    def _read(self) -> None:
        # If the recording is damaged, the readings before the damage are drawn.
        with contextlib.suppress(MjsimError):
            for robot in self._recording.robots:
                self._read_robot(robot)
        self.whole.set()

    def _read_robot(self, robot: str) -> None:
        left = MAX_BYTES // max(len(self._recording.robots), 1)
        for seen in self._recording.observations(robot):
            clouds = self._clouds(robot, seen) if left > 0 else {}
            left -= sum(points.nbytes for points in clouds.values())
            self._robots[robot].append((seen.time, clouds, seen.proximity, seen.bump))
            if self._ended.is_set():
                return

    def _clouds(self, robot: str, seen: Observation) -> dict[str, NDArray[np.float32]]:
        """Return the points of each lidar in the world, based on the robot's poses when they were measured."""
        found, track = {}, self._recording.robots[robot]
        for name, reading in lidar_readings(seen).items():
            mount = self._places.get(f"{robot}/{name}")
            if mount is not None:
                points = lidar_points(reading, mount, times=track.time, poses=track.truth_pose)
                found[name] = points.astype(np.float32)
        return found


def _time_of(row: _Row) -> float:
    return row[0]


def row_of(times: Array, time: float) -> int:
    """Return the index of the last of some times, shape (n,), that is not after a time [s]; 0 if all are later."""
    return max(int(np.searchsorted(times, time + SAME_TIME, side="right")) - 1, 0)
