"""Outline of a Python file from its text: the names that it binds, and the methods of its classes."""

import ast
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from mjsim.sentences import Sentence
from mjsim.syntax import parse_python

MAX_BYTES = 5_000_000
_MAX_BASES = 8
"""Maximum depth to which the bases of a class are followed."""


class UnreadableError(ValueError):
    """A file is not Python; the message says why."""


@dataclass(frozen=True, slots=True)
class BoundNames:
    """The names bound by importing a file."""

    names: Mapping[str, ast.stmt]
    """Each name with the statement that binds it."""
    open_ended: bool
    """Whether it may bind further names."""

    def classes(self) -> dict[str, ast.ClassDef]:
        """Return the classes by name."""
        return {name: item for name, item in self.names.items() if isinstance(item, ast.ClassDef)}


@dataclass(frozen=True, slots=True)
class Methods:
    """The names bound by a class and its bases."""

    names: Mapping[str, ast.stmt]
    whole: bool
    """Whether the list is complete: all bases are in the same file, and nothing adds methods."""


def outline_of(path: Path) -> BoundNames:
    """Return the names that a file binds, also inside `if`, `try`, `with` and loops.

    Raises:
        UnreadableError: It is not Python, or too large.
    """
    names: dict[str, ast.stmt] = {}
    open_ended = False
    for statement in statements(tree_of(path).body):
        if isinstance(statement, (ast.Import, ast.ImportFrom)):
            open_ended |= any(alias.name == "*" for alias in statement.names)
        for name in _bound(statement):
            if name not in names or isinstance(statement, (ast.ClassDef, ast.FunctionDef)):
                names[name] = statement
    return BoundNames(names, open_ended or "__getattr__" in names)


def tree_of(path: Path) -> ast.Module:
    """Return the syntax tree of a file.

    Raises:
        UnreadableError: It is not Python, or too large.
    """
    try:
        if path.stat().st_size > MAX_BYTES:
            raise UnreadableError(Sentence("'{name}' is too large to be a module", path.name))
        return parse_python(path.read_bytes(), file=path.name)
    except SyntaxError as error:
        raise UnreadableError(
            Sentence("{name}:{line}: {problem}; this is not Python", path.name, error.lineno, error.msg)
        ) from None
    except (RecursionError, MemoryError):
        raise UnreadableError(Sentence("{name} is nested too deeply to be Python", path.name)) from None
    except OSError as error:
        raise UnreadableError(Sentence("'{name}' cannot be read: {strerror}", path.name, error.strerror)) from None
    except UnreadableError:
        raise
    except ValueError as error:
        raise UnreadableError(Sentence("{name} is not Python: {error}", path.name, error)) from None


def methods_of(item: ast.ClassDef, known: Mapping[str, ast.ClassDef], depth: int = _MAX_BASES) -> Methods:
    """Return the names that a class binds, including inherited ones.

    Args:
        item: The class.
        known: Possible base classes.
        depth: Depth to which bases are followed.
    """
    names: dict[str, ast.stmt] = {}
    whole = not item.keywords and all(_adds_nothing(each) for each in item.decorator_list)
    for base in reversed(item.bases):
        above = known.get(base.id) if isinstance(base, ast.Name) else None
        if isinstance(base, ast.Name) and base.id == "object":
            continue
        if above is None or above is item or depth == 0:
            whole = False
            continue
        inherited = methods_of(above, known, depth - 1)
        names |= inherited.names
        whole &= inherited.whole
    for statement in statements(item.body):
        names |= dict.fromkeys(_bound(statement), statement)
    return Methods(names, whole)


def statements(body: Iterable[ast.stmt]) -> Iterator[ast.stmt]:
    """Yield the statements executed with a body, including those inside `if`, `try`, `with` and loops."""
    waiting: list[ast.AST] = list(body)
    while waiting:
        node = waiting.pop(0)
        if isinstance(node, ast.stmt):
            yield node
        if isinstance(node, (ast.If, ast.Try, ast.With, ast.ExceptHandler, ast.For, ast.While)):
            waiting += list(ast.iter_child_nodes(node))


def _bound(statement: ast.stmt) -> Iterator[str]:
    """Yield the names that a statement binds."""
    if isinstance(statement, (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)):
        yield statement.name
    elif isinstance(statement, (ast.Import, ast.ImportFrom)):
        for alias in statement.names:
            yield alias.asname or alias.name.partition(".")[0]
    elif isinstance(statement, (ast.Assign, ast.AnnAssign)):
        for node in ast.walk(statement):
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
                yield node.id


def _adds_nothing(decorator: ast.expr) -> bool:
    """Return whether a class decorator adds none of the methods of roles, such as `dataclass`."""
    called = decorator.func if isinstance(decorator, ast.Call) else decorator
    name = called.attr if isinstance(called, ast.Attribute) else getattr(called, "id", "")
    return name in ("dataclass", "final")
