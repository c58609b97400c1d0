"""Tables of MATLAB: their orientation, and their rows as values."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mjsim.errors import UsageError
from mjsim.geometry import Array

Entry = float | str
"""One value of a table: a number, or text in a cell."""


@dataclass(frozen=True, slots=True)
class Tables:
    """How tables of one file are read, and notes on this for the user."""

    file: str
    rows: bool = False
    """Whether a table that fits both ways has an item in each row, instead of each column."""
    told: list[str] = field(default_factory=list)

    def items(self, name: str, value: Any, *, sizes: Sequence[int], columns: str, limit: int) -> list[list[Entry]]:
        """Return the items of a table, each with one of the given numbers of values.

        Args:
            name: The variable.
            value: A matrix, a cell, a struct array, or a struct of vectors.
            sizes: Possible numbers of values of an item, the usual one first.
            columns: What the values are, for messages.
            limit: Maximum number of items.

        Raises:
            UsageError: It is not such a table.
        """
        try:
            table = _entries(value)
        except (ValueError, TypeError, IndexError):  # cells in cells, structs of cells, or nothing in a field
            table = None
        if table is None or not table or not table[0]:
            table = [] if table is not None and not any(table) else None
        wrong = f"'{self.file}' has {name} of {_sides(value)}; it must be {sizes[-1]} x n numbers, {columns}"
        if table is None:
            raise UsageError(wrong)
        if not table:
            return []
        table = _text_last(table)
        high, wide = len(table), len(table[0])
        upright, lying = _fits(table, high, sizes), _fits([*zip(*table, strict=True)], wide, sizes)
        if isinstance(value, Mapping) or (isinstance(value, list) and all(isinstance(item, Mapping) for item in value)):
            # Fields have names, so that each struct is an item.
            upright = False
        if not (upright or lying):
            raise UsageError(wrong)
        by_row = lying and (not upright or self.rows)
        if upright and lying and high > 1 and wide > 1:
            taken, other = ("row", "leave out --rows") if by_row else ("column", "--rows")
            self.told.append(f"{name} is {high} x {wide}: each {taken} is one item; {other} reverses that")
        items = [list(row) for row in (table if by_row else zip(*table, strict=True))]
        if len(items) > limit:
            kind = "rows" if by_row else "columns"
            raise UsageError(f"'{self.file}' has {len(items)} {kind} in {name}; at most {limit} can be read")
        return items

    def points(self, name: str, value: Any, *, limit: int) -> Array:
        """Return a table of x and y as points, shape (n, 2)."""
        items = self.items(name, value, sizes=(2,), columns="x above y", limit=limit)
        return self.finite(name, np.array(items, dtype=float).reshape(-1, 2))

    def finite(self, name: str, values: Array) -> Array:
        """Return the values.

        Raises:
            UsageError: One of them is not finite.
        """
        if not np.isfinite(values).all():
            raise UsageError(f"'{self.file}' has {name} that is not finite")
        return values


def _fits(table: Sequence[Sequence[Entry]], size: int, sizes: Sequence[int]) -> bool:
    """Return whether the items of a table can have this size; text is the last value of an item of four."""
    text = [row for row in table[: size - 1 if size == 4 else size] if any(isinstance(entry, str) for entry in row)]
    return size in sizes and not text


def _text_last(table: list[list[Entry]]) -> list[list[Entry]]:
    """Return a table whose items end with their text; if all begin with text, it is moved to the end."""
    if all(isinstance(entry, str) for entry in table[0]):
        return [*table[1:], table[0]]
    if all(isinstance(row[0], str) for row in table):
        return [[*row[1:], row[0]] for row in table]
    return table


def _entries(value: Any) -> list[list[Entry]] | None:
    """Return a table as rows of values; None if it is not one."""
    if isinstance(value, np.ndarray):
        return [list(row) for row in value.tolist()] if value.dtype.kind in "iuf" and value.ndim == 2 else None
    if isinstance(value, Mapping):
        value = [value] if all(np.size(each) == 1 or isinstance(each, str) for each in value.values()) else value
    if isinstance(value, Mapping):
        columns = [np.ravel(each).tolist() for each in value.values()]
        return _even([list(row) for row in zip(*columns, strict=False)])
    if not isinstance(value, list):
        return None
    if all(isinstance(item, Mapping) for item in value):
        return _even([[_entry(each) for each in item.values()] for item in value])
    rows = [_flat(row if isinstance(row, list) else [row]) for row in value]
    return _even(rows)


def _flat(row: Sequence[Any]) -> list[Entry]:
    """Return the values of a row whose parts may be vectors."""
    return [each for part in row for each in ([part] if isinstance(part, str) else np.ravel(part).tolist())]


def _entry(value: Any) -> Entry:
    return value if isinstance(value, str) else float(np.ravel(value)[0])


def _even(rows: list[list[Entry]]) -> list[list[Entry]] | None:
    return rows if len({len(row) for row in rows}) <= 1 else None


def _sides(value: Any) -> str:
    shape = np.shape(value) if isinstance(value, np.ndarray) else (1,) if isinstance(value, str) else (len(value),)
    widths = {len(row) for row in value if isinstance(row, list)} if isinstance(value, list) else set[int]()
    shape = (*shape, *widths) if len(widths) == 1 else shape
    return " x ".join(map(str, shape))
