"""Where a command may write: nothing is replaced unless the user allows it."""

import os
import stat
from collections.abc import Container, Iterable, Iterator
from pathlib import Path, PurePosixPath

from mjsim.errors import UsageError
from mjsim.sentences import Sentence


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
            raise UsageError(
                Sentence("'{file_above}' exists and is not a folder; name another one", _file_above(path))
            ) from None
        except OSError:
            continue
        if source is not None and source.exists() and path.samefile(source):
            raise UsageError(Sentence("'{path}' is the recording itself; name another file", path))
        if stat.S_ISDIR(mode):
            raise UsageError(Sentence("'{path}' is a folder; name a file", path))
        if not stat.S_ISREG(mode):
            raise UsageError(Sentence("'{path}' is a device or a pipe; name a file", path))
        if not overwrite:
            raise UsageError(
                Sentence("'{path}' exists; name another file, or add --overwrite (in Python: overwrite=True)", path)
            )


def _file_above(path: Path) -> Path:
    """Return the first parent of a path that exists and is not a folder."""
    return next(place for place in reversed(path.parents) if place.exists() and not place.is_dir())


def free_paths(folder: str | Path, names: Iterable[str], *, overwrite: bool = False) -> list[Path]:
    """Return the paths of files in a folder, after checking that all may be written.

    Raises:
        UsageError: One exists and may not be replaced, or its name is outside the folder.
    """
    paths = []
    for name in names:
        # Names may come from a file that somebody else made.
        if PurePosixPath(name).is_absolute() or ".." in PurePosixPath(name).parts or not name.isprintable():
            raise UsageError(Sentence("{name!r} is not a valid file name in '{folder}'", name[:80], folder))
        paths.append(Path(folder) / name)
    require_free(*paths, overwrite=overwrite)
    return paths


def free_path(path: Path, *, taken: Container[Path] = ()) -> Path:
    """Return the first of 'run.mcap', 'run-2.mcap' and so on that neither exists nor is taken."""
    return next(name for name in numbered(path) if name not in taken and not os.path.lexists(name))


def numbered(path: Path) -> Iterator[Path]:
    """Yield run.mcap, run-2.mcap, run-3.mcap and so on."""
    yield path
    number = 1
    while True:
        number += 1
        yield path.with_name(f"{path.stem}-{number}{path.suffix}")


def made_folders(folder: Path) -> list[Path]:
    """Create a folder and its parents; return the created ones, deepest first."""
    missing = [place for place in (folder, *folder.parents) if not place.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    return missing


def create(path: Path) -> None:
    """Create an empty file atomically; raises FileExistsError if it exists."""
    os.close(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL))
