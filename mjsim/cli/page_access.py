"""Shared by the commands that serve a page: the token, and addresses for further browsers."""

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from mjsim.errors import UsageError
from mjsim.progress import say

_HOW = "write --token file:PATH or --token env:NAME"


def read_token(source: str) -> str:
    """Return the token that a file or an environment variable holds.

    Args:
        source: 'file:PATH' or 'env:NAME'; the variable is removed, so that no other program inherits it.

    Raises:
        UsageError: It is neither, there is no such file or variable, or others can read the file.
    """
    kind, colon, place = source.partition(":")
    if not colon or kind not in ("file", "env") or not place:
        raise UsageError(f"all users of this machine can read a token on the command line; {_HOW}")
    token = _from_file(Path(place)) if kind == "file" else os.environ.pop(place, "")
    if not token.strip():
        label = f"file '{place}'" if kind == "file" else f"environment variable {place}"
        raise UsageError(f"{label} holds no token; {_HOW}")
    return token.strip()


@contextmanager
def addresses_on_signal(address: Callable[[], str]) -> Iterator[None]:
    """While the block runs, SIGUSR1 prints a new address for another browser; systems without it have none."""
    if sys.platform == "win32":
        yield
        return

    def answer(*_: Any) -> None:
        # A signal handler interrupts the main thread anywhere, even while it prints.
        threading.Thread(
            target=lambda: say(f"address for another browser, works once: {address()}"), daemon=True
        ).start()

    before = signal.signal(signal.SIGUSR1, answer)
    try:
        yield
    finally:
        signal.signal(signal.SIGUSR1, before)


def how_to_get_another() -> str:
    """Return how to get an address for another browser, as the end of a sentence; '' without SIGUSR1."""
    return "" if sys.platform == "win32" else f"; 'kill -USR1 {os.getpid()}' prints another one"


def _from_file(path: Path) -> str:
    try:
        with path.open(encoding="utf-8") as file:
            mode = os.fstat(file.fileno()).st_mode & 0o777
            text = file.read(4096)
    except OSError as error:
        raise UsageError(f"cannot read the token from '{path}': {error.strerror}") from None
    except ValueError:
        raise UsageError(f"'{path}' is not a text file; write the token into it, in one line") from None
    if sys.platform != "win32" and mode & 0o077:
        raise UsageError(f"other users can read '{path}' (mode {mode:04o}); run 'chmod 600 {path}'")
    return text


def has_screen() -> bool:
    """Return whether there is a graphical display; a text browser would occupy this terminal."""
    return sys.platform in ("darwin", "win32") or any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))
