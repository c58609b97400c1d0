"""Collects the Python files that user modules need, so that they can be copied to another machine."""

import ast
import importlib.util
import sys
import sysconfig
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from mjsim.errors import UsageError
from mjsim.modules.python.places import place_of
from mjsim.syntax import parse_python
from mjsim.world import Source, Use

INSTALLED = "modules"
"""Folder for the user's own files that are not beside the world file: packages under development."""


def python_files(uses: Sequence[Use], source: Source) -> dict[str, bytes]:
    """Return the files of classes that a world names with `use:`, by their paths relative to its folder.

    Each module is accompanied by its imports, if they are beside it or in a package under development, and by files
    beside it that are named in its text or in the keys beside `use`.

    Raises:
        UsageError: A file cannot be read.
    """
    follower = _Follower((source.folder or Path.cwd()).resolve())
    for use in uses:
        follower.take_use(use)
    return follower.files


class _Follower:
    """Follows imports from file to file."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._bases = {folder: ""}
        self.files: dict[str, bytes] = {}

    def take_use(self, use: Use) -> None:
        place = use.use.rpartition(":")[0]
        if place.endswith(".py"):
            if (self._folder / place).is_file():
                self._take_file(self._folder / place, self._folder)
        else:
            self._take_import(place.partition(".")[0], self._folder, self._folder)
        for text in _texts(use.arguments()):
            self._take_data(self._folder / text, self._folder)

    def _take_file(self, path: Path, base: Path) -> None:
        """Collect a file and its imports; `base` is the folder from which it is imported."""
        name = self._bases[base] + path.relative_to(base).as_posix()
        if name in self.files:
            return
        try:
            self.files[name] = data = path.read_bytes()
        except OSError as error:
            raise UsageError(f"cannot read '{path}': {error.strerror}") from error
        if path.suffix != ".py":
            return
        try:
            tree = parse_python(data)
        except (SyntaxError, ValueError):
            return  # The error will be reported when it is run.
        for node in ast.walk(tree):
            for top in _imported(node):
                self._take_import(top, path.parent, base)
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                self._take_data(path.parent / node.value, base)

    def _take_import(self, top: str, beside: Path, base: Path) -> None:
        """Collect a module or package by the first part of its name."""
        place = place_of(beside, top)
        if place is None and top not in sys.stdlib_module_names and top != "mjsim":
            self._take_installed(top)
        elif place == beside / f"{top}.py":
            self._take_file(place, base)
        elif place is not None:
            self._take_package(beside / top, base)

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
        if not name or len(name) > 100 or not path.suffix or "\n" in name or "\0" in str(path) or ".." in path.parts:
            return
        with suppress(OSError):
            if path.is_relative_to(base) and path.is_file():
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
