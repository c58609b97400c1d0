"""Collects the Python files that user modules need, so that they can be copied to another machine."""

import ast
import errno
import importlib.util
import os
import sys
import sysconfig
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from mjsim.errors import UsageError
from mjsim.modules.hosts import beside, folder_of
from mjsim.modules.python.import_places import place_of
from mjsim.sentences import Sentence
from mjsim.syntax import parse_python
from mjsim.world import Source, Use, holds_file, read_regular

INSTALLED = "modules"
"""Folder for the user's own files that are not beside the world file: packages under development."""
MAX_FILES, MAX_TOTAL = 10_000, 2_000_000_000
"""Limits of the number and the total size [bytes] of the files of a world's modules."""


def python_files(uses: Sequence[Use], source: Source, *, data: bool = True) -> dict[str, bytes]:
    """Return the files of classes that a world names with `use:`, by their paths relative to its folder.

    Each module is accompanied by its imports, if they are beside it or in a package under development, and by files
    beside it that are named in its text or in the keys beside `use`. Links out of these folders are left out.

    Args:
        uses: The classes.
        source: Source of the world.
        data: Whether to include files that are not Python.

    Raises:
        UsageError: A file cannot be read, or there are too many.
    """
    follower = _Follower(source, data=data)
    for use in uses:
        follower.take_use(use)
    return follower.files


class _Follower:
    """Follows imports from file to file."""

    def __init__(self, source: Source, *, data: bool) -> None:
        self._source, self._data = source, data
        self._folder = folder_of(source)
        self._bases = {self._folder: ""}
        self._left = MAX_TOTAL
        self.files: dict[str, bytes] = {}

    def take_use(self, use: Use) -> None:
        place = use.use.rpartition(":")[0]
        if place.endswith(".py"):
            with suppress(ValueError):  # It will be reported when it is run.
                self._take_file(beside(place, self._source), self._folder)
        elif all(part.isidentifier() for part in place.split(".")):
            self._take_import(place.partition(".")[0], self._folder, self._folder)
        for text in _texts(use.arguments()):
            self._take_data(self._folder / text, self._folder)

    def _take_file(self, path: Path, base: Path) -> None:
        """Collect a file and its imports; `base` is the folder from which it is imported."""
        name = self._bases[base] + path.relative_to(base).as_posix()
        if name in self.files or not holds_file(base, path):
            return
        self.files[name] = data = self._read(path)
        if path.suffix != ".py":
            return
        try:
            tree = parse_python(data)
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            return  # The error will be reported when it is run.
        for node in ast.walk(tree):
            for top in _imported(node):
                self._take_import(top, path.parent, base)
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                self._take_data(path.parent / node.value, base)

    def _read(self, path: Path) -> bytes:
        try:
            data = read_regular(path, limit=self._left)
        except OSError as error:
            if error.errno != errno.EFBIG:
                raise UsageError(Sentence("cannot read '{path}': {strerror}", path, error.strerror)) from error
            data = None
        if data is None or len(self.files) == MAX_FILES:
            limits = f"{MAX_FILES} files or {MAX_TOTAL >> 20} MB"
            raise UsageError(
                Sentence(
                    "the modules of '{file}' have over {limits}; name fewer or smaller ones", self._source.file, limits
                )
            )
        self._left -= len(data)
        return data

    def _take_import(self, top: str, folder: Path, base: Path) -> None:
        """Collect a module or package by the first part of its name."""
        place = place_of(folder, top)
        if place is None and top not in sys.stdlib_module_names and top != "mjsim":
            self._take_installed(top)
        elif place == folder / f"{top}.py":
            self._take_file(place, base)
        elif place is not None:
            self._take_package(folder / top, base)

    def _take_package(self, folder: Path, base: Path) -> None:
        for path in sorted(folder.rglob("*.py")):
            self._take_file(path, base)

    def _take_installed(self, top: str) -> None:
        """Collect a package under development, such as one installed with `pip install -e`."""
        with suppress(ValueError, ImportError):
            spec = importlib.util.find_spec(top)
            origin = Path(spec.origin) if spec is not None and spec.has_location and spec.origin else None
            if origin is None or origin.suffix != ".py" or _is_common(origin):
                return
            base = origin.parent.parent if origin.name == "__init__.py" else origin.parent
            self._bases.setdefault(base, f"{INSTALLED}/")
            if origin.name == "__init__.py":
                self._take_package(origin.parent, base)
            else:
                self._take_file(origin, base)

    def _take_data(self, path: Path, base: Path) -> None:
        """Collect a file named in a text, if it exists."""
        name = path.name
        # Most texts are not file names.
        if len(name) > 100 or not path.suffix or "\n" in name or "\0" in str(path) or ".." in path.parts:
            return
        if (self._data or path.suffix == ".py") and path.is_relative_to(base) and os.path.isfile(path):
            self._take_file(path, base)


def _imported(node: ast.AST) -> list[str]:
    """Return the first parts of the names imported by a statement."""
    if isinstance(node, ast.Import):
        return [alias.name.partition(".")[0] for alias in node.names]
    if isinstance(node, ast.ImportFrom) and node.level <= 1:
        return [node.module.partition(".")[0]] if node.module else [alias.name for alias in node.names]
    return []


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, Mapping):
        for item in value.values():
            yield from _texts(item)
    elif isinstance(value, (list, tuple)):
        for item in value:
            yield from _texts(item)


def _is_common(origin: Path) -> bool:
    """Return whether a module belongs to Python or to a regularly installed package."""
    paths = sysconfig.get_paths()
    return any(origin.is_relative_to(paths[key]) for key in ("stdlib", "platstdlib", "purelib", "platlib"))
