"""The folder in which a module's process runs: that of the world, or a copy of the files that the user allowed."""

import os
import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path

from mjsim.modules.foreign.reserved_keys import elsewhere_in
from mjsim.modules.hosts import Failed, Host, folder_of, read_admitted, read_code
from mjsim.world import Source, Use


class Workplace:
    """The files of a module while it runs.

    If code may only run with the content that the user allowed, the process gets a copy of exactly that, so it cannot
    be changed between check and start.
    """

    def __init__(self, host: Host, use: Use, source: Source) -> None:
        """Read the files of a module, if they need permission, also those outside the folder that a command line names.

        Raises:
            UsageError: A file may not run with its content, or cannot be read.
        """
        self._home, self._source = folder_of(source), source
        self._copy: Path | None = None
        self._files: dict[Path, tuple[bytes, int]] | None = None
        self._elsewhere: dict[Path, Path] = {}
        if source.admit is not None:
            self._files = {}
            for name, data in host.files([use], source).items():
                path = self._home / name
                content = read_code(path, source) if host.runs(name) else data
                self._files[Path(name)] = content, path.stat().st_mode & 0o777
            for number, path in enumerate(host.elsewhere([use], source)):
                self._elsewhere[path] = Path(f".elsewhere-{number}") / path.name
                self._files[self._elsewhere[path]] = read_admitted(path, source), path.stat().st_mode & 0o777

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

    def spelled(self, words: Sequence[str]) -> list[str]:
        """Return a command line that names the copies of files outside the folder; call `enter` first.

        Raises:
            Failed: A file outside the folder appeared only after the user allowed the code.
        """
        return [*words[:1], *map(self._spelled, words[1:])]

    def _spelled(self, word: str) -> str:
        if self._copy is None:
            return word
        for path, name in elsewhere_in([word], self._source).items():
            if path not in self._elsewhere:
                raise Failed(f"names '{name}', which did not exist when its code was allowed; start again to be asked")
            return f"{word.removesuffix(name)}{self._copy / self._elsewhere[path]}"
        return word

    def leave(self) -> None:
        """Remove the copy."""
        copy, self._copy = self._copy, None
        if copy is not None:
            shutil.rmtree(copy, ignore_errors=True)
