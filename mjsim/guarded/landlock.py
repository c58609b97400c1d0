"""Restricts this process to reading some folders, by Landlock of Linux 5.13 and later.

References:
    landlock(7), landlock_create_ruleset(2), landlock_add_rule(2), landlock_restrict_self(2); linux/landlock.h.
"""

import ctypes
import os
import stat
import struct
import sys
from collections.abc import Iterable
from pathlib import Path

_CREATE, _ADD, _RESTRICT = 444, 445, 446
"""System calls; the same numbers on x86-64 and aarch64."""
_VERSION, _PATH_BENEATH = 1, 1
_READ_FILE, _READ_FOLDER = 1 << 2, 1 << 3
_RIGHTS = {1: 13, 2: 14, 3: 15, 4: 15}
"""Version -> number of rights on files that it knows."""
_LATEST_RIGHTS = 16
_TCP, _SCOPES = 0b11, 0b11
"""Binding and connecting, from version 4; abstract Unix sockets and signals, from version 6."""


def read_only(folders: Iterable[Path], *, scratch: Path | None = None) -> bool:
    """Restrict this thread, and those it starts, to some folders, for good; return whether the system supports it.

    Args:
        folders: Folders and files; those that do not exist are left out.
        scratch: A folder in which files may be created, changed and deleted.
    """
    if sys.platform != "linux":
        return False
    libc = ctypes.CDLL(None, use_errno=True)
    version = libc.syscall(_CREATE, None, ctypes.c_size_t(0), _VERSION)
    if version < 1:
        return False
    every = (1 << _RIGHTS.get(version, _LATEST_RIGHTS)) - 1
    attributes = struct.pack("<QQQ", every, _TCP if version >= 4 else 0, _SCOPES if version >= 6 else 0)
    size = 24 if version >= 6 else 16 if version >= 4 else 8
    rules = libc.syscall(_CREATE, attributes, ctypes.c_size_t(size), 0)
    if rules < 0:
        return False
    try:
        for folder in folders:
            _allow(libc, rules, folder, _READ_FILE | _READ_FOLDER)
        if scratch is not None:
            _allow(libc, rules, scratch, every & ~1)  # all but executing
        return bool(libc.prctl(38, 1, 0, 0, 0) == 0 and libc.syscall(_RESTRICT, rules, 0) == 0)
    finally:
        os.close(rules)


def _allow(libc: ctypes.CDLL, rules: int, place: Path, rights: int) -> None:
    """Allow rights below a folder or on a file; one that does not exist is left out."""
    try:
        opened = os.open(place, os.O_PATH | os.O_CLOEXEC)
    except OSError:
        return
    try:
        if not stat.S_ISDIR(os.fstat(opened).st_mode):
            rights &= ~_READ_FOLDER
        libc.syscall(_ADD, rules, _PATH_BENEATH, struct.pack("<Qi", rights, opened), 0)
    finally:
        os.close(opened)
