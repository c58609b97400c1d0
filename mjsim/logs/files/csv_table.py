"""Text tables with named columns."""

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from mjsim.errors import MAX_MESSAGE_LENGTH, UsageError, did_you_mean
from mjsim.geometry import Array, headings
from mjsim.logs.files.number_table import NORM_TOLERANCE, is_number
from mjsim.logs.files.text_lines import MAX_NUMBER, left_out_cut, lines_of

DECIMAL = re.compile(r"[-+]?\d*,\d+(e[-+]?\d+)?", re.IGNORECASE)
"""A number with a decimal comma."""
DOTTED_DATE, SLASHED_DATE = re.compile(r"(\d{1,2})\.(\d{1,2})\.(\d{4})(?!\d)"), re.compile(r"\d{4}/\d\d/\d\d(?!\d)")
SPACED_DATE = re.compile(r"\b(\d{4}[-/]\d\d[-/]\d\d|\d{1,2}\.\d{1,2}\.\d{4})\s+(?=\d{1,2}:\d\d)")
"""A date before the time of day, in tables whose columns are separated by white space."""
COMMENTS = ("#", "% ")
"""Beginnings of comments, including those of MATLAB; `rostopic` writes %time before names."""
BLANK_CELLS = ("", "nan", "na", "n/a", "#n/a", "null", "none", "-")
"""Texts that other programs write for missing values."""
SEPARATOR_LINE = re.compile(r"sep=([;,\t|])", re.IGNORECASE)
MAX_SECONDS, MIN_STEP = 1e11, 5e-5
"""Times beyond, in the year 5138, are in a smaller unit than the given one [s]; rows closer than this on average are in
a larger one [s]."""
SEPARATORS = (";", "\t", "|", ",")
"""Column separators, tried in this order before white space. Unless it is a comma, numbers may have decimal commas."""


