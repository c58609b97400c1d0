"""Converts point clouds of ROS, with time, intensity and ring of each point if the driver provides them.

x, y, z: [m]; points that are not finite, or at the origin of the sensor, are left out. intensity, reflectivity or i: as
given by the driver. ring, line or channel: the number of the beam. time, t, offset_time, timestamp or time_stamp: time
of each point, relative to the stamp of the cloud or since 1970; integers are nanoseconds, others seconds, or
nanoseconds if they are too large for seconds.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.interface import PointCloud

KINDS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
"""`datatype` of a `sensor_msgs/PointField` -> type of its numbers."""
INTENSITIES, RINGS = ("intensity", "reflectivity", "i"), ("ring", "line", "channel")
TIMES = ("time", "t", "offset_time", "timestamp", "time_stamp")
MAX_TURN = 10.0
"""Maximum duration of a revolution; values farther apart are not times of points [s]."""
SINCE_1970, IN_NANOSECONDS = 1e8, 1e14
"""Times of points above these values count from 1970, in seconds or nanoseconds [s, ns]."""


def cloud_of(message: Any, stamp: float, *, robot_from_sensor: Array) -> PointCloud:
    """Return the cloud of a `sensor_msgs/PointCloud2` along the axes of the robot, its origin in the sensor.

    Args:
        message: As ROS defines it.
        stamp: When its last point was measured [s].
        robot_from_sensor: Its rotation is applied to the points, shape (4, 4).

    Raises:
        ValueError: Its data do not match its fields, or it has no x, y and z.
    """
    rows = _rows(message)
    xyz = np.column_stack([rows[axis].astype(float) for axis in "xyz"])
    back = np.isfinite(xyz).all(axis=1) & xyz.any(axis=1)
    times = _times(rows, _header_time(message))
    return PointCloud(
        stamp=stamp,
        points=(xyz[back] @ robot_from_sensor[:3, :3].T).astype(np.float32),
        times=(times[back] - _last(times)).astype(np.float32),
        intensities=_column(rows, INTENSITIES)[back].astype(np.float32),
        rings=np.clip(_column(rows, RINGS)[back], 0, 65535).astype(np.uint16),
    )


def end_of(message: Any) -> float:
    """Return the time of the last point of a `sensor_msgs/PointCloud2`, relative to its stamp [s].

    Raises:
        ValueError: As in `cloud_of`.
    """
    return _last(_times(_rows(message), _header_time(message)))


def misfit_of_times(message: Any) -> str:
    """Return why times of points of a `sensor_msgs/PointCloud2` are not taken, or ''; errors as in `cloud_of`."""
    rows = _rows(message)
    name = next((name for name in TIMES if name in (rows.dtype.names or ())), None)
    if name is None or not len(rows) or _times(rows, _header_time(message)).any() or not np.ptp(rows[name]) > 0.0:
        return ""
    low, high = float(rows[name].min()), float(rows[name].max())
    return f"{name} goes from {low:.6g} to {high:.6g}, which is not within {MAX_TURN:g} s, in s or ns; all are one"


def _header_time(message: Any) -> float:
    stamp = message.header.stamp
    return float(stamp.sec) + 1e-9 * float(stamp.nanosec)


def _last(times: Array) -> float:
    return float(times.max()) if len(times) else 0.0


def _rows(message: Any) -> NDArray[np.void]:
    """Return one record per point, shape (n,)."""
    order = ">" if message.is_bigendian else "<"
    size, width, height = int(message.point_step), int(message.width), int(message.height)
    known = {field.name: field for field in message.fields if field.datatype in KINDS}
    if not {"x", "y", "z"} <= known.keys():
        raise ValueError(f"a cloud of fields {', '.join(known) or 'without names'}; it needs x, y and z")
    kinds = {name: np.dtype(f"{order}{KINDS[field.datatype]}") for name, field in known.items()}
    step, data = int(message.row_step) or size * width, np.asarray(message.data, dtype=np.uint8)
    ends = [int(field.offset) + kinds[name].itemsize for name, field in known.items()]
    if not max(ends) <= size or step < size * width or len(data) < step * height:
        raise ValueError(f"a cloud of {width} x {height} points of {size} bytes in {len(data)} bytes, {step} per row")
    packed = data[: step * height].reshape(height, step)[:, : size * width]
    layout: Any = {
        "names": list(known),
        "formats": list(kinds.values()),
        "offsets": [int(field.offset) for field in known.values()],
        "itemsize": size,
    }
    rows: NDArray[np.void] = np.frombuffer(packed.tobytes(), dtype=np.dtype(layout))
    return rows


def _column(rows: NDArray[np.void], names: tuple[str, ...]) -> Array:
    """Return the first of some fields that exists, or zeros, shape (n,)."""
    name = next((name for name in names if name in (rows.dtype.names or ())), None)
    if name is None:
        return np.zeros(len(rows))
    values = rows[name].astype(float)
    return np.where(np.isfinite(values), values, 0.0)


def _times(rows: NDArray[np.void], stamp: float) -> Array:
    """Return the time of each point, relative to the stamp of its cloud, shape (n,) [s]."""
    name = next((name for name in TIMES if name in (rows.dtype.names or ())), None)
    if name is None or not len(rows):
        return np.zeros(len(rows))
    values = rows[name].astype(float)
    if rows.dtype[name].kind in "iu" or np.abs(values).max() > IN_NANOSECONDS:
        values = values * 1e-9
    if np.abs(values).max() > SINCE_1970:
        values = values - stamp
    fits = np.isfinite(values).all() and float(np.ptp(values)) <= MAX_TURN and np.abs(values).max() <= MAX_TURN
    return values if fits else np.zeros(len(rows))
