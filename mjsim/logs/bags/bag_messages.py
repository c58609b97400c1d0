"""Converts messages of ROS to readings: scans, motion, inertial readings, calibrations."""

import math
import struct
from dataclasses import replace
from typing import Any

import numpy as np

from mjsim.geometry import Array
from mjsim.interface import Intrinsics, Scan
from mjsim.logs.bags.bag_frames import matrix_of

MIN_RANGE, MAX_RANGE = 0.01, 100.0
"""Range limits of a lidar whose messages do not give them [m]."""
ASSUMED_FOV = math.radians(60.0)
"""Horizontal field of view of a camera without calibration."""
BROWNS, FISHEYES = ("plumb_bob", "rational_polynomial", "radtan", ""), ("equidistant", "fisheye", "kannala_brandt")
"""Names of lens models."""
MILLIMETRES = 2.0, 500.0
"""A lidar whose minimum and maximum range are at least these gives them in millimetres."""
UNMEASURED = -1.0
"""First element of the covariance of a quantity that an inertial sensor does not measure."""
NOTHING = (math.nan,) * 3
IMU_SIZE = 37 * 8
"""Orientation, turn rate and acceleration, each with its covariance [bytes]."""
MAX_SPEED = 1e6
"""Maximum of a valid twist [m/s, rad/s]."""
MAX_FOV = 3.0 * math.pi
"""Maximum angle of a scan: some lidars measure more than a whole turn [rad]."""
UPSIDE_DOWN = -0.5
"""A lidar is mounted upside down if the z component of its z axis in the robot frame is below this."""


def scan_of(message: Any, stamp: float, *, upside_down: bool, beams: int | None = None) -> Scan:
    """Return the scan of a `sensor_msgs/LaserScan`, with beams ordered from right to left.

    Of a `sensor_msgs/MultiEchoLaserScan`, the first echo of each beam is used. NaN and ranges below the minimum become
    -inf, ranges above the maximum +inf.

    Args:
        message: As ROS defines it.
        stamp: When it was taken [s].
        upside_down: Whether the lidar is mounted upside down, so that its left is the robot's right.
        beams: Number of beams of the scan; if another number was measured, each beam is the nearest measured one, over
            the same angle. By default as measured.

    Raises:
        ValueError: It has fewer than two beams, or angles that are not finite.
    """
    ranges = _first_echoes(message.ranges, none=np.inf) * range_unit(message)
    first, step = float(message.angle_min), _step(message)
    if len(ranges) < 2 or not math.isfinite(first) or not 0.0 < abs(step) < math.pi:
        raise ValueError(f"a scan of {len(ranges)} beams from {first:g} rad on, {step:g} rad apart")
    if abs(step) * (len(ranges) - 1) > MAX_FOV:
        raise ValueError(f"a scan over {abs(step) * (len(ranges) - 1):g} rad; angles are in radians")
    nearest, farthest = limits_of(message)
    ranges[~(ranges >= nearest)] = -np.inf
    ranges[ranges >= farthest] = np.inf
    strengths = _first_echoes(message.intensities, none=0.0)
    intensities = np.where(np.isfinite(strengths), strengths, 0.0) if len(strengths) == len(ranges) else None
    if upside_down:
        first, step = -first, -step
    if step < 0.0:
        ranges, first, step = ranges[::-1].copy(), first + step * (len(ranges) - 1), -step
        intensities = None if intensities is None else intensities[::-1].copy()
    scan = Scan(stamp, ranges, first, step, nearest, farthest, intensities)
    return scan if beams in (None, len(ranges)) else _resampled(scan, beams)


def is_clockwise(message: Any, *, upside_down: bool) -> bool:
    """Return whether the beams of a `sensor_msgs/LaserScan` are from left to right of the robot."""
    return (_step(message) < 0.0) != upside_down


def _step(message: Any) -> float:
    """Return the angle between two beams of a message, left positive [rad]."""
    step, count = float(message.angle_increment), len(message.ranges)
    if count < 2 or step:
        return step
    return (float(message.angle_max) - float(message.angle_min)) / (count - 1)


