"""Strict reader of text files with columns of numbers; errors have the line."""

import math
from collections.abc import Collection, Sequence
from pathlib import Path

import numpy as np

from mjsim.errors import MAX_MESSAGE_LENGTH, UsageError
from mjsim.geometry import Array
from mjsim.logs.files.text_lines import MAX_NUMBER, left_out_cut, lines_of

TIME = "time"
"""Name of the column whose values must not decrease."""
NORM_TOLERANCE = 0.01
"""Tolerance of the norm of a quaternion in a file."""


def read_table(
    path: Path,
    columns: Sequence[str],
    *,
    positive: Collection[str] = (),
    gaps: bool = False,
    notes: dict[str, str] | None = None,
) -> Array:
    """Return the numbers of a file, one row per line, shape (N, columns), N at least 1.

    Numbers are separated by white space or commas. Empty lines, comments after '#' and a first line of names are
    skipped.

    Args:
        path: A text file, compressed or not.
        columns: Name of each column, such as 'range'.
        positive: Columns whose values must be above 0.
        gaps: Whether lines with NaN are left out, as of a tracker that lost its target.
        notes: Metadata of the log. With it, a truncated file is read up to its end, which is noted, as gaps are.

    Raises:
        UsageError: The file cannot be read, is empty, or a line is invalid (the message has file and line).
    """
    rows: list[list[float]] = []
    latest, left_out, is_first = -math.inf, 0, True
    for number, line in enumerate(lines_of(path, notes), start=1):
        words = line.partition("#")[0].replace(",", " ").split()
        if not words:
            continue
        is_named, is_first = is_first and len(words) == len(columns) and not any(map(is_number, words)), False
        if is_named:
            continue
        if gaps and any(word.lower() == "nan" for word in words[1:]):
            left_out += 1
            continue
        try:
            row = _row(words, columns, positive)
            if columns[0] == TIME:
                if row[0] < latest:
                    raise ValueError(f"time is {row[0]:.15g} after {latest:.15g}; lines must be in order of time")
                latest = row[0]
        except ValueError as error:
            if rows and left_out_cut(path, line, notes):
                break
            raise UsageError(f"{path}:{number}: {error}"[:MAX_MESSAGE_LENGTH]) from None
        rows.append(row)
    if not rows:
        raise UsageError(f"'{path}' holds no numbers; each line has {len(columns)}: {', '.join(columns)}")
    if left_out and notes is not None:
        notes[f"lines of {path.name} with NaN left out"] = str(left_out)
    return np.array(rows)


def is_number(word: str) -> bool:
    """Return whether a word is a number, finite or not."""
    try:
        float(word)
    except ValueError:
        return False
    return True


def _row(words: Sequence[str], columns: Sequence[str], positive: Collection[str]) -> list[float]:
    """Return the numbers of a line."""
    if len(words) != len(columns):
        raise ValueError(f"{len(words)} values; a line has {len(columns)}: {', '.join(columns)}")
    row = []
    for word, column in zip(words, columns, strict=True):
        try:
            value = float(word)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise ValueError(f"{column} is {word[:40]!r}; it must be a finite number")
        if abs(value) > MAX_NUMBER:
            raise ValueError(f"{column} is {word[:40]!r}; it must be at most {MAX_NUMBER:g}")
        if column in positive and value <= 0.0:
            raise ValueError(f"{column} is {value:g}; it must be above 0")
        row.append(value)
    return row


def with_unit_quaternions(path: Path, rows: Array) -> Array:
    """Return rows of time [s], x, y, z [m] and quaternion with quaternions normalised, shape (N, 8).

    Args:
        path: The file that they were read from.
        rows: Shape (N, 8).

    Raises:
        UsageError: A quaternion is not a rotation.
    """
    lengths = np.linalg.norm(rows[:, 4:], axis=1)
    if len(odd := np.flatnonzero(np.abs(lengths - 1.0) > NORM_TOLERANCE)):
        raise UsageError(f"'{path}': the quaternion at {rows[odd[0], 0]:.3f} s has length {lengths[odd[0]]:.3g}, not 1")
    return np.column_stack([rows[:, :4], rows[:, 4:] / lengths[:, None]])


def whole_numbers(path: Path, values: Array, column: str) -> list[int]:
    """Return the values of a column of integers, such as barcodes, shape (N,).

    Raises:
        UsageError: One is not an integer.
    """
    odd = values[values != np.rint(values)]
    if len(odd):
        raise UsageError(f"'{path}': {column} is {odd[0]:g}; it must be a whole number")
    return [int(value) for value in values]
