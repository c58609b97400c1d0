"""Output files of commands: written completely or not at all; they replace files only if the user allows it.

Files that the studio and the editor of worlds replace without asking are written by `mjsim.world.files.saving`, which
is also safe against power failure.
"""

import errno
import fcntl
import json
import os
import shutil
import stat
import tempfile
from abc import abstractmethod
from collections.abc import Container, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from hashlib import sha256
from pathlib import Path, PurePosixPath
from typing import IO

from mjsim.closing import Closes
from mjsim.errors import UsageError

LIST = ".mjsim-files.json"
"""Name of the file that lists the files of a report or comparison in their folder."""


class Destination(Closes):
    """Where a file is written; without `publish`, nothing of it stays."""

    path: Path
    """Its destination, as the user named it."""

    @abstractmethod
    def opened(self) -> IO[bytes]:
        """Return a file to write to, in which one can go back; who closes it leaves the place as it is."""

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
        """The same, wherever the working directory is later."""
        self._overwrite = overwrite
        require_free(self.path, overwrite=overwrite)
        self._place = Path(os.path.realpath(self.path))
        self._folders = _made_folders(self._place.parent)
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
                _create(self._place)
            except FileExistsError:
                require_free(self.path, overwrite=self._overwrite)
        else:
            os.chmod(self.part, stat.S_IMODE(os.fstat(self._replaced).st_mode))
        os.replace(self.part, self._place)
        self._published = True

    def close(self) -> None:
        """Release the name; unless it was published, delete the file, and the folders made for it."""
        if self._closed:
            return
        self._closed = True
        if self._descriptor is not None and not self._published:
            self.part.unlink(missing_ok=True)
        for descriptor in (self._descriptor, self._replaced):
            if descriptor is not None:
                with suppress(OSError):  # A module may have closed it.
                    os.close(descriptor)
        for folder in self._folders if not self._published else ():
            # Others may have put something there meanwhile.
            with suppress(OSError):
                folder.rmdir()

    def _open_part(self) -> int:
        """Return a descriptor of the part file, locked."""
        while True:
            descriptor = os.open(self.part, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o666)
            try:
                self._lock(descriptor)
                # Its last owner may have moved or deleted it before the lock was ours.
                if _is_at(descriptor, self.part):
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
                if _is_at(descriptor, self._place):
                    return descriptor
            except BaseException:
                os.close(descriptor)
                raise
            os.close(descriptor)
        return None

    def _lock(self, descriptor: int) -> None:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise UsageError(f"'{self.path}' is being written; wait for that to end, or name another file") from None
        except OSError as error:
            # Some network file systems have no locks; there two writers at once are not noticed.
            if error.errno not in (errno.ENOLCK, errno.ENOTSUP, errno.EINVAL, errno.EBADF):
                raise


def require_free(*paths: Path, overwrite: bool = False, source: Path | None = None) -> None:
    """Check that paths may be written.

    Args:
        paths: Destinations.
        overwrite: Whether regular files may be replaced.
        source: The recording that is being read; it is never replaced.

    Raises:
        UsageError: One may not be written, or a file is in place of its folder.
    """
    for path in paths:
        try:
            mode = path.stat().st_mode
        except NotADirectoryError:
            raise UsageError(f"'{_file_above(path)}' exists and is not a folder; name another one") from None
        except OSError:
            continue
        if source is not None and source.exists() and path.samefile(source):
            raise UsageError(f"'{path}' is the recording itself; name another file")
        if stat.S_ISDIR(mode):
            raise UsageError(f"'{path}' is a folder; name a file")
        if not stat.S_ISREG(mode):
            raise UsageError(f"'{path}' is a device or a pipe; name a file")
        if not overwrite:
            raise UsageError(f"'{path}' exists; name another file, or add --overwrite (in Python: overwrite=True)")


def _file_above(path: Path) -> Path:
    """Return the first parent of a path that exists and is not a folder."""
    return next(place for place in reversed(path.parents) if place.exists() and not place.is_dir())


def free_path(path: Path, *, taken: Container[Path] = ()) -> Path:
    """Return the first of 'run.mcap', 'run-2.mcap' and so on that neither exists nor is taken."""
    return next(name for name in _numbered(path) if name not in taken and not os.path.lexists(name))


def next_free(path: Path) -> NewFile:
    """Reserve the first of 'run.mcap', 'run-2.mcap' and so on that neither exists nor is being written.

    Raises:
        OSError: It cannot be written.
    """
    for name in _numbered(path):
        if not os.path.lexists(name):
            with suppress(UsageError):
                return NewFile(name)
    raise AssertionError("the numbers never end")


def move_to_free(file: Path, path: Path) -> Path:
    """Move a complete file to the first of 'run.mcap', 'run-2.mcap' and so on that does not exist; return that path.

    Raises:
        OSError: It cannot be moved.
    """
    for name in _numbered(path):
        with suppress(FileExistsError):
            _create(name)
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
        raise UsageError(f"cannot write '{path}': {error.strerror or error}") from error


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


