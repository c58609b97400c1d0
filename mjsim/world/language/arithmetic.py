"""Evaluates arithmetic in world files, such as `${w / 2 + 1}`, in a small language; no Python code is run."""

import math
import operator
import re
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from mjsim.errors import did_you_mean
from mjsim.sentences import Sentence

Value = bool | int | float | str
"""Possible values of a variable."""
Number = int | float

MAX_NUMBER = 1e15
"""Maximum absolute result; a larger number of metres or seconds is a mistake."""
MAX_CHARACTERS = 400
"""Maximum length of an expression [characters]."""
MAX_DEPTH = 30
"""Maximum nesting of parentheses and powers."""
NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_TOKEN = re.compile(r"\s*(?:(\d+\.?\d*(?:[eE][-+]?\d+)?|\.\d+(?:[eE][-+]?\d+)?)|([A-Za-z_]\w*)|(\*\*|//|[-+*/%(),]))")
_SUMS, _PRODUCTS = ("+", "-"), ("*", "/", "//", "%")


def _degrees_of(function: Callable[[float], float]) -> Callable[..., Number]:
    # Rounded, so that the cosine of 90 degrees is 0 and the sine of 30 degrees is 0.5.
    return lambda angle: round(function(math.radians(angle)), 15)


def _rounded(value: Number, digits: Number = 0) -> Number:
    if not isinstance(digits, int) or not 0 <= digits <= 15:
        raise ValueError(Sentence("round() is given {digits} digits; give it 0 to 15", digits))
    return round(value, digits)


class _Function(NamedTuple):
    call: Callable[..., Number]
    fewest: int
    max_arguments: int


FUNCTIONS: Mapping[str, _Function] = {
    "min": _Function(min, 2, 20),
    "max": _Function(max, 2, 20),
    "abs": _Function(abs, 1, 1),
    "sqrt": _Function(math.sqrt, 1, 1),
    "sin": _Function(_degrees_of(math.sin), 1, 1),
    "cos": _Function(_degrees_of(math.cos), 1, 1),
    "tan": _Function(_degrees_of(math.tan), 1, 1),
    "atan2": _Function(lambda y, x: math.degrees(math.atan2(y, x)), 2, 2),
    "floor": _Function(math.floor, 1, 1),
    "ceil": _Function(math.ceil, 1, 1),
    "round": _Function(_rounded, 1, 2),
}
"""Angles are in degrees, as everywhere in a world file."""
CONSTANTS: Mapping[str, Number] = {"pi": math.pi}


class Expression:
    """An expression, parsed once and evaluated any number of times."""

    def __init__(self, text: str) -> None:
        """Parse an expression.

        Raises:
            ValueError: It is not a valid expression; the message says why.
        """
        if len(text) > MAX_CHARACTERS:
            raise ValueError(
                Sentence(
                    "an expression of {count} characters; write at most {max_characters}", len(text), MAX_CHARACTERS
                )
            )
        parser = _Parser(text)
        self._compute = parser.whole()
        self.names = frozenset(parser.names)
        """Variables and indices that it uses."""

    def value(self, names: Mapping[str, Value]) -> Value:
        """Return its value; a whole number is returned as an integer.

        Raises:
            ValueError: It cannot be evaluated; the message says why.
        """
        value = self._compute(names)
        whole = isinstance(value, float) and value.is_integer() and abs(value) <= MAX_NUMBER
        return int(value) if whole else value


def shown_number(value: Value) -> str:
    """Return a value as text within a longer text."""
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.10g}" if isinstance(value, float) else str(value)


_Compute = Callable[[Mapping[str, Value]], Value]


