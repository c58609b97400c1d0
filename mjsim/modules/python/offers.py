"""Modules in Python files: classes with the methods of a role, found in the source text."""

import ast
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeGuard

from mjsim.modules.hosts import Key, Offer
from mjsim.modules.python.annotations import schema_of
from mjsim.modules.python.import_places import is_installed, place_of
from mjsim.modules.python.outline import UnreadableError, methods_of, tree_of
from mjsim.modules.roles import ROLES
from mjsim.sentences import Sentence

MAX_BYTES = 1_000_000
ABBREVIATIONS = {"Dwa", "Ekf", "Imu", "Lqr", "Mppi", "Pd", "Pid", "Slam", "Ukf"}
"""Words of class names that people write in capitals."""
PARTS = {"arms", "balancing", "max_left"}
"""Fields of `RobotInfo` that only some robots have."""
_ARGUMENT = re.compile(r"^ {4}(\w+): (.*(?:\n {6,}.*)*)", re.MULTILINE)


def offers_in(files: Sequence[tuple[Path, str]]) -> Iterator[Offer]:
    """Yield the modules in files; a class may inherit from one in another file, and use names of it.

    Args:
        files: Each file with its text before the colon in a world file.
    """
    read = [(_body(path), place) for path, place in files]
    known = {item.name: item for body, _ in read for item in body if isinstance(item, ast.ClassDef)}
    values = {name: value for body, _ in read for name, value in _constants(body)}
    for body, place in read:
        for item in (each for each in body if isinstance(each, ast.ClassDef)):
            methods = methods_of(item, known).names
            role = next((role for role, needed in ROLES.items() if all(name in methods for name in needed)), None)
            if role is not None and not item.name.startswith("_") and not _is_protocol(item):
                made = methods.get("__init__")
                keys = tuple(keys_of(made, values)) if isinstance(made, ast.FunctionDef) else ()
                yield _offer(item, role, f"{place}:{item.name}", keys, _parts(methods.get("start")))


def faults_in(files: Sequence[tuple[Path, str]]) -> Iterator[tuple[str, str]]:
    """Yield why files cannot be imported, and why classes that look like modules are not; nothing is run."""
    for path, place in files:
        try:
            body = tree_of(path).body
            wanted = _missing_import(path, body)
            yield from _unfinished(body, place)
        except UnreadableError as error:
            yield place, str(error)
            continue
        if wanted is not None:
            yield (
                place,
                Sentence(
                    "{name}:{line}: no module '{module}' is installed or beside it", path.name, wanted[1], wanted[0]
                ),
            )


def _unfinished(body: Sequence[ast.stmt], place: str) -> Iterator[tuple[str, str]]:
    """Yield classes that start as modules do, and lack the method of a role."""
    own = sorted({name for needed in ROLES.values() if needed[0] == "start" for name in needed[1:]})
    for item in body:
        if isinstance(item, ast.ClassDef) and not item.bases and not _is_protocol(item):
            methods = {each.name: each for each in item.body if isinstance(each, ast.FunctionDef)}
            start = methods.get("start")
            if start is not None and len(start.args.args) == 4 and methods.keys().isdisjoint(own):
                listed = ", ".join(f"{name}()" for name in own)
                yield (
                    f"{place}:{item.name}",
                    Sentence("it has start(), but none of {methods}; add the method of its role", listed),
                )


def _missing_import(path: Path, body: Sequence[ast.stmt]) -> tuple[str, int] | None:
    """Return the first module that a file imports at its top level and that does not exist, with the line."""
    for item in body:
        names = [each.name for each in item.names] if isinstance(item, ast.Import) else []
        if isinstance(item, ast.ImportFrom) and item.module and not item.level:
            names = [item.module]
        for top in (name.partition(".")[0] for name in names):
            if place_of(path.parent, top) is None and not is_installed(top):
                return top, item.lineno
    return None


def _parts(start: ast.stmt | None) -> frozenset[str]:
    """Return the fields of the robot in the conditions on which the method `start` raises."""
    if not isinstance(start, ast.FunctionDef) or len(start.args.args) < 2:
        return frozenset()
    robot = start.args.args[1].arg
    tests = [node.test for node in ast.walk(start) if isinstance(node, ast.If) and isinstance(node.body[-1], ast.Raise)]
    found = {node.attr for test in tests for node in ast.walk(test) if _is_of(node, robot)}
    return frozenset(found & PARTS)


def _is_of(node: ast.AST, owner: str) -> TypeGuard[ast.Attribute]:
    return isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == owner


def keys_of(made: ast.FunctionDef, values: Mapping[str, ast.expr] = MappingProxyType({})) -> Iterator[Key]:
    """Yield the arguments of a constructor except self, `*` and `**` arguments.

    Args:
        made: The constructor.
        values: Values of names that its annotations and defaults refer to.
    """
    descriptions = {name: " ".join(about.split()) for name, about in _ARGUMENT.findall(ast.get_docstring(made) or "")}
    given = made.args
    in_order = [*given.posonlyargs, *given.args][1:]
    without: Sequence[ast.expr | None] = [None] * (len(in_order) - len(given.defaults))
    pairs = [*zip(in_order, [*without, *given.defaults][-len(in_order) or None :], strict=False)]
    for argument, default in [*pairs, *zip(given.kwonlyargs, given.kw_defaults, strict=True)]:
        named = values.get(default.id, default) if isinstance(default, ast.Name) else default
        yield Key(
            name=argument.arg,
            about=(about := descriptions.get(argument.arg, "")),
            default=None if named is None else _value(named),
            required=default is None,
            schema=schema_of(argument.annotation, about, values),
        )


def _body(path: Path) -> Sequence[ast.stmt]:
    try:
        return [] if path.stat().st_size > MAX_BYTES else tree_of(path).body
    except (OSError, UnreadableError):
        return []  # The error will be reported to whoever names it in a world.


def _constants(body: Sequence[ast.stmt]) -> Iterator[tuple[str, ast.expr]]:
    """Yield the names that a file assigns at its top level, with their values."""
    for item in body:
        if isinstance(item, ast.Assign) and len(item.targets) == 1 and isinstance(item.targets[0], ast.Name):
            yield item.targets[0].id, item.value


def _is_protocol(item: ast.ClassDef) -> bool:
    return any(isinstance(base, ast.Name) and base.id in ("Protocol", "ABC") for base in item.bases)


def title_of(name: str) -> str:
    """Return the name of a class as people write it: 'EkfSlam' is EKF-SLAM, 'MonteCarloLocalization' has spaces."""
    parts = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", " ", name).split()
    words = [part.upper() if part in ABBREVIATIONS else part for part in parts]
    return re.sub(r"\b(EKF|UKF) SLAM", r"\1-SLAM", re.sub(r"\b(Fast|Graph) SLAM", r"\1SLAM", " ".join(words)))


def _offer(item: ast.ClassDef, role: str, use: str, keys: Sequence[Key], parts: frozenset[str]) -> Offer:
    text = ast.get_docstring(item) or ""
    return Offer(
        role=role,
        use=use,
        title=title_of(item.name),
        about=" ".join(text.partition("\n\n")[0].split()),
        keys=keys,
        parts=parts,
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
