"""Trajectories in tables whose columns have names, in any order, or whose times are dates."""

import re
from collections.abc import Mapping, Sequence
from itertools import islice
from pathlib import Path

import numpy as np

from mjsim.errors import UsageError
from mjsim.geometry import Array
from mjsim.inventory import Fate, told
from mjsim.logs.files import COMMENTS, CsvTable, headings_in, instant_of, is_number, lines_of, read_csv

MAX_HEAD_LINES = 1000
"""Maximum number of lines before the first row."""
UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "m": 1.0, "cm": 1e-2, "mm": 1e-3, "rad": 1.0}
DEGREES = ("deg", "degree", "degrees", "°")
EPOCHS = ((1e18, 1e-9, "ns"), (1e15, 1e-6, "us"), (1e12, 1e-3, "ms"))
"""Times since 1970 of this century in units below a second: smallest value, unit [s], and its name."""
STEPS = ((1e6, 1e-9, "ns"), (1e3, 1e-6, "us"))
"""The same for the time between two poses, which is 1 ms to 1000 s."""
AXIS = r"(t_?|p_?|pos_?|position_?|(.*_)?position_|(.*_)?translation_|p_rs_r_)?{}(_?pos|_?position)?"
TURN = r"(q_?|quat_?|quaternion_?|(.*_)?orientation_|(.*_)?rotation_|(.*_)?quaternion_|q_rs_){}"
ROLES: Mapping[str, Sequence[str]] = {
    "time": (
        r"(.*_)?header_stamp",
        r"t|(time_?)?stamp|date_?time|elapsed|time|(time_)?(secs?|seconds)",
    ),
    **{axis: (axis, AXIS.format(axis)) for axis in "xy"},
    "heading": (r"heading|theta|(.*_)?yaw|th|phi|psi|angle|orientation",),
    **{f"q{axis}": (TURN.format(axis),) for axis in "xyzw"},
}
"""Names of columns, as `_plain` returns them; of two expressions, the first that fits a name counts."""
TURNED = tuple(f"q{axis}" for axis in "xyzw")
ORDERS = {4: ("time", "x", "y", "heading"), 8: ("time", "x", "y", "z", *TURNED)}
"""Roles of columns without names, by their count."""
FULL_TURN = 2.0 * np.pi + 0.01
MIN_AGREEMENT, MAX_AGREEMENT = 0.9, 0.7
"""Agreement of headings with the direction of travel, from 0 to 1: minimum in their unit, maximum in the other one."""


def named_rows(path: Path, notes: dict[str, str]) -> Array | None:
    """Return rows of time [s], x, y [m] and heading [rad], shape (N, 4); None if the file has no names and no dates.

    Args:
        path: A text file.
        notes: Notes on how the file was interpreted, to which this adds.

    Raises:
        UsageError: Columns have names, but a role has none or several, or a value is invalid.
    """
    if not _is_named(path):
        return None
    table = read_csv(path, notes=notes)
    nameless = all(map(is_number, table.names))
    roles = {role: [k] for k, role in enumerate(ORDERS.get(len(table.names), ()))} if nameless else _roles(table.names)
    where = {role: _only(table, role, roles.get(role, [])) for role in ("time", "x", "y")}
    angles = TURNED if any(roles.get(role) for role in TURNED) else ("heading",)
    where |= {role: _only(table, role, roles.get(role, [])) for role in angles}
    kept = table.filled(list(where.values()))
    if left := len(table.rows) - len(kept.rows):
        notes["rows without a pose left out"] = str(left)
    names = ", ".join(f"{role} = {table.names[column - 1]}" for role, column in where.items())
    notes["columns of the trajectory"] = told(Fate.KEPT, names)
    places = [kept.column(where[axis]) * _unit(kept, where[axis]) for axis in "xy"]
    turned = (
        _in_radians(kept, where["heading"], places, notes)
        if angles == ("heading",)
        else headings_in(kept, [where[role] for role in TURNED])
    )
    return np.column_stack([_times(kept, where["time"], notes), *places, turned])


def in_seconds(times: Array, notes: dict[str, str]) -> Array:
    """Return times [s], which may be in us or ns, since 1970 also in ms."""
    for smallest, unit, name in EPOCHS:
        if len(times) and times[0] >= smallest:
            notes["times of the trajectory"] = told(Fate.GUESSED, f"in {name} since 1970, by their size")
            return times * unit
    step = float(np.median(np.diff(np.sort(times)))) if len(times) > 1 else 0.0
    for smallest, unit, name in STEPS:
        if step >= smallest:
            notes["times of the trajectory"] = told(Fate.GUESSED, f"in {name}, by a step of {step:g}")
            return times * unit
    return times


