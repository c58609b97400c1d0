"""Writes several files: all of them, or none."""

import json
import shutil
import stat
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from hashlib import sha256
from pathlib import Path, PurePosixPath

from mjsim.errors import UsageError
from mjsim.output.output_places import create, free_paths, made_folders, require_free
from mjsim.output.reserved import new_file, write_file
from mjsim.sentences import Sentence

LIST = ".mjsim-files.json"
"""Name of the file that lists the files of a report or comparison in their folder."""


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
        made = made_folders(folder)
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
        raise UsageError(Sentence("cannot write '{folder}': {value}", folder, error.strerror or error)) from error


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
        create(path)
    except FileExistsError:
        require_free(path, overwrite=overwrite)
        part.chmod(stat.S_IMODE(path.stat().st_mode))
    part.replace(path)


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
