"""Parses Python source into syntax trees, in one thread at a time."""

import ast
import threading

_ATTEMPTS = 20
_lock = threading.RLock()


def parse_python(source: str | bytes, *, file: str = "<unknown>") -> ast.Module:
    """Return the syntax tree of a Python file.

    CPython 3.11 has one counter for the depth of the trees that all threads convert: two simultaneous conversions can
    raise SystemError ("AST constructor recursion depth mismatch"). A lock serialises our own; a conversion that
    collides with one elsewhere, such as in NumPy, is repeated.

    Args:
        source: Source of the file.
        file: Its name, for error messages.

    Raises:
        SyntaxError: It is not Python.
        ValueError: It holds null bytes.
        RecursionError: It is nested too deeply; MemoryError has the same cause.
    """
    for _ in range(_ATTEMPTS - 1):
        try:
            return _parsed(source, file)
        except SystemError:
            continue
    return _parsed(source, file)


def _parsed(source: str | bytes, file: str) -> ast.Module:
    with _lock:
        return ast.parse(source, filename=file)
