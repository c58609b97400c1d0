"""Joints of arms, wheels of balancing bases, and mechanisms, as tables and arrays for `export`."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from mjsim.geometry import Array
from mjsim.record.joint_messages import JointTrack
from mjsim.record.readings import SensorTable
from mjsim.record.recording import Recording

NAMES = {"positions": "q", "velocities": "qd", "accelerations": "qdd", "torques": "tau", "goal": "goal"}
"""Attribute of a track -> usual symbol."""
TOOL = ("x", "y", "z", "qx", "qy", "qz", "qw")


def joint_tables(recording: Recording, robot: str) -> list[SensorTable]:
    """Return a table for each arm of a robot, `joints_ARM`, and for the wheels of a balancing base, `joints_drive`.

    A row is a tick. Columns are `joint1_q`, `joint1_qd`, `joint1_qdd`, `joint1_tau`, `joint1_goal` and so on [rad, N m;
    m, N for prismatic joints], then the pose of an arm's tool in the world: `tool_x` to `tool_qw` [m, unit quaternion].
    Arrays are `time`, `names`, `q`, `qd`, `qdd`, `tau` and `goal`, shape (N, joints), `tool` (N, 7) and `T` (N, 4, 4).
    """
    return [
        _table(f"joints_{name.partition('/')[2]}", recording.time, track)
        for name, track in recording.joints.items()
        if name.partition("/")[0] == robot and "/" in name
    ]


def mechanism_tables(recording: Recording) -> dict[str, list[SensorTable]]:
    """Return the tables of each mechanism: `joints`, as those of an arm, and `sensors` with a column for each value.

    Arrays of sensors are `time`, `names`, `units`, and `values`, shape (N, names).
    """
    tables: dict[str, list[SensorTable]] = {}
    for name, track in recording.joints.items():
        if "/" not in name:
            tables.setdefault(name, []).append(_table("joints", recording.time, track))
    for name, read in recording.readings.items():
        columns: dict[str, Iterable[Any]] = {"time": recording.time.tolist()}
        columns |= {each: _fields(values) for each, values in zip(read.names, read.values.T, strict=True)}
        names = {key: np.array(words, dtype=np.str_) for key, words in (("names", read.names), ("units", read.units))}
        arrays: dict[str, Any] = {"time": recording.time, **names, "values": read.values}
        tables.setdefault(name, []).append(SensorTable(name="sensors", columns=columns, arrays=arrays))
    return tables


def _table(name: str, time: Array, track: JointTrack) -> SensorTable:
    values = {short: getattr(track, key) for key, short in NAMES.items()}
    columns: dict[str, Iterable[Any]] = {"time": time.tolist()}
    for number, joint in enumerate(track.names):
        columns |= {f"{joint}_{short}": _fields(array[:, number]) for short, array in values.items()}
    arrays = {"time": time, "names": np.array(track.names, dtype=np.str_), **values}
    if np.isfinite(track.tool).any():
        columns |= {f"tool_{key}": _fields(column) for key, column in zip(TOOL, track.tool.T, strict=True)}
        arrays |= {"tool": track.tool, "T": _matrices(track.tool)}
    return SensorTable(name=name, columns=columns, arrays=arrays)


def _fields(column: Array) -> list[float | None]:
    return [None if value != value else value for value in column.tolist()]


def _matrices(poses: Array) -> Array:
    """Return poses (x, y, z, qx, qy, qz, qw), shape (N, 7), as homogeneous transforms, shape (N, 4, 4)."""
    x, y, z, w = poses[:, 3:].T
    T = np.zeros((len(poses), 4, 4))
    T[:, 0, :3] = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], axis=1)
    T[:, 1, :3] = np.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)], axis=1)
    T[:, 2, :3] = np.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], axis=1)
    T[:, :3, 3], T[:, 3, 3] = poses[:, :3], 1.0
    return T
