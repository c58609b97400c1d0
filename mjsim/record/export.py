"""Exports recordings to files that other tools read: TUM, CSV, NPZ, MAT and pictures.

Every file is written completely or not at all, and replaces an existing one only with `overwrite`.
"""

import csv
import io
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mjsim.errors import UsageError
from mjsim.geometry import Array, Pose, Pose3, roll_and_pitch
from mjsim.interface import Sighting
from mjsim.output import free_paths, new_file, new_files, require_free, write_files, write_part
from mjsim.record.joint_tables import joint_tables, mechanism_tables
from mjsim.record.parse import FAULTS, unfit
from mjsim.record.readings import CODECS, SensorTable
from mjsim.record.recording import Recording
from mjsim.record.track import Track
from mjsim.sentences import Sentence
from mjsim.spelling import ascii_name
from mjsim.world import event_text

_SUFFIXES = {"jpeg": "jpg"}
"""File suffixes that differ from the name of the picture format."""
_MAX_FIELD_LENGTH = 63
"""Maximum length of a MATLAB name [characters]."""


def export_tum(recording: Recording, folder: str | Path, *, overwrite: bool = False) -> list[Path]:
    """Write `R_truth.tum`, `R_estimate.tum`, `R_odometry.tum`, `R_path.tum` for each robot R, as evo reads them.

    Rows are `t x y z qx qy qz qw` [s, m]. The truth is the 3-D pose of the base. Estimate, odometry and path (the final
    trajectory of an estimator that provides one) are planar, with qz = sin(heading / 2) and qw = cos(heading / 2). A
    robot without a driver has only its truth.

    Returns:
        The files written.

    Raises:
        UsageError: A file exists, or cannot be written, or there are no poses.
    """
    files = {}
    for name, track in recording.robots.items():
        planar = (("estimate", _in_space(track.estimate)), ("odometry", _in_space(track.odometry)))
        online = (
            (kind, np.column_stack([track.moments, poses])) for kind, poses in (("truth", track.truth_pose), *planar)
        )
        path = np.column_stack([track.path[:, 0], _in_space(track.path[:, 1:])])
        for kind, timed in (*online, ("path", path)):
            rows = timed[np.isfinite(timed).all(axis=1)]
            if len(rows):
                text = "".join(f"{' '.join(map(repr, row))}\n" for row in rows.tolist())
                files[f"{name}_{kind}.tum"] = text.encode()
    if not files:
        raise UsageError(Sentence("'{path}' has no poses of robots; nothing is written", recording.path))
    write_files(folder, files, overwrite=overwrite)
    return [Path(folder) / name for name in files]


def _in_space(planar: Array) -> Array:
    """Return poses in the plane, shape (N, 3), as (x, y, z, qx, qy, qz, qw), shape (N, 7)."""
    poses = [Pose3.from_planar(Pose(*row)).as_array() for row in planar.tolist()]
    return np.array(poses, dtype=float).reshape(-1, 7)


def export_csv(recording: Recording, folder: str | Path, *, overwrite: bool = False) -> list[Path]:
    """Write `R_track.csv`, `R_landmarks.csv`, `R_sightings.csv`, `R_innovations.csv`, `R_events.csv` for each robot R.

    There is also a table for each sensor whose readings have one, such as `R_scan_LIDAR.csv`, and for each arm,
    `R_joints_ARM.csv`; for each mechanism M, `M_joints.csv` and, if it has sensors, `M_sensors.csv`; and, unless they
    would be empty, `things.csv` (poses of doors, movers and movable things) and `events.csv` (events of the world).

    `time` is that of the tick, `moment` when the robot was at these poses: in a log, at the scan or picture that came
    with the tick. Numbers are written so that they read back exactly; a missing value is an empty field. The table of
    landmarks has a row for each landmark at each tick at which its mean or covariance changed.

    Returns:
        The files written.

    Raises:
        UsageError: A file exists, or cannot be written, or there is nothing to write.
    """
    tables = list(recording_tables(recording))
    if not tables:
        raise UsageError(
            Sentence("'{path}' has no robots, mechanisms, movable things or events; nothing is written", recording.path)
        )
    paths = free_paths(folder, (f"{name}.csv" for name, _, _ in tables), overwrite=overwrite)
    with new_files(folder, overwrite=overwrite) as parts:
        for path, (_, header, rows) in zip(paths, tables, strict=True):
            write_part(parts / path.name, _table(header, rows))
    return paths


