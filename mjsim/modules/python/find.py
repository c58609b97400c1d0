"""Finds a Python module and checks that its class exists and fits, without running any of its code."""

import ast
import difflib
import importlib.util
import pkgutil
import sys
from collections.abc import Iterator, Sequence
from importlib.machinery import ModuleSpec
from pathlib import Path

from mjsim.errors import did_you_mean
from mjsim.modules.hosts import Defect, beside
from mjsim.modules.python.annotations import misfit_of
from mjsim.modules.python.offers import keys_of
from mjsim.modules.python.outline import BoundNames, Methods, UnreadableError, methods_of, outline_of
from mjsim.modules.roles import ROLES, awaited, lacking, unmade
from mjsim.sentences import Sentence
from mjsim.world import Source, Use

MAX_STEPS = 8
"""Maximum number of modules through which a name is followed to its class."""


def class_defects(use: Use, role: str, source: Source) -> Iterator[Defect]:
    """Yield what does not exist, which keys the class does not accept or lacks, and why it cannot fill a role."""
    place, _, name = use.use.rpartition(":")
    try:
        outline = _defining(place, name, source)
    except UnreadableError as error:
        yield Defect(str(error), missing=False)
        return
    except ValueError as error:
        yield Defect(str(error))
        return
    item = outline.names.get(name)
    if item is None and not outline.open_ended:
        # A package without classes of its own offers those that it imports.
        classes = [word for word in outline.classes() or outline.names if not word.startswith("_")]
        yield Defect(Sentence("no class '{name}' in {place}{meant}", name, place, did_you_mean(name, classes)))
    elif isinstance(item, (ast.FunctionDef, ast.AsyncFunctionDef)):
        yield Defect(Sentence("{name} in {place} {problem}", name, place, unmade(role, "a function")), missing=False)
    elif isinstance(item, ast.ClassDef):
        methods = methods_of(item, outline.classes())
        yield from _wrong_keys(item, methods, use)
        if problem := _misfit(methods, role):
            yield Defect(Sentence("{name} in {place} {problem}", name, place, problem), missing=False)


def names_of(place: str, source: Source) -> BoundNames:
    """Return the names that a module binds; those of a package that loads them lazily are in its stub.

    Raises:
        UnreadableError: It is not Python, or too large.
        ValueError: There is no such module.
    """
    path = file_of(place, source)
    if path is None:
        return BoundNames({}, True)
    stub = path.with_suffix(".pyi")
    return outline_of(stub if _is_package(path) and stub.is_file() else path)


def imported(statement: ast.ImportFrom, name: str, place: str, source: Source) -> tuple[str, str] | None:
    """Return the module and the original name of a name that a package imports from one of its modules; else None."""
    if statement.level != 1 or statement.module is None or place.endswith(".py"):
        return None
    path = file_of(place, source)
    folder = place if path is not None and _is_package(path) else place.rpartition(".")[0]
    original = next((each.name for each in statement.names if name in (each.asname, each.name)), name)
    return f"{folder}.{statement.module}", original


def file_of(place: str, source: Source) -> Path | None:
    """Return the file of a module; None if it exists, but not as Python source.

    Raises:
        ValueError: There is no such module; the message says why.
    """
    return beside(place, source) if place.endswith(".py") else _installed_file(place)


def parts_of(name: str) -> list[str]:
    """Return the parts of a dotted module name.

    Raises:
        ValueError: It is not one.
    """
    parts = name.split(".")
    if not all(part.isidentifier() for part in parts):
        raise ValueError(Sentence("'{name}' is not a module; write 'package.module:Class' or 'file.py:Class'", name))
    return parts


def _defining(place: str, name: str, source: Source, steps: int = MAX_STEPS) -> BoundNames:
    """Return the names of the module that defines a class: for a package, the one from which it imports the class."""
    outline = names_of(place, source)
    item = outline.names.get(name)
    found = imported(item, name, place, source) if isinstance(item, ast.ImportFrom) else None
    if found is None or found[1] != name or steps == 0:
        return outline
    return _defining(*found, source, steps - 1)


def _is_package(path: Path) -> bool:
    return path.name == "__init__.py"


def _misfit(methods: Methods, role: str) -> str | None:
    for name in ROLES[role]:
        if isinstance(methods.names.get(name), ast.AsyncFunctionDef):
            return awaited(name)
    missing = [name for name in ROLES[role] if name not in methods.names]
    return lacking(role, missing) if missing and methods.whole else None


def _wrong_keys(item: ast.ClassDef, methods: Methods, use: Use) -> Iterator[Defect]:
    """Yield keys beside `use` that the constructor of a class does not accept, and required ones that are missing."""
    made = methods.names.get("__init__")
    if not (methods.whole and isinstance(made, ast.FunctionDef)) or made.decorator_list or "__new__" in methods.names:
        return
    known = {key.name: key for key in keys_of(made)}
    unknown = [key for key in use.arguments() if key not in known and made.args.kwarg is None]
    for key in unknown:
        yield Defect(Sentence("{name} takes no '{key}'{meant}", item.name, key, did_you_mean(key, known)), key)
    for key, value in use.arguments().items():
        # Only for our own annotations: Python does not enforce those of a user, which may be incomplete.
        if use.use.startswith("mjsim.") and key in known and (wanted := misfit_of(value, known[key].schema)):
            yield Defect(Sentence("{key} is {value!r:.40}; it must be {wanted}", key, value, wanted), key)
    missing = [key.name for key in known.values() if key.required and key.name not in use.arguments()]
    if missing and not unknown:
        listed = " and ".join(f"'{key}'" for key in missing)
        yield Defect(
            Sentence(
                "{name} needs {listed}; write {them} beside use",
                *(item.name, listed, "it" if len(missing) == 1 else "them"),
            )
        )


def _installed_file(name: str) -> Path | None:
    parts = parts_of(name)
    spec: ModuleSpec | None = None
    for count in range(1, len(parts) + 1):
        whole = ".".join(parts[:count])
        path = None if spec is None else list(spec.submodule_search_locations or ())
        spec = _spec(whole, path)
        if spec is None:
            raise ValueError(_not_installed(parts[:count], path))
    assert spec is not None
    return Path(spec.origin) if spec.has_location and spec.origin and spec.origin.endswith(".py") else None


def _not_installed(parts: Sequence[str], path: list[str] | None) -> str:
    """Return that a module is missing, and the name of a similar one in the folders of its package."""
    whole = ".".join(parts)
    names = [] if path is None else [module.name for module in pkgutil.iter_modules(path)]
    if similar := difflib.get_close_matches(parts[-1], names, n=1):
        meant = ".".join([*parts[:-1], *similar])
        return Sentence("no module '{whole}' is installed; did you mean '{meant}'?", whole, meant)
    return Sentence("no module '{whole}' is installed; install it or correct the name", whole)


def _spec(name: str, path: list[str] | None) -> ModuleSpec | None:
    """Find a module as `import` would, but without importing its parent packages."""
    if path is None:
        try:
            return importlib.util.find_spec(name)
        except ValueError:  # a module created by hand, such as __main__
            return None
    for finder in sys.meta_path:
        found = finder.find_spec(name, path)
        if found is not None:
            return found
    return None
