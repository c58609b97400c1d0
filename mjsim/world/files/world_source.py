"""The origin of a world, and the files that it refers to."""

import contextlib
import difflib
import errno
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path, PurePosixPath
from typing import Any, Self

from mjsim.models import picture_size, require_picture
from mjsim.sentences import Sentence
from mjsim.world.files.within import OutsideError, place_in, read_regular

MAX_BYTES = 64_000_000
"""Maximum size of a picture [bytes]."""
_LEAVES = "path '{name}' is outside its folder; name a file beside the world file or in assets"
_BACKSLASH = "path '{name}' has a backslash; write / between folders"


@dataclass(frozen=True, slots=True)
class Source:
    """The origin of a world; worlds are equal regardless of their origin."""

    file: str = field(default="world", compare=False)
    """Name in messages."""
    text: str | None = field(default=None, compare=False)
    """The text that was read; None for a world built in Python."""
    folder: Path | None = field(default=None, compare=False)
    """Folder in which files are looked up first."""
    attached: Mapping[str, bytes] = field(default_factory=dict, compare=False)
    """Files attached to the world, as in a recording; they take precedence over the folder."""
    included: Mapping[str, bytes] = field(default_factory=dict, compare=False)
    """World files included by the text, by their paths relative to the folder."""
    variables: Mapping[str, bool | int | float | str] = field(default_factory=dict, compare=False)
    """Variables of the text and its included files, with their values."""
    written: Any = field(default=None, compare=False, repr=False)
    """Position of each value in the text, for internal use by the reader."""
    admit: Callable[[Path, bytes], None] | None = field(default=None, compare=False, repr=False)
    """Called with path and content of each code file beside the world before it is run; raises UsageError to forbid it.
    None allows all."""
    live: dict[str, Any] = field(default_factory=dict, compare=False, repr=False)
    """State that module hosts share between the modules of one run."""

    def for_run(self) -> Self:
        """Return a copy for one run, whose modules share nothing with those of other runs."""
        return replace(self, live={})


BUILT = Source()
"""A world that was built in Python."""


def has_asset(name: str, source: Source) -> bool:
    """Return whether `read_asset` would find a file."""
    if name in source.attached:
        return True
    if _leaves(PurePosixPath(name), name):
        return False
    with contextlib.suppress(ValueError):
        if _beside(name, source) is not None:
            return True
    return _exists(resources.files("mjsim.assets").joinpath(name))


def read_asset(name: str, source: Source) -> bytes:
    """Return the content of a file that a world names: attached, beside the world file, or shipped with mjsim.

    Raises:
        ValueError: The file does not exist, is too large, or lies outside the allowed folders.
    """
    if name in source.attached:
        return source.attached[name]
    if _leaves(PurePosixPath(name), name):
        raise ValueError((_BACKSLASH if "\\" in name else _LEAVES).format(name=name))
    beside = _beside(name, source)
    if beside is not None:
        return _read(beside, name)
    shipped = resources.files("mjsim.assets").joinpath(name)
    if _exists(shipped):
        return shipped.read_bytes()
    raise ValueError(
        Sentence("no file '{name}' beside the world file or in assets{suggestion}", name, _suggestion(name, source))
    )


def check_picture(name: str, source: Source) -> None:
    """Raise ValueError if a picture that a world names does not exist, or cannot be read."""
    data = read_asset(name, source)
    try:
        picture_size(data)
        require_picture(data, name)
    except ValueError as error:
        raise ValueError(Sentence("'{name}' {problem}", name, error)) from None


def _beside(name: str, source: Source) -> Path | None:
    """Return a file beside the world file; None if there is none.

    Raises:
        ValueError: Its links lead elsewhere.
    """
    if source.folder is None or not os.path.isfile(source.folder / name):
        return None
    try:
        return place_in(source.folder, name)
    except OutsideError:
        raise ValueError(_LEAVES.format(name=name)) from None
    except ValueError:
        return None


def _leaves(path: PurePosixPath, name: str) -> bool:
    return path.is_absolute() or ".." in path.parts or "\\" in name or not name.isprintable()


def _exists(file: Traversable) -> bool:
    try:
        return file.is_file()
    except OSError:  # its name is too long for the system
        return False


def _resolved(path: Path) -> Path | None:
    """Return a path with links resolved; None for a loop of links, or a name too long for the system."""
    try:
        return path.resolve(strict=True)
    except (OSError, RuntimeError):
        return None


def _read(path: Path, name: str) -> bytes:
    try:
        return read_regular(path, limit=MAX_BYTES)
    except OSError as error:
        if error.errno == errno.EFBIG:
            raise ValueError(Sentence("'{name}' is too large: {strerror}", name, error.strerror)) from None
        raise ValueError(
            Sentence("'{name}' cannot be read: {strerror}; change its permissions", name, error.strerror)
        ) from None


def _suggestion(name: str, source: Source) -> str:
    """Return '; did you mean ...?' for a similar name in the same folder, or this one in assets; otherwise ''."""
    folder = PurePosixPath(name).parent
    known: list[str] = []
    with contextlib.suppress(OSError):  # a folder with a name too long for the system
        if source.folder is not None:
            known += _names_in(source.folder.resolve(), folder)
        shipped = resources.files("mjsim.assets").joinpath(str(folder))
        if shipped.is_dir():
            known += [str(folder / item.name) for item in shipped.iterdir() if item.is_file()]
    matches = difflib.get_close_matches(name, filter(str.isprintable, known), n=1) or _namesakes(name)
    return Sentence("; did you mean '{word}'?", matches[0]) if matches else ""


def _namesakes(name: str) -> list[str]:
    """Return the shipped files of this name, with or without its suffix, in any folder."""
    folders = [folder for folder in resources.files("mjsim.assets").iterdir() if folder.is_dir()]
    files = [(folder.name, item.name) for folder in folders for item in folder.iterdir() if item.is_file()]
    return sorted("/".join(file) for file in files if PurePosixPath(file[1]).stem == PurePosixPath(name).stem)


def _names_in(base: Path, folder: PurePosixPath) -> list[str]:
    """Return the files of a folder by their paths relative to a base, except links that lead outside it."""
    place = _resolved(base / folder)
    if place is None or not place.is_relative_to(base) or not place.is_dir():
        return []
    found = ((item.name, _resolved(item)) for item in place.iterdir())
    return [str(folder / name) for name, file in found if file is not None and _is_within(file, base)]


def _is_within(file: Path, base: Path) -> bool:
    """Return whether a regular file or folder, with links resolved, lies in a folder."""
    return file.is_relative_to(base) and (file.is_file() or file.is_dir())
