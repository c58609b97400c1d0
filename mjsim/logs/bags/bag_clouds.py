"""Converts point clouds of ROS, with time, intensity and ring of each point if the driver provides them.

x, y, z: [m]; points that are not finite, or at the origin of the sensor, are left out. intensity, reflectivity or i: as
given by the driver. ring, line or channel: the number of the beam. time, t, offset_time, timestamp or time_stamp: time
of each point, relative to the stamp of the cloud or on its clock; integers are nanoseconds, others seconds, unless
`units_of` finds that a scan would last much shorter or longer than the time to the next one.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.interface import PointCloud
from mjsim.inventory import Fate, told

KINDS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
"""`datatype` of a `sensor_msgs/PointField` -> type of its numbers."""
INTENSITIES, RINGS = ("intensity", "reflectivity", "i"), ("ring", "line", "channel")
TIMES = ("time", "t", "offset_time", "timestamp", "time_stamp")
MAX_TURN = 10.0
"""Maximum duration of a revolution; values farther apart are not times of points [s]."""
SINCE_1970, IN_NANOSECONDS = 1e8, 1e14
"""Stamps above count from 1970; times of points above are in nanoseconds [s, 1]."""
TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
PERIOD = 0.1
"""Time between clouds, if there is only one [s]."""
SCAN_PERIODS, INSTANT_PERIODS = (0.1, 1.5), 0.0015
"""Duration of a scan, in periods; below the second value, all points have one time [1]."""
MAX_REACH, MIN_REACH = 500.0, 0.3
"""Half of the points of a cloud are nearer than the first value; a cloud in millimetres has points beyond the second
[m]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CloudUnits:
    """Units of the clouds of a sensor."""

    time: float | None = None
    """Unit of the times of points, relative to the stamp [s]; None: nanoseconds for integers, else seconds."""
    length: float = 1.0
    """Unit of coordinates [m]."""
    notes: tuple[tuple[str, str], ...] = ()
    """What was guessed or left out, and why, as in the metadata of a recording."""


USUAL = CloudUnits()
"""As ROS defines them."""


def units_of(messages: Iterable[Any]) -> CloudUnits:
    """Return the units of a sensor from some of its clouds; those that `cloud_of` refuses are ignored."""
    clouds = []
    for message in messages:
        try:
            clouds.append((_header_time(message), _rows(message)))
        except ValueError:
            continue
    length, told_length = _length_of([rows for _, rows in clouds])
    time, told_time = _time_unit(clouds)
    found = (("coordinates", told_length), ("times", told_time))
    return CloudUnits(time=time, length=length, notes=tuple((what, why) for what, why in found if why))


def _length_of(clouds: list[NDArray[np.void]]) -> tuple[float, str]:
    """Return the unit of coordinates [m], and a note unless they are numbers in metres."""
    points = [np.column_stack([rows[axis].astype(float) for axis in "xyz"]) for rows in clouds]
    distances = np.abs(np.vstack([np.zeros((0, 3)), *points])).max(axis=1)
    distances = distances[np.isfinite(distances) & (distances > 0.0)]
    if not len(distances):
        return 1.0, ""
    whole, farthest = clouds[0].dtype["x"].kind in "iu", f"{distances.max():.6g}"
    if np.median(distances) > MAX_REACH or (whole and 1e-3 * distances.max() > MIN_REACH):
        return 1e-3, told(Fate.GUESSED, f"mm, not m: the farthest point is at {farthest}")
    return 1.0, told(Fate.GUESSED, f"m, though integers: the farthest point is at {farthest}") if whole else ""


