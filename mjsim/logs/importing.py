"""Imports logs of real robots: a guarded child process reads them, and this one writes the recording."""

import shutil
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing, suppress
from dataclasses import replace
from itertools import islice
from pathlib import Path
from pkgutil import resolve_name
from typing import IO, Any

from mjsim.errors import RecordingError, UsageError
from mjsim.guarded import Allowance, Reader, limits_for
from mjsim.logs.resampling import Output, Piece, SentFile, Wishes, recorded
from mjsim.record import Recording
from mjsim.world import Run, step_misfit

PART_TIMEOUT = 30.0
"""Time limit from one part of a recording to the next [s]."""
MIN_RECORDING_LIMIT, MAX_GROWTH = 256 << 20, 100
"""Maximum size of a recording, and of a temporary file: absolute [bytes], and as a multiple of the size of the log."""
PART_BYTES, PART_SECONDS = 1 << 20, 0.2
"""A part is passed on when it has this size, or after this time [bytes, s]."""
MIN_FREE_DISK = 1 << 30
"""Space that stays free on the disk to which files are unpacked [bytes]."""
DESCRIPTIONS = (".yaml", ".yml")
"""Suffixes of files that name tables beside them."""
MAX_FILES = 100_000
"""Maximum number of files whose sizes are added up."""


def import_log(
    source: str | Path,
    *,
    wishes: Wishes | None = None,
    record: str | Path | None = None,
    progress: Callable[[float], None] | None = None,
    overwrite: bool = False,
) -> Recording:
    """Convert the log of a real robot to a recording; the format is detected from its files.

    Args:
        source: A file or a folder; if a folder is not a log but contains a single one, that is imported.
        wishes: What to import, and the noise given to modules.
        record: The MCAP file to write; by default a temporary one, deleted with the recording.
        progress: Called with the progress [%].
        overwrite: Whether `record` may replace a file.

    Raises:
        UsageError: It is not a supported log, a file is invalid (the message has file and line), an option does not
            apply to its format; or `record` exists, or is a file of the log.
        RecordingError: The file cannot be written.
    """
    return guarded_recording(
        "mjsim.logs.log_kinds:convert",
        source,
        wishes or Wishes(),
        record=record,
        progress=progress,
        overwrite=overwrite,
    )


def guarded_recording(
    convert: str,
    source: str | Path,
    wishes: Wishes,
    *,
    record: str | Path | None,
    progress: Callable[[float], None] | None = None,
    overwrite: bool = False,
) -> Recording:
    """Return the recording of a log that a function converts in a guarded child process.

    Args:
        convert: The function, as 'module:name'; called with path, wishes and output, it yields the progress.
        source: A file or a folder.
        wishes: Options of the user.
        record: The MCAP file to write; by default a temporary one, deleted with the recording.
        progress: Called with the progress [%].
        overwrite: Whether `record` may replace a file.

    Raises:
        UsageError: There is no such file; what the function raises; or it crashed, or needed too much time or memory.
        RecordingError: The recording cannot be written.
    """
    path = Path(source)
    if not path.exists():
        raise UsageError(f"no file or folder '{path}'")
    _require_possible(path, wishes, record)

    def write(output: Output) -> Iterator[float]:
        limits = limits_of(path)
        with Reader(convert, folders=readable_folders(path), scratch=True, limits=limits) as reader:
            arguments = convert, path, wishes, output.command
            parts = reader.parts("mjsim.logs.importing:sent", *arguments, about=path, limits=limits)
            yield from put_together(parts, output, limit=limits.written)

    return recorded(write, record=record, overwrite=overwrite, progress=progress)


def sent(convert: str, path: Path, wishes: Wishes, command: str) -> Iterator[tuple[float, list[Piece]]]:
    """Convert a log in this process, and yield the progress [%] and the pieces of the recording, as they are made."""
    file, handed = SentFile(path), time.monotonic()
    for done in resolve_name(convert)(path, wishes, Output(file, command)):
        if file.waiting >= PART_BYTES or time.monotonic() > handed + PART_SECONDS:
            yield done, file.taken()
            handed = time.monotonic()
    yield 100.0, file.taken()


def put_together(parts: Iterable[Any], output: Output, *, limit: int) -> Iterator[float]:
    """Write the pieces of a recording, and yield the progress [%].

    Args:
        parts: As from `sent`; untrusted, since a hostile file may control the process that sends them.
        output: The recording.
        limit: Maximum number of bytes to write.

    Raises:
        UsageError: There are none, or too many.
        RecordingError: They cannot be written.
    """
    end = 0
    with closing(output.place.opened()) as file:
        for part in parts:
            try:
                done, pieces = _checked(part)
                for piece in pieces:
                    end, limit = max(end, _written(file, piece, end)), limit - len(piece[1])
            except ValueError:
                raise UsageError("the reader of the log gave no valid answer; the log is damaged") from None
            except OSError as error:
                raise RecordingError(f"cannot write '{output.place.path}': {error.strerror}") from None
            if limit < 0:
                raise UsageError("the recording is too large for the size of the log; choose a part with --seconds")
            yield done
    output.place.is_whole = True
    output.place.publish()


def _checked(part: Any) -> tuple[float, list[Any]]:
    """Return the progress and the pieces in a part.

    Raises:
        ValueError: It is not one.
    """
    match part:
        case (float(done), list(pieces)) if 0.0 <= done <= 100.0:
            return done, pieces
    raise ValueError("not a part of a recording")


def _written(file: IO[bytes], piece: Any, end: int) -> int:
    """Write a piece into a file, given the end of the file so far; return the end of the piece.

    Raises:
        ValueError: It is not a piece, or would leave a hole.
    """
    match piece:
        case (int(place), bytes(data)) if 0 <= place <= end:
            file.seek(place)
            rest = memoryview(data)
            while rest:
                rest = rest[file.write(rest) :]
            return place + len(data)
    raise ValueError("not a piece of a recording")


def limits_of(path: Path) -> Allowance:
    """Return the limits for a log."""
    folder = path if path.is_dir() else path.parent if path.suffix.lower() in DESCRIPTIONS else None
    size = sum(map(_size, [path] if folder is None else islice(folder.rglob("*"), MAX_FILES)))
    free = max(shutil.disk_usage(tempfile.gettempdir()).free - MIN_FREE_DISK, 1)
    return replace(limits_for(size), each=PART_TIMEOUT, written=min(free, MIN_RECORDING_LIMIT + MAX_GROWTH * size))


def _size(file: Path) -> int:
    """Return the size of a file [bytes]; 0 if it is gone."""
    with suppress(OSError):
        return file.stat().st_size
    return 0


def readable_folders(path: Path) -> list[Path]:
    """Return the folders of a log, as named and where a link leads."""
    return [each if each.is_dir() else each.parent for each in (path, path.resolve())]


def _require_possible(path: Path, wishes: Wishes, record: str | Path | None) -> None:
    """Refuse a recording that would replace a file of the log, and a rate that is not possible."""
    place = None if record is None else Path(record).resolve()
    if place is not None and place.exists() and place.is_relative_to(path.resolve()):
        raise UsageError(f"'{record}' is a file of the log; name another file")
    if wishes.rate_hz is not None and (misfit := step_misfit("a tick", wishes.rate_hz, Run().step)) is not None:
        raise UsageError(f"--rate: {misfit}")
