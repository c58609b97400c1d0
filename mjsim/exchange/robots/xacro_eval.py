"""Expressions of xacro files, which the xacro library evaluates as Python: those that could do more are refused.

The library refuses names with two underscores, but does not look into comprehensions, and `$(eval ...)` has all of
Python's functions: a robot's file could run any code.
"""

import ast
import builtins
from collections.abc import Callable, Container, Iterator
from contextlib import contextmanager
from typing import Any

from mjsim.exchange.robots.xacro_bounds import HIGHEST, Bounds, rewritten
from mjsim.syntax import parse_python

INNER = ("_", "gi_", "f_", "tb_", "co_", "cr_", "ag_", "func_")
"""Attributes with these prefixes lead from a value to the interpreter."""
FUNCTIONS = frozenset(
    ("True", "False", "None", "abs", "all", "any", "bool", "dict", "float", "int", "len", "list", "max", "min", "range")
) | {"round", "sorted", "str", "sum", "tuple", "zip", "map", "filter", "enumerate", "divmod", "pow"}
"""Functions of Python that an expression may call in `$(eval ...)`."""
MOST_MACROS = 20_000
"""Maximum number of elements of xacro that are expanded: macros that call others may double with each."""
REFUSED = (ast.Lambda, ast.NamedExpr, ast.Await, ast.Yield, ast.YieldFrom, ast.LShift)


def require_harmless(text: str, *, known: Container[str] | None = None) -> ast.expr:
    """Return the tree of an expression that only computes.

    Args:
        text: Of the expression.
        known: Names that it may use besides `FUNCTIONS`; by default any without two underscores at the beginning, as
            where Python's own functions are not available.

    Raises:
        ValueError: It could do something else, or take any time.
        SyntaxError: It is not an expression.
    """
    match parse_python(text.strip()).body:
        case [ast.Expr(value=tree)]:
            pass
        case _:
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
    return tree


def _is_known(name: str, known: Container[str] | None) -> bool:
    return known is None or name in known or name in FUNCTIONS or not hasattr(builtins, name)


def _is_low(exponent: ast.expr) -> bool:
    inner = exponent.operand if isinstance(exponent, ast.UnaryOp) else exponent
    return isinstance(inner, ast.Constant) and isinstance(inner.value, int | float) and abs(inner.value) <= HIGHEST


class _Evaluator:
    """Evaluates the expressions of one file."""

    def __init__(self, xacro: Any, substitution: Any) -> None:
        self._substitution = substitution
        self._bounds, self._macros = Bounds(), 0
        self._expand: Callable[..., Any] = xacro.handle_macro_call

    def of_text(self, text: str, names: dict[str, Any], inner: Any = None) -> Any:
        """Return the value of `${...}`, as `xacro.safe_eval` does."""
        names.update(__builtins__=self._bounds.names())
        return self._value(text, None, names, inner)

    def of_command(self, text: str, context: dict[str, Any]) -> str:
        """Return the value of `$(eval ...)`, as the library's module of substitutions does."""
        arguments, substitution = context.setdefault("arg", {}), self._substitution
        functions = {
            **substitution._eval_dict,
            "arg": lambda name: substitution.convert_value(substitution._eval_arg(name, args=arguments), "auto"),
            "dirname": lambda: substitution._eval_dirname(context["filename"]),
        }
        python = {name: getattr(builtins, name) for name in FUNCTIONS}
        inner = substitution._DictWrapper(arguments, functions)
        return str(self._value(text, arguments, {"__builtins__": python | self._bounds.names()}, inner))

    def macro(self, node: Any, *others: Any) -> Any:
        """Expand a macro, unless there are too many."""
        self._macros += 1
        if self._macros > MOST_MACROS:
            raise ValueError(f"more than {MOST_MACROS:,} elements of xacro are expanded")
        return self._expand(node, *others)

    def _value(self, text: str, known: Container[str] | None, names: dict[str, Any], inner: Any) -> Any:
        code = compile(rewritten(require_harmless(text, known=known)), "<expression>", "eval")
        # Checked, with nothing of Python but what is in the names.
        return self._bounds.made(eval(code, names, inner))


@contextmanager
def guarded(xacro: Any, substitution: Any) -> Iterator[None]:
    """Check every expression that the library evaluates in the block, and count the macros.

    Args:
        xacro: The library.
        substitution: Its module of `$(...)`.
    """
    before = xacro.safe_eval, substitution._eval, xacro.handle_macro_call
    ours = _Evaluator(xacro, substitution)
    xacro.safe_eval, substitution._eval, xacro.handle_macro_call = ours.of_text, ours.of_command, ours.macro
    try:
        yield
    finally:
        xacro.safe_eval, substitution._eval, xacro.handle_macro_call = before
