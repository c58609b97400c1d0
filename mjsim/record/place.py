"""The name of a recording, reserved before anything expensive begins."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mjsim.errors import RecordingError
from mjsim.output import NewFile, next_free


def reserve(path: str | Path | NewFile, *, overwrite: bool = False) -> NewFile:
    """Return the name of a recording, reserved for one writer; one that is reserved already as it is.

    Raises:
        UsageError: The file exists and may not be replaced, or is being written.
        RecordingError: It cannot be written.
    """
    if isinstance(path, NewFile):
        return path
    with _reporting(path):
        return NewFile(path, overwrite=overwrite)


class WholeFile(NewFile):
    """A recording that appears when it is whole; until then, and for good if it never is, what was there stays."""

    is_whole = False
    is_spoilt = False
    """Whether something could not be written, whatever `is_whole` says."""

    def publish(self) -> None:
        """Move the file to its destination if it is whole."""
        if self.is_whole and not self.is_spoilt:
            super().publish()


def reserve_whole(path: str | Path, *, overwrite: bool = False) -> WholeFile:
    """Return the name of a recording that is kept only when its writer says that it is whole.

    Raises:
        UsageError: The file exists and may not be replaced, or is being written.
        RecordingError: It cannot be written.
    """
    with _reporting(path):
        return WholeFile(path, overwrite=overwrite)


def reserve_next(path: Path) -> NewFile:
    """Return the first free name of 'run.mcap', 'run-2.mcap', 'run-3.mcap' and so on, reserved.

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
        raise RecordingError(f"cannot write '{path}': {error.strerror}") from error
