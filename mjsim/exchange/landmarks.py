"""Converts landmark maps of MATLAB SLAM simulators to worlds: `lm` (2 x n) are reflectors, `wp` (2 x m) waypoints.

References:
    The format of T. Bailey's SLAM simulators for MATLAB.
"""

import io
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.bounded_file import read_bounded
from mjsim.exchange.place import ODOMETRY_NOISE, ROBOT, WAYPOINTS
from mjsim.exchange.preset_files import inhabited, robot_of
from mjsim.geometry import Array
from mjsim.world import Beacon, Modules, Robot, Run, Use, World

SLAM = "mjsim.algorithms.ekf_slam:EkfSlam"
SPEED = 0.6
"""Speed along the waypoints [m/s]."""
MAX_BYTES, MAX_LANDMARKS, MAX_WAYPOINTS = 10_000_000, 2000, 1000
FARTHEST = 5000.0
"""Maximum distance of a point from the map's origin [m]."""
DIGITS = 3
"""Coordinates are rounded to the millimetre."""


@dataclass(frozen=True, slots=True, eq=False)
class LandmarkMap:
    """The contents of such a file, in metres."""

    landmarks: Array
    """Shape (n, 2) [m]."""
    waypoints: Array
    """Shape (m, 2) [m]; empty if the file has none."""

    def length(self) -> float:
        """Return the length of the path along the waypoints [m]."""
        return float(np.hypot(*np.diff(self.waypoints, axis=0).T).sum()) if len(self.waypoints) > 1 else 0.0


def read_landmarks(path: Path, *, scale: float) -> LandmarkMap:
    """Return the landmark map of a file.

    Args:
        path: A MAT-file, version 5 to 7.
        scale: Metres per unit of the file.

    Raises:
        UsageError: The file is not a MAT-file, or contains no such map.
    """
    content = _content(path)
    if "lm" not in content:
        names = ", ".join(sorted(content)) or "nothing"
        raise UsageError(f"'{path}' holds no landmarks: lm, 2 x n; it holds {names:.200}")
    landmarks = _points(path, "lm", content["lm"], limit=MAX_LANDMARKS) * scale
    waypoints = _points(path, "wp", content.get("wp", np.zeros((2, 0))), limit=MAX_WAYPOINTS) * scale
    if not len(landmarks):
        raise UsageError(f"'{path}' has an empty lm; a map has at least one landmark")
    farthest = float(np.abs(np.vstack([landmarks, waypoints])).max())
    if farthest > FARTHEST:
        raise UsageError(f"'{path}' reaches {farthest:g} m; the farthest is {FARTHEST:g} m, give a smaller --scale")
    return LandmarkMap(np.round(landmarks, DIGITS) + 0.0, np.round(waypoints, DIGITS) + 0.0)


def world_from_landmarks(
    map: LandmarkMap,
    *,
    name: str,
    preset: str | None,
    estimator: Use | None = None,
    folder: Path | None = None,
) -> World:
    """Return a world with a reflector for each landmark, and a robot that drives along the waypoints.

    Args:
        map: The landmark map.
        name: Name of the world.
        preset: Preset of the robot; None for no robot.
        folder: Folder in which the world will be saved; the preset may be a file in it.
        estimator: The estimator; by default EKF-SLAM.

    Raises:
        UsageError: The preset does not exist.
    """
    beacons = tuple(Beacon(name=f"lm{k}", at=_at(point)) for k, point in enumerate(map.landmarks, start=1))
    world = World(name=name, beacons=beacons)
    if preset is None:
        return world
    start = map.waypoints[0] if len(map.waypoints) else map.landmarks.mean(axis=0).round(DIGITS)
    robot = _robot(preset, start, _heading(start, map.waypoints[1:]), folder)
    points = [list(_at(point)) for point in map.waypoints[1:]]
    length = Use.model_validate({"use": WAYPOINTS, "points": points, "speed": SPEED}) if points else None
    modules = Modules(estimator=estimator or Use(use=SLAM), navigator=length)
    seconds = float(max(60, math.ceil(1.4 * map.length() / SPEED)))
    run = Run(seconds=seconds, drivers={ROBOT: modules})
    return inhabited(world, robot, run, folder)


def _content(path: Path) -> dict[str, Any]:
    from scipy.io import loadmat

    data = read_bounded(path, limit=MAX_BYTES, kind="a landmark map")
    content = loadmat(io.BytesIO(data), variable_names=["lm", "wp"])
    return {key: value for key, value in content.items() if not key.startswith("__")}


def _points(path: Path, name: str, value: Any, *, limit: int) -> Array:
    """Return columns as points, shape (n, 2)."""
    array = np.asarray(value)
    if array.dtype.kind not in "iuf" or array.ndim != 2 or (array.shape[0] != 2 and array.size):
        sides = " x ".join(map(str, array.shape))
        raise UsageError(f"'{path}' has {name} of {sides}; it must be 2 x n numbers, x above y")
    if not np.isfinite(array).all():
        raise UsageError(f"'{path}' has {name} that is not finite")
    if array.shape[1] > limit:
        raise UsageError(f"'{path}' has {array.shape[1]} columns in {name}; {limit} can be read")
    return np.asarray(array.T, dtype=float).reshape(-1, 2)


def _robot(preset: str, start: Array, heading: float, folder: Path | None) -> Robot:
    noise = {"range": 0.05, "bearing_deg": 1.0}
    sensor = {"beacons": "ring", "range": [0.3, 8.0], "fov_deg": 180.0, "rate_hz": 5.0, "noise": noise}
    keys = {"name": ROBOT, "preset": preset, "at": list(_at(start)), "heading_deg": heading}
    return robot_of({**keys, "sensors": [sensor], "odometry": {"noise": ODOMETRY_NOISE}}, folder)


def _heading(start: Array, ahead: Array) -> float:
    """Return the direction from the start to the first waypoint that differs from it [deg]."""
    for point in ahead:
        if (point != start).any():
            dx, dy = point - start
            return round(math.degrees(math.atan2(dy, dx)), 1)
    return 0.0


def _at(point: Array) -> tuple[float, float]:
    x, y = point.tolist()
    return x, y