class _Parser:
    """Recursive descent parser; each method returns a function from the names to the value."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._tokens = _tokens(text)
        self.names: set[str] = set()
        self._at = 0
        self._depth = 0

    def whole(self) -> _Compute:
        if not self._tokens:
            raise ValueError("'${}' contains no expression; write a number, a name or arithmetic between the braces")
        compute = self._sum()
        if self._at < len(self._tokens):
            raise self._unexpected()
        return compute

    def _next(self, *tokens: str) -> str | None:
        """Consume the next token if it is one of those wanted."""
        if self._at < len(self._tokens) and self._tokens[self._at] in tokens:
            self._at += 1
            return self._tokens[self._at - 1]
        return None

    def _unexpected(self) -> ValueError:
        found = (
            Sentence("'{token}' is not allowed there", self._tokens[self._at])
            if self._at < len(self._tokens)
            else "it ends too early"
        )
        return ValueError(
            Sentence("'{text}' is not an expression: {found}; write for example 'w / 2 + 1'", self._text.strip(), found)
        )

    def _sum(self) -> _Compute:
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise ValueError(
                Sentence(
                    "the expression is nested more than {max_depth} deep; use a variable for a part of it", MAX_DEPTH
                )
            )
        compute = self._product()
        while sign := self._next(*_SUMS):
            compute = _operation(sign, compute, self._product())
        self._depth -= 1
        return compute

    def _product(self) -> _Compute:
        compute = self._signed()
        while sign := self._next(*_PRODUCTS):
            compute = _operation(sign, compute, self._signed())
        return compute

    def _signed(self) -> _Compute:
        negative = False
        while sign := self._next(*_SUMS):
            negative ^= sign == "-"
        compute = self._power()
        return _operation("*", lambda names: -1, compute) if negative else compute

    def _power(self) -> _Compute:
        base = self._operand()
        if not self._next("**"):
            return base
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise ValueError(
                Sentence(
                    "the expression is nested more than {max_depth} deep; use a variable for a part of it", MAX_DEPTH
                )
            )
        compute = _operation("**", base, self._signed())
        self._depth -= 1
        return compute

    def _operand(self) -> _Compute:
        if self._next("("):
            compute = self._sum()
            if not self._next(")"):
                raise self._unexpected()
            return compute
        if self._at == len(self._tokens):
            raise self._unexpected()
        token = self._tokens[self._at]
        self._at += 1
        if NAME.fullmatch(token):
            if self._next("("):
                return self._call(token)
            self.names.add(token)
            return _variable(token)
        if token[0] in "0123456789.":
            number = _bounded(float(token), token) if re.search(r"[.eE]", token) else _bounded(int(token), token)
            return lambda names: number
        self._at -= 1
        raise self._unexpected()

    def _call(self, name: str) -> _Compute:
        if name not in FUNCTIONS:
            raise ValueError(Sentence("no function '{name}'{meant}", name, did_you_mean(name, FUNCTIONS)))
        inner = [self._sum()]
        while self._next(","):
            inner.append(self._sum())
        if not self._next(")"):
            raise self._unexpected()
        function, fewest, max_arguments = FUNCTIONS[name]
        if not fewest <= len(inner) <= max_arguments:
            expected = (
                str(fewest)
                if fewest == max_arguments
                else Sentence("{fewest} to {max_arguments}", fewest, max_arguments)
            )
            raise ValueError(Sentence("{name}() got {count} values; it takes {expected}", name, len(inner), expected))
        return _application(name, function, inner)


def _tokens(text: str) -> list[str]:
    found, end = [], 0
    while text[end:].strip():
        match = _TOKEN.match(text, end)
        if match is None:
            wrong = text[end:].strip()[0]
            raise ValueError(
                Sentence(
                    "'{text}' is not an expression: '{wrong}' is not allowed in it; use numbers, names, + - * /",
                    text.strip(),
                    wrong,
                )
            )
        found.append(match.group().strip())
        end = match.end()
    return found


def _variable(name: str) -> _Compute:
    if name in CONSTANTS:
        return lambda names: CONSTANTS[name]

    def compute(names: Mapping[str, Value]) -> Value:
        if name not in names:
            raise ValueError(_no_variable(name, names))
        return names[name]

    return compute


def _no_variable(name: str, names: Mapping[str, Value]) -> str:
    if name in INDICES:
        return Sentence("'{name}' has no meaning here; it counts the repetitions of an item with 'repeat'", name)
    return Sentence("no variable '{name}' before this{meant}", name, did_you_mean(name, names))


INDICES = ("i", "j", "k")
"""Names of the repetition indices, which count from 0."""


def _application(name: str, function: Callable[..., Number], inner: Sequence[_Compute]) -> _Compute:
    def compute(names: Mapping[str, Value]) -> Value:
        values = [_number(part(names)) for part in inner]
        try:
            result = function(*values)
            if -MAX_NUMBER <= result <= MAX_NUMBER:
                return result
        except (ArithmeticError, ValueError) as error:
            if name in str(error):
                raise
            raise ValueError(Sentence("{called} is not a number", _called(name, values))) from None
        raise ValueError(_too_large(_called(name, values)))

    return compute


def _called(name: str, values: Sequence[Number]) -> str:
    return f"{name}({', '.join(map(shown_number, values))})"


def _operation(sign: str, left: _Compute, right: _Compute) -> _Compute:
    function = _OPERATIONS[sign]

    def compute(names: Mapping[str, Value]) -> Value:
        one, other = left(names), right(names)
        if type(one) not in _NUMBERS or type(other) not in _NUMBERS:
            one, other = _number(one), _number(other)
        try:
            result = function(one, other)
            if -MAX_NUMBER <= result <= MAX_NUMBER:
                return result
        except ZeroDivisionError:
            raise ValueError(Sentence("{joined} divides by zero", _joined(sign, one, other))) from None
        except OverflowError:
            pass
        raise ValueError(_too_large(_joined(sign, one, other)))

    return compute


def _joined(sign: str, one: Value, other: Value) -> str:
    return f"{shown_number(one)} {sign} {shown_number(other)}"


def _power(base: Number, exponent: Number) -> Number:
    # In floating point first: an integer with a million digits takes long.
    result = float(base) ** float(exponent)
    if isinstance(result, complex):
        raise ValueError(Sentence("{base} ** {exponent} is not a number", shown_number(base), shown_number(exponent)))
    whole = isinstance(base, int) and isinstance(exponent, int) and exponent >= 0 and abs(result) <= MAX_NUMBER
    return base**exponent if whole else result


_NUMBERS = (int, float)
_OPERATIONS: Mapping[str, Callable[..., Number]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "//": operator.floordiv,
    "%": operator.mod,
    "**": _power,
}


def _number(value: Value) -> Number:
    if isinstance(value, (bool, str)):
        raise ValueError(Sentence("{value!r:.40} is not a number; arithmetic needs numbers", value))
    return value


def _bounded(value: Number, text: str) -> Number:
    if not -MAX_NUMBER <= value <= MAX_NUMBER:
        raise ValueError(_too_large(text))
    return value


def _too_large(text: str) -> str:
    return Sentence("{text:.60} is too large; results are at most {max_number:g}", text, MAX_NUMBER)