def _time_unit(clouds: list[tuple[float, NDArray[np.void]]]) -> tuple[float | None, str]:
    """Return the unit of the times of points [s] if it is not the usual one, and a note if it is not or there is none.

    Args:
        clouds: Time in the header [s] and points of each.
    """
    name = next(filter(None, (_name_of_times(rows) for _, rows in clouds)), "")
    timed = [(stamp, rows[name]) for stamp, rows in clouds if len(rows) and name in (rows.dtype.names or ())]
    spans = [float(np.ptp(times)) if np.isfinite(times).all() else 0.0 for _, times in timed]
    if not any(spans):
        return None, ""
    (stamp, times), span = timed[int(np.argmax(spans))], max(spans)
    if _on_clock(times, stamp) is not None:
        return None, ""
    steps = np.diff(sorted(stamp for stamp, _ in clouds))
    period = float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else PERIOD
    usual, (shortest, longest) = _usual_unit(times), SCAN_PERIODS
    if INSTANT_PERIODS < span * usual / period <= longest:
        return None, ""
    for unit, scale in TIME_UNITS.items():
        if shortest <= span * scale / period <= longest:
            lasts = f"a scan lasts {span * scale:.3g} s, and the next comes after {period:.3g} s"
            return scale, told(Fate.GUESSED, f"'{name}' in {unit}, so that {lasts}")
    low, high = float(times.min()), float(times.max())
    range_of_times = f"'{name}' goes from {low:.6g} to {high:.6g}; clouds come every {period:.3g} s"
    if max(abs(low), abs(high), span) * usual <= MAX_TURN:
        return None, told(Fate.GUESSED, f"in {'s' if usual == 1.0 else 'ns'}, though {range_of_times}")
    return None, told(Fate.LEFT_OUT, f"{range_of_times}; all points have one time")


def cloud_of(message: Any, stamp: float, *, robot_from_sensor: Array, units: CloudUnits = USUAL) -> PointCloud:
    """Return the cloud of a `sensor_msgs/PointCloud2` along the axes of the robot, its origin in the sensor.

    Args:
        message: As ROS defines it.
        stamp: When its last point was measured [s].
        robot_from_sensor: Its rotation is applied to the points, shape (4, 4).
        units: Units of coordinates and times.

    Raises:
        ValueError: Its data do not match its fields, or it has no x, y and z.
    """
    rows = _rows(message)
    xyz = np.column_stack([rows[axis].astype(float) * units.length for axis in "xyz"])
    back = np.isfinite(xyz).all(axis=1) & xyz.any(axis=1)
    times = _times(rows, _header_time(message), units)
    return PointCloud(
        stamp=stamp,
        points=(xyz[back] @ robot_from_sensor[:3, :3].T).astype(np.float32),
        times=(times[back] - _last(times)).astype(np.float32),
        intensities=_column(rows, INTENSITIES)[back].astype(np.float32),
        rings=np.clip(_column(rows, RINGS)[back], 0, 65535).astype(np.uint16),
    )


def end_of(message: Any, units: CloudUnits = USUAL) -> float:
    """Return the time of the last point of a `sensor_msgs/PointCloud2`, relative to its stamp [s].

    Raises:
        ValueError: As in `cloud_of`.
    """
    return _last(_times(_rows(message), _header_time(message), units))


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


def _name_of_times(rows: NDArray[np.void]) -> str | None:
    return next((name for name in TIMES if name in (rows.dtype.names or ())), None)


def _usual_unit(values: NDArray[Any]) -> float:
    """Return the unit that times of points usually have [s]."""
    return 1e-9 if values.dtype.kind in "iu" or np.abs(values).max() > IN_NANOSECONDS else 1.0


def _on_clock(values: NDArray[Any], stamp: float) -> Array | None:
    """Return times on the clock of the stamp of a cloud, relative to it [s], shape (n,); None if they are not."""
    for unit in TIME_UNITS.values() if stamp > SINCE_1970 else (_usual_unit(values),):
        times = values.astype(float) * unit
        if np.abs(times).max() > MAX_TURN >= np.abs(times - stamp).max():
            return times - stamp
    return None


def _times(rows: NDArray[np.void], stamp: float, units: CloudUnits) -> Array:
    """Return the time of each point, relative to the stamp of its cloud, shape (n,) [s]."""
    name = _name_of_times(rows)
    if name is None or not len(rows):
        return np.zeros(len(rows))
    times = _on_clock(rows[name], stamp)
    if times is None:
        times = rows[name].astype(float) * (units.time or _usual_unit(rows[name]))
    fits = np.isfinite(times).all() and float(np.ptp(times)) <= MAX_TURN and np.abs(times).max() <= MAX_TURN
    return times if fits else np.zeros(len(rows))
