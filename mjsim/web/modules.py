"""Classes that can drive a robot, found in the text of modules; nothing of them is run."""

import ast
import importlib.util
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from mjsim.web.files import files_below
from mjsim.web.folder import Folder
from mjsim.web.items import Json

METHODS = {"observe": "observers", "update": "estimators", "command": "navigators", "adjust": "avoidances"}
"""What a class has that is one of these, beside `start`."""
MOST_BYTES = 1_000_000
_ARGUMENT = re.compile(r"^ {4}(\w+): (.*(?:\n {6,}.*)*)", re.MULTILINE)


def modules_in(folder: Folder, world: str | None = None) -> Json:
    """Return observers, estimators, navigators and avoidances that come with mjsim, and those beside a world.

    Each has `use`, title, about, and keys: name, default (absent when it must be given) and about.

    Args:
        folder: Of the studio.
        world: Whose folder is looked through; that of the studio unless given.
    """
    place = folder.root if world is None else folder.path(world).parent
    files = [(path, f"mjsim.algorithms.{path.stem}") for path in sorted(_algorithms())]
    if place.is_dir():
        beside = (path for path in files_below(place) if path.suffix == ".py")
        files += [(path, path.relative_to(place).as_posix()) for path in beside]
    shelf = _Shelf()
    # All are read before any is looked at: a class may be made of one in another file.
    read = [(shelf.classes(path), module) for path, module in files]
    found: dict[str, list[Json]] = {kind: [] for kind in METHODS.values()}
    for items, module in read:
        for kind, told in shelf.drivers(items, module):
            found[kind].append(told)
    return dict(found)


def _algorithms() -> Iterator[Path]:
    spec = importlib.util.find_spec("mjsim.algorithms")
    for folder in (spec.submodule_search_locations or ()) if spec is not None else ():
        yield from Path(folder).glob("*.py")


class _Shelf:
    """Classes by their names, for those that are made of others."""

    def __init__(self) -> None:
        self._known: dict[str, ast.ClassDef] = {}

    def classes(self, path: Path) -> list[ast.ClassDef]:
        """Read a file, and return its classes."""
        try:
            if path.stat().st_size > MOST_BYTES:
                return []
            tree = ast.parse(path.read_bytes())
        except (OSError, SyntaxError, ValueError, RecursionError, MemoryError):
            return []  # Who names it in a world is told what is wrong with it.
        own = [statement for statement in tree.body if isinstance(statement, ast.ClassDef)]
        self._known |= {statement.name: statement for statement in own}
        return own

    def drivers(self, items: Sequence[ast.ClassDef], module: str) -> Iterator[tuple[str, Json]]:
        """Yield the classes of a module that can drive a robot: which kind, and what the page is told."""
        for item in items:
            methods = self._methods(item)
            kind = next((kind for name, kind in METHODS.items() if name in methods and "start" in methods), None)
            if kind is not None and not item.name.startswith("_") and not _is_protocol(item):
                yield kind, _told(item, use=f"{module}:{item.name}", made=methods.get("__init__"))

    def _methods(self, item: ast.ClassDef, depth: int = 8) -> dict[str, ast.FunctionDef]:
        """Return the methods of a class and of those it is made of, as far as they are known."""
        found: dict[str, ast.FunctionDef] = {}
        for base in item.bases if depth else ():
            known = self._known.get(base.id) if isinstance(base, ast.Name) else None
            if known is not None and known is not item:
                found = {**self._methods(known, depth - 1), **found}
        return found | {part.name: part for part in item.body if isinstance(part, ast.FunctionDef)}


def _is_protocol(item: ast.ClassDef) -> bool:
    return any(isinstance(base, ast.Name) and base.id in ("Protocol", "ABC") for base in item.bases)


def _told(item: ast.ClassDef, *, use: str, made: ast.FunctionDef | None) -> Json:
    text = ast.get_docstring(item) or ""
    first = " ".join(text.partition("\n\n")[0].split())
    title = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", " ", item.name)
    return {"use": use, "title": title, "about": first, "keys": [] if made is None else list(_keys(made))}


def _keys(made: ast.FunctionDef) -> Iterator[Json]:
    """Yield the arguments of a constructor."""
    said = {name: " ".join(about.split()) for name, about in _ARGUMENT.findall(ast.get_docstring(made) or "")}
    given = made.args
    in_order = [*given.posonlyargs, *given.args][1:]
    without: Sequence[ast.expr | None] = [None] * (len(in_order) - len(given.defaults))
    pairs = [*zip(in_order, [*without, *given.defaults][-len(in_order) or None :], strict=False)]
    for argument, default in [*pairs, *zip(given.kwonlyargs, given.kw_defaults, strict=True)]:
        told: Json = {"name": argument.arg, "about": said.get(argument.arg, "")}
        yield told if default is None else {**told, "default": _value(default)}


def _value(node: ast.expr) -> Any:
    """Return a default as JSON has it; None for what is computed."""
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
