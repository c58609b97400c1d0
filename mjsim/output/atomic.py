"""Writes files atomically: a reader sees the old or the new content, also after a crash or a power failure."""

import contextlib
import os
import secrets
import time
from collections.abc import Iterator
from pathlib import Path

NEW = ".mjsim-{}.new"
"""Name of a file while it is being written; short enough to fit wherever the final name does."""
LEFT_BEHIND = 60.0
"""Age at which such a file counts as left behind by a killed process [s]."""


def write_whole(place: Path, data: bytes) -> None:
    """Write a file of the user atomically, with the mode and owner of the file that it replaces.

    Raises:
        OSError: It cannot be written; the old content stays.
    """
    remove_leftovers(place.parent)
    mode = 0o666
    with contextlib.suppress(FileNotFoundError):
        mode = place.stat().st_mode & 0o7777
        if not os.access(place, os.W_OK):
            raise PermissionError(13, "the file is write-protected")
    with _written(place, data, mode=mode) as new:
        _keep_owner(place, new, mode)
        new.replace(place)
    _keep_name(place)


def write_new(place: Path, data: bytes) -> None:
    """Create a file of the user atomically.

    Raises:
        FileExistsError: The file exists, even if it was created during this call.
        OSError: It cannot be written.
    """
    remove_leftovers(place.parent)
    with _written(place, data, mode=0o666) as new:
        try:
            os.link(new, place)
        except FileExistsError:
            raise
        except OSError:  # a file system without hard links
            if place.exists():
                raise FileExistsError(17, "File exists") from None
            new.replace(place)
    _keep_name(place)


def replace_file(place: Path, data: bytes, *, mode: int = 0o666) -> None:
    """Write a file of our own atomically, whatever it was before.

    Args:
        place: The file; its folder exists.
        data: Its content.
        mode: Its permissions, less those of the umask: 0o600 for files that no other user may read.

    Raises:
        OSError: It cannot be written; the old content stays.
    """
    with _written(place, data, mode=mode) as new:
        new.replace(place)


def remove_leftovers(folder: Path) -> None:
    """Remove files in a folder that killed processes left behind."""
    with contextlib.suppress(OSError):
        for path in folder.glob(NEW.format("*")):
            if time.time() - path.lstat().st_mtime > LEFT_BEHIND:
                path.unlink(missing_ok=True)


@contextlib.contextmanager
def _written(place: Path, data: bytes, *, mode: int) -> Iterator[Path]:
    """Yield a temporary file beside a path with all the data, synced to disk; it is removed after the block."""
    new = place.with_name(NEW.format(secrets.token_hex(8)))
    try:
        with os.fdopen(os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode), "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        yield new
    finally:
        new.unlink(missing_ok=True)


def _keep_name(place: Path) -> None:
    """Sync the folder, so that a power failure does not bring back the previous file of this name."""
    with contextlib.suppress(OSError):  # not supported by all file systems
        folder = os.open(place.parent, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)


def _keep_owner(place: Path, new: Path, mode: int) -> None:
    """Give a new file the owner and mode of the one that it replaces, as far as permitted."""
    with contextlib.suppress(FileNotFoundError):
        old = place.stat()
        for owner, group in ((-1, old.st_gid), (old.st_uid, -1)) if hasattr(os, "chown") else ():
            with contextlib.suppress(PermissionError):
                os.chown(new, owner, group)
    new.chmod(mode)
