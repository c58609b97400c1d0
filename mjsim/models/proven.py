"""Models and pictures that worlds name are first read in the guarded reader, once per content.

What a child has read within its limits is noted by its SHA-256 in the user's cache folder, as an empty file; files that
ship with mjsim need no child.
"""

import functools
import hashlib
import os
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib import metadata, resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from mjsim.errors import UsageError
from mjsim.guarded import in_child, one_reader, reader_for

MOST_NOTES = 10_000
"""Maximum number of files that are noted; beyond it all are forgotten."""
TRIALS = f"{__package__}.trials"
"""Module of the functions that the child runs; it is not imported here."""
LIBRARIES = ("mujoco", "opencv-python-headless")
"""Libraries that read them, beside the modules of this package: others may fail on what these have read."""


def require_readable(
    trial: str, *arguments: Any, content: Iterable[bytes], about: str, files: Collection[str] = ()
) -> None:
    """Check that a file can be read in the guarded reader; inside of it this does nothing.

    Args:
        trial: Name of the function of `trials` that reads it; it returns what is wrong, or None.
        arguments: Its arguments.
        content: All bytes that it reads.
        about: Name of the file, for messages.
        files: SHA-256 of each file as it was found; by default that of the content.

    Raises:
        ValueError: It cannot be read.
    """
    if in_child():
        return
    parts = tuple(content)
    if shipped() >= (set(files) or {digest(part) for part in parts}):
        return
    note = _notes() / _digest(trial, *_readers(), *parts)
    if note.exists():
        return
    try:
        with reader_for(f"{TRIALS}:{trial}") as reader:
            wrong = reader.call(f"{TRIALS}:{trial}", *arguments, about=about, size=sum(map(len, parts)))
    except UsageError as error:
        raise ValueError(str(error).removeprefix(f"'{about}' ")) from None
    if wrong is not None:
        raise ValueError(wrong)
    _note(note)


def require_picture(data: bytes, name: str) -> None:
    """Raise ValueError if a picture cannot be read; see `require_readable`."""
    require_readable("picture", data, content=[data], about=name)


@contextmanager
def one_trial_child() -> Iterator[None]:
    """Let all files that are tried in a block share one child, which starts with the first of them."""
    with one_reader(f"{TRIALS}:picture"):
        yield


def digest(data: bytes) -> str:
    """Return the SHA-256 of a file."""
    return hashlib.sha256(data).hexdigest()


@functools.cache
def shipped() -> frozenset[str]:
    """Return the SHA-256 of each file in the assets of mjsim."""
    return frozenset(digest(file.read_bytes()) for file in _below(resources.files("mjsim.assets")))


def _below(folder: Traversable) -> Iterable[Traversable]:
    for each in folder.iterdir():
        yield from _below(each) if each.is_dir() else [each]


def _digest(*parts: str | bytes) -> str:
    """Return the SHA-256 of several parts, each after its length."""
    whole = hashlib.sha256()
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        whole.update(b"%d:" % len(data))
        whole.update(data)
    return whole.hexdigest()


@functools.cache
def _readers() -> Sequence[str]:
    """Return the versions of the libraries, and the SHA-256 of each module that may take part."""
    modules = sorted(Path(__file__).parent.glob("*.py"))
    return [*map(metadata.version, LIBRARIES), *(digest(module.read_bytes()) for module in modules)]


def _notes() -> Path:
    """Return the folder of the notes, below the user's cache folder (XDG Base Directory Specification)."""
    base = os.environ.get("XDG_CACHE_HOME") or ""
    return (Path(base) if os.path.isabs(base) else Path(os.path.expanduser("~/.cache"))) / "mjsim" / "read"


def _note(note: Path) -> None:
    """Note a file; a cache that cannot be written is none."""
    with suppress(OSError):
        note.parent.mkdir(parents=True, exist_ok=True)
        others = list(note.parent.iterdir())
        for other in others if len(others) >= MOST_NOTES else ():
            other.unlink(missing_ok=True)
        note.touch()
