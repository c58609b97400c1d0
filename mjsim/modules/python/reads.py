"""Which readings a class uses: from its source and from that of what it calls, without running any of it."""

import ast
from collections import deque
from collections.abc import Iterator, Mapping
from pathlib import Path

from mjsim.modules.python.find import imported, names_of
from mjsim.modules.python.offers import keys_of
from mjsim.modules.python.outline import UnreadableError, methods_of
from mjsim.world import SENSOR_KINDS, Source, Use

SHARED = frozenset({"ranges", "joints", "imu", "encoders", "proximity", "bump"})
"""Fields of `Observation` that other values have too, such as a scan its ranges: they count of an observation as roles
name it."""
PLAIN = frozenset(model.reading for model in SENSOR_KINDS.values()) - SHARED
"""Fields that few other values have: they count of every variable."""
_OBSERVATIONS = {"observe": 1, "update": 1, "command": 1, "adjust": 2}
"""Method of a role -> place of its argument that is an observation."""


def readings_of(use: Use, source: Source) -> Iterator[str]:
    """Yield the fields of `Observation` that a class reads, as far as its source shows; files are read when needed."""
    place, _, name = use.use.rpartition(":")
    observations = {"seen"}
    for part in _reached(place, name, source):
        observations |= set(_observations(part))
        yield from _fields(part, observations)


def key_of(use: Use, name: str, source: Source) -> object:
    """Return the value of a key of a class: as written, or its default; None without one, or if it is computed."""
    if name in use.arguments():
        return use.arguments()[name]
    place, _, called = use.use.rpartition(":")
    classes = {each: item for each, item in _names(place, source).items() if isinstance(item, ast.ClassDef)}
    made = methods_of(classes[called], classes).names.get("__init__") if called in classes else None
    keys = keys_of(made) if isinstance(made, ast.FunctionDef) else ()
    return next((key.default for key in keys if key.name == name), None)


def _reached(place: str, name: str, source: Source) -> Iterator[ast.stmt]:
    """Yield the definition of a class, and those of all that it names, in its file and in files that are followed."""
    files: dict[str, Mapping[str, ast.stmt]] = {}
    waiting, known = deque([(place, name)]), set[tuple[str, str]]()
    while waiting:
        place, name = waiting.popleft()
        if (place, name) in known:
            continue
        known.add((place, name))
        if place not in files:
            files[place] = _names(place, source)
        found = files[place]
        if name not in found:
            continue
        if isinstance(found[name], ast.ImportFrom):
            waiting += _imported(found[name], name, place, source)
            continue
        yield found[name]
        used = {node.id for node in _run(found[name]) if isinstance(node, ast.Name)}
        waiting += [(place, word) for word in used if word in found]


def _names(place: str, source: Source) -> Mapping[str, ast.stmt]:
    """Return the names that a file beside the world, or of mjsim.algorithms, binds; none of another."""
    try:
        return names_of(place, source).names
    except (UnreadableError, ValueError):
        return {}  # reported by the check of the module


def _imported(statement: ast.stmt, name: str, place: str, source: Source) -> Iterator[tuple[str, str]]:
    """Yield module and name of an imported name, if the module is beside the importing file or of mjsim.algorithms."""
    if not isinstance(statement, ast.ImportFrom) or statement.module is None:
        return
    original = next((each.name for each in statement.names if name in (each.asname, each.name)), name)
    beside = place.endswith(".py")
    if statement.module.startswith("mjsim.algorithms"):
        yield statement.module, original
    elif beside:
        yield (Path(place).parent / f"{statement.module.replace('.', '/')}.py").as_posix(), original
    elif found := imported(statement, name, place, source):
        yield found


def _run(part: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes of a definition that are run: all except annotations."""
    waiting = [part]
    while waiting:
        node = waiting.pop()
        yield node
        for name, value in ast.iter_fields(node):
            if name not in ("annotation", "returns"):
                waiting += [
                    each for each in (value if isinstance(value, list) else [value]) if isinstance(each, ast.AST)
                ]


def _observations(part: ast.stmt) -> Iterator[str]:
    """Yield the names that the methods of roles give to observations."""
    for node in ast.walk(part):
        if isinstance(node, ast.FunctionDef) and node.name in _OBSERVATIONS:
            yield from (argument.arg for argument in node.args.args[_OBSERVATIONS[node.name] :][:1])


def _fields(part: ast.stmt, observations: set[str]) -> Iterator[str]:
    for node in _run(part):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and isinstance(node.ctx, ast.Load):
            owner = node.value.id
            if (node.attr in PLAIN and owner != "self") or (node.attr in SHARED and owner in observations):
                yield node.attr
