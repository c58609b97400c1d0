"""Projects scans of a tilted lidar (by mounting or balancing) to the horizontal."""

import math
from dataclasses import dataclass, replace

import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.interface import Observation, RobotInfo, Scan

from ..balance import TickLean
from .moving_lidar import MovingLidar

CLEARANCE, ANGLE_MARGIN = 0.05, 0.02
"""A beam that ends lower than this above the floor may have hit it; the limit increases with its range [m, rad]: the
pitch error of an inertial sensor while the robot is pushed."""


@dataclass(frozen=True, slots=True, eq=False)
class LevelScan:
    """A scan, and its planar pose."""

    scan: Scan
    robot_from_lidar: Pose
    """Pose in the level frame of the robot."""

    def points(self) -> Array:
        """Return the points hit by beams, in the level frame of the robot, shape (n, 2) [m]."""
        return np.asarray(self.robot_from_lidar.transform(self.scan.points()))


class LevelLidar:
    """Converts the scans of one lidar to those of a level lidar at rest, without returns from the floor.

    For a balancing body, the lean comes from its inertial sensor; the motion while the lidar rotates, from odometry. A
    lidar that is always level and measures all beams at once costs nothing.
    """

    def __init__(self, robot: RobotInfo, name: str | None, *, deskew: bool = True) -> None:
        """Find the lidar.

        Args:
            robot: Data sheet of the robot.
            name: Name of the lidar; None for its first.
            deskew: Whether to undo the motion of the robot in scans of a lidar that measures while it rotates.

        Raises:
            ValueError: It has no such lidar.
        """
        lidars = [key for key, sensor in robot.sensors.items() if sensor.kind == "lidar"]
        if not lidars or name not in (None, *lidars):
            raise ValueError(
                f"robot '{robot.name}' has no lidar{f' {name!r}' if name else ''}; it has {lidars or 'none'}"
            )
        self._name = name or lidars[0]
        self._robot_from_lidar = robot.sensors[self._name].robot_from_sensor
        self._lean = TickLean(robot)
        self._motion = MovingLidar(rate_hz=robot.sensors[self._name].rate_hz) if deskew else None
        self._level = _in_plane(self._robot_from_lidar) if not self._robot_from_lidar[2, :2].any() else None

    def update(self, seen: Observation) -> LevelScan | None:
        """Return the scan of this tick; None if none is due. Call it at every tick, because the pitch is integrated."""
        pitch = self._lean.update(seen)
        if self._motion is not None:
            self._motion.move(seen)
        scan = seen.scans.get(self._name)
        if scan is None:
            return None
        if not pitch and self._level is not None:
            level = LevelScan(scan, self._level)
        else:
            level = level_scan(scan, leaning(pitch) @ self._robot_from_lidar)
        if self._motion is None or not scan.time_increment:
            return level
        return replace(level, scan=self._motion.still(level.scan, level.robot_from_lidar))


def level_scan(scan: Scan, level_from_lidar: Array) -> LevelScan:
    """Return a scan as from a level lidar at the same place; beams that may have hit the floor become -inf.

    Each range is the horizontal length of the beam. Beams keep their angles: for a tilt of t, the error is at most t^2
    / 4, 0.04 degrees at a tilt of 3 degrees.

    Args:
        scan: Scan in the frame of the lidar.
        level_from_lidar: Its pose in the level frame of the robot, shape (4, 4).
    """
    angles, away = scan.angles(), scan.ranges
    directions = level_from_lidar[:3, :2] @ np.stack([np.cos(angles), np.sin(angles)])
    hit = np.isfinite(away)
    lengths = np.where(hit, away, 0.0)
    height = level_from_lidar[2, 3] + lengths * directions[2]
    flat = np.where(hit, lengths * np.hypot(*directions[:2]), away)
    flat[hit & (height < CLEARANCE + ANGLE_MARGIN * lengths)] = -math.inf
    return LevelScan(replace(scan, ranges=flat), _in_plane(level_from_lidar))


def leaning(pitch: float) -> Array:
    """Return level_from_robot of a body that leans forward [rad], shape (4, 4); both frames have one origin."""
    c, s = math.cos(pitch), math.sin(pitch)
    level_from_robot = np.eye(4)
    level_from_robot[:3, :3] = [[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]
    return level_from_robot


def _in_plane(level_from_lidar: Array) -> Pose:
    """Return the pose of a lidar in the plane."""
    x, y = level_from_lidar[:2, 3].tolist()
    return Pose(x, y, math.atan2(level_from_lidar[1, 0], level_from_lidar[0, 0]))
