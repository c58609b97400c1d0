"""Pictures of a log in files of their own, and the list that says when each was taken."""

from pathlib import Path

import numpy as np

from mjsim.errors import LONGEST_MESSAGE, UsageError
from mjsim.geometry import Array
from mjsim.interface import Intrinsics
from mjsim.logs.readings import rising
from mjsim.logs.text import lines_of
from mjsim.models import any_picture_size
from mjsim.record import LoggedFrame, filed_frame


def listed_pictures(
    path: Path, notes: dict[str, str], *, folder: str = ".", separator: str | None = None, second: float = 1.0
) -> tuple[Array, list[Path]]:
    """Return when pictures were taken, ascending [s], and their files; those that are not there are counted in notes.

    Args:
        path: The list: a time and a path a line.
        notes: Facts about the log.
        folder: That paths start from, seen from the list.
        separator: Between time and path; blanks unless given.
        second: Seconds in the unit of time.

    Raises:
        UsageError: A line is not as it must be, or there are no pictures; names file and line.
    """
    stamps, files, missing = [], [], []
    for number, line in enumerate(lines_of(path), start=1):
        words = line.partition("#")[0].strip().split(separator, maxsplit=1)
        if not any(words):
            continue
        try:
            stamp, name = float(words[0]) * second, words[1].strip()
        except (ValueError, IndexError):
            raise UsageError(f"{path}:{number}: {line.strip()[:60]!r}; a line has a time and a path") from None
        file = path.parent / folder / name
        if not np.isfinite(stamp) or not file.resolve().is_relative_to(path.parent.resolve()):
            raise UsageError(f"{path}:{number}: {line.strip()[:60]!r}; the time is finite, the path in the folder")
        if not file.is_file():
            missing.append(f"{path}:{number}: no file '{name}'"[:LONGEST_MESSAGE])
            continue
        stamps.append(stamp)
        files.append(file)
    if not files:
        raise UsageError(missing[0] if missing else f"'{path}' lists no pictures")
    listed = path.name if folder == "." else f"{path.parent.name}/{path.name}"
    notes[f"files of {listed} that are not there left out"] = str(len(missing))
    order = rising(np.array(stamps))
    return np.array(stamps)[order], [files[k] for k in order.tolist()]


def frame_in(file: Path, stamp: float, intrinsics: Intrinsics) -> LoggedFrame:
    """Return the picture in a file.

    Raises:
        UsageError: It is broken, or of another size than its camera has.
    """
    try:
        return filed_frame(file.read_bytes(), stamp, intrinsics)
    except ValueError as error:
        raise UsageError(f"'{file}' holds {error}; it needs {intrinsics.width} x {intrinsics.height}") from None


def size_in(file: Path, data: bytes) -> tuple[int, int]:
    """Return width and height of the picture that a file holds, without decoding it [px].

    Raises:
        UsageError: It is none.
    """
    try:
        return any_picture_size(data)
    except ValueError as error:
        raise UsageError(f"'{file}' {error}") from None
