"""The files of a robot as its manufacturer lays them out: beside the description, in parents, in ROS packages."""

import os
import posixpath
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from xml.etree.ElementTree import Element

from mjsim.errors import UsageError, did_you_mean, file_meant
from mjsim.exchange.robots.folders import Folders
from mjsim.exchange.robots.sdf_robot import urdf_of_sdf
from mjsim.inventory import Fate, FileItem
from mjsim.models import (
    ROBOT_PARTS,
    Given,
    PlacedError,
    SaidDrive,
    XacroBudget,
    XacroError,
    drives_in_parameters,
    line_and_column,
    line_of,
    names_in,
    parsed,
    plain_yaml,
    resolved,
    sdf_named_in,
)

ROBOT_ENDINGS = (".urdf", ".xacro", ".sdf", ".xml", ".mjcf")
_URI = re.compile(rb"(?:package|model)://([A-Za-z0-9_.-]+)/?([^\"'<>\s]*)")
_FILE = re.compile(rb"file://(/[^\"'<>]*)")
_NO_NUMBER = re.compile(rb"""=\s*["'](?:[^"'<>]*\s)?[+-]?nan[\s"']""", re.IGNORECASE)
"""An attribute that contains the word `nan`."""


class RobotSource:
    """Reads the files of one robot; it opens nothing outside the robot's folders and the ROS packages that it names."""

    def __init__(
        self, path: Path, *, packages: Mapping[str, Path], given: Given, search: Sequence[Path] = (), model: str = ""
    ) -> None:
        """Locate the description.

        Args:
            path: A URDF, xacro, SDF or MJCF file.
            packages: Folders of ROS packages by name; they take precedence.
            given: Arguments and variables for xacro.
            search: Folders in which the user keeps ROS packages.
            model: Name of the robot in an SDF file with several.

        Raises:
            UsageError: The file does not exist.
        """
        if path.is_dir():
            raise UsageError(f"'{path}' is a folder; name a URDF, SDF or MJCF file in it")
        if not path.is_file():
            meant = file_meant(path, ROBOT_ENDINGS, otherwise="a URDF, SDF or MJCF file")
            raise UsageError(f"no file '{path}'{meant}")
        self._given, self._path = path, path.resolve()
        self._folders, self._xacro = Folders(self._path, packages, search=search), given
        self._root = self._folders.root
        self._asked: frozenset[str] = frozenset()
        self._parameters: set[str] = set()
        self.absent: tuple[tuple[str, str], ...] = ()
        """Place of each include of xacro that was not found, and what is missing."""
        self._packages, self._model = packages, model
        self.moved: list[str] = []
        """Files named by their path on another machine."""
        self.sdf = False
        """Whether it is SDF."""
        self.changed: list[FileItem] = []
        """Contents of an SDF file that its conversion to URDF changed or left out."""
        self.expanded = False
        """Whether xacro changed the text of the description."""

    @property
    def missing(self) -> set[str]:
        """Packages that were named but not found."""
        return self._folders.missing

    @property
    def installed(self) -> list[FileItem]:
        """Files that are elsewhere in a package once it is installed."""
        found = sorted(self._folders.installed.items())
        return [FileItem(Fate.MENDED, "file", name, f"it is '{place}' before a build") for name, place in found]

    def unused(self) -> list[FileItem]:
        """Return options of the user that the file does not use."""
        known = ", ".join(sorted(self._asked)) or "none"
        asked = f"xacro uses no such name; those that it uses: {known}"
        given = {"--arg": self._xacro.arguments, "--env": self._xacro.environment}
        found = [(option, name, asked) for option, names in given.items() for name in names if name not in self._asked]
        gone = [name for name in self._packages if name not in self._folders.used]
        if self._model and not self.sdf:
            found.append(("--model", self._model, "the file is not SDF, and has one robot"))
        found += [("--package", name, "the file names no such package") for name in gone]
        return [FileItem(Fate.LEFT_OUT, option, name, why) for option, name, why in found]

    @property
    def name(self) -> str:
        """Path of the description, as accepted by `read`."""
        return self._path.relative_to(self._root).as_posix()

    def read(self, name: str) -> bytes:
        """Return a file by its path from the root, or by `@PACKAGE/...`.

        Raises:
            ValueError: The file does not exist, or lies outside the allowed folders.
        """
        data = self._bytes(name)
        if name != self.name or data[:2] == b"\x1f\x8b":
            return data
        return self._description(data)

    def drives(self) -> list[SaidDrive]:
        """Return what the parameters of controllers in the robot's packages state about its drive.

        If the description names one of these files, as for ros2_control, the others belong to other robots.
        """
        found: list[SaidDrive] = []
        budget, paths = XacroBudget(), list(self._folders.parameters())
        for path in [path for path in paths if path.name in self._parameters] or paths:
            with suppress(XacroError):
                value = plain_yaml(self._folders.read(path), str(path), budget, lambda text: text)
                found += drives_in_parameters(value, f"controllers of {path.name}")
        return found

    def placed(self, text: str) -> str:
        """Return a message about this file with line and column of the first part that it names."""
        head = f"{self._given}: "
        if not text.startswith(head):
            return text
        written = self._bytes(self.name)
        found = next((start for name in names_in(text) if (start := line_of(name, written)) is not None), None)
        return text if found is None else f"{self._given}:{found.line}:{found.column}: {text.removeprefix(head)}"

    def shown(self, note: str) -> str:
        """Return a message with the path from the root replaced by the path that the user gave."""
        return note.replace(self.name, str(self._given), 1)

    def described(self, error: ValueError) -> str:
        """Return an error about a file of the robot with the path that the user gave."""
        folder = posixpath.dirname(self.name)
        written = self._bytes(self.name)
        if "XML contains a 'NaN'" in str(error) and (match := _NO_NUMBER.search(written)):
            line, column = line_and_column(match.start(), written)
            return f"{self._given}:{line}:{column}: a value is not a number (nan); correct it"
        if not isinstance(error, PlacedError):
            text = (
                str(error).replace(f"'{self.name}': ", f"{self._given}: ").replace(f"'{self.name}'", f"'{self._given}'")
            )
            return self.placed(text.replace(f"'{folder}/", f"'{self._given.parent}/") if folder else text)
        problem = f"MuJoCo cannot read {error.what}"
        if error.path != self.name:
            return f"{self._root / error.path}:{error.start.line}:{error.start.column}: {problem}"
        if self.expanded:
            return self.placed(f"{self._given}: {problem}")
        return f"{self._given}:{error.start.line}:{error.start.column}: {problem}"

    def _description(self, data: bytes) -> bytes:
        """Return the description with xacro resolved, and package paths in the form accepted by `read`."""
        written, root = parsed(data, self._given)
        found = resolved(written, self._path, shown=self._given, given=self._xacro, files=self._folders)
        text, self._asked, self.absent = found.text, found.asked, found.missing
        if root.tag == "sdf":
            self.sdf = True
            text, self.changed = urdf_of_sdf(root, str(self._given), self._included, model=self._model)
        self.expanded = text != written
        if self.expanded:
            _, root = parsed(text.encode(), self._given)
        _check_links(root, data, self._given)
        others = {part.tag for part in root} - ROBOT_PARTS if root.tag == "robot" else ()
        unknown = sorted(tag for tag in others if not tag.startswith("{"))
        self.changed += [FileItem(Fate.LEFT_OUT, "element", tag, "not one of URDF") for tag in unknown]
        self._parameters = {posixpath.basename((each.text or "").strip()) for each in root.iter("parameters")}
        depth = self.name.count("/")

        def named(match: "re.Match[bytes]") -> bytes:
            package, rest = match[1].decode(), match[2].decode("utf-8", "replace")
            self._folders.package(package)
            return f"{'../' * depth}@{package}/{rest}".encode()

        return _FILE.sub(self._local, _URI.sub(named, text.encode()))

    def _included(self, uri: str) -> tuple[Element, str] | None:
        """Return the root of the SDF file of a model, and the URI of its folder; None if it is missing."""
        # There may be a local copy of a model from a server.
        name = uri.rstrip("/").rpartition("/")[2]
        folder = self._folders.package(name)
        if folder is None:
            return None
        names = ["model.sdf"]
        with suppress(XacroError, UsageError):
            names = [*sdf_named_in(self._tree(folder / "model.config")), *names]
        for file in names:
            with suppress(XacroError):
                return self._tree(folder / file), f"model://{name}/"
        return None

    def _tree(self, path: Path) -> Element:
        return parsed(self._folders.read(path), path)[1]

    def _local(self, match: "re.Match[bytes]") -> bytes:
        """Return an absolute path relative to the folder of the description."""
        path = Path(os.path.normpath(match[1].decode("utf-8", "replace")))
        found = self._folders.moved(path)
        if found is not None:
            self.moved.append(path.name)
            path = found
        return os.path.relpath(path, self._path.parent).encode()

    def _bytes(self, name: str) -> bytes:
        base, rest = self._root, name
        if name.startswith("@"):
            package, _, rest = name[1:].partition("/")
            folder = self._folders.package(package)
            if folder is None:
                raise ValueError(f"no package '{package}'")
            base = folder
        place = base / rest
        if not place.is_file() and (other := self._folders.in_other_case(base, rest)) is not None:
            note = FileItem(Fate.MENDED, "file", Path(rest).name, f"it is '{os.path.relpath(other, base)}' on the disk")
            self.changed += [note] if note not in self.changed else []
            place = other
        elif (source := self._folders.unbuilt(base, rest)) is not None:
            place = source
        return self._folders.read(place)


