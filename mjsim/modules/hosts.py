"""Hosts run user modules, one host per language."""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from mjsim.closing import Closes
from mjsim.errors import UsageError
from mjsim.world import Source, Use

if TYPE_CHECKING:  # Slow to load for those who only look at files.
    from mjsim.interface import BeaconInfo, WorldMap

Provenance = Literal["shipped", "installed", "beside"]
"""With mjsim, in some other package, or in files beside the world."""


@dataclass(frozen=True, slots=True)
class Doubt:
    """What is wrong with a module, found without running it."""

    message: str
    key: str = "use"
    """Where: a key of the mapping with `use`."""
    missing: bool = True
    """Whether something is not there, which is the world file's mistake; else it is the module's own."""


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
    """What a world file writes to name it."""
    title: str
    about: str = ""
    keys: Sequence[Key] = field(default=())


class Host(ABC):
    """Runs the modules of one language. All methods but `make` look at files without running them."""

    @abstractmethod
    def speaks(self, use: str) -> bool:
        """Return whether the text of `use:` names a module of this language."""

    @abstractmethod
    def origin(self, use: str) -> Provenance:
        """Return where a module comes from."""

    @abstractmethod
    def place(self, use: str) -> str:
        """Return the file, by its path from the world's folder, or the package that a module is in."""

    @abstractmethod
    def runs(self, file: str) -> bool:
        """Return whether a file of a module, by its name, is code rather than data."""

    @abstractmethod
    def doubts(self, use: Use, role: str, source: Source) -> Iterator[Doubt]:
        """Yield what is wrong with a module, and why it cannot fill a role."""

    @abstractmethod
    def files(self, uses: Sequence[Use], source: Source) -> Mapping[str, bytes]:
        """Return the files that modules consist of, by their paths from the world's folder.

        Raises:
            UsageError: A file cannot be read.
        """

    @abstractmethod
    def offers(self, files: Sequence[tuple[Path, str]]) -> Iterator[Offer]:
        """Yield the modules that files hold; each file comes with what a world file writes before the colon."""

    def at_hand(self, named: str) -> tuple[Path | None, str]:
        """Return the folder of a module, and its `use:`, for what a command line names from the working folder."""
        return None, named

    @abstractmethod
    def make(self, use: Use, source: Source, *, role: str, robot: str) -> Any:
        """Return a module that is ready for its role's `start`; what costs much begins there.

        Code beside the world is read by `read_code`, so that what runs is what somebody allowed.

        Raises:
            UsageError: It does not exist, or does not take these keys.
            ModuleFault: It is there, and fails.
        """


def read_code(path: Path, source: Source) -> bytes:
    """Return the content of a file of code, which may run; what is run must be made of these bytes.

    Args:
        path: Of the file, beside the world or below.
        source: Of the world.

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
    """Fault of a hosted module; the text is a sentence without its subject."""


class Hosted(Closes):
    """A live module that holds more than memory, such as a process: it is closed when the run ends."""

    place: str = ""
    """Where it is written, such as 'my_slam.m:1'; for what it does wrong without telling where."""

    @property
    @abstractmethod
    def name(self) -> str:
        """What it is called in messages."""

    def take_world(self, catalogue: "Mapping[str, BeaconInfo]", map: "WorldMap | None") -> None:
        """Get the catalogue and the map before `start`, in any role; the map is None unless `map: known`."""