def write_files(folder: str | Path, files: Mapping[str, bytes], *, overwrite: bool = False) -> None:
    """Write files into a folder, by their names; all of them, or none.

    Raises:
        UsageError: One exists, would be outside the folder, or cannot be written.
    """
    free_paths(folder, files, overwrite=overwrite)
    with new_files(folder, overwrite=overwrite) as parts:
        for name, data in files.items():
            write_part(parts / name, data)


@contextmanager
def new_files(folder: str | Path, *, overwrite: bool = False) -> Iterator[Path]:
    """Yield a folder to write files into; at the end of the block all are moved to `folder`, or none if it fails.

    Raises:
        UsageError: A file exists and may not be replaced, or cannot be written.
    """
    folder = Path(folder)
    try:
        made = _made_folders(folder)
        parts = Path(tempfile.mkdtemp(prefix=".mjsim-files-", dir=folder))
        try:
            yield parts
            moves = {part: folder / part.relative_to(parts) for part in sorted(parts.rglob("*")) if part.is_file()}
            require_free(*moves.values(), overwrite=overwrite)
            for part, path in moves.items():
                _move(part, path, overwrite=overwrite)
        finally:
            shutil.rmtree(parts, ignore_errors=True)
            for place in made:
                with suppress(OSError):  # it is no longer empty
                    place.rmdir()
    except OSError as error:
        raise UsageError(f"cannot write '{folder}': {error.strerror or error}") from error


def write_part(part: Path, data: bytes) -> None:
    """Write a file of `new_files`, whose name may have folders."""
    part.parent.mkdir(parents=True, exist_ok=True)
    part.write_bytes(data)


def _move(part: Path, path: Path, *, overwrite: bool) -> None:
    """Move a complete file to its path; a symbolic link there is followed, and the mode of a replaced file stays."""
    if path.is_symlink():
        # It may lead to another file system.
        with new_file(path, overwrite=overwrite) as place:
            shutil.copyfile(part, place)
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        _create(path)
    except FileExistsError:
        require_free(path, overwrite=overwrite)
        part.chmod(stat.S_IMODE(path.stat().st_mode))
    os.replace(part, path)


def write_set(folder: str | Path, files: Mapping[str, bytes], *, of: str, overwrite: bool = False) -> None:
    """Write a set of files, such as a report, and remove files of the previous set that are not in it.

    A list in the folder holds their names and SHA-256. A file that is not listed, or has changed since it was
    written, belongs to the user and stays.

    Args:
        folder: Their folder; created if necessary.
        files: Name -> content.
        of: What the set is, such as 'report'.
        overwrite: Whether files may be replaced.

    Raises:
        UsageError: As `write_files`.
    """
    write_files(folder, files, overwrite=overwrite)
    listed = _listed(Path(folder) / LIST)
    for name, digest in listed.get(of, {}).items():
        path = Path(folder) / name
        if name not in files and PurePosixPath(name).name == name and _holds(path, digest):
            path.unlink(missing_ok=True)
    listed[of] = {name: sha256(data).hexdigest() for name, data in files.items()}
    write_file(Path(folder) / LIST, (json.dumps(listed, indent=1) + "\n").encode(), overwrite=True)


def _listed(path: Path) -> dict[str, dict[str, str]]:
    """Return the content of a list: the kind of set, and the SHA-256 of each file by name."""
    try:
        listing = json.loads(path.read_bytes())
        return {str(of): {str(name): str(digest) for name, digest in names.items()} for of, names in listing.items()}
    except (OSError, ValueError, AttributeError, RecursionError):
        return {}  # There is none, or it is not ours.


def _holds(path: Path, digest: str) -> bool:
    """Return whether a file that is not a link has this content."""
    try:
        return stat.S_ISREG(path.lstat().st_mode) and sha256(path.read_bytes()).hexdigest() == digest
    except (OSError, ValueError):
        return False


def free_paths(folder: str | Path, names: Iterable[str], *, overwrite: bool = False) -> list[Path]:
    """Return the paths of files in a folder, after checking that all may be written.

    Raises:
        UsageError: One exists and may not be replaced, or its name leads out of the folder.
    """
    paths = []
    for name in names:
        # Names may come from a file that somebody else made.
        if PurePosixPath(name).is_absolute() or ".." in PurePosixPath(name).parts or not name.isprintable():
            raise UsageError(f"{name[:80]!r} is not a valid file name in '{folder}'")
        paths.append(Path(folder) / name)
    require_free(*paths, overwrite=overwrite)
    return paths


def _made_folders(folder: Path) -> list[Path]:
    """Create a folder and its parents; return the created ones, deepest first."""
    missing = [place for place in (folder, *folder.parents) if not place.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    return missing


def _create(path: Path) -> None:
    """Create an empty file atomically; raises FileExistsError if it exists."""
    os.close(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL))


def _numbered(path: Path) -> Iterator[Path]:
    yield path
    number = 1
    while True:
        number += 1
        yield path.with_name(f"{path.stem}-{number}{path.suffix}")


def _is_at(descriptor: int, path: Path) -> bool:
    """Return whether an open file is the one at a path."""
    try:
        return os.path.samestat(os.fstat(descriptor), os.stat(path))
    except FileNotFoundError:
        return False