def recording_tables(recording: Recording) -> Iterator[tuple[str, Sequence[str], Iterable[Iterable[Any]]]]:
    """Yield name, header and rows of each table; those of sensors, read from the file, come last for each robot."""
    yield from _world_tables(recording)
    for name, track in recording.robots.items():
        for kind, header, rows in (
            ("track", _TRACK_HEADER, _track_rows(track)),
            ("landmarks", _LANDMARKS_HEADER, _landmark_rows(track)),
            ("sightings", _SIGHTINGS_HEADER, _sighting_rows(track)),
            ("innovations", _INNOVATIONS_HEADER, _innovation_rows(track)),
            ("events", _EVENTS_HEADER, ((e.time, e.kind, e.text, e.bearing) for e in track.events)),
            *([("path", ["time", *_POSE], track.path.tolist())] if len(track.path) else []),
        ):
            yield f"{name}_{kind}", header, rows
        for table in _more_tables(recording, name):
            yield f"{name}_{table.name}", list(table.columns), zip(*table.columns.values(), strict=True)
    for name, tables in mechanism_tables(recording).items():
        for table in tables:
            yield f"{name}_{table.name}", list(table.columns), zip(*table.columns.values(), strict=True)


def _table(header: Sequence[str], rows: Iterable[Iterable[Any]]) -> bytes:
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(header)
    table.writerows(rows)
    return text.getvalue().encode()


def _world_tables(recording: Recording) -> Iterator[tuple[str, list[str], Iterable[Iterable[Any]]]]:
    """Yield name, header and rows of each table of the world that has a row."""
    if recording.things:
        rows = (
            (time, name, *place)
            for name, places in recording.things.items()
            for time, place in zip(recording.time.tolist(), places.tolist(), strict=True)
            if np.isfinite(place).all()
        )
        yield "things", ["time", "name", "x", "y", "heading"], rows
    if recording.events:
        yield "events", ["time", "text"], ((event.time, event_text(event)) for event in recording.events)


def _covariance_header(prefix: str, states: Sequence[str]) -> list[str]:
    return [f"{prefix}_cov_{a}_{b}" for a in states for b in states]


_POSE = ("x", "y", "heading")
_TRACK_HEADER = [
    "time",
    *(f"{kind}_{state}" for kind in ("truth", "odometry", "estimate") for state in _POSE),
    "command_forward",
    "command_left",
    "command_turn",
    *_covariance_header("odometry", _POSE),
    *_covariance_header("estimate", _POSE),
    *("truth_z", "truth_roll", "truth_pitch"),
    "moment",
]
_LANDMARKS_HEADER = ["time", "name", "x", "y", *_covariance_header("landmark", ("x", "y"))]
_SIGHTINGS_HEADER = [
    "time",
    "stamp",
    "name",
    "range",
    "bearing",
    *_covariance_header("sighting", ("range", "bearing")),
    *(f"{axis}{corner}" for corner in range(4) for axis in "uv"),
]
_INNOVATIONS_HEADER = ["time", "name", "nu_0", "nu_1", "S_0_0", "S_0_1", "S_1_0", "S_1_1"]
_EVENTS_HEADER = ["time", "kind", "text", "bearing"]


def _track_rows(track: Track) -> Iterable[list[float | None]]:
    n = len(track.time)
    parts = (
        track.time.reshape(n, 1),
        track.truth,
        track.odometry,
        track.estimate,
        track.command,
        track.odometry_covariance.reshape(n, 9),
        track.covariance.reshape(n, 9),
        track.truth_pose[:, 2:3],
        roll_and_pitch(track.truth_pose[:, 3:]),
        track.moments.reshape(n, 1),
    )
    for row in np.concatenate(parts, axis=1).tolist():
        yield [None if value != value else value for value in row]


def _landmark_rows(track: Track) -> Iterable[list[Any]]:
    marks = track.landmarks
    n, k = marks.mean.shape[:2]
    values = np.concatenate([marks.mean, marks.covariance.reshape(n, k, 4)], axis=2)
    before = np.concatenate([np.full((1, k, 6), np.nan), values[:-1]])
    changed = ((values != before) & ~np.isnan(values)).any(axis=2)
    for tick, mark in np.argwhere(changed).tolist():
        yield [track.time[tick].item(), marks.names[mark], *values[tick, mark].tolist()]


