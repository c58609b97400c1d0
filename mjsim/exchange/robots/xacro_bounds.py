"""Bounds what an expression of a xacro file can compute: sizes are checked before a value is made.

The tree of an expression is rewritten so that operators, calls, loops and lists go through `Bounds`.
"""

import ast
import math
import operator
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sized
from types import BuiltinFunctionType, FunctionType, MethodDescriptorType, MethodType
from typing import Any

LONGEST, TOTAL = 1_000_000, 10_000_000
"""Maximum size of a value, and of all values of a file: characters of texts and entries of lists, in all of what they
hold."""
MAX_BITS = 4096
"""Maximum size of a whole number [bits]."""
HIGHEST = 10
"""Maximum exponent."""
MANY = 1000
"""Maximum argument or number of arguments of functions whose result grows fast."""
GROWING = {math.factorial, math.comb, math.perm, math.prod, math.lcm, math.ldexp}
UNBOUND = ("translate", "format_map", "expandtabs", "to_bytes", "maketrans")
"""Methods whose results no expression of a robot needs, and whose size is hard to tell."""
FIELD, WIDTH = re.compile(r"[%{]"), re.compile(r"\d+")
"""In a format: what begins a field, and its width or precision."""
LONGEST_WIDTH = 9
"""Digits that are read of a width: more are too many in any case."""
GIVEN = re.compile(r"%[^a-zA-Z%]*\*|\{[^{}]*\{")
"""In a format: a width that is an argument."""
CALLABLE = (BuiltinFunctionType, FunctionType, MethodDescriptorType, MethodType, type)
OPERATORS: Mapping[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
    ast.RShift: operator.rshift,
    ast.BitAnd: operator.and_,
    ast.BitOr: operator.or_,
    ast.BitXor: operator.xor,
}
MAKERS = (ast.List, ast.Tuple, ast.Set, ast.Dict, ast.JoinedStr, ast.ListComp, ast.SetComp, ast.DictComp)
"""Expressions that give a list, a text or the like."""
NAMES = {kind.__name__: function for kind, function in OPERATORS.items()}
BINARY, CALL, EACH, MADE = "__binary", "__call", "__each", "__made"
"""Names of the functions in rewritten expressions; those of a file do not begin with two underscores."""


class TooLargeError(ValueError):
    """An expression would give a value that is too large, or take too long."""

    def __init__(self) -> None:
        """Say so."""
        super().__init__("an expression gives a number or a text that is too large")


class Bounds:
    """Computes for the expressions of one file."""

    def __init__(self) -> None:
        """Start with nothing computed."""
        self._left = TOTAL

    def names(self) -> dict[str, Callable[..., Any]]:
        """Return the functions of rewritten expressions by their names."""
        return {BINARY: self.binary, CALL: self.call, EACH: self.each, MADE: self.made}

    def made(self, value: Any) -> Any:
        """Return a value that is not too large."""
        self._left -= size_of(value)
        if self._left < 0:
            raise TooLargeError
        return value

    def each(self, values: Iterable[Any]) -> Iterator[Any]:
        """Yield values, as many as may still be computed."""
        for value in values:
            self.made(None)
            yield value

    def binary(self, kind: str, left: Any, right: Any) -> Any:
        """Return the result of an operator."""
        if kind == "Mult":
            for count, value in ((left, right), (right, left)):
                if isinstance(count, int) and _has_length(value) and count * size_of(value) > LONGEST:
                    raise TooLargeError
        if kind == "Pow" and not abs(right) <= HIGHEST:
            raise TooLargeError
        if kind == "Mod" and isinstance(left, str | bytes):
            _require_narrow(left, right)
        return self.made(NAMES[kind](left, right))

    def call(self, function: Any, *values: Any, **named: Any) -> Any:
        """Return the result of a call."""
        given = (*values, *named.values())
        # Methods of a type get their object as an argument.
        owner = getattr(function, "__self__", values[0] if isinstance(function, MethodDescriptorType) and values else 0)
        self._check(function, owner, given)
        if function is map or function is filter or "key" in named:
            values = tuple(self._guarded(value) for value in values)
            named = {name: self._guarded(value) for name, value in named.items()}
        if getattr(function, "__name__", "") == "join" and isinstance(owner, str | bytes):
            *before, parts = values
            values = (*before, self._joined(owner, parts))
        found = function(*values, **named)
        self.made(owner if isinstance(owner, list | dict | set) else None)
        return self.made(found)

    def _check(self, function: Any, owner: Any, given: tuple[Any, ...]) -> None:
        """Check the arguments of a call, before it."""
        numbers = [abs(value) for value in given if isinstance(value, int)]
        name = getattr(function, "__name__", "")
        if name in UNBOUND:
            raise ValueError(f"{name}() is not allowed in an expression")
        if function in (pow, math.pow) and any(number > HIGHEST for number in numbers[1:]):
            raise TooLargeError
        if any(function is each for each in GROWING) and not _is_few(numbers, given):
            raise TooLargeError
        if function is round and any(number > MANY for number in numbers[1:]):
            raise TooLargeError
        if function is sum and any(_has_length(value) for value in given[1:]):
            raise TooLargeError
        if isinstance(owner, str | bytes):
            _require_short(name, owner, given, numbers)

    def _guarded(self, value: Any) -> Any:
        """Return a function whose calls are checked, too; any other value unchanged."""
        return (lambda *values: self.call(value, *values)) if isinstance(value, CALLABLE) else value

    def _joined(self, separator: str | bytes, parts: Iterable[Any]) -> list[Any]:
        """Return the parts of a text that is not too long."""
        texts = list(self.each(parts))
        if sum(len(text) for text in texts) + len(separator) * len(texts) > LONGEST:
            raise TooLargeError
        return texts