def _check_links(root: Element, data: bytes, path: Path) -> None:
    """Check that the links of all joints exist, and that these connect all links.

    Raises:
        UsageError: They do not; the message has the line.
    """
    links = {link.get("name", "") for link in root.findall("link")}
    for kind in ("link", "joint"):
        names = [item.get("name", "") for item in root.findall(kind)]
        twice = next((name for name in names if names.count(name) > 1), None) if len({*names}) < len(names) else None
        if twice:
            raise UsageError(
                f"{_location(twice, data, path)}: two {kind}s are called '{twice}'; give each its own name"
            )
    _check_loops(root, data, path)
    for joint in root.findall("joint"):
        name = joint.get("name", "")
        for end in ("parent", "child"):
            found = joint.find(end)
            link = None if found is None else found.get("link")
            if link not in links:
                location = _location(name, data, path)
                which = f"names link '{link}', which does not exist" if link else f"has no {end}"
                suggestion = did_you_mean(link, links) if link else "; name one of its links"
                raise UsageError(f"{location}: joint '{name}' {which}{suggestion}")
    carried = {end.get("link") for joint in root.findall("joint") for end in joint.findall("child")}
    roots = [name for link in root.findall("link") if (name := link.get("name", "")) not in carried]
    if len(roots) > 1:
        problem = f"no joint carries link '{roots[1]}', nor '{roots[0]}'; a robot has one such link, its root"
        raise UsageError(f"{_location(roots[1], data, path)}: {problem}")


def _location(name: str, data: bytes, path: Path) -> str:
    """Return the position of a named element, as messages begin with it."""
    start = line_of(name, data)
    return f"{path}" if start is None else f"{path}:{start.line}:{start.column}"


def _check_loops(root: Element, data: bytes, path: Path) -> None:
    """Check that no link is the child of two joints, or its own ancestor.

    Raises:
        UsageError: A link is.
    """
    above: dict[str, tuple[str, str]] = {}
    for joint in root.findall("joint"):
        ends = [end.get("link", "") if (end := joint.find(which)) is not None else "" for which in ("parent", "child")]
        parent, child, name = ends[0], ends[1], joint.get("name", "")
        if child and child in above:
            problem = f"joints '{above[child][1]}' and '{name}' both carry link '{child}'; a link has one parent joint"
            raise UsageError(f"{_location(name, data, path)}: {problem}")
        above[child] = parent, name
        at, seen = child, set[str]()
        while at in above and at not in seen:
            seen.add(at)
            at = above[at][0]
        if at and at in seen:
            raise UsageError(
                f"{_location(name, data, path)}: joint '{name}' closes a loop of links; URDF allows only trees"
            )