@dataclass(frozen=True, slots=True, eq=False)
class CsvTable:
    """The words of a table; columns are converted to numbers on request."""

    path: Path
    names: Sequence[str]
    rows: Sequence[Sequence[str]]
    lines: Sequence[int]
    """Line number of each row, counted from 1."""

    def column(self, name: str | int) -> Array:
        """Return the numbers of a column, shape (N,).

        Raises:
            UsageError: The column does not exist, or a value is not a finite number (the message has file and line).
        """
        return self._numbers([self._index(name)])[:, 0]

    def times(self, name: str | int, *, unit: float) -> Array:
        """Return the times of a column, shape (N,) [s].

        Args:
            name: Name of the column.
            unit: Unit of numbers; dates with times, see `instant_of`, count from 1970 [s].

        Raises:
            UsageError: A value is neither (the message has file and line), or they do not fit their unit.
        """
        words = self.words(name)
        if not words or is_number(words[0]):
            times = self.column(name) * unit
            if len(late := np.flatnonzero(np.abs(times) > MAX_SECONDS)):
                problem = f"{self.names[self._index(name)]} is {words[late[0]][:40]}, {times[late[0]]:.3g} s"
                raise UsageError(
                    f"{self.path}:{self.lines[late[0]]}: {problem}; give its time_unit (ms, us or ns)"[
                        :MAX_MESSAGE_LENGTH
                    ]
                )
            span = float(np.ptp(times)) if len(times) else 0.0
            if 0.0 < span < MIN_STEP * len(times):
                problem = f"its {len(times)} rows last {span:.2g} s; give its time_unit (s, ms, us or ns)"
                raise UsageError(f"{self.path}:{self.lines[0]}: {problem}")
            return times
        found = []
        for line, word in zip(self.lines, words, strict=True):
            if (instant := instant_of(word)) is None:
                problem = f"{self.names[self._index(name)]} is {word[:40]!r}; write a number, or 2026-01-31T12:00:00.5"
                raise UsageError(f"{self.path}:{line}: {problem}"[:MAX_MESSAGE_LENGTH])
            found.append(instant)
        return np.array(found)

    def filled(self, names: Sequence[str | int]) -> "CsvTable":
        """Return the rows that have a value in each of some columns; NaN counts as none.

        Raises:
            UsageError: There are none.
        """
        columns = [self._index(name) for name in names]
        kept = [
            k for k, row in enumerate(self.rows) if not any(row[column].lower() in BLANK_CELLS for column in columns)
        ]
        if not kept:
            named = ", ".join(self.names[column] for column in columns)
            raise UsageError(
                f"'{self.path}' holds no row with values of {named}; name other columns"[:MAX_MESSAGE_LENGTH]
            )
        if len(kept) == len(self.rows):
            return self
        return replace(self, rows=[self.rows[k] for k in kept], lines=[self.lines[k] for k in kept])

    def words(self, name: str | int) -> list[str]:
        """Return the words of a column."""
        index = self._index(name)
        return [row[index] for row in self.rows]

    def block(self, first: str | int, *, but: str | int) -> Array:
        """Return the numbers of many columns, shape (N, columns), including infinite values and NaN.

        An empty value becomes NaN.

        Args:
            first: Prefix of their names, or the number of the first one, up to the last column.
            but: A column to leave out.
        """
        left_out = self._index(but)
        if isinstance(first, int):
            indices = list(range(self._index(first), len(self.names)))
        else:
            indices = [index for index, name in enumerate(self.names) if name.startswith(first)]
        indices = [index for index in indices if index != left_out]
        if len(indices) < 2:
            raise UsageError(
                f"'{self.path}' has {len(indices)} columns whose names begin with '{first}'; a scan needs at least 2"
            )
        blank = [["nan" if word.lower() in BLANK_CELLS else word for word in row] for row in self.rows]
        return replace(self, rows=blank)._numbers(indices, finite=False)

    def _index(self, name: str | int) -> int:
        if isinstance(name, int):
            if name > len(self.names):
                raise UsageError(f"'{self.path}' has {len(self.names)} columns; there is no column {name}")
            return name - 1
        if name not in self.names:
            raise UsageError(
                f"no column '{name}' in '{self.path}'{did_you_mean(name, self.names)}"[:MAX_MESSAGE_LENGTH]
            )
        if (count := self.names.count(name)) > 1:
            raise UsageError(
                f"'{self.path}' has {count} columns '{name}'; give its number, from 1"[:MAX_MESSAGE_LENGTH]
            )
        return self.names.index(name)

    def _numbers(self, indices: Sequence[int], *, finite: bool = True) -> Array:
        accepted, right = (_is_finite, "a finite number") if finite else (is_number, "a number")
        for line, row in zip(self.lines, self.rows, strict=True):
            for index in indices:
                if not accepted(row[index]):
                    problem = f"{self.names[index]} is {row[index][:40]!r}; it must be {right}"
                    raise UsageError(f"{self.path}:{line}: {problem}"[:MAX_MESSAGE_LENGTH])
        return np.array([[float(row[index]) for index in indices] for row in self.rows])


def instant_of(word: str) -> float | None:
    """Return the time since 1970 of a date, UTC unless it says otherwise [s]; None for other texts.

    Dates are those of ISO 8601, also with a space or slashes, or `31.01.2026 12:00:00.5`; `01/31/2026` is not, as the
    day may come first.
    """
    if found := DOTTED_DATE.match(word):
        day, month, year = found.groups()
        word = f"{year}-{month:0>2}-{day:0>2}{word[found.end() :]}"
    elif SLASHED_DATE.match(word):
        word = word.replace("/", "-", 2)
    try:
        when = datetime.fromisoformat(word)
    except ValueError:
        return None
    return (when if when.tzinfo else when.replace(tzinfo=UTC)).timestamp()


