"""Functions that expressions may call: a fixed table of pure functions of plain values."""

import math
import operator
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from mjsim.models.xacro.budget import MAX_BITS, MAX_VALUE_SIZE, TooLargeError, Value, XacroError, size_of
from mjsim.sentences import Sentence

MAX_ARGUMENT = 200
"""Maximum argument of functions whose result grows faster than a power."""
MAX_RANGE = 10_000
MAX_DIGITS = 30
"""Maximum number of digits to which a number is rounded."""
_CONVERSIONS = re.compile(r"(?:[^%]|%%|%(?:\(\w+\))?[-+ #]*\d{0,2}(?:\.\d{0,2})?[diouxXeEfFgGsr])*")
"""Text with conversions such as `%.3f`, of bounded width."""
WIDEST = 100


@dataclass(frozen=True, slots=True)
class Function:
    """A function for expressions."""

    name: str
    run: Callable[..., Any]
    """Takes plain values and returns one."""
    higher: bool = False
    """Whether it takes functions too; then its first argument is a function that calls one of these."""


@dataclass(frozen=True, slots=True)
class Module:
    """A group of functions and constants, such as `math`."""

    name: str
    members: Mapping[str, "Function | Value"]


def _bits(base: int) -> int:
    return base.bit_length() if abs(base) > 1 else 0


def power(base: Any, exponent: Any) -> Any:
    """Return a power of bounded size."""
    if isinstance(base, int) and isinstance(exponent, int) and _bits(base) * exponent > MAX_BITS:
        raise TooLargeError
    result = base**exponent
    if isinstance(result, complex):
        raise XacroError(
            Sentence("{base} has no power of {exponent} that is a real number; make it positive", base, exponent)
        )
    return result


def product(left: Any, right: Any) -> Any:
    """Return a product of numbers, or a repeated sequence of limited size."""
    for sequence, count in ((left, right), (right, left)):
        if (
            isinstance(sequence, str | list | tuple)
            and isinstance(count, int)
            and size_of(sequence) * count > MAX_VALUE_SIZE
        ):
            raise TooLargeError
    return left * right


def remainder(left: Any, right: Any) -> Any:
    """Return the remainder of numbers, or a formatted text."""
    if isinstance(left, str):
        if not _CONVERSIONS.fullmatch(left):
            raise XacroError(Sentence("'{left:.40}' is not a text with conversions such as %d and %.3f", left))
        if left.count("%") * (size_of(right) + WIDEST) > MAX_VALUE_SIZE:
            raise TooLargeError
    return left % right


def _range(*bounds: int) -> Value:
    numbers = range(*bounds)
    if len(numbers) > MAX_RANGE:
        raise TooLargeError
    return list(numbers)


def _round(number: Any, ndigits: Any = None) -> Any:
    if ndigits is not None and abs(ndigits) > MAX_DIGITS:
        raise TooLargeError
    return round(number, ndigits)


def _sum(values: Iterable[Any], start: Any = 0) -> Any:
    numbers = [start, *values]
    if not all(isinstance(number, int | float) for number in numbers):
        raise XacroError("sum adds numbers; use + for others")
    return sum(numbers)


