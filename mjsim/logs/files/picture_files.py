"""Pictures of a log in separate files, and the list with their times."""

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from mjsim.errors import MAX_MESSAGE_LENGTH, UsageError
from mjsim.geometry import Array
from mjsim.interface import Intrinsics
from mjsim.logs.files.png_sums import require_sound
from mjsim.logs.files.text_lines import left_out_cut, lies_in, lines_of
from mjsim.logs.resampling import DamagedReadingError, rising
from mjsim.models import any_picture_size
from mjsim.record import LoggedFrame, filed_frame

SEPARATOR = re.compile(r"\s*,\s*|\s+")
"""Separator between the time and the path of a picture."""
SAMPLE_COUNT = 9
"""Number of pictures of a camera whose sizes are compared."""


def listed_pictures(
    path: Path, notes: dict[str, str], *, folder: str = ".", separator: str | None = None, second: float = 1.0
) -> tuple[Array, list[Path]]:
    """Return the times of pictures, ascending [s], and their files; missing files are counted in the notes.

    Args:
        path: The list, with a time and a path per line.
        notes: Metadata of the log.
        folder: Base of the paths, relative to the list.
        separator: Separator of time and path; by default white space.
        second: One second in the unit of time.

    Raises:
        UsageError: A line is invalid, or there are no pictures (the message has file and line).
    """
    return _listed(path, lines_of(path, notes), notes, folder=folder, separator=separator, second=second)


def paired_pictures(path: Path, notes: dict[str, str]) -> tuple[tuple[Array, list[Path]], tuple[Array, list[Path]]]:
    """Return the times, ascending [s], and the files of pictures and of depth.

    Args:
        path: `associations.txt`, with time and path of a picture and of its depth per line, or depth first; paths of
            depth contain 'depth'.
        notes: Metadata of the log.

    Raises:
        UsageError: As in `listed_pictures`.
    """
    halves: tuple[list[str], list[str]] = [], []
    for number, line in enumerate(lines_of(path, notes), start=1):
        words = line.partition("#")[0].split()
        if words and (len(words) != 4 or ("depth" in words[1]) == ("depth" in words[3])):
            if halves[0] and left_out_cut(path, line, notes):
                break
            raise UsageError(f"{path}:{number}: {line.strip()[:60]!r}; a line has time, path, time, path of depth")
        pair = sorted((" ".join(words[:2]), " ".join(words[2:])), key=lambda half: "depth" in half)
        for lines, half in zip(halves, pair, strict=True):
            lines.append(half)
    pictures, depths = (_listed(path, lines, notes) for lines in halves)
    return pictures, depths


def _listed(
    path: Path,
    lines: Iterable[str],
    notes: dict[str, str],
    *,
    folder: str = ".",
    separator: str | None = None,
    second: float = 1.0,
) -> tuple[Array, list[Path]]:
    """Return the entries of a list, as `listed_pictures` does."""
    stamps: list[float] = []
    files: list[Path] = []
    missing: list[str] = []
    for number, line in enumerate(lines, start=1):
        text = line.partition("#")[0].strip()
        words = text.split(separator, maxsplit=1) if separator else SEPARATOR.split(text, maxsplit=1)
        if not any(words):
            continue
        try:
            stamp, name = float(words[0]) * second, words[1].strip()
        except (ValueError, IndexError):
            if files and left_out_cut(path, line, notes):
                break
            raise UsageError(f"{path}:{number}: {line.strip()[:60]!r}; a line has a time and a path") from None
        file = path.parent / folder / name
        if not file.is_file() and "\\" in name:
            # A list that was written on Windows.
            file = path.parent / folder / name.replace("\\", "/")
        if not np.isfinite(stamp) or not lies_in(file, path.parent):
            raise UsageError(
                f"{path}:{number}: {line.strip()[:60]!r}; the time must be finite, and the path in the folder"
            )
        if not file.is_file():
            missing.append(f"{path}:{number}: no file '{name}'"[:MAX_MESSAGE_LENGTH])
            continue
        stamps.append(stamp)
        files.append(file)
    if not files:
        raise UsageError(missing[0] if missing else f"'{path}' lists no pictures")
    listed = path.name if folder == "." else f"{path.parent.name}/{path.name}"
    fact = f"files of {listed} that are not there left out"
    notes[fact] = str(int(notes.get(fact, "0")) + len(missing))
    order = rising(np.array(stamps))
    return np.array(stamps)[order], [files[k] for k in order.tolist()]


def frame_in(file: Path, stamp: float, intrinsics: Intrinsics) -> LoggedFrame:
    """Return the picture in a file.

    Raises:
        DamagedReadingError: It is broken, cannot be read, or does not have its camera's size.
    """
    try:
        data = bytes_in(file)
        require_sound(data)
        return filed_frame(data, stamp, intrinsics)
    except ValueError as error:
        needed = f"it needs {intrinsics.width} x {intrinsics.height}"
        raise DamagedReadingError(f"'{file}' holds {error}; {needed}") from None


def bytes_in(file: Path) -> bytes:
    """Return the content of a file.

    Raises:
        DamagedReadingError: It cannot be read.
    """
    try:
        return file.read_bytes()
    except OSError as error:
        raise DamagedReadingError(f"cannot read '{file}': {error.strerror or error}") from None


def usual_size(files: Sequence[Path]) -> tuple[int, int]:
    """Return the most common width and height of pictures in files, from a sample [px].

    Raises:
        UsageError: None is a picture.
    """
    sizes, problems = Counter[tuple[int, int]](), []
    # The last picture of a log that was cut off is often damaged, the first one a test.
    for number in np.unique(np.linspace(0, len(files) - 1, SAMPLE_COUNT).astype(int)).tolist():
        try:
            sizes[any_picture_size(bytes_in(files[number]))] += 1
        except (ValueError, DamagedReadingError) as error:
            problems.append(f"{error}" if isinstance(error, DamagedReadingError) else f"'{files[number]}' {error}")
    if not sizes:
        raise UsageError(problems[0][:MAX_MESSAGE_LENGTH])
    return sizes.most_common(1)[0][0]
