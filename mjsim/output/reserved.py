"""Writes a file over time; meanwhile its name is reserved."""

import os
import shutil
import stat
import tempfile
from abc import abstractmethod
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

from mjsim.closing import Closes
from mjsim.errors import UsageError
from mjsim.output.file_locks import is_at, try_lock
from mjsim.output.output_places import create, made_folders, numbered, require_free
from mjsim.sentences import Sentence

_PART = os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0)


class Destination(Closes):
    """Where a file is written; without `publish`, it is deleted."""

    path: Path
    """Its destination, as the user named it."""

    @abstractmethod
    def opened(self) -> IO[bytes]:
        """Return a seekable file to write to; closing it neither publishes nor deletes anything."""

    @abstractmethod
    def publish(self) -> None:
        """Make the file appear at its destination."""


class NewFile(Destination):
    """A file being written beside its destination; `publish` moves it there in one step.

    While it is open, its name is reserved: any other writer of the same path is refused, in this process and in others.
    An existing file at the destination stays until `publish`, and for good if that is never called. The locks end with
    the process, so a killed writer does not block others.
    """

    def __init__(self, path: str | Path, *, overwrite: bool = False) -> None:
        """Reserve the name, and open the file.

        Args:
            path: The destination; its folder is created if necessary. A symbolic link is followed.
            overwrite: Whether an existing file may be replaced.

        Raises:
            UsageError: It exists, or is being written.
            OSError: It cannot be written.
        """
        self.path = Path(path)
        self.whole_path = self.path.absolute()
        """Its absolute path, which stays valid if the working directory changes."""
        self._overwrite = overwrite
        require_free(self.path, overwrite=overwrite)
        self._place = Path(os.path.realpath(self.path))
        self._folders = made_folders(self._place.parent)
        self.part = self._place.with_name(f".{self._place.name}.part")
        """Its path until it is published. Write to this file, do not replace it: it carries the lock."""
        self._published = self._closed = False
        self._descriptor: int | None = None
        self._replaced: int | None = None
        try:
            self._descriptor = self._open_part()
            # It may have been created since the first look, by a writer that has published meanwhile.
            require_free(self.path, overwrite=overwrite)
            self._replaced = self._lock_replaced()
            os.ftruncate(self.fileno(), 0)
        except BaseException:
            self.close()
            raise

    def fileno(self) -> int:
        """Return the descriptor of the open file, which this object owns."""
        assert self._descriptor is not None, "it is open from the beginning"
        return self._descriptor

    def opened(self) -> IO[bytes]:
        """Return the file opened for writing, by a descriptor of its own."""
        return os.fdopen(os.dup(self.fileno()), "wb", buffering=0)

    def publish(self) -> None:
        """Move the file to its destination; further calls do nothing.

        Raises:
            UsageError: Another program has created the destination meanwhile.
            OSError: It cannot be moved.
        """
        if self._published:
            return
        if self._replaced is None:
            try:
                create(self._place)
            except FileExistsError:
                require_free(self.path, overwrite=self._overwrite)
        else:
            os.chmod(self.part, stat.S_IMODE(os.fstat(self._replaced).st_mode))
        if os.name == "nt":  # Windows cannot move an open file.
            self._unlock()
        os.replace(self.part, self._place)
        self._published = True

    def close(self) -> None:
        """Release the name; unless it was published, delete the file, and the folders made for it."""
        if self._closed:
            return
        self._closed = True
        if self._descriptor is not None and not self._published:
            self.part.unlink(missing_ok=True)
        self._unlock()
        for folder in self._folders if not self._published else ():
            # Others may have put something there meanwhile.
            with suppress(OSError):
                folder.rmdir()

    def _unlock(self) -> None:
        for descriptor in (self._descriptor, self._replaced):
            if descriptor is not None:
                with suppress(OSError):  # A module may have closed it.
                    os.close(descriptor)
        self._descriptor = self._replaced = None

    def _open_part(self) -> int:
        """Return a descriptor of the part file, locked."""
        while True:
            descriptor = os.open(self.part, _PART, 0o666)
            try:
                self._lock(descriptor)
                # Its last owner may have moved or deleted it before the lock was ours.
                if is_at(descriptor, self.part):
                    return descriptor
            except BaseException:
                os.close(descriptor)
                raise
            os.close(descriptor)

    def _lock_replaced(self) -> int | None:
        """Return a locked descriptor of the file that will be replaced; None if there is none."""
        while self._overwrite:
            try:
                descriptor = os.open(self._place, os.O_RDONLY)
            except FileNotFoundError:
                return None
            try:
                self._lock(descriptor)
                if is_at(descriptor, self._place):
                    return descriptor
            except BaseException:
                os.close(descriptor)
                raise
            os.close(descriptor)
        return None

    def _lock(self, descriptor: int) -> None:
        if not try_lock(descriptor):
            raise UsageError(
                Sentence("'{path}' is being written; wait for that to end, or name another file", self.path)
            )


def next_free(path: Path) -> NewFile:
    """Reserve the first of 'run.mcap', 'run-2.mcap' and so on that neither exists nor is being written.

    Raises:
        OSError: It cannot be written.
    """
    for name in numbered(path):
        if not os.path.lexists(name):
            with suppress(UsageError):
                return NewFile(name)
    raise AssertionError("the numbers never end")


def move_to_free(file: Path, path: Path) -> Path:
    """Move a complete file to the first of 'run.mcap', 'run-2.mcap' and so on that does not exist; return that path.

    Raises:
        OSError: It cannot be moved.
    """
    for name in numbered(path):
        with suppress(FileExistsError):
            create(name)
            os.replace(file, name)
            return name
    raise AssertionError("the numbers never end")


@contextmanager
def new_file(path: str | Path, *, overwrite: bool = False) -> Iterator[Path]:
    """Yield where to write a file; it is moved to its path at the end of the block, and deleted if the block fails.

    Raises:
        UsageError: The path exists and may not be replaced, is being written, or cannot be written.
    """
    try:
        with NewFile(path, overwrite=overwrite) as file:
            yield file.part
            file.publish()
    except OSError as error:
        raise UsageError(Sentence("cannot write '{path}': {value}", path, error.strerror or error)) from error


@contextmanager
def temporary_file(name: str) -> Iterator[Path]:
    """Yield the path of a temporary file in a folder of its own, which is removed if the block fails.

    Otherwise the caller removes the folder.
    """
    folder = Path(tempfile.mkdtemp(prefix="mjsim-"))
    try:
        yield folder / name
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise


def write_file(path: str | Path, data: bytes, *, overwrite: bool = False) -> Path:
    """Write a file and return its path.

    Raises:
        UsageError: It exists and may not be replaced, or cannot be written.
    """
    with new_file(path, overwrite=overwrite) as part:
        part.write_bytes(data)
    return Path(path)
