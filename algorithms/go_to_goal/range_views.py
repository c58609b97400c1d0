"""Views: readings of lidars, proximity rays and depth cameras as ranges over bearings in the plane."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import minimum_filter1d

from mjsim.geometry import Array, Pose
from mjsim.interface import CameraFrame, Observation, PointCloud, RobotInfo, SensorInfo

from ..scans.level_scan import LevelLidar, LevelScan

LOWEST, HEADROOM = 0.06, 0.1
"""Points of depth cameras and 3-D lidars are obstacles from the first height, above the floor, to the second, above the
highest sensor [m]."""
BEARING = math.radians(1.0)
"""Width of a bearing into which such points are sorted [rad]."""
DEPTH_RANGE, CLOUD_RANGE = 4.0, 8.0
"""Range of a depth camera, and of a 3-D lidar, beyond which nothing counts [m]."""
STRIDE = 8
"""Step in rows and columns of a depth image: the others are not used."""
SMOOTHED = 3
"""Beams to each side over which the noise of a range is averaged, as far as they hit the same surface."""
WINDOWS = (0, 1, 2, 4, 8, 16)
"""Numbers of beams to each side over which the shortest range is known."""
TOUCHED = 0.02
"""Distance of points on a touched obstacle from the rim, and from each other [m]."""
NOISY = 0.005
"""Range noise from which ranges are averaged [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class RangeView:
    """Ranges over bearings around a sensor, in the plane."""

    name: str
    """Name of the sensor."""
    robot_from_sensor: Pose
    first: float
    """Bearing of the first range in the sensor's frame [rad]."""
    step: float
    """Step between neighbouring bearings, above 0 [rad]."""
    ranges: Array
    """Shape (n,) [m]; +inf for nothing within `farthest`, 0 for unknown."""
    farthest: float
    """Range up to which it surely detects obstacles [m]."""
    nearest: float = 0.0
    """Range from which a longer range means free space; nearer, an obstacle may be below the field of view [m]."""

    def points(self) -> Array:
        """Return the obstacles, in the robot frame, shape (k, 2) [m]."""
        hit = (self.ranges > 0.0) & np.isfinite(self.ranges)
        bearings = self.first + self.step * np.flatnonzero(hit)
        ranges = self.ranges[hit]
        return self.robot_from_sensor.transform(
            np.stack([ranges * np.cos(bearings), ranges * np.sin(bearings)], axis=-1)
        )

    def faces(self, points: Array) -> NDArray[np.bool_]:
        """Return which points are in the sensor's field of view: robot frame, shape (k, 2) [m]."""
        x, y = self.robot_from_sensor.inverse().transform(points).T
        turned = (np.arctan2(y, x) - self.first + 0.5 * self.step) % (2.0 * math.pi)
        return np.asarray(turned < len(self.ranges) * self.step)

    def is_free(self, points: Array, size: float) -> Array:
        """Return whether the sensor has seen past each point.

        Args:
            points: Points in the robot frame, shape (k, 2) [m].
            size: Side of the cells that they stand for [m].
        """
        x, y = self.robot_from_sensor.inverse().transform(points).T
        away = np.maximum(np.hypot(x, y), 1e-3)
        turned = (np.arctan2(y, x) - self.first + 0.5 * self.step) % (2.0 * math.pi) - 0.5 * self.step
        beam = np.rint(turned / self.step).astype(int)
        count = len(self.ranges)
        seen = (beam >= 0) & (beam < count) & (away > self.nearest) & (away < self.farthest - 2.0 * size)
        # Sparse beams may miss something between them.
        seen &= np.abs(turned - beam * self.step) * away < size
        extent = 1.5 * size / (away * self.step)
        level = np.clip(np.searchsorted(WINDOWS, extent), 0, len(WINDOWS) - 1)
        shortest = np.stack([minimum_filter1d(self.ranges, 2 * window + 1, mode="nearest") for window in WINDOWS])
        return np.asarray(seen & (shortest[level, np.clip(beam, 0, count - 1)] > away + 1.2 * size))


class Views:
    """The views of a robot's sensors."""

    def __init__(self, robot: RobotInfo) -> None:
        """Find the sensors of the robot that detect obstacles."""
        self._robot = robot
        kinds = {name: sensor.kind for name, sensor in robot.sensors.items()}
        self._lidars = {name: LevelLidar(robot, name) for name, kind in kinds.items() if kind == "lidar"}
        self._top = HEADROOM + max([float(s.robot_from_sensor[2, 3]) for s in robot.sensors.values()], default=0.3)
        self._latest: dict[str, RangeView] = {}
        self._rims, self._reach = rims(robot, np.linspace(0.0, 2.0 * math.pi, 16, endpoint=False)), 0.0

    def update(self, seen: Observation) -> list[RangeView]:
        """Return the views of this tick."""
        views = [self._ring(seen.proximity)]
        for name, lidar in self._lidars.items():
            if (scan := lidar.update(seen)) is not None:
                views.append(_scanned(name, scan, self._robot.sensors[name]))
        for name, frame in seen.cameras.items():
            if frame.depth is not None:
                views.append(self._imaged(name, frame))
        views += [self._clouded(name, cloud) for name, cloud in seen.clouds.items()]
        self._latest |= {view.name: view for view in views}
        return views

    def hidden(self, pose: Pose, points: Array) -> NDArray[np.bool_]:
        """Return which points (n, 2) [m] are outside the fields of view of all sensors at a pose of the robot.

        The rays of the ring leave gaps: they count only without other sensors.
        """
        ring, *others = self._latest.values()
        robot = pose.inverse().transform(points)
        return np.asarray(~np.logical_or.reduce([view.faces(robot) for view in others or [ring]]))

    def _ring(self, proximity: Array) -> RangeView:
        """Return the view of the proximity rays; their range is unknown, at least the longest range measured."""
        self._reach = float(np.max(proximity, where=np.isfinite(proximity), initial=self._reach))
        farthest = self._reach + float(self._rims.min())
        return RangeView("proximity", Pose(0.0, 0.0, 0.0), 0.0, 2.0 * math.pi / 16, proximity + self._rims, farthest)

    def _imaged(self, name: str, frame: CameraFrame) -> RangeView:
        """Return the view of a depth image."""
        assert frame.depth is not None
        k, pose = frame.intrinsics, self._robot.sensors[name].robot_from_sensor
        rows, columns = np.mgrid[STRIDE // 2 : k.height : STRIDE, STRIDE // 2 : k.width : STRIDE]
        depth = frame.depth[rows, columns]
        near = np.isfinite(depth)
        z = depth[near]
        points = np.stack([(columns[near] - k.cx) / k.fx * z, (rows[near] - k.cy) / k.fy * z, z], axis=-1)
        forward = pose[:3, 2]
        lowest = math.asin(float(np.clip(forward[2], -1.0, 1.0))) - math.atan2(k.height - k.cy, k.fy)
        height = float(pose[2, 3])
        blind = height / math.tan(-lowest) if lowest < -0.05 else DEPTH_RANGE
        fov = 2.0 * math.atan2(max(k.cx, k.width - k.cx), k.fx)
        return self._sorted(name, points, math.atan2(forward[1], forward[0]), fov, farthest=DEPTH_RANGE, blind=blind)

    def _clouded(self, name: str, cloud: PointCloud) -> RangeView:
        """Return the view of a 3-D lidar."""
        sensor = self._robot.sensors[name]
        heading = math.atan2(sensor.robot_from_sensor[1, 0], sensor.robot_from_sensor[0, 0])
        farthest = min(sensor.range[1] if sensor.range else CLOUD_RANGE, CLOUD_RANGE)
        return self._sorted(name, cloud.points.astype(float), heading, 2.0 * math.pi, farthest=farthest, blind=1.0)

    def _sorted(
        self, name: str, points: Array, heading: float, fov: float, *, farthest: float, blind: float
    ) -> RangeView:
        """Return the view of points in space: the shortest distance of an obstacle in each bearing.

        Args:
            name: Name of the sensor.
            points: Points in its frame, shape (n, 3) [m].
            heading: Direction in which it looks, in the robot frame [rad].
            fov: Its field of view [rad].
            farthest: Its range [m].
            blind: Distance within which obstacles may be below its field of view [m].
        """
        pose = self._robot.sensors[name].robot_from_sensor
        place = Pose(float(pose[0, 3]), float(pose[1, 3]), heading)
        level = points @ pose[:3, :3].T + pose[:3, 3]
        solid = level[(level[:, 2] > LOWEST) & (level[:, 2] < self._top)]
        x, y = place.inverse().transform(solid[:, :2]).T
        count = max(round(fov / BEARING), 1)
        bins = np.floor((np.arctan2(y, x) + 0.5 * fov) / fov * count).astype(int)
        ranges = np.full(count, np.inf)
        inside = (bins >= 0) & (bins < count)
        away = np.hypot(x, y)
        inside &= away < farthest
        np.minimum.at(ranges, bins[inside], away[inside])
        return RangeView(name, place, -0.5 * fov + 0.5 * fov / count, fov / count, ranges, farthest, blind)


def touched(robot: RobotInfo, bearings: Array) -> Array:
    """Return points just beyond the rim of an obstacle touched at bearings (n,) [rad], robot frame, (k, 2) [m].

    The obstacle is taken for a flat surface half as wide as the robot.
    """
    across = np.linspace(-0.5, 0.5, 1 + 2 * math.ceil(robot.radius / TOUCHED)) * robot.radius
    away, (c, s) = rims(robot, bearings) + TOUCHED, (np.cos(bearings), np.sin(bearings))
    x, y = (away * c)[:, None] - s[:, None] * across, (away * s)[:, None] + c[:, None] * across
    return np.stack([x, y], axis=-1).reshape(-1, 2)


def rims(robot: RobotInfo, bearings: Array) -> Array:
    """Return the distances from the origin to the rim of the body at bearings (n,) [rad], shape (n,) [m]."""
    if robot.outline is None:
        return np.full(len(bearings), robot.radius)
    start, edge = robot.outline, np.roll(robot.outline, -1, axis=0) - robot.outline
    along = np.stack([np.cos(bearings), np.sin(bearings)], axis=-1)[:, None]
    across = along[..., 0] * edge[:, 1] - along[..., 1] * edge[:, 0]
    safe = np.where(np.abs(across) < 1e-9, np.inf, across)
    distance = (start[:, 0] * edge[:, 1] - start[:, 1] * edge[:, 0]) / safe
    share = (start[:, 0] * along[..., 1] - start[:, 1] * along[..., 0]) / safe
    return np.asarray(np.where((np.abs(share - 0.5) <= 0.5 + 1e-9) & (distance > 0.0), distance, 0.0).max(axis=1))


def _scanned(name: str, level: LevelScan, sensor: SensorInfo) -> RangeView:
    """Return the view of a level scan, with less noise."""
    scan, pose = level.scan, level.robot_from_lidar
    ranges = np.where(scan.ranges == -math.inf, 0.0, np.nan_to_num(scan.ranges, nan=0.0, posinf=np.inf))
    ranges = np.where(ranges < scan.range_max, ranges, np.inf)
    if (noise := sensor.noise.get("range", 0.0)) > NOISY:
        ranges = smoothed(ranges, 3.0 * noise)
    if scan.angle_increment > 0.0:
        return RangeView(name, pose, scan.angle_min, scan.angle_increment, ranges, scan.range_max)
    last = scan.angle_min + scan.angle_increment * (len(ranges) - 1)
    return RangeView(name, pose, last, max(-scan.angle_increment, 1e-6), ranges[::-1], scan.range_max)


def smoothed(ranges: Array, tolerance: float) -> Array:
    """Return ranges, shape (n,), averaged over neighbours that differ by at most a tolerance [m]."""
    padded = np.pad(np.where(np.isfinite(ranges), ranges, -1e6), SMOOTHED, constant_values=-1e6)
    around = np.lib.stride_tricks.sliding_window_view(padded, 2 * SMOOTHED + 1)
    same = np.abs(around - ranges[:, None]) < tolerance
    count = same.sum(axis=1)
    mean = np.where(same, around, 0.0).sum(axis=1) / np.maximum(count, 1)
    return np.where(np.isfinite(ranges) & (count > 0), mean, ranges)
