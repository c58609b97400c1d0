"""Tables of numbers in files beside a world: CSV with a time column."""

import csv
import io
import math
from collections.abc import Iterator, Sequence
from itertools import islice

import numpy as np

from mjsim.errors import did_you_mean
from mjsim.geometry import Array
from mjsim.sentences import Sentence

MAX_BYTES = 20_000_000
MAX_ROWS = 200_000


def read_columns(data: bytes, name: str, columns: Sequence[str | int]) -> Array:
    """Return columns of a table, shape (rows, columns).

    Args:
        data: CSV in UTF-8, separated by commas, semicolons or tabs; a first line of words names the columns; empty
            lines and lines that begin with '#' are ignored.
        name: Name of the file in messages.
        columns: The columns, by name or by number from 1.

    Raises:
        ValueError: It is not such a table; the message gives the line.
    """
    if len(data) > MAX_BYTES:
        raise ValueError(
            Sentence(
                "'{name}' has {size:.0f} MB; a table has at most {max_bytes} MB",
                *(name, len(data) / 1e6, MAX_BYTES // 1_000_000),
            )
        )
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError(Sentence("'{name}' is not UTF-8 text; write a table of numbers (CSV)", name)) from None
    lines = _lines(text)
    first = next(lines, None)
    if first is None:
        raise ValueError(Sentence("'{name}' is empty; write lines such as '0.0, 1.5'", name))
    named = not all(map(_is_number, first[1]))
    places = [_place(column, first[1] if named else None, len(first[1]), name) for column in columns]
    rows = list(islice(lines, MAX_ROWS + 1)) if named else [first, *islice(lines, MAX_ROWS)]
    if len(rows) > MAX_ROWS:
        raise ValueError(Sentence("'{name}' has over {max_rows} lines; a table has at most that many", name, MAX_ROWS))
    if not rows:
        raise ValueError(Sentence("'{name}' has no line of numbers; write lines such as '0.0, 1.5'", name))
    return np.array([[_number(cells, place, f"{name}:{line}") for place in places] for line, cells in rows])


def _lines(text: str) -> Iterator[tuple[int, list[str]]]:
    """Yield number and cells of each non-empty line."""
    head = next((line for line in text.splitlines() if line.strip() and not line.startswith("#")), "")
    separator = next((mark for mark in ("\t", ";", ",") if mark in head), ",")
    for number, line in enumerate(io.StringIO(text), start=1):
        if line.strip() and not line.startswith("#"):
            yield number, [cell.strip() for cell in next(csv.reader([line.rstrip("\r\n")], delimiter=separator), [])]


def _place(column: str | int, names: list[str] | None, count: int, name: str) -> int:
    if isinstance(column, int):
        if not 1 <= column <= count:
            raise ValueError(Sentence("'{name}' has no column {column}; it has {count}", name, column, count))
        return column - 1
    if names is None:
        raise ValueError(
            Sentence("'{name}' does not name its columns; give the number of one, from 1 to {count}", name, count)
        )
    if column not in names:
        raise ValueError(
            Sentence("'{name}' has no column '{column}'{meant}", name, column, did_you_mean(column, names))
        )
    return names.index(column)


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _number(cells: Sequence[str], place: int, line: str) -> float:
    if place >= len(cells):
        raise ValueError(
            Sentence("{line}: the line has {count} columns; it must have {needed} or more", line, len(cells), place + 1)
        )
    if not _is_number(cells[place]) or not math.isfinite(value := float(cells[place])):
        raise ValueError(Sentence("{line}: '{cell:.20}' is not a finite number", line, cells[place]))
    return value
