"""The folder in which a module's process runs: that of the world, or a copy of the files that the user allowed."""

import os
import shutil
import tempfile
from pathlib import Path

from mjsim.modules.foreign.keys import folder_of
from mjsim.modules.hosts import Host, read_code
from mjsim.world import Source, Use


class Workplace:
    """The files of a module while it runs.

    If code may only run with the content that the user allowed, the process gets a copy of exactly that, so it cannot
    be changed between check and start.
    """

    def __init__(self, host: Host, use: Use, source: Source) -> None:
        """Read the files of a module, if they need permission.

        Raises:
            UsageError: A file may not run with its content, or cannot be read.
        """
        self._home = folder_of(source)
        self._copy: Path | None = None
        self._files: dict[Path, tuple[bytes, int]] | None = None
        if source.admit is not None:
            self._files = {}
            for name, data in host.files([use], source).items():
                path = self._home / name
                content = read_code(path, source) if host.runs(name) else data
                self._files[Path(name)] = content, path.stat().st_mode & 0o777

    def enter(self) -> Path:
        """Return the folder, after copying if necessary."""
        if self._files is None:
            return self._home
        if self._copy is None:
            self._copy = Path(tempfile.mkdtemp(prefix="mjsim-module-"))
            for name, (data, mode) in self._files.items():
                (self._copy / name).parent.mkdir(parents=True, exist_ok=True)
                (self._copy / name).write_bytes(data)
                os.chmod(self._copy / name, mode | 0o600)
        return self._copy

    def leave(self) -> None:
        """Remove the copy."""
        copy, self._copy = self._copy, None
        if copy is not None:
            shutil.rmtree(copy, ignore_errors=True)