def _require_short(name: str, owner: str | bytes, given: tuple[Any, ...], numbers: list[int]) -> None:
    """Check that a method of a text gives no longer one."""
    if name == "format":
        _require_narrow(owner, given)
    if name in ("ljust", "rjust", "center", "zfill") and any(number > LONGEST for number in numbers):
        raise TooLargeError
    texts = [len(value) for value in given if isinstance(value, str | bytes)]
    if name == "replace" and (len(owner) + 1) * max(texts, default=0) > LONGEST:
        raise TooLargeError


def _require_narrow(form: str | bytes, given: Any) -> None:
    """Check that a format with its arguments gives no long text."""
    text = form if isinstance(form, str) else form.decode("latin-1")
    widths = sum(int(width[:LONGEST_WIDTH]) for width in WIDTH.findall(text))
    if GIVEN.search(text) or widths + len(FIELD.findall(text)) * size_of(given) > LONGEST:
        raise TooLargeError


def _is_few(numbers: list[int], given: tuple[Any, ...]) -> bool:
    """Return whether the arguments of a function, and their numbers, are small."""
    return all(number <= MANY for number in numbers) and not any(_has_length(v) and len(v) > MANY for v in given)


def _has_length(value: Any) -> bool:
    return isinstance(value, Sized) and not isinstance(value, type)


def size_of(value: Any) -> int:
    """Return the size of a value with all that it holds, as often as it holds it; at least 1.

    Raises:
        TooLargeError: It is larger than allowed.
    """
    size, waiting = 0, [value]
    while waiting:
        each = waiting.pop()
        size += 1
        if isinstance(each, str | bytes | bytearray | range):
            size += len(each)
        elif isinstance(each, int) and each.bit_length() > MAX_BITS:
            raise TooLargeError
        elif isinstance(each, list | tuple | set | frozenset) and size + len(each) <= LONGEST:
            waiting.extend(each)
        elif isinstance(each, Mapping) and size + len(each) <= LONGEST:
            waiting.extend(part for entry in each.items() for part in entry)
        elif _has_length(each):
            size += len(each)
        if size + len(waiting) > LONGEST:
            raise TooLargeError
    return size


class _Rewriter(ast.NodeTransformer):
    """Puts calls of `Bounds` in place of operators, calls, loops and lists."""

    def visit(self, node: ast.AST) -> Any:
        made = super().visit(node)
        # What a loop assigns to is no value.
        is_value = isinstance(made, MAKERS) and not isinstance(getattr(made, "ctx", None), ast.Store)
        return _call(MADE, made) if is_value else made

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        self.generic_visit(node)
        return _call(BINARY, ast.Constant(type(node.op).__name__), node.left, node.right)

    def visit_Call(self, node: ast.Call) -> ast.AST:
        self.generic_visit(node)
        return ast.Call(ast.Name(CALL, ast.Load()), [node.func, *node.args], node.keywords)

    def visit_comprehension(self, node: ast.comprehension) -> ast.AST:
        self.generic_visit(node)
        node.iter = _call(EACH, node.iter)
        return node

    def visit_Starred(self, node: ast.Starred) -> ast.AST:
        self.generic_visit(node)
        if isinstance(node.ctx, ast.Load):
            node.value = _call(EACH, node.value)
        return node

    def visit_FormattedValue(self, node: ast.FormattedValue) -> ast.AST:
        form = node.format_spec
        if form is not None:
            if not isinstance(form, ast.JoinedStr) or not all(isinstance(part, ast.Constant) for part in form.values):
                raise TooLargeError
            _require_narrow("".join(str(part.value) for part in form.values if isinstance(part, ast.Constant)), ())
        node.value = _call(MADE, self.visit(node.value))
        return node


def _call(name: str, *values: ast.expr) -> ast.Call:
    return ast.Call(ast.Name(name, ast.Load()), list(values), [])


def rewritten(tree: ast.expr) -> ast.Expression:
    """Return an expression that computes with `Bounds`."""
    return ast.fix_missing_locations(ast.Expression(_Rewriter().visit(tree)))