def _sighting_rows(track: Track) -> Iterable[list[Any]]:
    for time, sightings in zip(track.time.tolist(), track.sightings, strict=True):
        for sighting in sightings:
            corners = [None] * 8 if sighting.corners is None else sighting.corners.ravel().tolist()
            covariance = sighting.covariance.ravel().tolist()
            yield [time, sighting.stamp, sighting.name, sighting.range, sighting.bearing, *covariance, *corners]


def _innovation_rows(track: Track) -> Iterable[list[Any]]:
    for time, innovations in zip(track.time.tolist(), track.innovations, strict=True):
        for name, nu, S in innovations:
            yield [time, name, *nu.tolist(), *S.ravel().tolist()]


def export_npz(recording: Recording, file: str | Path, *, overwrite: bool = False) -> Path:
    """Write all arrays into one NumPy file, as 'time', 'qpos', 'qvel', 'seed', 'R/truth', 'R/landmarks/mean' and so on.

    Sightings and innovations are flat: `tick` is the row of `time` that each belongs to.

    Returns:
        The file written.

    Raises:
        UsageError: It exists, or cannot be written.
    """
    require_free(Path(file), overwrite=overwrite, source=recording.path)
    arrays = _arrays_of(recording)
    for name, track in recording.robots.items():
        found = _arrays_of_track(track) | _arrays_of_sensors(recording, name)
        arrays |= {f"{name}/{key}": value for key, value in found.items()}
    for name, tables in mechanism_tables(recording).items():
        arrays |= {f"{name}/{key}": value for key, value in _arrays_of_tables(tables).items()}
    with new_file(file, overwrite=overwrite) as part, part.open("wb") as stream:
        np.savez_compressed(stream, **arrays)
    return Path(file)


def export_mat(recording: Recording, file: str | Path, *, overwrite: bool = False) -> Path:
    """Write all arrays into one MATLAB file: `time`, `qpos`, `qvel`, `seed`, and the struct `robots` of all robots.

    Its fields have the names of `export_npz`: `robots.R.landmarks.mean` and so on; `mechanisms` has the mechanisms, if
    there are any. Characters that MATLAB does not allow in names become underscores; `robots.R.name` is the robot's own
    name.

    Returns:
        The file written.

    Raises:
        UsageError: It exists, or cannot be written.
    """
    from scipy.io import savemat

    require_free(Path(file), overwrite=overwrite, source=recording.path)
    robots: dict[str, Any] = {}
    for name, track in recording.robots.items():
        arrays = _arrays_of_track(track) | _arrays_of_sensors(recording, name)
        robots[_field_name(name, robots)] = _struct(name, arrays)
    mechanisms: dict[str, Any] = {}
    for name, tables in mechanism_tables(recording).items():
        mechanisms[_field_name(name, mechanisms)] = _struct(name, _arrays_of_tables(tables))
    content = _arrays_of(recording) | {"robots": robots} | ({"mechanisms": mechanisms} if mechanisms else {})
    with new_file(file, overwrite=overwrite) as part, part.open("wb") as stream:
        savemat(stream, content, long_field_names=True, do_compression=True, oned_as="column")
    return Path(file)