def _resampled(scan: Scan, beams: int) -> Scan:
    """Return a scan over the same angle with another number of beams, each the nearest one that was measured."""
    last = len(scan.ranges) - 1
    nearest = np.rint(np.linspace(0.0, last, beams)).astype(int)
    return replace(
        scan,
        ranges=scan.ranges[nearest],
        angle_increment=scan.angle_increment * last / (beams - 1),
        intensities=None if scan.intensities is None else scan.intensities[nearest],
    )


def _first_echoes(values: Any, *, none: float) -> Array:
    """Return the first echo of each beam, shape (n,)."""
    if len(values) and hasattr(values[0], "echoes"):
        values = [beam.echoes[0] if len(beam.echoes) else none for beam in values]
    return np.asarray(values, dtype=float)


def range_unit(message: Any) -> float:
    """Return the unit of the ranges of a lidar's messages [m]: no lidar in metres has limits like these."""
    nearest, farthest = MILLIMETRES
    return 1e-3 if message.range_min >= nearest and message.range_max >= farthest else 1.0


def limits_of(message: Any) -> tuple[float, float]:
    """Return the minimum and maximum range given in a lidar's messages [m]."""
    unit = range_unit(message)
    nearest, farthest = float(message.range_min) * unit, float(message.range_max) * unit
    nearest = nearest if nearest > 0.0 and math.isfinite(nearest) else MIN_RANGE
    return nearest, farthest if nearest < farthest <= 1e4 else max(MAX_RANGE, 2.0 * nearest)


def imu_of(data: bytes, *, is_ros2: bool) -> tuple[float, ...]:
    """Return the reading of a `sensor_msgs/Imu` in its own frame; NaN for quantities that it declares as not measured.

    Decoded by hand: a bag may have hundreds of these for each scan.

    Args:
        data: The serialised message.
        is_ros2: Whether in CDR.

    Returns:
        Acceleration x, y, z [m/s^2] and turn rate x, y, z [rad/s].

    Raises:
        ValueError: It is truncated, or a number is not finite.

    References:
        ROS REP 145, Conventions for IMU sensor drivers: a first element of -1 in a covariance.
    """
    order = ">" if is_ros2 and data[1:2] == b"\x00" else "<"
    # After the time come the length of the frame's name, the name and, in CDR, the padding to 8 bytes.
    length = int.from_bytes(data[12:16], "big" if order == ">" else "little")
    begin = 16 + length + (-(12 + length) % 8 if is_ros2 else 0)
    if len(data) < begin + IMU_SIZE:
        raise ValueError("a truncated inertial reading")
    numbers = struct.unpack_from(f"{order}37d", data, begin)
    (turned, *_), (felt, *_) = numbers[16:25], numbers[28:37]
    values = *numbers[25:28], *numbers[13:16]
    if not all(map(math.isfinite, values)):
        raise ValueError("an inertial reading that is not a number")
    return (*(NOTHING if felt == UNMEASURED else values[:3]), *(NOTHING if turned == UNMEASURED else values[3:]))


def pose_of(message: Any) -> Array:
    """Return the pose in a message, outer_from_inner, shape (4, 4) [m].

    Types: `nav_msgs/Odometry`, and Pose, PoseStamped, PoseWithCovarianceStamped, TransformStamped of `geometry_msgs`.

    Raises:
        ValueError: It is not a valid pose.
    """
    if hasattr(message, "transform"):
        return matrix_of(message.transform.translation, message.transform.rotation)
    pose = message.pose
    pose = getattr(pose, "pose", pose)
    return matrix_of(pose.position, pose.orientation)


