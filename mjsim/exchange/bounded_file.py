"""Reads files within size limits."""

from pathlib import Path

from mjsim.errors import UsageError


def read_bounded(path: Path, *, limit: int, kind: str) -> bytes:
    """Return the contents of a file.

    Raises:
        UsageError: The file does not exist, is not a regular file, or has more than `limit` bytes.
    """
    try:
        if not path.is_file():
            raise UsageError(f"no file '{path}'; name {kind}")
        size = path.stat().st_size
        if size > limit:
            raise UsageError(f"'{path}' has {size / 1e6:.0f} MB; {kind} has at most {limit / 1e6:g} MB")
        return path.read_bytes()
    except OSError as error:
        raise UsageError(f"'{path}' cannot be read: {error.strerror}") from None
