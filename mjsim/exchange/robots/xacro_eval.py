"""Expressions of xacro files, which the xacro library evaluates as Python: those that could do more are refused.

The library refuses names with two underscores, but does not look into comprehensions, and `$(eval ...)` has all of
Python's functions: a robot's file could run any code.
"""

import ast
import builtins
from collections.abc import Callable, Container, Iterator
from contextlib import contextmanager
from typing import Any

from mjsim.syntax import parse_python

INNER = ("_", "gi_", "f_", "tb_", "co_", "cr_", "ag_", "func_")
"""Attributes with these prefixes lead from a value to the interpreter."""
FUNCTIONS = frozenset(
    ("True", "False", "None", "abs", "all", "any", "bool", "dict", "float", "int", "len", "list", "max", "min", "range")
) | {"round", "sorted", "str", "sum", "tuple", "zip", "map", "filter", "enumerate", "divmod", "pow"}
"""Functions of Python that an expression may call in `$(eval ...)`."""
HIGHEST = 10
"""Maximum exponent: higher powers take any time and memory."""
MAX_BITS, LONGEST = 4096, 1_000_000
"""Maximum size of a number [bits], and length of a text or a list that an expression gives."""
REFUSED = (ast.Lambda, ast.NamedExpr, ast.Await, ast.Yield, ast.YieldFrom, ast.LShift)


def require_harmless(text: str, *, known: Container[str] | None = None) -> None:
    """Check that an expression only computes.

    Args:
        text: Of the expression.
        known: Names that it may use besides `FUNCTIONS`; by default any without two underscores at the beginning, as
            where Python's own functions are not available.

    Raises:
        ValueError: It could do something else, or take any time.
        SyntaxError: It is not an expression.
    """
    tree = parse_python(text.strip())
    if [type(statement) for statement in tree.body] != [ast.Expr]:
        raise SyntaxError(f"'{text.strip()[:60]}' is not an expression")
    for node in ast.walk(tree):
        match node:
            case ast.Attribute(attr=name) if name.startswith(INNER):
                raise ValueError(f"'{name[:40]}' is not allowed in '{text.strip()[:60]}'")
            case ast.Name(id=name) if name.startswith("__") or not _is_known(name, known):
                raise ValueError(f"'{name[:40]}' is not allowed in '{text.strip()[:60]}'")
            case ast.BinOp(op=ast.Pow(), right=right) if not _is_low(right):
                raise ValueError(f"'{text.strip()[:60]}' has a power; exponents are numbers up to {HIGHEST}")
            case _ if isinstance(node, REFUSED):
                raise ValueError(f"{type(node).__name__} is not allowed in '{text.strip()[:60]}'")


def _is_known(name: str, known: Container[str] | None) -> bool:
    return known is None or name in known or name in FUNCTIONS or not hasattr(builtins, name)


def _is_low(exponent: ast.expr) -> bool:
    inner = exponent.operand if isinstance(exponent, ast.UnaryOp) else exponent
    return isinstance(inner, ast.Constant) and isinstance(inner.value, int | float) and abs(inner.value) <= HIGHEST


def _bounded(value: Any) -> Any:
    """Return a value, unless it is too large to go on with."""
    is_large = value.bit_length() > MAX_BITS if isinstance(value, int) else False
    if is_large or (hasattr(value, "__len__") and len(value) > LONGEST):
        raise ValueError("an expression gives a number or a text that is too large")
    return value


@contextmanager
def guarded(xacro: Any, substitution: Any) -> Iterator[None]:
    """Check every expression that the library evaluates in the block.

    Args:
        xacro: The library.
        substitution: Its module of `$(...)`.
    """
    of_text: Callable[..., Any] = xacro.safe_eval
    of_command: Callable[..., str] = substitution._eval

    def safe_eval(text: str, *names: Any) -> Any:
        require_harmless(text)
        return _bounded(of_text(text, *names))

    def command(text: str, context: Any) -> str:
        require_harmless(text, known=context.get("arg", {}))
        return str(_bounded(of_command(text, context)))

    xacro.safe_eval, substitution._eval = safe_eval, command
    try:
        yield
    finally:
        xacro.safe_eval, substitution._eval = of_text, of_command
