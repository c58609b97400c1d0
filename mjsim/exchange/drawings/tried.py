"""Reads parts of a damaged file: what a library cannot read is left out and counted."""

from collections.abc import Callable
from typing import ParamSpec, TypeVar

from mjsim.errors import MjsimError

P = ParamSpec("P")
T = TypeVar("T")


def tried(read: Callable[P, T], *arguments: P.args, **keywords: P.kwargs) -> T | None:
    """Return what a library reads from a part of a file; None if it fails in any way.

    The caller reports what was left out. It runs in the guarded reader, which survives a crash or a hang.

    Raises:
        MjsimError: The part can be read, and is wrong.
        MemoryError: There is too little memory for the whole file.
    """
    try:
        return read(*arguments, **keywords)
    except (MjsimError, MemoryError):
        raise
    except Exception:
        return None
