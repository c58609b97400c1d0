"""The host of programs: 'exec:./my_slam --flag'."""

import os
import shlex
import shutil
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from mjsim.modules.foreign import (
    elsewhere_in,
    files_in,
    key_defects,
    options_of,
    paths_of,
    patience_of,
    read_files,
    require_sound,
)
from mjsim.modules.hosts import Defect, Host, Offer, Provenance, beside, folder_of
from mjsim.sentences import Sentence
from mjsim.world import Source, Use

_MARK = "exec:"
_SHEBANG_BYTES = 256
"""Number of bytes of a first line that Linux reads."""
_INTERPRETERS = {
    ".py": "python3",
    ".js": "node",
    ".mjs": "node",
    ".pl": "perl",
    ".rb": "ruby",
    ".lua": "lua",
    ".jl": "julia",
    ".R": "Rscript",
    ".m": "octave",
}
"""Usual interpreters by the ends of names."""


class ProgramHost(Host):
    """Runs a program beside a world file, or an installed one, such as 'exec:julia slam.jl'."""

    def speaks(self, use: str) -> bool:
        """Return whether it names a program."""
        return use.startswith(_MARK)

    def origin(self, use: str) -> Provenance:
        """Return the origin of the program: a bare word is installed, a path is beside the world file."""
        return "beside" if "/" in next(iter(_words(use)), "") else "installed"

    def place(self, use: str) -> str:
        """Return the program, by its path relative to the world's folder."""
        return os.path.normpath(next(iter(_words(use)), ""))

    def runs(self, file: str) -> bool:
        """Return True: any file on the command line may be code."""
        return True

    def defects(self, use: Use, role: str, source: Source) -> Iterator[Defect]:
        """Yield what does not exist or is not executable."""
        yield from key_defects(use, role, source)
        try:
            _require_program(use, source)
        except ValueError as error:
            yield Defect(str(error))

    def files(self, uses: Sequence[Use], source: Source, *, data: bool = True) -> Mapping[str, bytes]:
        """Return the programs, the files beside the world on their command lines, and the files in `paths`."""
        home, found = folder_of(source), []
        for use in uses:
            for word in _words(use.use):
                try:
                    found.append(beside(word, source))
                except ValueError:
                    continue  # A flag, or an installed program.
            try:
                found += [path for folder in paths_of(use, source) for path in files_in(folder, home)]
            except ValueError:
                continue  # An error will be reported when it is run.
        return read_files(found, source)

    def elsewhere(self, uses: Sequence[Use], source: Source) -> Sequence[Path]:
        """Return the files outside the folder of the world on the command lines: they may be code, too."""
        return [path for use in uses for path in elsewhere_in(_words(use.use)[1:], source)]

    def offers(self, files: Sequence[tuple[Path, str]]) -> Iterator[Offer]:
        """Yield nothing: the role of a program cannot be derived from its file."""
        yield from ()

    def at_hand(self, named: str) -> tuple[Path | None, str]:
        """Return the working directory, to which the program's path is relative."""
        return Path.cwd(), named

    def make(self, use: Use, source: Source, *, role: str, robot: str) -> Any:
        """Return the module; the program starts with the run."""
        # Loaded when a module is created: checking a world asks every host, and starts none.
        from mjsim.modules.foreign import ForeignModule, Workplace
        from mjsim.modules.program.program_engine import ProgramEngine

        require_sound(self.defects(use, role, source))
        words, paths = _words(use.use), [path.relative_to(folder_of(source)) for path in paths_of(use, source)]
        place = Workplace(self, use, source)
        engine = ProgramEngine(words, place, who=f"{robot}/{role}", patience=patience_of(use), paths=paths)
        return ForeignModule(engine, role=role, name=Path(words[0]).name, place="", options=options_of(use))


def _words(use: str) -> list[str]:
    """Return the words of a command line, split as by a shell."""
    try:
        return shlex.split(use.removeprefix(_MARK))
    except ValueError:
        return []


def _require_program(use: Use, source: Source) -> None:
    """Raise ValueError if a program does not exist, or is not executable."""
    words = _words(use.use)
    if not words:
        raise ValueError(
            Sentence("'{use}' names no program; write 'exec:./program --flag', with quotes in pairs", use.use)
        )
    program = words[0]
    if "/" not in program:
        if shutil.which(program) is None:
            raise ValueError(
                Sentence("no program '{program}' is installed; one beside the world file is './{program}'", program)
            )
        return
    path = beside(program, source)
    if not os.access(path, os.X_OK):
        raise ValueError(Sentence("'{program}' cannot be executed; type: chmod +x {name}", program, path.name))
    try:
        folders = paths_of(use, source)
    except ValueError:
        return  # Reported with the key.
    if problem := _unstartable(path, folders):
        raise ValueError(Sentence("'{program}' {problem}", program, problem))


def _unstartable(path: Path, folders: Sequence[Path]) -> str:
    """Return why the first line of a script starts no interpreter, as a sentence without its subject; '' if it does.

    The shell would only say that the script itself was not found, or read it as a script of its own.
    """
    if not os.access(path, os.R_OK):
        return ""  # A compiled program starts all the same.
    with path.open("rb") as file:
        first, end, _ = file.read(_SHEBANG_BYTES).partition(b"\n")
    if not first.startswith(b"#!"):
        needed = _INTERPRETERS.get(path.suffix)
        if needed is None or b"\0" in first:
            return ""
        by_name = f"'exec:{needed} {path.name}'"
        return Sentence(
            "does not name its interpreter; begin it with '#!/usr/bin/env {needed}', or write {by_name}",
            needed,
            by_name,
        )
    if end and first.endswith(b"\r"):
        return "has Windows line endings, so its first line starts no interpreter; save it with those of Linux"
    words = os.fsdecode(first[2:]).split()
    if not words or not Path(words[0]).is_file():
        return Sentence(
            "names the interpreter '{interpreter}' in its first line, which does not exist; correct the line",
            " ".join(words[:1]),
        )
    asked = [word for word in words[1:] if not word.startswith("-") and "=" not in word]
    where = os.pathsep.join([*map(str, folders), os.environ.get("PATH", "")])
    if Path(words[0]).name == "env" and asked and shutil.which(asked[0], path=where) is None:
        return Sentence("needs the interpreter '{interpreter}', which is not installed", asked[0])
    return ""
