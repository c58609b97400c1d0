"""The folder that a studio was opened in: nothing outside of it is read or written."""

import threading
from pathlib import Path, PurePosixPath

from mjsim.errors import UsageError
from mjsim.web.answers import RefusedError

LONGEST = 400
"""Characters of a path."""
LONGEST_NAME = 255
"""Bytes of one name in it, as file systems have it."""


class Folder:
    """A folder and the files below it, named by their paths from it."""

    def __init__(self, root: Path) -> None:
        """Take a folder.

        Raises:
            UsageError: There is none.
        """
        self.root = root.resolve()
        self.writing = threading.Lock()
        """Held while a file is written whose old content, or absence, was checked before."""
        if not self.root.is_dir():
            raise UsageError(f"no folder '{root}'; name one that is there")

    def path(self, name: str) -> Path:
        """Return the place of a file, whether it is there or not, links followed.

        Raises:
            RefusedError: It would be outside of the folder, or cannot be a name.
        """
        given = PurePosixPath(name)
        if not name or len(name) > LONGEST or not name.isprintable() or "\\" in name:
            raise RefusedError(400, f"path {name[:60]!r} is not a file name; write for example 'worlds/room.yaml'")
        if any(len(part.encode("utf-8", "replace")) > LONGEST_NAME for part in given.parts):
            raise RefusedError(400, f"path '{name:.60}...' has a name of more than {LONGEST_NAME} bytes; shorten it")
        if given.is_absolute() or ".." in given.parts or name[1:2] == ":":
            raise RefusedError(403, f"path '{name:.60}' leaves the folder of the studio; keep to what is in it")
        try:
            path = (self.root / given).resolve()
        except (OSError, RuntimeError):
            raise RefusedError(400, f"path '{name:.60}' leads nowhere; name another") from None
        if path == self.root or not path.is_relative_to(self.root):
            raise RefusedError(403, f"path '{name:.60}' leads out of the folder of the studio; keep to what is in it")
        return path

    def name(self, path: Path) -> str:
        """Return the name of a file below the folder."""
        return path.relative_to(self.root).as_posix()
