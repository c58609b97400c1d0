"""Deskews the scan of a lidar that moves while it rotates: each beam is measured at its own time and place."""

from dataclasses import replace

import numpy as np

from mjsim.geometry import Array, Pose, places_at, wrap_angles
from mjsim.interface.readings import Scan

SMOOTH = 0.1
"""Between neighbouring beams that differ by less than this fraction, the range is interpolated [1]."""


def swept(scan: Scan, times: Array, track: Array, robot_from_lidar: Pose) -> Scan:
    """Return a scan as if the lidar had measured all beams from where it was at the stamp.

    Directions without a beam get -inf, as if too near to measure.

    Args:
        scan: The measured scan.
        times: When each beam was measured, relative to the stamp, shape (beams,) [s].
        track: Poses of the robot by odometry: rows of time [s], x, y [m] and heading [rad], in order of time.
        robot_from_lidar: Pose of the lidar on the robot.
    """
    moments = np.append(scan.stamp + times, scan.stamp).clip(track[0, 0], track[-1, 0])
    places = _mounted(places_at(moments, track, gap=np.inf), robot_from_lidar)
    *_, last = places
    shift, turn = places[:-1, :2] - last[:2], wrap_angles(places[:-1, 2] - last[2])
    if not shift.any() and not turn.any():
        return scan
    c, s = np.cos(last[2]), np.sin(last[2])
    away = shift @ np.array([[c, -s], [s, c]])
    directions = scan.angles() + turn
    ranges = scan.ranges.copy()
    hit = np.isfinite(ranges)
    points = away[hit] + ranges[hit, None] * np.stack([np.cos(directions[hit]), np.sin(directions[hit])], axis=-1)
    ranges[hit] = np.hypot(points[:, 0], points[:, 1])
    bearings = directions.copy()
    bearings[hit] += wrap_angles(np.arctan2(points[:, 1], points[:, 0]) - directions[hit])
    return _sampled(scan, bearings, ranges)


def _mounted(places: Array, robot_from_lidar: Pose) -> Array:
    """Return the poses of a lidar from those of its robot, shape (N, 3)."""
    x, y, yaw = robot_from_lidar.x, robot_from_lidar.y, robot_from_lidar.heading
    c, s = np.cos(places[:, 2]), np.sin(places[:, 2])
    return np.column_stack([places[:, 0] + c * x - s * y, places[:, 1] + s * x + c * y, places[:, 2] + yaw])


def _sampled(scan: Scan, bearings: Array, ranges: Array) -> Scan:
    """Return a scan with the same angles, interpolated between ranges along some bearings."""
    count = len(bearings)
    # In a full turn, what lies beyond one end is also at the other end.
    around = np.concatenate([bearings - 2.0 * np.pi, bearings, bearings + 2.0 * np.pi])
    order = np.argsort(around, kind="stable")
    around, beams = around[order], order % count
    angles = scan.angles()
    right = np.searchsorted(around, angles).clip(1, len(around) - 1)
    gaps = angles - around[right - 1], around[right] - angles
    nearest = beams[np.where(gaps[0] <= gaps[1], right - 1, right)]
    first, second = ranges[beams[right - 1]], ranges[beams[right]]
    width = gaps[0] + gaps[1]
    with np.errstate(invalid="ignore"):
        smooth = np.abs(second - first) <= SMOOTH * np.minimum(first, second)
    smooth &= np.isfinite(first) & np.isfinite(second) & (width > 0.0) & (width <= 2.0 * scan.angle_increment)
    values = ranges[nearest]
    values[smooth] = first[smooth] + (gaps[0] / np.where(width > 0.0, width, 1.0) * (second - first))[smooth]
    values[np.minimum(*gaps) > scan.angle_increment] = -np.inf
    values[values < scan.range_min] = -np.inf
    values[values >= scan.range_max] = np.inf
    intensities = None if scan.intensities is None else scan.intensities[nearest].copy()
    return replace(scan, ranges=values, intensities=intensities, time_increment=None)
