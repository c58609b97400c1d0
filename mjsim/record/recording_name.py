"""Reserves the name of a recording before anything expensive starts."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mjsim.errors import RecordingError, UsageError
from mjsim.output import NewFile, next_free
from mjsim.sentences import Sentence

OTHER = (
    *(".mp4", ".m4v", ".mov", ".avi", ".mkv", ".webm", ".gif", ".png", ".jpg", ".jpeg", ".svg", ".pdf", ".html"),
    *(".yaml", ".yml", ".json", ".csv", ".txt", ".npz", ".mat", ".bag", ".db3", ".zip", ".py", ".m"),
)
"""Suffixes of other files, under which nobody would look for a recording."""


def require_recording_name(path: str | Path) -> None:
    """Raise UsageError if a file name has the suffix of another kind of file than a recording."""
    if Path(path).suffix.lower() in OTHER:
        raise UsageError(Sentence("cannot write a recording as '{name}'; name it .mcap", Path(path).name))


def reserve(path: str | Path | NewFile, *, overwrite: bool = False) -> NewFile:
    """Reserve the name of a recording for one writer; a name that is already reserved is returned as it is.

    Raises:
        UsageError: The file exists and may not be replaced, is being written, or has the suffix of another kind.
        RecordingError: It cannot be written.
    """
    if isinstance(path, NewFile):
        return path
    require_recording_name(path)
    with _reporting(path):
        return NewFile(path, overwrite=overwrite)


class WholeFile(NewFile):
    """A recording that appears only once it is complete; until then, an existing file stays."""

    is_whole = False
    is_spoilt = False
    """Whether writing failed, whatever `is_whole` says."""

    def publish(self) -> None:
        """Move the file to its destination if it is complete."""
        if self.is_whole and not self.is_spoilt:
            super().publish()


def reserve_whole(path: str | Path, *, overwrite: bool = False) -> WholeFile:
    """Reserve the name of a recording that is kept only if its writer reports that it is complete.

    Raises:
        UsageError: The file exists and may not be replaced, is being written, or has the suffix of another kind.
        RecordingError: It cannot be written.
    """
    require_recording_name(path)
    with _reporting(path):
        return WholeFile(path, overwrite=overwrite)


def reserve_next(path: Path) -> NewFile:
    """Reserve the first free name of 'run.mcap', 'run-2.mcap', 'run-3.mcap' and so on.

    Raises:
        RecordingError: It cannot be written.
    """
    with _reporting(path):
        return next_free(path)


@contextmanager
def _reporting(path: str | Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise RecordingError(Sentence("cannot write '{path}': {strerror}", path, error.strerror)) from error
