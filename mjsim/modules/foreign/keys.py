"""Keys beside `use` that are for mjsim, not for the module: `patience` and `paths`."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from mjsim.errors import UsageError, did_you_mean
from mjsim.modules.hosts import Defect
from mjsim.world import Source, Use

PATIENCE = 10.0
"""Default time limit for a module to start, or to answer [s]."""
OWN_KEYS = ("patience", "paths")
"""Keys beside `use` that are not for the module."""
MAX_FILES, MAX_BYTES = 1000, 100_000_000
"""Limits of the number and the size of files of a module."""


def folder_of(source: Source) -> Path:
    """Return the base folder of a world's paths."""
    return (source.folder or Path.cwd()).resolve()


def options_of(use: Use) -> dict[str, Any]:
    """Return the keys that are for the module."""
    return {key: value for key, value in use.arguments().items() if key not in OWN_KEYS}


def patience_of(use: Use) -> float:
    """Return the time limit for a module to answer [s].

    Raises:
        ValueError: It is invalid.
    """
    patience = use.arguments().get("patience", PATIENCE)
    if isinstance(patience, bool) or not isinstance(patience, (int, float)) or not 0 < patience <= 1e5:
        raise ValueError(f"patience is {patience!r}; it must be a time above 0 [s]")
    return float(patience)


def paths_of(use: Use, source: Source) -> list[Path]:
    """Return the folders that `paths` adds.

    Raises:
        ValueError: One does not exist, or is outside the folder of the world.
    """
    named = use.arguments().get("paths", [])
    if not isinstance(named, (list, tuple)) or not all(isinstance(name, str) for name in named):
        raise ValueError("paths is no list of folders; write paths: [lib, other]")
    return [beside(name, source, folder=True) for name in named]


def beside(name: str, source: Source, *, folder: bool = False) -> Path:
    """Return a file, or folder, within the folder of the world.

    Raises:
        ValueError: It does not exist, or is outside that folder.
    """
    home = folder_of(source)
    try:
        path = (home / name).resolve()
        exists = path.is_dir() if folder else path.is_file()
    except (OSError, RuntimeError, ValueError):
        path, exists = home, False
    if not path.is_relative_to(home):
        raise ValueError(f"path '{name}' leaves the folder of the world; keep it beside the world file")
    if not exists:
        kind = "folder" if folder else "file"
        candidates = [item.name for item in home.iterdir() if item.is_dir() == folder] if home.is_dir() else []
        raise ValueError(f"no {kind} '{name}' beside the world file{did_you_mean(name, candidates)}")
    return path


def key_defects(use: Use, role: str, source: Source) -> Iterator[Defect]:
    """Yield problems of the keys, and of a role that is only possible in Python."""
    for key, read in (("patience", lambda: patience_of(use)), ("paths", lambda: paths_of(use, source))):
        try:
            read()
        except ValueError as error:
            yield Defect(str(error), key)
    if role == "drive":
        yield Defect("a drive is a class in Python; write 'file.py:Class'")


def require_sound(defects: Iterator[Defect]) -> None:
    """Check that everything exists; raises UsageError otherwise."""
    for defect in defects:
        if defect.missing:
            raise UsageError(defect.message)


def read_files(paths: Sequence[Path], source: Source) -> dict[str, bytes]:
    """Return files by path, relative to the folder of the world.

    Raises:
        UsageError: One cannot be read, or there are too many.
    """
    home = folder_of(source)
    files: dict[str, bytes] = {}
    try:
        if len(paths) > MAX_FILES or sum(path.stat().st_size for path in paths) > MAX_BYTES:
            raise UsageError(
                f"the modules of '{source.file}' have over {MAX_FILES} files or {MAX_BYTES >> 20} MB in their folders"
            )
        for path in paths:
            files[path.relative_to(home).as_posix()] = path.read_bytes()
    except OSError as error:
        raise UsageError(f"cannot read '{error.filename}': {error.strerror}") from error
    return files


def files_in(folder: Path, home: Path) -> list[Path]:
    """Return the files below a folder, except links out of the world's folder."""
    return [path for path in sorted(folder.rglob("*")) if path.is_file() and path.resolve().is_relative_to(home)]
