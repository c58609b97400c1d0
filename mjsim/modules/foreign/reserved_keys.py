"""Keys beside `use` that are for mjsim, not for the module: `patience` and `paths`."""

import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from mjsim.errors import UsageError
from mjsim.modules.hosts import MAX_BYTES, Defect, beside, folder_of
from mjsim.sentences import Sentence
from mjsim.world import Source, Use, holds_file, read_regular

DEFAULT_TIMEOUT = 10.0
"""Default time limit for a module to start, or to answer [s]."""
OWN_KEYS = ("patience", "paths")
"""Keys beside `use` that are not for the module."""
MAX_FILES = 1000
"""Maximum number of files of a world's modules."""


def options_of(use: Use) -> dict[str, Any]:
    """Return the keys that are for the module."""
    return {key: value for key, value in use.arguments().items() if key not in OWN_KEYS}


def patience_of(use: Use) -> float:
    """Return the time limit for a module to answer [s].

    Raises:
        ValueError: It is invalid.
    """
    patience = use.arguments().get("patience", DEFAULT_TIMEOUT)
    if isinstance(patience, bool) or not isinstance(patience, (int, float)) or not 0 < patience <= 1e5:
        raise ValueError(Sentence("patience is {patience!r}; it must be a time above 0 [s]", patience))
    return float(patience)


def paths_of(use: Use, source: Source) -> list[Path]:
    """Return the folders that `paths` adds.

    Raises:
        ValueError: One does not exist, or is outside the folder of the world.
    """
    named = use.arguments().get("paths", [])
    if not isinstance(named, (list, tuple)) or not all(isinstance(name, str) for name in named):
        raise ValueError("paths is not a list of folders; write paths: [lib, other]")
    return [beside(name, source, folder=True) for name in named]


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
                Sentence(
                    "the modules of '{file}' have over {max_files} files or {max_bytes} MB in their folders",
                    source.file,
                    MAX_FILES,
                    MAX_BYTES >> 20,
                )
            )
        for path in paths:
            files[path.relative_to(home).as_posix()] = read_regular(path, limit=MAX_BYTES)
    except OSError as error:
        raise UsageError(Sentence("cannot read '{filename}': {strerror}", error.filename, error.strerror)) from error
    return files


def files_in(folder: Path, home: Path) -> list[Path]:
    """Return the files below a folder, except links out of the world's folder."""
    return [path for path in sorted(folder.rglob("*")) if holds_file(home, path)]


def elsewhere_in(words: Sequence[str], source: Source) -> Mapping[Path, str]:
    """Return the files outside the world's folder that a command line names, each with its spelling there."""
    home, found = folder_of(source), dict[Path, str]()
    for name in (part for word in words for part in (word, word.partition("=")[2])):
        path = Path(os.path.realpath(home / name)) if "\0" not in name else home
        if not path.is_relative_to(home) and os.path.isfile(path):
            found[path] = name
    return found
