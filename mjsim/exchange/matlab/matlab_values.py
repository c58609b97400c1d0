"""Values of a MATLAB script: matrices, text, cells as lists of rows, structs as mappings; parts and arithmetic."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from mjsim.geometry import Array

MAX_ELEMENTS = 100_000
"""Maximum number of elements of a matrix."""

WHOLE = -1.0
"""Index of all rows, or columns."""
ELEMENTWISE = {"+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide}


class NotLiteralError(Exception):
    """A value is not a literal."""


def size_of(size: tuple[Any, ...]) -> tuple[int, int]:
    """Return rows and columns from arguments such as 2, 3 or [2 3].

    Raises:
        NotLiteralError: There are too many elements, or they are not whole numbers.
    """
    numbers = [float(each) for part in size for each in np.ravel(part)]
    numbers = numbers * 2 if len(numbers) == 1 else numbers
    if len(numbers) != 2 or not all(each.is_integer() and 0 <= each <= MAX_ELEMENTS for each in numbers):
        raise NotLiteralError
    if numbers[0] * numbers[1] > MAX_ELEMENTS:
        raise NotLiteralError
    return int(numbers[0]), int(numbers[1])


def matrix(value: Any) -> Any:
    """Return an array or a number as a matrix; other values as they are."""
    return np.atleast_2d(np.asarray(value, dtype=float)) if isinstance(value, np.ndarray | float | int) else value


def number(value: Any) -> Array:
    """Return a value that is a matrix; others are not literals."""
    if not isinstance(value, np.ndarray):
        raise NotLiteralError
    return value


def one_of(value: Any) -> float:
    """Return the number of a matrix of one element."""
    return float(number(matrix(value)).item())


def applied(operator: str, left: Array, right: Array) -> Array:
    """Return the result of an operator of arithmetic."""
    matrices = operator in "*/" and right.size > 1 and (left.size > 1 or operator == "/")
    shape = (left.shape[0], right.shape[1]) if matrices else np.broadcast_shapes(left.shape, right.shape)
    if (operator == "/" and matrices) or shape[0] * shape[1] > MAX_ELEMENTS:
        raise NotLiteralError
    if matrices:
        return np.asarray(left @ right)
    return np.asarray(ELEMENTWISE[operator.removeprefix(".")](left, right))


def powered(operator: str, base: Array, exponent: float) -> Array:
    """Return powers of elements."""
    if operator == "^" and base.size > 1:  # The power of a matrix.
        raise NotLiteralError
    return np.asarray(base**exponent)


def transposed(value: Any) -> Any:
    """Return a matrix or a cell with rows for columns."""
    if isinstance(value, list):
        return [list(row) for row in zip(*value, strict=True)]
    return number(value).T


def joined(rows: list[list[Any]]) -> Any:
    """Return the matrix of rows of matrices, or text of pieces of text."""
    if len(rows) == 1 and rows[0] and all(isinstance(part, str) for part in rows[0]):
        if sum(map(len, rows[0])) > MAX_ELEMENTS:
            raise NotLiteralError
        return "".join(rows[0])
    parts = [np.hstack([number(part) for part in row if number(part).size or len(row) == 1]) for row in rows]
    whole = np.vstack([part for part in parts if part.size]) if any(part.size for part in parts) else np.zeros((0, 0))
    if whole.size > MAX_ELEMENTS:
        raise NotLiteralError
    return whole


def stored(old: Any, keys: list[Any], value: Any) -> Any:
    """Return a variable with a value put at fields and indices in it."""
    if not keys:
        return value
    key, *rest = keys
    if isinstance(key, tuple):
        if rest:
            raise NotLiteralError
        return _filled(old, key, number(value))
    if isinstance(key, str):
        fields = dict(old) if isinstance(old, dict) else {}
        return {**fields, key: stored(fields.get(key), rest, value)}
    items = list(old) if isinstance(old, list) else [] if old is None or np.size(old) == 0 else [old]
    if not 1 <= key <= len(items) + 1:
        raise NotLiteralError
    before = items[key - 1] if key <= len(items) else None
    # A cell is one row of items, a struct array a list of mappings.
    items[key - 1 : key] = [stored(before, rest, value)]
    return items


def part_at(value: Any, key: Any) -> Any:
    """Return the value at a key of a variable, None if there is none yet."""
    if isinstance(key, str):
        return value.get(key) if isinstance(value, dict) else None
    return value[key - 1] if isinstance(value, list) and isinstance(key, int) and 1 <= key <= len(value) else None


def _places(index: Array, length: int) -> Any:
    """Return indices from 0; of WHOLE, all below a length."""
    if index.size == 1 and index.item() == WHOLE:
        return np.arange(length)
    places = np.ravel(index)
    if not (places == np.round(places)).all() or (places < 1).any() or places.max(initial=0) > MAX_ELEMENTS:
        raise NotLiteralError
    return places.astype(int) - 1


def chosen(value: Array, places: list[Array]) -> Array:
    """Return elements of a matrix by one index or two."""
    if len(places) == 2:
        return np.asarray(value[np.ix_(_places(places[0], value.shape[0]), _places(places[1], value.shape[1]))])
    if len(places) != 1:
        raise NotLiteralError
    flat = np.ravel(value, order="F")[_places(places[0], value.size)]
    return np.asarray(flat[None] if value.shape[0] == 1 and value.shape[1] > 1 else flat[:, None])


def _filled(old: Any, places: tuple[Array, ...], value: Array) -> Array:
    """Return a matrix with elements set by one index or two; it grows if they are beyond it."""
    grid = old if isinstance(old, np.ndarray) else np.zeros((0, 0))
    if len(places) == 1:
        if 1 not in grid.shape:
            raise NotLiteralError
        one = np.ones((1, 1))
        return _filled(grid, (one, *places) if grid.shape[0] == 1 else (*places, one), value)
    sizes = (value.shape if value.size > 1 else grid.shape) if grid.size else value.shape
    across = [_places(place, max(now, size)) for place, now, size in zip(places, grid.shape, sizes, strict=True)]
    shape = tuple(int(max([*at + 1, now])) for at, now in zip(across, grid.shape, strict=True))
    if shape[0] * shape[1] > MAX_ELEMENTS:
        raise NotLiteralError
    grown = np.zeros(shape)
    grown[: grid.shape[0], : grid.shape[1]] = grid
    grown[np.ix_(*across)] = value if value.size == 1 else value.reshape(tuple(map(len, across)))
    return grown


def _structs(fields: dict[Any, Any]) -> Any:
    """Return a struct; if fields are cells of n values, a list of n structs."""
    cells = {key: [each for row in value for each in row] for key, value in fields.items() if isinstance(value, list)}
    count = max(map(len, cells.values()), default=1)
    items = [{key: cells[key][k if len(cells[key]) > 1 else 0] if key in cells else value
              for key, value in fields.items()} for k in range(count)]  # fmt: skip
    return items[0] if count == 1 else items


def _tiles(value: Array, size: tuple[int, int]) -> tuple[int, int]:
    if size[0] * size[1] * np.size(value) > MAX_ELEMENTS:
        raise NotLiteralError
    return size


FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    **{name: getattr(np, name) for name in ("sin", "cos", "tan", "sqrt", "exp", "deg2rad", "rad2deg", "abs")},
    **dict.fromkeys(("double", "single", "int32", "uint8"), lambda value: value),
    "atan2": np.arctan2,
    "zeros": lambda *size: np.zeros(size_of(size)),
    "ones": lambda *size: np.ones(size_of(size)),
    "eye": lambda *size: np.eye(*size_of(size)),
    "diag": lambda value: np.diag(np.ravel(value)) if 1 in np.shape(value) else np.diag(value)[:, None],
    "linspace": lambda a, b, n: np.linspace(one_of(a), one_of(b), size_of((n, 1))[0])[None],
    "struct": lambda *pairs: _structs(dict(zip(pairs[::2], pairs[1::2], strict=True))),
    "repmat": lambda value, *size: np.tile(value, _tiles(value, size_of(size))),
}
