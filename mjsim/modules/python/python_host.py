"""The host of Python modules: they run in the simulator's process.

Which readings a class uses is found in its source and that of the code it calls, without running any of it.
"""

import ast
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from mjsim.modules.hosts import Defect, Host, Offer, Provenance
from mjsim.modules.python.find import class_defects, imported, names_of
from mjsim.modules.python.needed_files import python_files
from mjsim.modules.python.offers import keys_of, offers_in
from mjsim.modules.python.outline import UnreadableError, methods_of
from mjsim.world import SENSOR_KINDS, Source, Use


class PythonHost(Host):
    """Imports 'file.py:Class' beside a world file, and 'package.module:Class'."""

    def speaks(self, use: str) -> bool:
        """Return whether it names a class of a Python module."""
        place, colon, name = use.rpartition(":")
        return bool(place and colon) and name.isidentifier()

    def origin(self, use: str) -> Provenance:
        """Return the origin of the class."""
        if self.place(use).endswith(".py"):
            return "beside"
        return "shipped" if use.startswith("mjsim.algorithms.") else "installed"

    def place(self, use: str) -> str:
        """Return the file or the dotted module that contains the class."""
        return use.rpartition(":")[0]

    def runs(self, file: str) -> bool:
        """Return whether a file is Python."""
        return file.endswith(".py")

    def defects(self, use: Use, role: str, source: Source) -> Iterator[Defect]:
        """Yield what does not exist or is not Python, keys that the class does not accept, and missing methods."""
        return class_defects(use, role, source)

    def files(self, uses: Sequence[Use], source: Source, *, data: bool = True) -> Mapping[str, bytes]:
        """Return the files of the classes, of their imports, and of files beside them that they name."""
        return python_files(uses, source, data=data)

    def offers(self, files: Sequence[tuple[Path, str]]) -> Iterator[Offer]:
        """Yield the classes in files with the suffix .py."""
        return offers_in([(path, place) for path, place in files if path.suffix == ".py"])

    def readings(self, use: Use, role: str, source: Source) -> Iterator[str]:
        """Yield the fields of `Observation` that the class and all that it calls read."""
        return readings_of(use, source)

    def key(self, use: Use, name: str, source: Source) -> object:
        """Return the argument of the class."""
        return key_of(use, name, source)

    def at_hand(self, named: str) -> tuple[Path | None, str]:
        """Return the folder of a file, and its name with the class; a dotted module is found anywhere."""
        place, _, name = named.rpartition(":")
        file = Path(place)
        return (file.parent, f"{file.name}:{name}") if place.endswith(".py") else (None, named)

    def make(self, use: Use, source: Source, *, role: str, robot: str) -> Any:
        """Return an instance of the class."""
        from mjsim.modules.python.load import make_class  # Slow to load, and not needed to inspect files.

        return make_class(use, source, role=role, robot=robot)


SHARED = frozenset({"ranges", "joints", "imu", "encoders", "proximity", "bump"})
"""Fields that other values have too, as a scan has ranges: they count only on observations named as in roles."""
PLAIN = frozenset(model.reading for model in SENSOR_KINDS.values()) - SHARED
"""Fields that few other values have, so they count on any variable."""
_OBSERVATIONS = {"observe": 1, "update": 1, "command": 1, "adjust": 2}
"""Method of a role -> position of its argument that is an observation."""


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
