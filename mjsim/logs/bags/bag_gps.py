"""Converts fixes of a satellite receiver (`sensor_msgs/NavSatFix`) to poses of a robot, in local metres.

References:
    NIMA TR 8350.2, Department of Defense World Geodetic System 1984, 3rd edition, 2000, section 4.2: a, 1/f, and the
    equations of latitude, longitude and height to Cartesian coordinates.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mjsim.geometry import Array
from mjsim.logs.files import SCATTER, car_poses
from mjsim.logs.resampling import MotionNoise, track_motions

SEMI_MAJOR_AXIS, FLATTENING = 6378137.0, 1.0 / 298.257223563
"""Semi-major axis of the ellipsoid of WGS 84 [m], and its flattening."""
COVARIANCE_UNKNOWN = 0
"""`position_covariance_type` of a fix that does not say how accurate it is."""
NO_NOISE = MotionNoise(distance=0.0, turn=0.0, veer=0.0, aside=0.0)


@dataclass(frozen=True, slots=True)
class Fix:
    """A fix of a receiver."""

    time: float
    """[s]"""
    latitude: float
    """[rad]"""
    longitude: float
    """[rad]"""
    height: float
    """Above the ellipsoid; 0 if the fix has none [m]."""
    deviation: float
    """Standard deviation of east and north, as reported; NaN if it is not [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class GpsPoses:
    """Poses of a robot from fixes."""

    rows: Array
    """Time [s], x (east), y (north) from the first fix [m] and heading [rad], shape (N, 4)."""
    about: str
    """Origin and accuracy, for the metadata."""
    jumped: int
    """Number of fixes left out because they disagree with their neighbours."""


def fix_of(message: Any, time: float) -> Fix:
    """Return the fix in a `sensor_msgs/NavSatFix`.

    Raises:
        ValueError: The receiver had none, or its numbers are not a place on Earth.
    """
    latitude, longitude, height = (float(message.latitude), float(message.longitude), float(message.altitude))
    if message.status.status < 0 or not (abs(latitude) <= 90.0 and abs(longitude) <= 360.0):
        raise ValueError(f"no fix, at latitude {latitude:g} and longitude {longitude:g}")
    variances = np.asarray(message.position_covariance, dtype=float)[[0, 4]]
    known = (
        message.position_covariance_type != COVARIANCE_UNKNOWN
        and np.isfinite(variances).all()
        and variances.min() >= 0.0
    )
    return Fix(
        time,
        math.radians(latitude),
        math.radians(longitude),
        height if math.isfinite(height) else 0.0,
        math.sqrt(float(variances.mean())) if known else math.nan,
    )


def east_north(fixes: Sequence[Fix]) -> Array:
    """Return places in the tangent plane at the first fix: east and north of it, shape (N, 2) [m]."""
    latitude, longitude, height = np.array([(fix.latitude, fix.longitude, fix.height) for fix in fixes]).T
    away = _cartesian(latitude, longitude, height)
    away = away - away[0]
    sin_p, cos_p, sin_l, cos_l = (each(angle[0]) for angle in (latitude, longitude) for each in (np.sin, np.cos))
    ecef_from_local = np.array([[-sin_l, -sin_p * cos_l], [cos_l, -sin_p * sin_l], [0.0, cos_p]])
    return np.asarray(away @ ecef_from_local, dtype=float)


def _cartesian(latitude: Array, longitude: Array, height: Array) -> Array:
    """Return Earth-centred, Earth-fixed places, shape (N, 3) [m]."""
    squared = FLATTENING * (2.0 - FLATTENING)
    radius = SEMI_MAJOR_AXIS / np.sqrt(1.0 - squared * np.sin(latitude) ** 2)
    across = (radius + height) * np.cos(latitude)
    return np.column_stack(
        [across * np.cos(longitude), across * np.sin(longitude), ((1.0 - squared) * radius + height) * np.sin(latitude)]
    )


def gps_poses(fixes: Sequence[Fix], track: Array, antenna: tuple[float, float]) -> GpsPoses:
    """Return the poses of a robot at fixes of its antenna, with headings by odometry as in `car_poses`.

    Args:
        fixes: Fixes of one receiver, in order of time.
        track: Odometry, rows of time [s], x, y [m] and heading [rad], shape (K, 4).
        antenna: Position of the antenna, ahead of the robot's origin and to its left [m].
    """
    # Beyond odometry nothing says how the robot moved.
    known = [fix for fix in fixes if track[0, 0] <= fix.time <= track[-1, 0]]
    if not known:
        return GpsPoses(np.zeros((0, 4)), "", 0)
    times = np.array([fix.time for fix in known])
    reported = [fix.deviation for fix in known if math.isfinite(fix.deviation)]
    accuracy = float(np.median(reported)) if reported else 0.0
    found = car_poses(
        np.column_stack([times, east_north(known)]),
        track_motions(track, times, NO_NOISE),
        antenna,
        scatter=max(SCATTER, accuracy),
    )
    place = [math.degrees(known[0].latitude), math.degrees(known[0].longitude)]
    about = (
        f"x is east and y is north of latitude {place[0]:.9f}, longitude {place[1]:.9f};"
        f" standard deviation {f'{accuracy:.3g} m, as reported' if reported else 'not reported'}"
    )
    return GpsPoses(found.rows, about, found.jumped)
