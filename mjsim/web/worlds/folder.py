"""The folder of a studio; nothing outside it is read or written."""

import os
import threading
from pathlib import Path, PurePosixPath

from mjsim.errors import UsageError
from mjsim.sentences import Sentence
from mjsim.web.server import RefusedError
from mjsim.world import OutsideError, place_in

MAX_PATH_LENGTH = 400
"""Maximum length of a path [characters]."""


class Folder:
    """A folder and the files below it, named by their relative paths."""

    def __init__(self, root: Path) -> None:
        """Use a folder.

        Raises:
            UsageError: It does not exist.
        """
        self.root = root.resolve()
        self.writing = threading.Lock()
        """Held while writing a file after checking its previous content or absence."""
        if not self.root.is_dir():
            raise UsageError(Sentence("no folder '{root}'; name an existing one", root))

    def path(self, name: str) -> Path:
        """Return the absolute path of a file, which need not exist, with links resolved.

        Raises:
            RefusedError: It lies outside the folder, or is not a valid name.
        """
        given = PurePosixPath(name)
        if not name or len(name) > MAX_PATH_LENGTH or "\\" in name:
            raise RefusedError(
                400, Sentence("path {name!r} is not a file name; write for example 'worlds/room.yaml'", name[:60])
            )
        if given.is_absolute() or ".." in given.parts or name[1:2] == ":":
            raise RefusedError(
                403, Sentence("path '{name:.60}' is outside the folder of the studio; name a file in it", name)
            )
        try:
            path = place_in(self.root, name).resolve()
        except OutsideError:
            path = self.root
        except ValueError as error:
            raise RefusedError(400, str(error)) from None
        if path == self.root:
            raise RefusedError(
                403, Sentence("path '{name:.60}' is outside the folder of the studio; name a file in it", name)
            )
        if os.path.lexists(path) and not (os.path.isfile(path) or os.path.isdir(path)):
            raise RefusedError(400, Sentence("path '{name:.60}' is a pipe or a device; name a file", name))
        return path

    def name(self, path: Path) -> str:
        """Return the relative path of a file below the folder."""
        return path.relative_to(self.root).as_posix()
