"""Hosts run user modules, one host per language."""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from mjsim.closing import Closes
from mjsim.errors import UsageError
from mjsim.world import Source, Use

if TYPE_CHECKING:  # Slow to load, and not needed to inspect files.
    from mjsim.interface import BeaconInfo, WorldMap

Provenance = Literal["shipped", "installed", "beside"]
"""Part of mjsim, in another package, or in files beside the world."""


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


@dataclass(frozen=True, slots=True, kw_only=True)
class Offer:
    """A module that a file offers for a role, found in its text."""

    role: str
    use: str
    """Its `use:` in a world file."""
    title: str
    about: str = ""
    keys: Sequence[Key] = field(default=())


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
    def files(self, uses: Sequence[Use], source: Source) -> Mapping[str, bytes]:
        """Return the files of modules by path, relative to the world's folder.

        Raises:
            UsageError: A file cannot be read.
        """

    @abstractmethod
    def offers(self, files: Sequence[tuple[Path, str]]) -> Iterator[Offer]:
        """Yield the modules in files; each file is given with its part of `use:` before the colon."""

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


def read_code(path: Path, source: Source) -> bytes:
    """Return the content of a code file after checking that it may run; only run these bytes.

    Args:
        path: Path of the file, beside the world or below.
        source: Source of the world.

    Raises:
        UsageError: It may not run with this content, or cannot be read.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise UsageError(f"cannot read '{path}': {error.strerror}") from error
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
