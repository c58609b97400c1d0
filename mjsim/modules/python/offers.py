"""Modules in Python files: classes with the methods of a role, found in the source text."""

import ast
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from mjsim.modules.hosts import Key, Offer
from mjsim.modules.python.outline import UnreadableError, methods_of, tree_of
from mjsim.modules.roles import ROLES

MAX_BYTES = 1_000_000
_ARGUMENT = re.compile(r"^ {4}(\w+): (.*(?:\n {6,}.*)*)", re.MULTILINE)


def offers_in(files: Sequence[tuple[Path, str]]) -> Iterator[Offer]:
    """Yield the modules in files; a class may inherit from one in another file.

    Args:
        files: Each file with its text before the colon in a world file.
    """
    read = [(_classes(path), place) for path, place in files]
    known = {item.name: item for classes, _ in read for item in classes}
    for classes, place in read:
        for item in classes:
            methods = methods_of(item, known).names
            role = next((role for role, needed in ROLES.items() if all(name in methods for name in needed)), None)
            if role is not None and not item.name.startswith("_") and not _is_protocol(item):
                yield _offer(item, role, f"{place}:{item.name}", methods.get("__init__"))


def keys_of(made: ast.FunctionDef) -> Iterator[Key]:
    """Yield the arguments of a constructor except self, `*` and `**` arguments."""
    descriptions = {name: " ".join(about.split()) for name, about in _ARGUMENT.findall(ast.get_docstring(made) or "")}
    given = made.args
    in_order = [*given.posonlyargs, *given.args][1:]
    without: Sequence[ast.expr | None] = [None] * (len(in_order) - len(given.defaults))
    pairs = [*zip(in_order, [*without, *given.defaults][-len(in_order) or None :], strict=False)]
    for argument, default in [*pairs, *zip(given.kwonlyargs, given.kw_defaults, strict=True)]:
        value = None if default is None else _value(default)
        yield Key(name=argument.arg, about=descriptions.get(argument.arg, ""), default=value, required=default is None)


def _classes(path: Path) -> list[ast.ClassDef]:
    try:
        if path.stat().st_size > MAX_BYTES:
            return []
        return [item for item in tree_of(path).body if isinstance(item, ast.ClassDef)]
    except (OSError, UnreadableError):
        return []  # The error will be reported to whoever names it in a world.


def _is_protocol(item: ast.ClassDef) -> bool:
    return any(isinstance(base, ast.Name) and base.id in ("Protocol", "ABC") for base in item.bases)


def _offer(item: ast.ClassDef, role: str, use: str, made: ast.stmt | None) -> Offer:
    text = ast.get_docstring(item) or ""
    return Offer(
        role=role,
        use=use,
        title=re.sub(r"(?<=[a-z0-9])(?=[A-Z])", " ", item.name),
        about=" ".join(text.partition("\n\n")[0].split()),
        keys=tuple(keys_of(made)) if isinstance(made, ast.FunctionDef) else (),
    )


def _value(node: ast.expr) -> Any:
    """Return a default as a JSON value; None for a computed one."""
    try:
        value = ast.literal_eval(node)
    except (ValueError, TypeError, SyntaxError, MemoryError, RecursionError):
        return None
    return _json(value)


def _json(value: Any) -> Any:
    if isinstance(value, (list, tuple)):
        return [_json(item) for item in value]
    if isinstance(value, dict):
        return {str(key): _json(item) for key, item in value.items()}
    return value if value is None or isinstance(value, (bool, int, float, str)) else None