def read_csv(path: Path, *, skip: int = 0, notes: dict[str, str] | None = None) -> CsvTable:
    """Read a table from a text file, compressed or not; empty lines and those that begin with '#' or '% ' are skipped.

    The first line has the names of the columns, unless it only has numbers; a first comment with as many words as there
    are columns also gives their names. A first line `sep=;`, which spreadsheets write, says what separates columns.

    Args:
        path: The file.
        skip: Number of lines to skip at the beginning.
        notes: Metadata of the log. With it, a truncated file is read up to its end, which is noted.

    Raises:
        UsageError: It cannot be read, has no rows, or rows of different lengths (the message has file and line).
    """
    comment = last = separator_line = ""
    texts: list[str] = []
    lines: list[int] = []
    for number, line in enumerate(lines_of(path, notes), start=1):
        text, last = line.strip().lstrip("\ufeff"), line
        if not text or number <= skip:
            continue
        if not texts and (found := SEPARATOR_LINE.fullmatch(text)):
            separator_line = found[1]
            continue
        if text.startswith(COMMENTS):
            comment = comment if texts else text.lstrip("#% ")
            continue
        texts.append(text)
        lines.append(number)
    if not texts:
        raise UsageError(f"'{path}' holds no rows")
    separator = separator_line or next((mark for mark in SEPARATORS if mark in texts[0]), None)
    try:
        rows = _words(texts, separator)
    except csv.Error as error:
        raise UsageError(f"'{path}' is not a table with the separator '{separator}': {error}") from None
    if len(rows) != len(texts):
        raise UsageError(f"'{path}' has a quotation mark that is not closed in its line")
    names = rows[0]
    if all(is_number(word) or instant_of(word) is not None for word in names):
        given = _words([comment], separator)[0] if comment else []
        names = given if len(given) == len(rows[0]) else [str(k + 1) for k in range(len(rows[0]))]
    else:
        rows, lines = _below_names(path, rows[1:], lines[1:], notes)
    if all(len(row) == len(names) + 1 and not row[-1] for row in rows):
        # Small loggers end each value with the separator, but not each name.
        rows = [row[:-1] for row in rows]
    if len(rows) > 1 and len(rows[-1]) < len(names) and left_out_cut(path, last, notes):
        rows, lines = rows[:-1], lines[:-1]
    _require_columns(path, names, rows, lines)
    return CsvTable(path, names, rows, lines)


def _require_columns(path: Path, names: Sequence[str], rows: Sequence[list[str]], lines: Sequence[int]) -> None:
    """Raise UsageError if there are no rows, or one of another length than the names."""
    for number, row in zip(lines, rows, strict=True):
        if len(row) != len(names):
            hint = "; if its names are in a later line, say how many lines are before them (skip)"
            raise UsageError(
                f"{path}:{number}: {len(row)} values; the table has {len(names)} columns"
                f"{hint if number == lines[0] else ''}"
            )
    if not rows:
        raise UsageError(f"'{path}' holds no rows, only names of columns")


def _below_names(
    path: Path, rows: Sequence[list[str]], lines: list[int], notes: dict[str, str] | None
) -> tuple[list[list[str]], list[int]]:
    """Return the rows below the names of columns and their line numbers, without one of units, which is noted."""
    first, following = (any(map(is_number, row)) for row in rows[:2]) if len(rows) > 1 else (True, True)
    if first or not following or notes is None:
        return list(rows), lines
    notes[f"line of {path.name} below the names of columns left out"] = ", ".join(rows[0])[:MAX_MESSAGE_LENGTH]
    return list(rows[1:]), lines[1:]


def _words(lines: Sequence[str], separator: str | None) -> list[list[str]]:
    if separator == ",":
        return [[word.strip() for word in row] for row in csv.reader(lines, skipinitialspace=True)]
    dated = (SPACED_DATE.sub(r"\1T", line) for line in lines)
    rows = map(str.split, dated) if separator is None else csv.reader(lines, delimiter=separator, skipinitialspace=True)
    return [[_with_point(word.strip()) for word in row] for row in rows]


def _with_point(word: str) -> str:
    """Return a number with its decimal comma replaced by a point, any other word unchanged."""
    return word.replace(",", ".") if DECIMAL.fullmatch(word) else word


def _is_finite(word: str) -> bool:
    return is_number(word) and abs(float(word)) <= MAX_NUMBER


def headings_in(table: CsvTable, names: Sequence[str | int]) -> Array:
    """Return the headings of quaternions, seen from above [rad]."""
    x, y, z, w = (table.column(name) for name in names)
    length = np.sqrt(x * x + y * y + z * z + w * w)
    if len(odd := np.flatnonzero(np.abs(length - 1.0) > NORM_TOLERANCE)):
        line = table.lines[odd[0]]
        raise UsageError(f"{table.path}:{line}: the quaternion has length {length[odd[0]]:.3g}, not 1")
    return headings(np.stack([x, y, z, w], axis=-1))