def _bounded(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function of whole numbers that accepts small ones only."""

    def run(*numbers: int) -> Any:
        if any(abs(number) > MAX_ARGUMENT for number in numbers):
            raise TooLargeError
        return function(*numbers)

    return run


def _joined(separator: str, texts: Iterable[Any]) -> str:
    words = list(texts)
    if len(separator) * len(words) > MAX_VALUE_SIZE:
        raise TooLargeError
    return separator.join(words)


def _replaced(text: str, old: str, new: str, count: int = -1) -> str:
    if len(text) + (text.count(old) + 1) * len(new) > MAX_VALUE_SIZE:
        raise TooLargeError
    return text.replace(old, new, count)


def _tokens(text: str, sep: str = ",; ", skip_empty: bool = True) -> list[str]:
    words = re.split(f"[{re.escape(sep)}]", text) if sep else [text]
    return [word for word in words if word] if skip_empty else words


def _fatal(*words: Value) -> Value:
    raise XacroError(Sentence("the file says: {map:.200}", " ".join(map(str, words))))


def _map(apply: Callable[..., Value], function: Function, *lists: Any) -> list[Value]:
    return [apply(function, values) for values in zip(*lists, strict=False)]


def _filter(apply: Callable[..., Value], function: Function, values: Iterable[Any]) -> list[Any]:
    return [value for value in values if apply(function, (value,))]


def _isinstance(_: object, value: Value, *kinds: Function) -> bool:
    known = {kind.__name__: kind for kind in (bool, int, float, str, list, tuple, dict)}
    if not all(isinstance(kind, Function) and kind.name in known for kind in kinds):
        raise XacroError(Sentence("isinstance takes kinds of values; name {known}", ", ".join(known)))
    return any(isinstance(value, known[kind.name]) for kind in kinds)


def _as_list(function: Callable[..., Iterable[Any]]) -> Callable[..., list[Any]]:
    return lambda *arguments, **named: list(function(*arguments, **named))


def _table(entries: Mapping[str, Callable[..., Any]]) -> dict[str, Function]:
    return {name: Function(name, run) for name, run in entries.items()}


_FAST_GROWING = ("comb", "factorial", "gcd", "lcm", "perm")
_MATH: Mapping[str, Function | Value] = {
    **{name: getattr(math, name) for name in ("e", "inf", "nan", "pi", "tau")},
    **_table({
        name: getattr(math, name)
        for name in (
            *("acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "ceil", "copysign", "cos", "cosh"),
            *("degrees", "dist", "erf", "erfc", "exp", "expm1", "fabs", "floor", "fmod", "frexp", "fsum", "gamma"),
            *("hypot", "isclose", "isfinite", "isinf", "isnan", "isqrt", "ldexp", "lgamma", "log", "log10", "log1p"),
            *("log2", "modf", "pow", "radians", "remainder", "sin", "sinh", "sqrt", "tan", "tanh", "trunc"),
        )
    }),
    **_table({name: _bounded(getattr(math, name)) for name in _FAST_GROWING}),
}  # fmt: skip
_PLAIN: Mapping[str, Function | Value] = {
    "True": True,
    "False": False,
    **_table({"bool": bool, "dict": dict, "float": float, "int": int, "len": len, "list": list, "max": max}),
    **_table({"min": min, "round": _round, "sorted": sorted, "str": str, "range": _range}),
    "map": Function("map", _map, higher=True),
}
PYTHON: Mapping[str, Function | Value] = {
    **_PLAIN,
    **_table({"abs": abs, "all": all, "any": any, "divmod": divmod, "ord": ord, "sum": _sum, "tuple": tuple}),
    **_table({"enumerate": _as_list(enumerate), "reversed": _as_list(reversed), "zip": _as_list(zip)}),
    "filter": Function("filter", _filter, higher=True),
    "isinstance": Function("isinstance", _isinstance, higher=True),
}
"""Functions of `python.NAME`, also known by name unless the file uses the name for something else."""
_XACRO: Mapping[str, Function | Value] = _table({
    **dict.fromkeys(("message", "warning", "error", "print_location"), lambda *_, **__: ""),
    "fatal": _fatal,
    "tokenize": _tokens,
    "dotify": dict,
})  # fmt: skip
METHODS: Mapping[type, Mapping[str, Function]] = {
    str: _table({
        **{name: getattr(str, name) for name in ("count", "endswith", "find", "isdigit", "lower", "lstrip", "rstrip")},
        **{name: getattr(str, name) for name in ("split", "startswith", "strip", "title", "upper")},
        "join": _joined,
        "replace": _replaced,
    }),
    list: _table({"count": list.count, "index": list.index, "pop": list.pop}),
    tuple: _table({"count": tuple.count, "index": tuple.index}),
    dict: _table({"get": dict.get, **{name: _as_list(getattr(dict, name)) for name in ("items", "keys", "values")}}),
}  # fmt: skip
"""Methods of values, called by `value.name(...)`: entries of this table, not attributes."""
BINARY: Mapping[str, Callable[[Any, Any], Any]] = {
    "Add": operator.add,
    "Sub": operator.sub,
    "Mult": product,
    "Div": operator.truediv,
    "FloorDiv": operator.floordiv,
    "Mod": remainder,
    "Pow": power,
    "BitAnd": operator.and_,
    "BitOr": operator.or_,
    "BitXor": operator.xor,
}
UNARY: Mapping[str, Callable[[Any], Any]] = {"USub": operator.neg, "UAdd": operator.pos, "Not": operator.not_}
COMPARISONS: Mapping[str, Callable[[Any, Any], bool]] = {
    "Eq": operator.eq,
    "NotEq": operator.ne,
    "Lt": operator.lt,
    "LtE": operator.le,
    "Gt": operator.gt,
    "GtE": operator.ge,
    "Is": operator.is_,
    "IsNot": operator.is_not,
    "In": lambda left, right: left in right,
    "NotIn": lambda left, right: left not in right,
}


def known_names(own: Mapping[str, Callable[..., Any]]) -> Mapping[str, "Function | Module | Value"]:
    """Return the names that expressions accept without a property of the file.

    Args:
        own: Functions of xacro that depend on the file, such as `load_yaml`.
    """
    xacro = {**_XACRO, **_table(own)}
    modules = {"math": _MATH, "python": PYTHON, "xacro": xacro}
    direct = {name: member for name, member in xacro.items() if name in ("load_yaml", "abs_filename", "dotify")}
    return {**_MATH, **_PLAIN, **direct, **{name: Module(name, each) for name, each in modules.items()}}


SUBSTITUTED: Mapping[str, "Function | Module | Value"] = {
    **PYTHON,
    **_MATH,
    "true": True,
    "false": False,
}
"""Names that `$(eval ...)` accepts besides arguments."""
