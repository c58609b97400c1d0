"""Whether a module or file and the class in it are there, told without running any of its code."""

import ast
import importlib.util
import sys
from importlib.machinery import ModuleSpec
from pathlib import Path

from mjsim.errors import did_you_mean
from mjsim.world.source import Source

MOST_BYTES = 5_000_000


def missing_class(use: str, source: Source) -> str | None:
    """Return what is missing of 'module:Class' or 'file.py:Class', in a sentence; None when it is there."""
    place, _, name = use.rpartition(":")
    try:
        path = _file_of(place, source) if place.endswith(".py") else _module_of(place)
        if path is None:
            return None
        known, open_ended = _names_in(path)
    except ValueError as error:
        return str(error)
    if name in known or open_ended:
        return None
    classes = [word for word, is_class in known.items() if is_class and not word.startswith("_")]
    return f"no class '{name}' in {place}{did_you_mean(name, classes)}"


def _file_of(name: str, source: Source) -> Path:
    folder = (source.folder or Path.cwd()).resolve()
    try:
        path = (folder / name).resolve()
        there = path.is_file()
    except (OSError, RuntimeError, ValueError):
        path, there = folder, False
    if not path.is_relative_to(folder):
        raise ValueError(f"path '{name}' leaves the folder of the world; keep it beside the world file")
    if not there:
        near = [item.name for item in folder.glob("*.py")] if folder.is_dir() else []
        raise ValueError(f"no file '{name}' beside the world file{did_you_mean(name, near)}")
    return path


def _module_of(name: str) -> Path | None:
    """Return the file of a dotted module; None when it is there but not as Python text."""
    parts = name.split(".")
    if not all(part.isidentifier() for part in parts):
        raise ValueError(f"'{name}' is not a module; write 'package.module:Class' or 'file.py:Class'")
    spec: ModuleSpec | None = None
    for count in range(1, len(parts) + 1):
        whole = ".".join(parts[:count])
        spec = _spec(whole, None if spec is None else list(spec.submodule_search_locations or ()))
        if spec is None:
            raise ValueError(f"no module '{whole}' is installed; install it or mend the name")
    assert spec is not None
    return Path(spec.origin) if spec.has_location and spec.origin and spec.origin.endswith(".py") else None


def _spec(name: str, path: list[str] | None) -> ModuleSpec | None:
    """Find a module as import would, but without importing the packages around it."""
    if path is None:
        try:
            return importlib.util.find_spec(name)
        except ValueError:  # a module that was made by hand, such as __main__
            return None
    for finder in sys.meta_path:
        found = finder.find_spec(name, path)
        if found is not None:
            return found
    return None


def _names_in(path: Path) -> tuple[dict[str, bool], bool]:
    """Return the names that a file binds and whether each is a class, and whether it may bind others too."""
    try:
        if path.stat().st_size > MOST_BYTES:
            raise ValueError(f"'{path.name}' is too large to be a module")
        tree = ast.parse(path.read_bytes(), filename=path.name)
    except SyntaxError as error:
        raise ValueError(f"{path.name}:{error.lineno}: {error.msg}; this is not Python") from None
    except (RecursionError, MemoryError):
        raise ValueError(f"{path.name} is nested too deeply to be Python") from None
    except OSError as error:
        raise ValueError(f"'{path.name}' cannot be read: {error.strerror}") from None
    names: dict[str, bool] = {}
    open_ended = False
    for statement in _top_level(tree):
        if isinstance(statement, (ast.ClassDef, ast.FunctionDef)):
            names[statement.name] = isinstance(statement, ast.ClassDef)
            open_ended |= statement.name == "__getattr__"
        elif isinstance(statement, (ast.Import, ast.ImportFrom)):
            for alias in statement.names:
                open_ended |= alias.name == "*"
                names.setdefault(alias.asname or alias.name.partition(".")[0], False)
        elif isinstance(statement, (ast.Assign, ast.AnnAssign)):
            for node in ast.walk(statement):
                if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
                    names.setdefault(node.id, False)
    return names, open_ended


def _top_level(tree: ast.Module) -> list[ast.stmt]:
    """Return the statements that run when a module is imported, those inside `if`, `try` and `with` too."""
    found: list[ast.stmt] = []
    waiting: list[ast.AST] = list(tree.body)
    while waiting:
        node = waiting.pop(0)
        if isinstance(node, ast.stmt):
            found.append(node)
        if isinstance(node, (ast.If, ast.Try, ast.With, ast.ExceptHandler, ast.For, ast.While)):
            waiting += list(ast.iter_child_nodes(node))
    return found
