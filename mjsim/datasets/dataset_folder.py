"""Output folders of data sets: they appear when all are complete, and replace only files of the same kind."""

import os
import re
import shutil
import sqlite3
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from mjsim.errors import UsageError


@contextmanager
def new_folders(places: Sequence[Path], *, files: str, overwrite: bool) -> Iterator[list[Path]]:
    """Yield where to write the files of each folder; they are moved to their destinations at the end of the block.

    Args:
        places: The folders, all beside each other.
        files: Regular expression for paths of their files. Such files of an older data set are removed when it is
            replaced; all others stay.
        overwrite: Whether such files may be replaced.

    Raises:
        UsageError: There are such files and they may not be replaced, or a folder cannot be written.
    """
    _require_free(places, files=files, overwrite=overwrite)
    home = places[0].parent
    made = [each for each in (home, *home.parents) if not each.exists()]
    try:
        home.mkdir(parents=True, exist_ok=True)
        beside = Path(tempfile.mkdtemp(prefix=".mjsim-export-", dir=home))
        try:
            parts = [beside / Path(os.path.abspath(place)).name for place in places]  # '.' has no name
            yield parts
            _require_free(places, files=files, overwrite=overwrite)  # others may have been created in the meantime
            for part, place in zip(parts, places, strict=True):
                _move(part, place, files=files)
        finally:
            shutil.rmtree(beside, ignore_errors=True)
            for folder in made:
                with suppress(OSError):  # it is no longer empty
                    folder.rmdir()
    except (OSError, sqlite3.OperationalError) as error:
        # The database of a bag reports a full disk in its own way.
        reason = getattr(error, "strerror", None) or error
        raise UsageError(f"cannot write '{home}': {reason}") from error


def _move(part: Path, place: Path, *, files: str) -> None:
    """Move a folder to its destination, or its files into an existing one, replacing files of their kind."""
    if not place.exists():
        os.rename(part, place)
        return
    for old in _of_kind(place, files):
        old.unlink()
    for new in part.rglob("*"):
        if new.is_file():
            to = place / new.relative_to(part)
            to.parent.mkdir(parents=True, exist_ok=True)
            os.rename(new, to)


def _require_free(places: Sequence[Path], *, files: str, overwrite: bool) -> None:
    """Check that no file exists that may not be replaced."""
    for place in places:
        if os.path.lexists(place) and not place.is_dir():
            raise UsageError(f"'{place}' exists and is not a folder; name another one")
        if not overwrite and _of_kind(place, files):
            raise UsageError(f"'{place}' exists; name another folder, or add --overwrite (in Python: overwrite=True)")


def _of_kind(place: Path, files: str) -> list[Path]:
    """Return the files in a folder whose paths match the expression."""
    if not place.is_dir():
        return []
    return [
        path
        for path in place.rglob("*")
        if not path.is_dir() and re.fullmatch(files, path.relative_to(place).as_posix())
    ]
