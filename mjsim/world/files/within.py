"""Checks files that someone else's text names: their location, and whether they are regular files."""

import errno
import os
import stat
from pathlib import Path

from mjsim.sentences import Sentence

MAX_NAME_LENGTH = 255
"""Maximum length of a file name, as in file systems [bytes]."""


class OutsideError(ValueError):
    """A name is outside the folder that it is relative to."""


def place_in(folder: Path, name: str) -> Path:
    """Return the path, without `..`, of a file or folder below another, which need not exist.

    Args:
        folder: The folder; its own links are resolved.
        name: Relative to it; an absolute name must lead into it, too.

    Raises:
        OutsideError: It leads elsewhere, by itself or by links.
        ValueError: It is not a valid name, or its links form a loop.
    """
    home = folder.resolve()
    parts = Path(name).parts
    if not name.isprintable():
        raise ValueError(Sentence("path {name!r} is not a file name; write for example 'worlds/room.yaml'", name[:60]))
    if any(len(part.encode("utf-8", "replace")) > MAX_NAME_LENGTH for part in parts):
        raise ValueError(
            Sentence(
                "path '{name}...' has a name of more than {max_name_length} bytes; shorten it",
                name[:60],
                MAX_NAME_LENGTH,
            )
        )
    path = Path(os.path.normpath(home / name))
    try:
        resolved = path.resolve()
    except (OSError, RuntimeError):
        raise ValueError(Sentence("path '{name:.60}' cannot be resolved; name another", name)) from None
    if not resolved.is_relative_to(home):
        raise OutsideError(Sentence("path '{name}' is outside its folder", name))
    return path if path.is_relative_to(home) else resolved


def holds_file(folder: Path, path: Path) -> bool:
    """Return whether a path leads to a regular file in a folder, with links resolved."""
    try:
        return os.path.isfile(place_in(folder, str(path)))
    except ValueError:
        return False


def read_regular(path: Path, *, limit: int) -> bytes:
    """Return the content of a regular file; a pipe without a writer does not block.

    Args:
        path: The file.
        limit: Maximum size [bytes].

    Raises:
        OSError: It cannot be read, is not a regular file, or is larger.
    """
    with open(path, "rb", opener=_open_at_once) as file:
        status = os.fstat(file.fileno())
        if not stat.S_ISREG(status.st_mode):
            raise OSError(errno.EINVAL, "it is a pipe or a device, not a file", str(path))
        if status.st_size > limit:
            size = Sentence("it has {size:.0f} MB, more than {limit:.0f} MB", status.st_size / 1e6, limit / 1e6)
            raise OSError(errno.EFBIG, size, str(path))
        return file.read(limit)


def _open_at_once(path: str, flags: int) -> int:
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))
