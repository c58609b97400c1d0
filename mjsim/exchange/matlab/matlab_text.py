"""Reads the literal assignments of a MATLAB script: numbers, text, matrices, cells and fields. It runs nothing."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from mjsim.exchange.matlab.matlab_tokens import Token, statements
from mjsim.exchange.matlab.matlab_values import (
    FUNCTIONS,
    WHOLE,
    NotLiteralError,
    applied,
    chosen,
    joined,
    matrix,
    number,
    one_of,
    part_at,
    powered,
    size_of,
    stored,
    transposed,
)
from mjsim.geometry import Array

MAX_DEPTH = 40
"""Maximum nesting of brackets."""
OPENS, CLOSES = {"if", "for", "while", "switch", "try", "do", "parfor"}, {"end", "endif", "endfor", "endwhile", "until"}
DEFAULTS = {"nargin", "exist"}
QUIET = {"clear", "clc", "close", "format", "more", "warning", "return", "end", "endfunction", "function", "1"}
"""Statements that set nothing."""
CONSTANTS = {"pi": math.pi, "Inf": math.inf, "inf": math.inf, "NaN": math.nan, "nan": math.nan, "true": 1.0}
MISTAKES = (NotLiteralError, ValueError, TypeError, LookupError, ArithmeticError, AttributeError, RecursionError)
"""Exceptions on a statement that is not a literal assignment."""


@dataclass(frozen=True, slots=True)
class Assignments:
    """What a script assigns, and its other statements."""

    values: Mapping[str, Any]
    """Matrices of shape (rows, columns), text, lists of rows (cells), mappings (structs), and lists of mappings."""
    unread: tuple[str, ...]
    """One line for each statement other than a literal assignment, with its line number."""


def read_assignments(text: str) -> Assignments:
    """Return the literal assignments of a script; arithmetic of numbers and of earlier variables counts as literal."""
    values: dict[str, Any] = {}
    unread, open_blocks = [], 0
    for statement in statements(text):
        first, line = statement[0].text, statement[0].line
        if first == "if" and any(token.text in DEFAULTS for token in statement):
            # Defaults for missing arguments of a function; here all are missing.
            continue
        open_blocks += (first in OPENS or first == "else") - (first in CLOSES and open_blocks > 0)
        written = " ".join(token.text for token in statement if token.text != "\n")
        if open_blocks or first in OPENS or first == "else":
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
        self._ends: list[int] = []

    def assign(self) -> None:
        """Store the value of the statement.

        Raises:
            NotLiteralError: It is not a literal assignment.
        """
        name = self._next("name").text
        keys: list[Any] = []
        inner = self._values.get(name)
        while not self._at("="):
            keys.append(self._key(inner))
            inner = part_at(inner, keys[-1])
        self._next("op")
        value = self._range()
        if self._place != len(self._tokens):
            raise NotLiteralError
        self._values[name] = stored(self._values.get(name), keys, value)

    def _key(self, value: Any) -> Any:
        """Return a field, a whole index of a list from 1, or the indices of a matrix, given its value."""
        if self._at("."):
            self._next("op")
            return self._next("name").text
        close = {"(": ")", "{": "}"}.get(self._peek().text)
        if close is None:
            raise NotLiteralError
        is_matrix = isinstance(value, np.ndarray) and value.size > 0 and close == ")"
        places = self._indices(value, close)
        if len(places) == 1 and not is_matrix:
            return size_of((places[0], 1))[0]
        return tuple(places)

    def _indices(self, value: Any, close: str) -> list[Array]:
        """Return the indices in brackets, from 1; `end` and `:` refer to the value."""
        self._next("op")
        count = self._commas(close) + 1
        shape = (np.shape(value) or (0, 0)) if not isinstance(value, list) else (len(value), 1)
        shape = shape if len(shape) == 2 else (0, 0)
        found = []
        for k in range(count):
            self._ends.append(shape[k] if count == 2 else shape[0] * shape[1])
            if self._at(":"):
                self._place += 1
                found.append(np.full((1, 1), WHOLE))
            else:
                found.append(number(matrix(self._range())))
            self._ends.pop()
            self._expect("," if k < count - 1 else close)
        return found

    def _commas(self, close: str) -> int:
        """Return the number of commas up to a bracket that closes."""
        depth, commas = 0, 0
        for token in self._tokens[self._place :]:
            if depth == 0 and token.text == close:
                return commas
            depth += (token.text in "([{" and token.kind == "op") - (token.text in ")]}" and token.kind == "op")
            commas += depth == 0 and token.text == ","
        raise NotLiteralError

    def _peek(self) -> Token:
        if self._place >= len(self._tokens):
            return Token("end", "", True, 0)
        return self._tokens[self._place]

    def _at(self, *texts: str) -> bool:
        return self._peek().kind in ("op", "end", "name") and self._peek().text in texts

    def _next(self, kind: str) -> Token:
        token = self._peek()
        if token.kind != kind or not token.text:
            raise NotLiteralError
        self._place += 1
        return token

    def _expect(self, text: str) -> None:
        if not self._at(text):
            raise NotLiteralError
        self._place += 1

    def _range(self, inside: bool = False) -> Any:
        parts = [self._sum(inside)]
        while self._at(":") and len(parts) < 3:
            self._place += 1
            parts.append(self._sum(inside))
        if len(parts) == 1:
            return parts[0]
        first, *step, last = (one_of(part) for part in parts)
        by = step[0] if step else 1.0
        count = math.floor((last - first) / by * (1 + 1e-12)) + 1
        return first + by * np.arange(size_of((count, 1))[0])[None]

    def _sum(self, inside: bool) -> Any:
        value = self._product(inside)
        while self._at("+", "-"):
            token, after = self._peek(), self._tokens[self._place + 1 : self._place + 2]
            # In a matrix [1 -2] has two elements, [1 - 2] and [1-2] have one.
            if inside and token.spaced and after and not after[0].spaced:
                break
            self._place += 1
            other = self._product(inside)
            value = applied(token.text, number(value), number(other))
        return value

    def _product(self, inside: bool) -> Any:
        value = self._unary(inside)
        while self._at("*", "/", ".*", "./"):
            operator = self._next("op").text
            other = number(self._unary(inside))
            value = applied(operator, number(value), other)
        return value

    def _unary(self, inside: bool) -> Any:
        if self._at("+", "-"):
            sign = -1.0 if self._next("op").text == "-" else 1.0
            return sign * number(self._unary(inside))
        value = self._postfix(inside)
        while self._at("^", ".^"):
            operator = self._next("op").text
            value = powered(operator, number(value), one_of(self._exponent(inside)))
        return value

    def _exponent(self, inside: bool) -> Any:
        """Return an exponent with its signs; 2^3^2 is (2^3)^2."""
        sign = 1.0
        while self._at("+", "-"):
            sign = -sign if self._next("op").text == "-" else sign
        return sign * number(self._postfix(inside))

    def _postfix(self, inside: bool) -> Any:
        value = self._primary(inside)
        while self._at("'", ".'", ".") and not (inside and self._peek().spaced):
            is_field = self._next("op").text == "."
            value = value[self._next("name").text] if is_field else transposed(value)
        return value

    def _primary(self, inside: bool) -> Any:
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise NotLiteralError
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
        if token.text == "end" and self._ends:
            return np.full((1, 1), float(self._ends[-1]))
        if token.kind == "name":
            return self._named(token.text, inside)
        if token.text == "(":
            value = self._range()
            self._expect(")")
            return value
        if token.text in ("[", "{"):
            rows = self._rows("]" if token.text == "[" else "}")
            return joined(rows) if token.text == "[" else rows
        raise NotLiteralError

    def _named(self, name: str, inside: bool) -> Any:
        called = self._at("(") and not (inside and self._peek().spaced)
        if name in self._values and not called:
            return self._values[name]
        if name in self._values and isinstance(self._values[name], np.ndarray):
            return chosen(self._values[name], self._indices(self._values[name], ")"))
        if name in FUNCTIONS and called:
            self._place += 1
            arguments = []
            while not self._at(")"):
                arguments.append(self._range())
                if self._at(","):
                    self._place += 1
            self._place += 1
            return matrix(FUNCTIONS[name](*arguments))
        if name == "false" or name in CONSTANTS:
            return np.full((1, 1), CONSTANTS.get(name, 0.0))
        raise NotLiteralError

    def _rows(self, close: str) -> list[list[Any]]:
        rows: list[list[Any]] = [[]]
        while not self._at(close):
            if self._at(";", "\n"):
                rows.append([])
                self._place += 1
            elif self._at(","):
                self._place += 1
            elif self._place >= len(self._tokens):
                raise NotLiteralError
            else:
                rows[-1].append(self._range(inside=True))
        self._place += 1
        return [row for row in rows if row]
