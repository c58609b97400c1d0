"""Locks on open files, which end with the process that holds them."""

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_WITHOUT = {getattr(errno, name, None) for name in ("ENOLCK", "ENOTSUP", "EOPNOTSUPP", "EINVAL", "EBADF", "ENOSYS")}
"""Errors of file systems without locks, such as some network ones; there, concurrent writers are not detected."""


def try_lock(descriptor: int) -> bool:
    """Lock an open file for this process; return whether no other holds it.

    Raises:
        OSError: It cannot be locked.
    """
    # Imported here, as it takes longer than a command that writes nothing should wait.
    import filelock

    try:
        return filelock.lock_descriptor(descriptor, blocking=False)
    except OSError as error:
        if error.errno in _WITHOUT:
            return True
        raise


def is_locked(place: Path) -> bool:
    """Return whether a process holds the lock of a file; a file that cannot be opened has none."""
    try:
        with place.open("rb") as file:
            return not try_lock(file.fileno())
    except OSError:
        return False


@contextmanager
def locked_folder(folder: Path) -> Iterator[bool]:
    """Lock a folder for the block; yields whether no other process holds it.

    Raises:
        OSError: It cannot be opened.
    """
    if os.name == "nt":  # Windows cannot open folders.
        yield True
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        yield try_lock(descriptor)
    finally:
        os.close(descriptor)


def is_at(descriptor: int, path: Path) -> bool:
    """Return whether an open file is the one at a path."""
    try:
        return os.path.samestat(os.fstat(descriptor), os.stat(path))
    except FileNotFoundError:
        return False
