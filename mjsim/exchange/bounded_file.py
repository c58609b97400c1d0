"""Reads files within size limits."""

from pathlib import Path

from mjsim.errors import UsageError


def read_bounded(path: Path, *, most: int, kind: str) -> bytes:
    """Return the contents of a file.

    Raises:
        UsageError: The file does not exist, is not a regular file, or has more than `most` bytes.
    """
    try:
        if not path.is_file():
            raise UsageError(f"no file '{path}'; name {kind}")
        size = path.stat().st_size
        if size > most:
            raise UsageError(f"'{path}' has {size / 1e6:.0f} MB; {kind} has at most {most / 1e6:g} MB")
        return path.read_bytes()
    except OSError as error:
        raise UsageError(f"'{path}' cannot be read: {error.strerror}") from None
