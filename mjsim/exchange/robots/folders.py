"""The folders in which the files of a robot are: its own, and those of ROS packages; nothing else is opened."""

import glob
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path

from mjsim.models import XacroError
from mjsim.world import read_regular

MAX_BYTES = 64_000_000
"""Maximum size of one file [bytes]."""
MAX_PARENTS = 3
"""Number of parent folders of the description that may be its package."""
MANIFEST_FILES = ("package.xml", "manifest.xml", "model.config")
"""A folder that contains one of these is a ROS package, or a model of Gazebo."""
PACKAGE_FOLDERS = ("meshes", "assets", "urdf")
"""A folder that contains one of these is laid out like a package."""
DESCRIPTION = "_description"
PACKAGE_SUFFIXES = ("_control", "_controllers", "_bringup", "_base", "_node", "_gazebo", "_controller_configuration")
"""Packages of a robot beside NAME_description: NAME with one of these endings."""
PARAMETER_FOLDERS = ("config", "param", "params")
"""Folders of a package that hold parameters of its controllers."""
MAX_PARAMETERS, MAX_YAML = 100, 100_000
"""Maximum number of such files in a folder, and their maximum size [bytes]."""
MAX_BESIDE = 200
"""Maximum number of folders in a folder that are examined."""
MAX_LISTED = 10_000
"""Maximum number of files in a folder that are searched for a name."""
_DECLARED = re.compile(rb"<name>\s*([A-Za-z][A-Za-z0-9_.-]{0,99})\s*</name>")
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_.-]{0,99}")
_PATTERN = re.compile(r"[*?[]")


class Folders:
    """Opens files in the package of a description, and in the packages that it names."""

    def __init__(self, path: Path, packages: Mapping[str, Path], *, search: Sequence[Path] = ()) -> None:
        """Find the package of a description: the nearest folder around it that is one, else its own folder.

        Args:
            path: The description, absolute, without links.
            packages: Folders of ROS packages by name; they take precedence.
            search: Folders in which the user keeps ROS packages.
        """
        self._path, self._search = path, search
        around = [path.parent, *path.parent.parents][: MAX_PARENTS + 1]
        likely = [folder for signs in (MANIFEST_FILES, PACKAGE_FOLDERS) for folder in around if _has(folder, signs)]
        self.root = likely[0] if likely else path.parent
        self._name = _declared(self.root) or self.root.name
        self._packages = {name: folder.resolve() for name, folder in packages.items()}
        self.used: set[str] = set()
        """Packages that the description names."""
        self.missing: set[str] = set()
        """Packages that were named but not found."""
        self.installed: dict[str, str] = {}
        """Paths that files have in a package that is installed, and in its source."""

    def package(self, name: str) -> Path | None:
        """Return the folder of a ROS package; None if it was not found."""
        self.used.add(name)
        if name not in self._packages:
            places = self._likely(name) if _NAME.fullmatch(name) else []
            found = next((place for place in places if place.is_dir()), None)
            if found is None:
                self.missing.add(name)
                return None
            self._packages[name] = found.resolve()
        return self._packages[name]

    def parameters(self) -> Iterator[Path]:
        """Yield the YAML files of the description's packages, and of those beside them for the same robot."""
        known = {self._name: self.root, **self._packages}
        for name in [name for name in known if name.endswith(DESCRIPTION)]:
            for ending in PACKAGE_SUFFIXES:
                other = name.removesuffix(DESCRIPTION) + ending
                place = next((p for p in self._likely(other) if p.is_dir() and _has(p, MANIFEST_FILES)), None)
                if place is not None and other not in self._packages:
                    known[other] = self._packages[other] = place.resolve()
        for package in known.values():
            for folder in PARAMETER_FOLDERS:
                places = [package / folder, *(place / folder for place in _folders_in(package))]
                files = [path for place in places for path in sorted(place.glob("*.y*ml"))[:MAX_PARAMETERS]]
                yield from (path for path in files if path.is_file() and path.stat().st_size < MAX_YAML)

    def _likely(self, name: str) -> list[Path]:
        """Return where a package may be; only the user's own settings name folders that do not look like one."""
        around = [self._path.parent, *self._path.parent.parents]
        named = [place for place in around if name in (place.name, _declared(place))]
        near = around[: MAX_PARENTS + 2]
        beside = [*(place / name for place in near), *(found for place in near for found in _renamed(place, name))]
        given = [place for path in self._search for place in _in_path(path, name)]
        signs = (*MANIFEST_FILES, *PACKAGE_FOLDERS)
        return [*(place for place in named if _has(place, signs)), *given, *(p for p in beside if _has(p, signs))]

    def locate(self, name: str, beside: Path) -> list[Path]:
        """Return the paths of a file, or of all files of a pattern.

        Args:
            name: A path or pattern; relative, or in a package, as `package://NAME/PATH`.
            beside: Folder from which a relative path starts.

        Raises:
            XacroError: A package was not found, or the path is outside the folders.
        """
        package, _, rest = name.removeprefix("package://").partition("/")
        if name.startswith("package://"):
            folder = self.package(package)
            if folder is None:
                problem = f"it names the package '{package:.60}', which was not found"
                raise XacroError(f"{problem}; give --package {package:.60}=DIR")
            beside, name = folder, rest
        match = _PATTERN.search(name)
        if match is None:
            place = self._inside(beside / name)
            return [self.unbuilt(beside, name) or place]
        start = name[: match.start()].rfind("/") + 1
        folder, pattern = self._inside(beside / name[:start]), name[start:]
        if "/" in pattern:
            raise XacroError(f"the folder in '{name:.60}' is a pattern; name it, and write * in names of files only")
        return [self._inside(folder / found) for found in sorted(glob.glob(pattern, root_dir=folder))]

    def read(self, path: Path) -> bytes:
        """Return the contents of a file in one of the folders.

        Raises:
            XacroError: It is not in them, is not a file, or is too large.
        """
        place = self._inside(path)
        try:
            return read_regular(place, limit=MAX_BYTES)
        except FileNotFoundError as error:
            raise XacroError(f"no file '{path}': {error.strerror}") from None
        except OSError as error:
            raise XacroError(f"'{path}' cannot be read: {error.strerror}; name a smaller or another file") from None

    def moved(self, path: Path) -> Path | None:
        """Return the path here of a file named by its absolute path on another machine; None if it is missing."""
        if any(path.is_relative_to(folder) for folder in (self.root, *self._packages.values())):
            return None
        tails = [Path(*path.parts[start:]) for start in range(1, len(path.parts))]
        folders = {self._name: self.root, **self._packages}
        for tail in tails:
            for name, folder in folders.items():
                place = folder / tail.relative_to(name) if tail.is_relative_to(name) else folder / tail
                if len(tail.parts) > 1 and place.is_file():
                    return place
        return None

    def unbuilt(self, package: Path, name: str) -> Path | None:
        """Return the only file of a package with this path below one of its folders, as CMake installs their contents.

        None if the package has a file of this path itself, or not one such.
        """
        # Names may be too long for `Path.is_file`, which would raise.
        if os.path.isfile(package / name) or package not in self._packages.values():
            return None
        found = [place for folder in _folders_in(package) if os.path.isfile(place := folder / name)]
        if len(found) != 1:
            return None
        self.installed[name] = os.path.relpath(found[0], package)
        return self._inside(found[0])

    def in_other_case(self, base: Path, name: str) -> Path | None:
        """Return the file below a folder whose name differs only in case, as Windows opens it; None if there is none.

        Raises:
            XacroError: It would be outside the folders.
        """
        self._inside(base / name)
        place = base
        for part in Path(os.path.normpath(name)).parts:
            own = place / part
            likely = [own] if part == ".." or own.exists() else _alike(place, part)
            if len(likely) != 1:
                return None
            place = likely[0]
        return place if place.is_file() else None

    def _inside(self, path: Path) -> Path:
        """Return a path without links.

        Raises:
            XacroError: It is outside the folders.
        """
        allowed = [self.root, *self._packages.values()]
        place = Path(os.path.normpath(path))
        for _ in range(2):  # First as written, so that nothing outside is accessed, then with its links followed.
            if not any(place.is_relative_to(folder) for folder in allowed):
                raise XacroError(
                    f"'{path!s:.200}' lies outside of the robot's folder and its packages; copy it to them"
                )
            try:
                place = place.resolve()
            except (OSError, RuntimeError, ValueError):
                raise XacroError(f"no file '{str(path)!r:.100}'; correct its name") from None
        return place