def _is_named(path: Path) -> bool:
    """Return whether the first row has names or a date, or the last comment above it has names."""
    comment = ""
    for line in islice(lines_of(path, {}), MAX_HEAD_LINES):
        text = line.strip()
        if text.startswith(COMMENTS):
            comment = text.lstrip("#% ")
        elif text:
            words = _words(text)
            if all(map(is_number, words)):
                return _has_names(_words(comment)) and len(_words(comment)) == len(words)
            return _has_names(words) or instant_of(words[0]) is not None
    return False


def _words(text: str) -> list[str]:
    mark = next((mark for mark in ";\t|," if mark in text), None)
    return [word.strip().strip('"') for word in text.split(mark)] if text.strip() else []


def _has_names(words: Sequence[str]) -> bool:
    roles = _roles(words)
    return all(roles[role] for role in ("time", "x", "y"))


def _roles(names: Sequence[str]) -> dict[str, list[int]]:
    """Return the columns that may have each role."""
    plain = [_plain(name)[0] for name in names]
    fits = {
        role: [[k for k, name in enumerate(plain) if re.fullmatch(one, name)] for one in expressions]
        for role, expressions in ROLES.items()
    }
    return {role: next(filter(None, columns), []) for role, columns in fits.items()}


def _plain(name: str) -> tuple[str, str]:
    """Return a name in lower case with '_' between its words, and its unit or ''."""
    words = [word for word in re.split(r"[^a-z0-9°]+", name.lower()) if word]
    unit = words.pop() if len(words) > 1 and words[-1] in (*UNITS, *DEGREES) else ""
    return "_".join(words), unit


def _only(table: CsvTable, role: str, columns: Sequence[int]) -> int:
    """Return the number of the column that has a role, from 1."""
    if len(columns) == 1:
        return columns[0] + 1
    names = ", ".join(f"'{table.names[k]:.40}'" for k in columns or range(len(table.names)))
    problem = (
        f"{len(columns)} columns may be {role} ({names:.200})" if columns else f"no column is {role} among {names:.200}"
    )
    raise UsageError(f"'{table.path}': {problem}; name the columns time, x, y, and heading or qx, qy, qz, qw")


def _unit(table: CsvTable, column: int) -> float:
    return UNITS.get(_plain(table.names[column - 1])[1], 1.0)


def _times(table: CsvTable, column: int, notes: dict[str, str]) -> Array:
    unit = _plain(table.names[column - 1])[1]
    if not is_number(table.words(column)[0]):
        notes["dates of the trajectory"] = told(Fate.GUESSED, "in UTC, unless they say otherwise")
        return table.times(column, unit=1.0)
    return table.column(column) * UNITS[unit] if unit in UNITS else in_seconds(table.column(column), notes)


def _in_radians(table: CsvTable, column: int, places: Sequence[Array], notes: dict[str, str]) -> Array:
    """Return headings [rad]; without a unit, those beyond a turn are in the one that fits the direction of travel."""
    angles, name = table.column(column), table.names[column - 1]
    unit = _plain(name)[1]
    if unit in DEGREES:
        return np.radians(angles)
    if unit or not np.abs(angles).max() > FULL_TURN:
        return angles
    steps = np.diff(np.stack(places), axis=1)
    agreement = {
        each: float(np.abs(np.mean(np.exp(1j * (np.arctan2(*steps[::-1]) - scale * angles[:-1]))[steps.any(axis=0)])))
        for each, scale in (("rad", 1.0), ("deg", np.pi / 180.0))
        if steps.any()
    }
    ranked = sorted(agreement, key=lambda each: agreement[each])
    if not ranked or agreement[ranked[1]] < MIN_AGREEMENT or agreement[ranked[0]] > MAX_AGREEMENT:
        problem = f"{name:.40} goes to {np.abs(angles).max():.4g} without a unit"
        raise UsageError(f"'{table.path}': {problem}; name it heading_deg or heading_rad")
    notes["headings of the trajectory"] = told(Fate.GUESSED, f"in {ranked[1]}, as the poses move in their direction")
    return np.radians(angles) if ranked[1] == "deg" else angles
