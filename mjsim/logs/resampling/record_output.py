"""Where an import writes its recording: into a file, or from the child process that reads the log to its parent."""

import sys
import weakref
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from shutil import rmtree
from typing import IO, cast

from mjsim.output import Destination, temporary_file
from mjsim.record import Recording, WholeFile, read_recording, reserve_whole

Piece = tuple[int, bytes]
"""Offset in a file [bytes], and the bytes written there."""


class SentFile(Destination):
    """A recording whose pieces another thread takes and passes on."""

    is_whole = False

    def __init__(self, path: Path) -> None:
        """Begin an empty file, with a name for messages."""
        self.path = path
        self.waiting = 0
        """Approximate length of the pieces not taken yet [bytes]."""
        self._pieces = deque[Piece]()
        self._at = self._end = 0

    def opened(self) -> IO[bytes]:
        """Return itself: it has the methods that the writer of recordings calls."""
        return cast(IO[bytes], self)

    def write(self, data: memoryview) -> int:
        """Keep a copy of a piece; return its length."""
        self._pieces.append((self._at, bytes(data)))
        self._at += len(data)
        self.waiting += len(data)
        self._end = max(self._end, self._at)
        return len(data)

    def seek(self, offset: int, whence: int) -> int:
        """Move to a position given from the beginning, from the current position or from the end; return it."""
        self._at = offset + (0, self._at, self._end)[whence]
        return self._at

    def taken(self) -> list[Piece]:
        """Return the pieces since the last call, with consecutive ones merged."""
        pieces: list[tuple[int, list[bytes]]] = []
        end, self.waiting = -1, 0
        for place, data in [self._pieces.popleft() for _ in range(len(self._pieces))]:
            if place != end:
                pieces.append((place, []))
            pieces[-1][1].append(data)
            end = place + len(data)
        return [(place, b"".join(parts)) for place, parts in pieces]

    def publish(self) -> None:
        """Do nothing: the process that joins the pieces publishes."""

    def close(self) -> None:
        """Do nothing: pieces not taken yet stay."""


@dataclass(frozen=True, slots=True)
class Output:
    """The recording of an import."""

    place: WholeFile | SentFile
    command: str
    """The command line, for the metadata."""


def recorded(
    write: Callable[[Output], Iterator[float]],
    *,
    record: str | Path | None,
    overwrite: bool = False,
    progress: Callable[[float], None] | None = None,
) -> Recording:
    """Return the recording that a function writes, which yields its progress [%].

    Args:
        write: Writes it.
        record: The MCAP file; a temporary one, deleted with the recording, if None.
        overwrite: Whether that may replace a file.
        progress: Called with the progress [%].

    Raises:
        UsageError: The file exists.
        RecordingError: The file cannot be written.
    """
    if record is None:
        with temporary_file("log.mcap") as path:
            recording = recorded(write, record=path, progress=progress)
        weakref.finalize(recording, rmtree, path.parent, ignore_errors=True)
        return recording
    with reserve_whole(record, overwrite=overwrite) as place:
        for done in write(Output(place, " ".join(sys.argv))):
            if progress is not None:
                progress(done)
    return read_recording(record)
