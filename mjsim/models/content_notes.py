"""Notes about contents of files, in the user's cache folder: slow results are looked up the next time."""

import hashlib
from contextlib import suppress
from pathlib import Path

from mjsim.output import replace_file, user_cache

MAX_NOTES = 10_000
"""Maximum number of notes; beyond it, all are deleted."""


def noted(*about: str | bytes) -> bytes | None:
    """Return the note about some texts and contents; None if there is none."""
    with suppress(OSError):
        return _place(about).read_bytes()
    return None


def note(data: bytes, *about: str | bytes) -> None:
    """Write the note about some texts and contents; a cache that cannot be written is ignored."""
    place = _place(about)
    with suppress(OSError):
        place.parent.mkdir(parents=True, exist_ok=True)
        others = list(place.parent.iterdir())
        for other in others if len(others) >= MAX_NOTES else ():
            other.unlink(missing_ok=True)
        replace_file(place, data)


def folder() -> Path:
    """Return the folder of the notes, below the user's cache folder."""
    return user_cache("read")


def _place(about: tuple[str | bytes, ...]) -> Path:
    """Return the file of a note: the SHA-256 of all texts and contents, each after its length."""
    whole = hashlib.sha256()
    for part in about:
        data = part.encode() if isinstance(part, str) else part
        whole.update(b"%d:" % len(data))
        whole.update(data)
    return folder() / whole.hexdigest()
