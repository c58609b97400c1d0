"""The user's own tables, described by a small YAML file: which file and column contains what.

    log: tables
    odometry: {file: odometry.csv, time: t, x: x, y: y, heading_deg: yaw}
    scans: [{file: scan.csv, time: t, ranges: r_, from_deg: -90, step_deg: 0.5, range: [0.05, 20]}]
    truth: {file: truth.csv, time: t, x: x, y: y, heading: theta}

Paths start from the YAML file. The first line of a table has the names of the columns, which are separated by commas,
semicolons, tabs or spaces. In a table without names, columns are called 1, 2 and so on.
"""

import math
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from mjsim.errors import UsageError
from mjsim.geometry import Array
from mjsim.interface import ImuReading, Scan, Sighting
from mjsim.inventory import Fate, told
from mjsim.logs.files import CsvTable, headings_in, lies_in, lines_of, read_csv
from mjsim.logs.formats.description import (
    LENGTHS,
    OURS,
    UNITS,
    AngledColumns,
    Description,
    Inertial,
    Marks,
    Poses,
    Scans,
    Sightings,
    TimedColumns,
    Twists,
)
from mjsim.logs.resampling import MOTION, Log, RobotLog, Wishes, kept
from mjsim.world import read_described


def is_description(path: Path) -> bool:
    """Return whether a file describes the tables of a log."""
    if path.suffix.lower() not in (".yaml", ".yml") or not path.is_file():
        return False
    return any(OURS.match(line) for line in lines_of(path))


def read_columns(path: Path, wishes: Wishes) -> Log:
    """Read the log described by a file.

    Raises:
        WorldError: The description is wrong.
        UsageError: A table does not exist or differs from its description (the message has file and line).
    """
    description = read_described(path, Description)
    notes: dict[str, str] = {}
    tables = _Tables(path.parent, UNITS[description.time_unit], LENGTHS[description.length_unit], notes)
    noise = description.noise
    motion = type(MOTION)(distance=noise.distance, turn=noise.turn, veer=noise.veer)
    deviations = wishes.sighting_over(noise.range, math.radians(noise.bearing_deg))
    sightings, names = tables.sightings(description.sightings, deviations)
    scans = description.scans
    if len({scan.name for scan in scans}) < len(scans):
        raise UsageError(f"'{path}': two lidars have the same name; give each its own")
    robot = RobotLog(
        twists=tables.twists(description.twist),
        track=tables.poses(description.odometry),
        sightings=sightings,
        identities=names,
        scans={scan.name: kept(tables.scans(scan)) for scan in scans},
        imu=tables.imu(description.imu),
        truth=tables.poses(description.truth),
        gap=description.gap,
    )
    return Log(
        kind="tables",
        robot=robot,
        mounts={scan.name: scan.mount() for scan in scans},
        landmarks=tables.landmarks(description.landmarks),
        motion=motion,
        sighting=(noise.range, math.radians(noise.bearing_deg)),
        notes=notes,
    )