def _struct(name: str, arrays: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields of a robot or a mechanism, those with a `/` in their names one level down."""
    fields: dict[str, Any] = {"name": name}
    for key, value in arrays.items():
        group, _, field = key.rpartition("/")
        (fields.setdefault(ascii_name(group), {}) if group else fields)[field] = value
    return fields


def _field_name(name: str, taken: Iterable[str]) -> str:
    """Return a valid MATLAB name that is not taken."""
    plain = ascii_name(name)[: _MAX_FIELD_LENGTH - 8]
    if not plain[0].isalpha():
        plain = f"x{plain}"  # as by makeValidName of MATLAB
    number, field = 1, plain
    while field in taken:
        number += 1
        field = f"{plain}_{number}"
    return field


def _arrays_of(recording: Recording) -> dict[str, Any]:
    return {
        "time": recording.time,
        "qpos": recording.qpos,
        "qvel": recording.qvel,
        "seed": np.array(recording.seed, dtype=np.int64),
    }


def _arrays_of_track(track: Track) -> dict[str, Any]:
    sightings = [(tick, seen) for tick, seens in enumerate(track.sightings) for seen in seens]
    innovations = [(tick, *item) for tick, items in enumerate(track.innovations) for item in items]
    return {
        "moment": track.moments,
        "truth": track.truth,
        "truth_pose": track.truth_pose,
        "odometry": track.odometry,
        "odometry_covariance": track.odometry_covariance,
        "estimate": track.estimate,
        "covariance": track.covariance,
        "command": track.command,
        "path": track.path,
        "landmarks/names": _texts(map(str, track.landmarks.names)),
        "landmarks/mean": track.landmarks.mean,
        "landmarks/covariance": track.landmarks.covariance,
        "sightings/tick": np.array([tick for tick, _ in sightings], dtype=np.int64),
        "sightings/stamp": np.array([seen.stamp for _, seen in sightings], dtype=float),
        "sightings/name": _texts(seen.name or "" for _, seen in sightings),
        "sightings/range": np.array([seen.range for _, seen in sightings], dtype=float),
        "sightings/bearing": np.array([seen.bearing for _, seen in sightings], dtype=float),
        "sightings/covariance": _stack([seen.covariance for _, seen in sightings], 2, 2),
        "sightings/corners": _stack([_corners(seen) for _, seen in sightings], 4, 2),
        "innovations/tick": np.array([tick for tick, *_ in innovations], dtype=np.int64),
        "innovations/name": _texts(str(name) for _, name, _, _ in innovations),
        "innovations/nu": _stack([nu for _, _, nu, _ in innovations], 2),
        "innovations/S": _stack([S for _, _, _, S in innovations], 2, 2),
        "events/time": np.array([event.time for event in track.events], dtype=float),
        "events/kind": _texts(event.kind for event in track.events),
        "events/text": _texts(event.text for event in track.events),
    }


def _arrays_of_sensors(recording: Recording, robot: str) -> dict[str, Any]:
    return _arrays_of_tables(_more_tables(recording, robot))


def _arrays_of_tables(tables: Iterable[SensorTable]) -> dict[str, Any]:
    return {f"{table.name}/{key}": values for table in tables for key, values in table.arrays.items()}


def _more_tables(recording: Recording, robot: str) -> list[SensorTable]:
    """Return the tables of a robot's sensors, then those of its joints."""
    return [*sensor_tables(recording, robot), *joint_tables(recording, robot)]


def _texts(words: Iterable[str]) -> Any:
    return np.array(list(words), dtype=np.str_)


def _stack(arrays: Sequence[Array], *shape: int) -> Array:
    return np.array(arrays, dtype=float).reshape(-1, *shape)


def _corners(sighting: Sighting) -> Array:
    return np.full((4, 2), np.nan) if sighting.corners is None else sighting.corners


def export_images(recording: Recording, folder: str | Path, *, overwrite: bool = False) -> int:
    """Write the recorded pictures of each camera as `R/CAMERA/STAMP.jpg`, with the stamp in seconds.

    Returns:
        The number of pictures written.

    Raises:
        UsageError: A file exists, or cannot be written, or there are no pictures.
    """
    folder, count = Path(folder), 0
    for robot, camera in recording.cameras():
        # Otherwise pictures of two runs, taken at different times, would be in one folder.
        if not overwrite and any((folder / robot / camera).glob("*.*")):
            full = "'{folder}' holds pictures; name another folder, or add --overwrite (in Python: overwrite=True)"
            raise UsageError(Sentence(full, folder / robot / camera))
    with new_files(folder, overwrite=overwrite) as parts:
        for robot, camera in recording.cameras():
            for stamp, data, form in recording.pictures(robot, camera):
                # Padded, so that files sort by time.
                write_part(parts / robot / camera / f"{stamp:015.6f}.{_SUFFIXES.get(form, form)}", data)
                count += 1
        if not count:
            missing = "pictures" if recording.cameras() else "camera"
            raise UsageError(Sentence("'{path}' has no {missing}; nothing is written", recording.path, missing))
    return count


def sensor_tables(recording: Recording, robot: str) -> list[SensorTable]:
    """Return a table for each sensor of a robot whose kind of reading has one.

    In each, `time` is when modules received a reading, and `stamp` when it was taken [s].

    Raises:
        RecordingError: Readings of one sensor differ in size.
    """
    exported = [(codec.field, codec.tables) for codec in CODECS if codec.tables is not None]
    given: dict[str, list[tuple[float, Any]]] = {field: [] for field, _ in exported}
    for seen in recording.observations(robot):
        for field, values in given.items():
            if value := getattr(seen, field):
                values.append((seen.time, value))
    try:
        return [table for field, tables in exported for table in tables(given[field])]
    except FAULTS as error:
        raise unfit(f"'{recording.path}': what the sensors of robot '{robot}' gave", error) from error
