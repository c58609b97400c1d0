"""Scans and inertial readings of a recording as tables and arrays, for `export`."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from mjsim.geometry import Array
from mjsim.interface import ImuReading, Scan
from mjsim.record.recording import Recording

SCAN_HEADER = ("time", "stamp", "angle_min", "angle_increment")
IMU_HEADER = ("time", "stamp", *(f"{part}_{axis}" for part in ("acceleration", "turn") for axis in "xyz"))

Timed = tuple[float, Any]
"""When modules were given a reading [s], and the reading."""


def readings_of(recording: Recording, robot: str) -> tuple[dict[str, list[Timed]], dict[str, list[Timed]]]:
    """Return all scans by lidar, and all inertial readings by sensor, each with the time when modules got it."""
    scans: dict[str, list[Timed]] = {}
    imus: dict[str, list[Timed]] = {}
    for seen in recording.observations(robot):
        for name, scan in seen.scans.items():
            scans.setdefault(name, []).append((seen.time, scan))
        for reading in seen.imu:
            imus.setdefault(reading.name, []).append((seen.time, reading))
    return scans, imus


def sensor_tables(recording: Recording, robot: str) -> Iterator[tuple[str, list[str], Iterator[list[float]]]]:
    """Yield a name, a header and rows for each lidar and each inertial sensor of a robot."""
    scans, imus = readings_of(recording, robot)
    for name, readings in scans.items():
        beams = len(readings[0][1].ranges)
        yield f"scan_{name}", [*SCAN_HEADER, *(f"range_{beam}" for beam in range(beams))], map(_scan_row, readings)
    for name, readings in imus.items():
        yield f"imu_{name}", list(IMU_HEADER), map(_imu_row, readings)


def _scan_row(reading: Timed) -> list[float]:
    time, scan = reading[0], reading[1]
    return [time, scan.stamp, scan.angle_min, scan.angle_increment, *scan.ranges.tolist()]


def _imu_row(reading: Timed) -> list[float]:
    time, felt = reading[0], reading[1]
    return [time, felt.stamp, *felt.acceleration.tolist(), *felt.turn.tolist()]


def sensor_arrays(recording: Recording, robot: str) -> dict[str, Any]:
    """Return the arrays of each lidar, as 'scan_NAME/ranges' and so on, and of each inertial sensor, 'imu_NAME/turn'.

    One row a reading; `time` is when modules got it, `stamp` when it was taken [s]. Angles are of each beam [rad].
    """
    scans, imus = readings_of(recording, robot)
    arrays: dict[str, Any] = {}
    for name, readings in scans.items():
        arrays |= {f"scan_{name}/{key}": value for key, value in _scan_arrays(readings).items()}
    for name, readings in imus.items():
        arrays |= {f"imu_{name}/{key}": value for key, value in _imu_arrays(readings).items()}
    return arrays


def _scan_arrays(readings: list[Timed]) -> dict[str, Array]:
    scans: list[Scan] = [scan for _, scan in readings]
    arrays = {
        "time": np.array([time for time, _ in readings]),
        "stamp": np.array([scan.stamp for scan in scans]),
        "ranges": np.array([scan.ranges for scan in scans]),
        "angles": scans[0].angles(),
    }
    if scans[0].intensities is not None:
        arrays["intensities"] = np.array([scan.intensities for scan in scans], dtype=float)
    return arrays


def _imu_arrays(readings: list[Timed]) -> dict[str, Array]:
    felt: list[ImuReading] = [reading for _, reading in readings]
    return {
        "time": np.array([time for time, _ in readings]),
        "stamp": np.array([reading.stamp for reading in felt]),
        "acceleration": np.array([reading.acceleration for reading in felt]),
        "turn": np.array([reading.turn for reading in felt]),
    }