class _Tables:
    """The tables beside a description."""

    def __init__(self, folder: Path, second: float, metre: float, notes: dict[str, str]) -> None:
        self._folder, self._second, self._metre, self._notes = folder, second, metre, notes
        self._read: dict[tuple[str, int], CsvTable] = {}

    def poses(self, columns: Poses | None) -> Array | None:
        """Return rows of time, x, y and heading, shape (N, 4)."""
        if columns is None:
            return None
        headed = [columns.heading, columns.heading_deg, *(columns.quaternion or ())]
        table = self._filled(columns, columns.x, columns.y, *headed)
        turned = (
            _angle(table, columns, "heading") if columns.quaternion is None else headings_in(table, columns.quaternion)
        )
        return self._rows(columns, table, *self._lengths(table, columns.x, columns.y), turned)

    def twists(self, columns: Twists | None) -> Array:
        """Return rows of time, forward, turn and, if it is given, left, shape (N, 3 or 4)."""
        if columns is None:
            return np.zeros((0, 3))
        table = self._filled(columns, columns.forward, columns.left, columns.turn, columns.turn_deg)
        lateral = [] if columns.left is None else self._lengths(table, columns.left)
        return self._rows(
            columns, table, *self._lengths(table, columns.forward), _angle(table, columns, "turn"), *lateral
        )

    def sightings(
        self, spec: Sightings | None, deviations: tuple[float, float]
    ) -> tuple[list[Sighting], Sequence[str | None] | None]:
        """Return sightings in order of time, and the landmark of each; None for an empty name."""
        if spec is None:
            return [], None
        table = self._filled(spec, spec.range, spec.bearing, spec.bearing_deg)
        names = None if spec.name is None else [(word and _plain(word)) or None for word in table.words(spec.name)]
        columns = self._times(spec, table), *self._lengths(table, spec.range), _angle(table, spec, "bearing")
        if len(bad := np.flatnonzero(columns[1] <= 0.0)):
            line = table.lines[bad[0]]
            raise UsageError(f"{table.path}:{line}: a range is {columns[1][bad[0]]:g} m; it must be above 0")
        rows = np.column_stack(columns).tolist()
        covariance = np.diag(np.square(deviations))
        order = sorted(range(len(rows)), key=lambda k: rows[k][0])
        seen = [
            Sighting(rows[k][0], None if names is None else names[k], rows[k][1], rows[k][2], covariance) for k in order
        ]
        return seen, None if names is None else [names[k] for k in order]

    def scans(self, columns: Scans) -> list[Scan]:
        """Return scans in order of time, without duplicate times."""
        table = self._table(columns)
        nearest, farthest = columns.range
        ranges = table.block(columns.ranges, but=columns.time) * self._metre
        ranges[~(ranges >= nearest)] = -np.inf
        ranges[ranges >= farthest] = np.inf
        first, step = math.radians(columns.from_deg), math.radians(columns.step_deg)
        if step < 0.0:
            ranges, first, step = ranges[:, ::-1], first + step * (ranges.shape[1] - 1), -step
        times = self._times(columns, table)
        _, unique = np.unique(times, return_index=True)
        return [Scan(float(times[k]), ranges[k].copy(), first, step, nearest, farthest) for k in unique]

    def imu(self, spec: Inertial | None) -> list[ImuReading]:
        """Return inertial readings in order of time."""
        if spec is None:
            return []
        table = self._filled(spec, *spec.acceleration, *(spec.turn or spec.turn_deg or ()))
        turn, unit = (spec.turn, 1.0) if spec.turn is not None else (spec.turn_deg or (), math.pi / 180.0)
        columns = [table.column(name) for name in spec.acceleration] + [unit * table.column(name) for name in turn]
        rows = self._rows(spec, table, *columns)
        return [ImuReading(float(row[0]), row[1:4].copy(), row[4:7].copy()) for row in rows]

    def landmarks(self, columns: Marks | None) -> dict[str, tuple[float, float]]:
        """Return landmark name -> position [m]."""
        if columns is None:
            return {}
        table = self._table(columns)
        names, (x, y) = table.words(columns.name), self._lengths(table, columns.x, columns.y)
        places: dict[str, tuple[float, float]] = {}
        for k, (line, word) in enumerate(zip(table.lines, names, strict=True)):
            name = _plain(word)
            if not word:
                raise UsageError(f"{table.path}:{line}: a landmark has no name; give it one, or leave the line out")
            if name in places:
                raise UsageError(f"{table.path}:{line}: landmark '{name}' has two positions; each must have one line")
            places[name] = float(x[k]), float(y[k])
        return places

    def _table(self, spec: TimedColumns | Marks) -> CsvTable:
        key = spec.file, spec.skip
        if key not in self._read:
            path = self._folder / spec.file
            if not lies_in(path, self._folder):
                raise UsageError(f"'{spec.file}' is outside the folder of the description; put the table beside it")
            self._read[key] = read_csv(path, skip=spec.skip, notes=self._notes)
        return self._read[key]

    def _filled(self, spec: TimedColumns, *names: str | int | None) -> CsvTable:
        """Return the rows of a table with a time and a value in each of some columns; others are noted."""
        table = self._table(spec)
        needed = [spec.time, *(name for name in names if name is not None)]
        kept = table.filled(needed)
        if left := len(table.rows) - len(kept.rows):
            self._notes[f"rows of {spec.file} without {', '.join(map(str, needed))} left out"] = str(left)
        return kept

    def _lengths(self, table: CsvTable, *names: str | int) -> list[Array]:
        """Return columns of lengths [m] or velocities [m/s]."""
        return [table.column(name) * self._metre for name in names]

    def _times(self, spec: TimedColumns, table: CsvTable) -> Array:
        times = table.times(spec.time, unit=self._second)
        if back := int(np.count_nonzero(np.diff(times) < 0.0)):
            self._notes[f"clock of {spec.file}"] = told(
                Fate.MENDED, f"set back {back} times; the rows are sorted by time"
            )
        return times

    def _rows(self, spec: TimedColumns, table: CsvTable, *columns: Array) -> Array:
        rows = np.column_stack([self._times(spec, table), *columns])
        return np.asarray(rows[np.argsort(rows[:, 0], kind="stable")])


def _angle(table: CsvTable, spec: AngledColumns, name: str) -> Array:
    """Return a column of angles [rad]."""
    radians = getattr(spec, name)
    return table.column(radians) if radians is not None else np.radians(table.column(getattr(spec, f"{name}_deg")))


def _plain(name: str) -> str:
    """Return the name of a landmark, with characters that a world does not allow replaced by '_'."""
    word = re.sub(r"[^A-Za-z0-9_.-]", "_", name)
    return f"_{word}" if word.startswith((".", "-")) else word
