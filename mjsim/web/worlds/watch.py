"""Changes on disk while a page shows a world: of its own file, and of the files that it names."""

import os
import re
import stat
import time
from collections.abc import Iterable, Iterator, Mapping
from itertools import islice
from pathlib import Path
from typing import Any

from mjsim.web.worlds.folder import Folder
from mjsim.web.worlds.items import Json
from mjsim.web.worlds.world_files import source_of, stamp_of
from mjsim.world import MAX_BYTES

MAX_FILES = 1000
"""Maximum number of watched files per world."""
_FILE = re.compile(
    r"(.+\.(?:yaml|yml|jpg|jpeg|png|webp|xml|mjcf|urdf|obj|stl|py|m|csv))(?::\w+)?", re.IGNORECASE | re.DOTALL
)
_RECENT_SECONDS = 2.0
"""A file changed less than this ago [s] may change again without a new sign, because file system clocks are coarse."""

Signs = Mapping[str, str]
"""Name of a file -> a value that identifies its state without reading it; '' if the file does not exist."""


def named_in(value: Any) -> Iterator[str]:
    """Yield what looks like a file name in the plain value of a text, whether the file exists or not."""
    waiting = [value]
    while waiting:
        item = waiting.pop()
        if isinstance(item, dict):
            waiting += item.values()
        elif isinstance(item, list):
            waiting += item
        elif isinstance(item, str) and (found := _FILE.fullmatch(item)) is not None:
            yield found.group(1)


def signs_of(folder: Folder, path: str, names: Iterable[str]) -> Signs:
    """Return the signs of files that a world names; '' for those outside the studio's folder.

    Args:
        folder: Folder of the studio.
        path: Path of the world.
        names: Paths of the files relative to its folder.
    """
    base = source_of(folder, path).folder or folder.root
    return {name: _sign(folder, os.path.normpath(base / name)) for name in islice(names, MAX_FILES)}


def _sign(folder: Folder, place: str) -> str:
    try:
        found = os.stat(place)
    except (OSError, ValueError):
        return ""
    inside = Path(os.path.realpath(place)).is_relative_to(folder.root)
    if not (inside and stat.S_ISREG(found.st_mode)):
        return ""
    return f"{found.st_ino}-{found.st_mtime_ns}-{found.st_ctime_ns}-{found.st_size}"


class DiskWatch:
    """Informs one page of changes on disk to the world that it shows."""

    def __init__(self, folder: Folder) -> None:
        """Start without a world."""
        self._folder = folder
        self._place: Path | None = None
        self._path, self._reported, self._seen = "", "", ""
        self._read: tuple[str, float, str] | None = None
        self._signs: Signs = {}
        self._seen_signs: Signs = {}

    def show(self, path: str, *, stamp: str | None, files: Signs) -> None:
        """Store what the page shows now.

        Args:
            path: Path of its world, whether it has a file or not; '' for none.
            stamp: Stamp of the content known to the page; None if the world has no file.
            files: Files that the world names, with their signs when it was read.

        Raises:
            RefusedError: The path is outside the folder.
        """
        source_of(self._folder, path)
        self._path, self._reported, self._seen = path, stamp or "", stamp or ""
        self._signs = self._seen_signs = files
        self._place = None if stamp is None else self._folder.path(path)

    def news(self) -> Iterator[Json]:
        """Yield changes since the last call: `disk` of the world's own file, `files` of those it names.

        A change is reported once it is the same at two checks in a row: editors delete a file before they rewrite it,
        or empty it before they fill it.
        """
        if self._place is not None:
            stamp = self._stamp(self._place)
            settled, self._seen = stamp == self._seen, stamp
            if settled and stamp != self._reported:
                self._reported = stamp
                yield {"kind": "disk", "path": self._path, "stamp": stamp or None}
        signs = signs_of(self._folder, self._path, self._signs)
        seen, self._seen_signs = self._seen_signs, signs
        changed = [name for name, sign in signs.items() if sign == seen[name] != self._signs[name]]
        if changed:
            self._signs = {**self._signs, **{name: signs[name] for name in changed}}
            yield {"kind": "files", "files": changed}

    def _stamp(self, place: Path) -> str:
        """Return the stamp of a file's content, read again only if its sign has changed; '' if the file is gone."""
        sign = _sign(self._folder, str(place))
        if not sign:
            return ""
        _, modified, _, size = map(int, sign.split("-"))
        # A change directly after the last reading may have left the same sign.
        if self._read is None or self._read[0] != sign or self._read[1] < modified / 1e9 + _RECENT_SECONDS:
            began = time.time()
            try:
                stamp = stamp_of(place) if size <= MAX_BYTES else f"too large: {sign}"
            except OSError:
                stamp = f"unreadable: {sign}"
            self._read = sign, began, stamp
        return self._read[2]