def twist_of(message: Any) -> tuple[float, float, float]:
    """Return forward velocity [m/s], turn rate [rad/s] and velocity to the left [m/s] from a message.

    Types: `nav_msgs/Odometry`, and Twist and TwistStamped of `geometry_msgs`.

    Raises:
        ValueError: They are not finite, or too large.
    """
    twist = getattr(message, "twist", message)
    twist = getattr(twist, "twist", twist)
    values = float(twist.linear.x), float(twist.angular.z), float(twist.linear.y)
    if not all(abs(value) < MAX_SPEED for value in values):
        raise ValueError(f"a twist of {values[0]:g} m/s and {values[1]:g} rad/s")
    return values


def intrinsics_of(message: Any, *, width: int, height: int, rectified: bool) -> Intrinsics | None:
    """Return the calibration in a `sensor_msgs/CameraInfo`; None if it has none.

    Args:
        message: As ROS defines it.
        width: Width of the pictures, which may be smaller than those of the calibration [px].
        height: [px]
        rectified: Whether the pictures are rectified.
    """
    K, P, D = (
        np.asarray(getattr(message, name.lower(), getattr(message, name, ())), dtype=float).ravel() for name in "KPD"
    )
    straight = rectified and P.size == 12 and P[0] > 0.0
    fx, fy, cx, cy = (P[0], P[5], P[2], P[6]) if straight else (K[0], K[4], K[2], K[5])
    if not fx > 0.0 or not fy > 0.0 or not np.isfinite([fx, fy, cx, cy, *D]).all():
        return None
    (left, told_width), (top, told_height) = _sides(message, width, height)
    across, down = ((size / given if given else 1.0) for size, given in ((width, told_width), (height, told_height)))
    fisheye = message.distortion_model in FISHEYES
    bent = D.any() and not rectified and message.distortion_model in (*FISHEYES, *BROWNS)
    distortion = tuple(D[: 4 if fisheye else 8].tolist()) if bent else ()
    if not fisheye and len(distortion) == 8 and not any(distortion[5:]):
        distortion = distortion[:5]
    lens = "pinhole" if not distortion else "fisheye" if fisheye else "brown"
    # Pixel centres are at integers: a picture of half the size starts a quarter of its pixel earlier.
    return Intrinsics(
        width,
        height,
        float(fx * across),
        float(fy * down),
        float((cx - left + 0.5) * across - 0.5),
        float((cy - top + 0.5) * down - 0.5),
        lens,
        distortion,
    )


def unread_lens(message: Any) -> str:
    """Return which part of the lens in a `sensor_msgs/CameraInfo` is not supported, '' if all is."""
    D = np.asarray(getattr(message, "d", getattr(message, "D", ())), dtype=float).ravel()
    if D.any() and message.distortion_model not in (*FISHEYES, *BROWNS):
        known = ", ".join(filter(None, (*BROWNS, *FISHEYES)))
        return f"lens of model '{message.distortion_model[:40]}' taken for a pinhole; supported are {known}"
    return "coefficients after the eighth, of thin prisms and tilted sensors, left out" if D[8:].any() else ""


def _sides(message: Any, width: int, height: int) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return first pixel and number of pixels of the calibrated picture that a picture shows, across and down.

    A camera may send only a region of interest of the calibrated picture, and join its pixels (binning).

    Args:
        message: A `sensor_msgs/CameraInfo`.
        width: Width of the pictures [px].
        height: [px]
    """
    part, whole = message.roi, ((0, int(message.width)), (0, int(message.height)))
    sides = (int(part.x_offset), int(part.width)), (int(part.y_offset), int(part.height))
    joins = max(int(message.binning_x), 1), max(int(message.binning_y), 1)
    fits = [size // join == shown for (_, size), join, shown in zip(sides, joins, (width, height), strict=True)]
    return sides if all(fits) else whole


def assumed_intrinsics(width: int, height: int) -> Intrinsics:
    """Return a calibration for a camera of which only the picture size is known [px]."""
    focal = width / 2.0 / math.tan(ASSUMED_FOV / 2.0)
    return Intrinsics(width, height, focal, focal, (width - 1) / 2.0, (height - 1) / 2.0)