def _folders_in(package: Path) -> list[Path]:
    """Return the folders of a package, the first of them, except other packages."""
    try:
        folders = [place for place in sorted(package.iterdir())[:MAX_BESIDE] if place.is_dir()]
        return [folder for folder in folders if not _has(folder, MANIFEST_FILES)]
    except OSError:
        return []


def _alike(folder: Path, name: str) -> list[Path]:
    """Return the entries of a folder with a name, regardless of case."""
    try:
        return [each for each in islice(folder.iterdir(), MAX_LISTED) if each.name.casefold() == name.casefold()]
    except OSError:
        return []


def _has(folder: Path, names: Iterable[str]) -> bool:
    return any((folder / name).exists() for name in names)


def _declared(folder: Path) -> str | None:
    """Return the name of a package by its manifest; a folder that was downloaded is NAME-main."""
    try:
        found = _DECLARED.search(read_regular(folder / MANIFEST_FILES[0], limit=MAX_YAML))
    except OSError:
        return None
    return found[1].decode() if found else None


def _renamed(folder: Path, package: str) -> Iterator[Path]:
    """Yield the folders in a folder that are a package only according to their manifest."""
    try:
        yield from (place for place in sorted(folder.iterdir())[:MAX_BESIDE] if _declared(place) == package)
    except OSError:
        return


def _in_path(path: Path, package: str) -> list[Path]:
    """Return where a package may lie below a folder of packages."""
    own = [path] if path.name == package else []
    try:
        deeper = [place / package for place in sorted(path.iterdir()) if place.is_dir()][:MAX_BESIDE]
    except OSError:
        deeper = []
    return [*own, path / package, *deeper]
