"""Reads files within size limits."""

from pathlib import Path

from mjsim.errors import UsageError, file_meant
from mjsim.world import read_regular


def read_bounded(path: Path, *, limit: int, kind: str) -> bytes:
    """Return the contents of a file.

    Raises:
        UsageError: The file does not exist, is not a regular file, or has more than `limit` bytes.
    """
    try:
        return read_regular(path, limit=limit)
    except (FileNotFoundError, IsADirectoryError, ValueError):
        raise UsageError(f"no file '{path}'{file_meant(path, (path.suffix.lower(),), otherwise=kind)}") from None
    except OSError as error:
        raise UsageError(f"'{path}' cannot be read: {error.strerror}; name {kind}") from None
