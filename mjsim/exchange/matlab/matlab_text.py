"""Reads the literal assignments of a MATLAB script: numbers, text, matrices, cells and fields. It runs nothing."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from mjsim.exchange.matlab.matlab_tokens import Token, statements
from mjsim.geometry import Array

MAX_ELEMENTS = 100_000
"""Maximum number of elements of a matrix."""
MAX_DEPTH = 40
"""Maximum nesting of brackets."""
OPENS, CLOSES = {"if", "for", "while", "switch", "try", "do", "parfor"}, {"end", "endif", "endfor", "endwhile", "until"}
QUIET = {"clear", "clc", "close", "format", "more", "warning", "return", "end", "endfunction", "function", "1"}
"""Statements that set nothing."""
CONSTANTS = {"pi": math.pi, "Inf": math.inf, "inf": math.inf, "NaN": math.nan, "nan": math.nan, "true": 1.0}
FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    **{name: getattr(np, name) for name in ("sin", "cos", "tan", "sqrt", "exp", "deg2rad", "rad2deg", "abs")},
    **dict.fromkeys(("double", "single", "int32", "uint8"), lambda value: value),
    "atan2": np.arctan2,
    "zeros": lambda *size: np.zeros(_size(size)),
    "ones": lambda *size: np.ones(_size(size)),
    "eye": lambda *size: np.eye(*_size(size)),
    "diag": lambda value: np.diag(np.ravel(value)) if 1 in np.shape(value) else np.diag(value)[:, None],
    "linspace": lambda a, b, n: np.linspace(_one(a), _one(b), _size((n, 1))[0])[None],
    "struct": lambda *pairs: dict(zip(pairs[::2], pairs[1::2], strict=True)),
}

ELEMENTWISE = {"+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide}


class _NotLiteralError(Exception):
    """A value is not a literal."""


MISTAKES = (_NotLiteralError, ValueError, TypeError, LookupError, ArithmeticError, AttributeError, RecursionError)
"""Exceptions on a statement that is not a literal assignment."""


@dataclass(frozen=True, slots=True)
class Assignments:
    """What a script assigns, and its other statements."""

    values: Mapping[str, Any]
    """Matrices of shape (rows, columns), text, lists of rows (cells), mappings (structs), and lists of mappings."""
    unread: tuple[str, ...]
    """One line for each statement that is no literal assignment, with its line number."""


def read_assignments(text: str) -> Assignments:
    """Return the literal assignments of a script; arithmetic of numbers and of earlier variables counts as literal."""
    values: dict[str, Any] = {}
    unread, open_blocks = [], 0
    for statement in statements(text):
        first, line = statement[0].text, statement[0].line
        open_blocks += (first in OPENS) - (first in CLOSES and open_blocks > 0)
        written = " ".join(token.text for token in statement if token.text != "\n")
        if open_blocks or first in OPENS:
            unread.append(f"line {line}: '{written:.60}' is part of a block; write its values as literals")
        elif first not in QUIET:
            try:
                with np.errstate(all="ignore"):
                    _Statement(statement, values).assign()
            except MISTAKES:
                unread.append(f"line {line}: '{written:.60}' is not a literal assignment")
    return Assignments(values, tuple(unread))


class _Statement:
    """One assignment: a target, and an expression by recursive descent."""

    def __init__(self, tokens: list[Token], values: dict[str, Any]) -> None:
        self._tokens = tokens
        self._values = values
        self._place = 0
        self._depth = 0

    def assign(self) -> None:
        """Store the value of the statement.

        Raises:
            _NotLiteralError: It is no literal assignment.
        """
        name = self._next("name").text
        keys: list[Any] = []
        while not self._at("="):
            keys.append(self._key())
        self._next("op")
        value = self._range()
        if self._place != len(self._tokens):
            raise _NotLiteralError
        self._values[name] = _stored(self._values.get(name), keys, value)

    def _key(self) -> Any:
        """Return a field, or a whole index from 1; -1 for one beyond the end."""
        if self._at("."):
            self._next("op")
            return self._next("name").text
        close = {"(": ")", "{": "}"}.get(self._peek().text)
        if close is None:
            raise _NotLiteralError
        self._next("op")
        if self._at("end"):
            beyond = [self._tokens[self._place + k].text for k in range(3)] == ["end", "+", "1"]
            if not beyond:
                raise _NotLiteralError
            self._place += 3
            index = -1
        else:
            index = _size((self._range(), 1))[0]
        self._expect(close)
        return index

    def _peek(self) -> Token:
        if self._place >= len(self._tokens):
            return Token("end", "", True, 0)
        return self._tokens[self._place]

    def _at(self, *texts: str) -> bool:
        return self._peek().kind in ("op", "end", "name") and self._peek().text in texts

    def _next(self, kind: str) -> Token:
        token = self._peek()
        if token.kind != kind or not token.text:
            raise _NotLiteralError
        self._place += 1
        return token

    def _expect(self, text: str) -> None:
        if not self._at(text):
            raise _NotLiteralError
        self._place += 1

    def _range(self, inside: bool = False) -> Any:
        parts = [self._sum(inside)]
        while self._at(":") and len(parts) < 3:
            self._place += 1
            parts.append(self._sum(inside))
        if len(parts) == 1:
            return parts[0]
        first, *step, last = (_one(part) for part in parts)
        by = step[0] if step else 1.0
        count = math.floor((last - first) / by * (1 + 1e-12)) + 1
        return first + by * np.arange(_size((count, 1))[0])[None]

    def _sum(self, inside: bool) -> Any:
        value = self._product(inside)
        while self._at("+", "-"):
            token, after = self._peek(), self._tokens[self._place + 1 : self._place + 2]
            # In a matrix [1 -2] has two elements, [1 - 2] and [1-2] have one.
            if inside and token.spaced and after and not after[0].spaced:
                break
            self._place += 1
            other = self._product(inside)
            value = _applied(token.text, _number(value), _number(other))
        return value

    def _product(self, inside: bool) -> Any:
        value = self._unary(inside)
        while self._at("*", "/", ".*", "./"):
            operator = self._next("op").text
            other = _number(self._unary(inside))
            value = _applied(operator, _number(value), other)
        return value

    def _unary(self, inside: bool) -> Any:
        if self._at("+", "-"):
            sign = -1.0 if self._next("op").text == "-" else 1.0
            return sign * _number(self._unary(inside))
        value = self._postfix(inside)
        while self._at("^", ".^"):
            operator = self._next("op").text
            value = _powered(operator, _number(value), _one(self._exponent(inside)))
        return value

    def _exponent(self, inside: bool) -> Any:
        """Return an exponent with its signs: of 2^3^2 the first power is taken first."""
        sign = 1.0
        while self._at("+", "-"):
            sign = -sign if self._next("op").text == "-" else sign
        return sign * _number(self._postfix(inside))

    def _postfix(self, inside: bool) -> Any:
        value = self._primary(inside)
        while self._at("'", ".'", ".") and not (inside and self._peek().spaced):
            is_field = self._next("op").text == "."
            value = value[self._next("name").text] if is_field else _transposed(value)
        return value

    def _primary(self, inside: bool) -> Any:
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise _NotLiteralError
        try:
            return self._atom(inside)
        finally:
            self._depth -= 1

    def _atom(self, inside: bool) -> Any:
        token = self._peek()
        self._place += 1
        if token.kind == "number":
            return np.full((1, 1), float(token.text.lower().replace("d", "e")))
        if token.kind == "text":
            return token.text
        if token.kind == "name":
            return self._named(token.text, inside)
        if token.text == "(":
            value = self._range()
            self._expect(")")
            return value
        if token.text in ("[", "{"):
            rows = self._rows("]" if token.text == "[" else "}")
            return _joined(rows) if token.text == "[" else rows
        raise _NotLiteralError

    def _named(self, name: str, inside: bool) -> Any:
        called = self._at("(") and not (inside and self._peek().spaced)
        if name in self._values and not called:
            return self._values[name]
        if name in FUNCTIONS and called:
            self._place += 1
            arguments = []
            while not self._at(")"):
                arguments.append(self._range())
                if self._at(","):
                    self._place += 1
            self._place += 1
            return _matrix(FUNCTIONS[name](*arguments))
        if name == "false" or name in CONSTANTS:
            return np.full((1, 1), CONSTANTS.get(name, 0.0))
        raise _NotLiteralError

    def _rows(self, close: str) -> list[list[Any]]:
        rows: list[list[Any]] = [[]]
        while not self._at(close):
            if self._at(";", "\n"):
                rows.append([])
                self._place += 1
            elif self._at(","):
                self._place += 1
            elif self._place >= len(self._tokens):
                raise _NotLiteralError
            else:
                rows[-1].append(self._range(inside=True))
        self._place += 1
        return [row for row in rows if row]


def _size(size: tuple[Any, ...]) -> tuple[int, int]:
    """Return rows and columns from arguments such as 2, 3 or [2 3].

    Raises:
        _NotLiteralError: They are too many elements, or not whole numbers.
    """
    numbers = [float(each) for part in size for each in np.ravel(part)]
    numbers = numbers * 2 if len(numbers) == 1 else numbers
    if len(numbers) != 2 or not all(each.is_integer() and 0 <= each <= MAX_ELEMENTS for each in numbers):
        raise _NotLiteralError
    if numbers[0] * numbers[1] > MAX_ELEMENTS:
        raise _NotLiteralError
    return int(numbers[0]), int(numbers[1])


def _matrix(value: Any) -> Any:
    return np.atleast_2d(np.asarray(value, dtype=float)) if isinstance(value, np.ndarray | float | int) else value


def _number(value: Any) -> Array:
    if not isinstance(value, np.ndarray):
        raise _NotLiteralError
    return value


def _one(value: Any) -> float:
    return float(_number(_matrix(value)).item())


def _applied(operator: str, left: Array, right: Array) -> Array:
    matrices = operator in "*/" and right.size > 1 and (left.size > 1 or operator == "/")
    shape = (left.shape[0], right.shape[1]) if matrices else np.broadcast_shapes(left.shape, right.shape)
    if (operator == "/" and matrices) or shape[0] * shape[1] > MAX_ELEMENTS:
        raise _NotLiteralError
    if matrices:
        return np.asarray(left @ right)
    return np.asarray(ELEMENTWISE[operator.removeprefix(".")](left, right))


def _powered(operator: str, base: Array, exponent: float) -> Array:
    if operator == "^" and base.size > 1:  # The power of a matrix.
        raise _NotLiteralError
    return np.asarray(base**exponent)


def _transposed(value: Any) -> Any:
    if isinstance(value, list):
        return [list(row) for row in zip(*value, strict=True)]
    return _number(value).T


def _joined(rows: list[list[Any]]) -> Any:
    """Return the matrix of rows of matrices, or text of pieces of text."""
    if len(rows) == 1 and rows[0] and all(isinstance(part, str) for part in rows[0]):
        if sum(map(len, rows[0])) > MAX_ELEMENTS:
            raise _NotLiteralError
        return "".join(rows[0])
    parts = [np.hstack([_number(part) for part in row if _number(part).size or len(row) == 1]) for row in rows]
    whole = np.vstack([part for part in parts if part.size]) if any(part.size for part in parts) else np.zeros((0, 0))
    if whole.size > MAX_ELEMENTS:
        raise _NotLiteralError
    return whole


def _stored(old: Any, keys: list[Any], value: Any) -> Any:
    """Return a variable with a value put at fields and indices in it."""
    if not keys:
        return value
    key, *rest = keys
    if isinstance(key, str):
        fields = dict(old) if isinstance(old, dict) else {}
        return {**fields, key: _stored(fields.get(key), rest, value)}
    items = list(old) if isinstance(old, list) else [] if old is None or np.size(old) == 0 else [old]
    key = len(items) + 1 if key == -1 else key
    if not 1 <= key <= len(items) + 1:
        raise _NotLiteralError
    before = items[key - 1] if key <= len(items) else None
    # A cell is one row of items, a struct array a list of mappings.
    items[key - 1 : key] = [_stored(before, rest, value)]
    return items
