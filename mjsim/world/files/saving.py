"""Writing a file in one step: a reader sees the old content or the new one, also after a crash or a power cut."""

import contextlib
import os
import secrets
import time
from collections.abc import Iterator
from pathlib import Path

NEW = ".mjsim-{}.new"
"""Name of a file that is being written; short, so that it fits wherever the final name does."""
LEFT_BEHIND = 60.0
"""Age of such a file whose writer was killed [s]."""


def write_whole(place: Path, data: bytes) -> None:
    """Write a file in one step, with the mode and the owner of the file that it replaces.

    Raises:
        OSError: It cannot be written; what was there stays.
    """
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
    """Write a file that is not there yet, in one step.

    Raises:
        FileExistsError: It is there, even if it came while this was being written.
        OSError: It cannot be written.
    """
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


def write_private(place: Path, data: bytes) -> None:
    """Write a file in one step that nobody else may read.

    Raises:
        OSError: It cannot be written; what was there stays.
    """
    with _written(place, data, mode=0o600) as new:
        new.replace(place)


def remove_leftovers(folder: Path) -> None:
    """Remove what writers left behind in a folder when they were killed."""
    with contextlib.suppress(OSError):
        for path in folder.glob(NEW.format("*")):
            if time.time() - path.lstat().st_mtime > LEFT_BEHIND:
                path.unlink(missing_ok=True)


@contextlib.contextmanager
def _written(place: Path, data: bytes, *, mode: int) -> Iterator[Path]:
    """Yield a file beside a place that holds all of the data, on the disk; it is gone after the block."""
    remove_leftovers(place.parent)
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
    """Make sure that a power cut does not bring back what stood under a name before."""
    with contextlib.suppress(OSError):  # not all file systems can
        folder = os.open(place.parent, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)


def _keep_owner(place: Path, new: Path, mode: int) -> None:
    """Give a new file the owner and the mode of the one that it replaces, as far as the system lets us."""
    with contextlib.suppress(FileNotFoundError):
        old = place.stat()
        for owner, group in ((-1, old.st_gid), (old.st_uid, -1)):
            with contextlib.suppress(PermissionError):
                os.chown(new, owner, group)
        new.chmod(mode)
