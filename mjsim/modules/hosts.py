"""Hosts run user modules, one host per language."""

import os
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any, Literal

from mjsim.closing import Closes
from mjsim.errors import UsageError, did_you_mean
from mjsim.sentences import Sentence
from mjsim.world import OutsideError, Source, Use, place_in, read_regular

if TYPE_CHECKING:  # Slow to load, and not needed to inspect files.
    from mjsim.interface import BeaconInfo, WorldMap

Provenance = Literal["shipped", "installed", "beside"]
"""Part of mjsim, in another package, or in files beside the world."""
MAX_BYTES = 100_000_000
"""Maximum size of a file with code [bytes]."""


@dataclass(frozen=True, slots=True)
class Defect:
    """A problem of a module, found without running it."""

    message: str
    key: str = "use"
    """Location: a key of the mapping with `use`."""
    missing: bool = True
    """Whether something does not exist, which is an error of the world file, not of the module."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Key:
    """A key that a module takes beside `use`."""

    name: str
    about: str = ""
    default: Any = None
    required: bool = False
    schema: Mapping[str, Any] = field(default_factory=dict)
    """JSON Schema of its value as far as it is known, without default and description."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Offer:
    """A module that a file offers for a role, found in its text."""

    role: str
    use: str
    """Its `use:` in a world file."""
    title: str
    about: str = ""
    keys: Sequence[Key] = field(default=())
    parts: frozenset[str] = frozenset()
    """Fields of `RobotInfo` because of which it refuses robots: arms, balancing, max_left."""


class Host(ABC):
    """Runs the modules of one language. All methods except `make` inspect files without running them."""

    @abstractmethod
    def speaks(self, use: str) -> bool:
        """Return whether a `use:` names a module of this language."""

    @abstractmethod
    def origin(self, use: str) -> Provenance:
        """Return the origin of a module."""

    @abstractmethod
    def place(self, use: str) -> str:
        """Return the file of a module, relative to the world's folder, or its package."""

    @abstractmethod
    def runs(self, file: str) -> bool:
        """Return whether a file of a module is code rather than data, from its name."""

    @abstractmethod
    def defects(self, use: Use, role: str, source: Source) -> Iterator[Defect]:
        """Yield problems of a module, and why it does not fit a role."""

    @abstractmethod
    def files(self, uses: Sequence[Use], source: Source, *, data: bool = True) -> Mapping[str, bytes]:
        """Return the files of modules by path, relative to the world's folder.

        Args:
            uses: The modules.
            source: Source of the world.
            data: Whether to include files other than code.

        Raises:
            UsageError: A file cannot be read, or there are too many.
        """

    def elsewhere(self, uses: Sequence[Use], source: Source) -> Sequence[Path]:
        """Return the files outside the world's folder that modules name, where that is possible."""
        return ()

    @abstractmethod
    def offers(self, files: Sequence[tuple[Path, str]]) -> Iterator[Offer]:
        """Yield the modules in files; each file is given with its part of `use:` before the colon."""

    def readings(self, use: Use, role: str, source: Source) -> Iterator[str]:
        """Yield the fields of `Observation` that a module uses, as far as its text shows."""
        return iter(())

    def key(self, use: Use, name: str, source: Source) -> object:
        """Return the value of a key of a module, or its default as far as its text shows it."""
        return use.arguments().get(name)

    def at_hand(self, named: str) -> tuple[Path | None, str]:
        """Return the folder of a module, and its `use:`, for a name on the command line."""
        return None, named

    @abstractmethod
    def make(self, use: Use, source: Source, *, role: str, robot: str) -> Any:
        """Create a module, ready for `start`, where expensive work happens.

        Code beside the world is read by `read_code`, so that only code that the user allowed runs.

        Raises:
            UsageError: It does not exist, or does not accept these keys.
            ModuleFault: It exists but fails.
        """


def folder_of(source: Source) -> Path:
    """Return the base folder of a world's paths."""
    return (source.folder or Path.cwd()).resolve()


def beside(name: str, source: Source, *, folder: bool = False) -> Path:
    """Return a file, or folder, within the folder of the world.

    Raises:
        ValueError: It does not exist, is of another kind, or is outside that folder.
    """
    home, exists = folder_of(source), os.path.isdir if folder else os.path.isfile
    try:
        path = place_in(home, name)
        if exists(path):
            return path
    except OutsideError:
        raise ValueError(
            Sentence("path '{name}' is outside the folder of the world; keep it beside the world file", name)
        ) from None
    except ValueError:
        pass  # No file can have this name.
    suffix, known = PurePath(name).suffix, list[str]()
    with suppress(OSError):
        known = [item.name for item in home.iterdir() if exists(item) and item.name.endswith(suffix)]
    kind = "folder" if folder else "file"
    raise ValueError(Sentence("no {kind} '{name}' beside the world file{meant}", kind, name, did_you_mean(name, known)))


def read_code(path: Path, source: Source) -> bytes:
    """Return the content of a code file after checking that it may run; only run these bytes.

    Args:
        path: Path of the file, beside the world or below.
        source: Source of the world.

    Raises:
        UsageError: It may not run with this content, cannot be read, or is outside the folder of the world.
    """
    try:
        beside(os.path.relpath(path, folder_of(source)), source)
    except ValueError as error:
        raise UsageError(str(error)) from None
    return read_admitted(path, source)


def read_admitted(path: Path, source: Source) -> bytes:
    """Return the content of a code file anywhere, as `read_code` does."""
    try:
        data = read_regular(path, limit=MAX_BYTES)
    except OSError as error:
        raise UsageError(Sentence("cannot read '{path}': {strerror}", path, error.strerror)) from error
    if source.admit is not None:
        source.admit(path, data)
    return data


class Failed(Exception):  # noqa: N818  # as the faults of `mjsim.errors`
    """Error of a hosted module; the text is a sentence without its subject."""


class Hosted(Closes):
    """A module with resources, such as a process: it is closed when the run ends."""

    place: str = ""
    """Its location, such as 'my_slam.m:1', for errors without a location."""

    @property
    @abstractmethod
    def name(self) -> str:
        """Its name in messages."""

    def take_world(self, catalogue: "Mapping[str, BeaconInfo]", map: "WorldMap | None") -> None:
        """Get the catalogue and the map before `start`, in any role; the map is None unless `map: known`."""
