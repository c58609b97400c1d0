"""Every error of mjsim: one line for a person, and the exit code of the command line.

MjsimError
├── WorldError        a world file is wrong; one line a problem (exit 2)
├── UsageError        a wrong name, value or file given by the user (exit 2)
├── RecordingError    a file that is not a recording, or holds none of what was asked (exit 2)
├── ModuleFault       a user's module raised or returned what it must not (exit 1)
├── PhysicsFault      the state of the simulation exploded (exit 1)
└── OpenGLError       no way to draw pictures on this machine (exit 1)
"""

import difflib
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import ClassVar

LONGEST_MESSAGE = 400
"""Characters; a key or a list of names may be longer, a line for people is not."""

MOST_WORDS = 1000
"""Names that a misspelt one is compared with."""


class MjsimError(Exception):
    """Base of all errors that are not a bug of mjsim."""

    exit_code: ClassVar[int] = 1


@dataclass(frozen=True, slots=True, order=True)
class Problem:
    """One thing that is wrong in a text file, and where."""

    file: str
    line: int
    """Counted from 1."""
    column: int
    """Counted from 1."""
    message: str
    """What is wrong with the value it had; what would be right. One line, whatever the file held."""

    def __post_init__(self) -> None:
        """Keep the message on one line, printable and not too long."""
        object.__setattr__(self, "message", _shortened(printable(self.message)))

    def __str__(self) -> str:
        """Return 'file:line:column: message'."""
        return f"{self.file}:{self.line}:{self.column}: {self.message}"


class WorldError(MjsimError):
    """A world file is wrong; `problems` holds every fault, sorted by place."""

    exit_code = 2

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems: Sequence[Problem] = tuple(sorted(problems))
        super().__init__("\n".join(map(str, self.problems)))


class UsageError(MjsimError):
    """The user named something that is not there, or a value that cannot be."""

    exit_code = 2


class RecordingError(MjsimError):
    """A file is not a recording, or lacks what was asked of it."""

    exit_code = 2


# Faults of what runs, not errors of what was asked: their names are settled.
class ModuleFault(MjsimError):  # noqa: N818
    """A user's module raised, or returned what it must not; one line, whatever the module said."""

    def __init__(self, message: str, *, robot: str | None = None) -> None:
        self.robot = robot
        super().__init__(one_line(message))


class PhysicsFault(MjsimError):  # noqa: N818
    """MuJoCo warned that the state of the simulation is no longer to be trusted."""


class OpenGLError(MjsimError):
    """No OpenGL backend works on this machine; the message says what to type."""


def one_line(text: str) -> str:
    """Return a text on one line: white space collapsed, control characters escaped, and cut where it is too long."""
    return _shortened(printable(" ".join(text.split())))


def _shortened(line: str) -> str:
    return line if len(line) <= LONGEST_MESSAGE else f"{line[:LONGEST_MESSAGE]}..."


def printable(text: str) -> str:
    """Return a text with its control characters escaped; ends of lines too."""
    return text if text.isprintable() else "".join(map(_printable, text))


def _printable(character: str) -> str:
    return character if character.isprintable() else repr(character)[1:-1]


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return '; did you mean ...?' when a known word is near, else a list of those there are.

    Of very many words only the first are looked at.
    """
    words = sorted(known)[:MOST_WORDS]
    near = difflib.get_close_matches(word, words, n=1)
    if near:
        return f"; did you mean '{near[0]}'?"
    return f"; there are {', '.join(words)}" if words else "; there are none"


def how_to_install(*packages: str) -> str:
    """Return the command that installs packages beside mjsim, with uv in an environment that has no pip."""
    import importlib.util
    import shlex
    import shutil
    import sys

    if importlib.util.find_spec("pip"):
        words = [sys.executable, "-m", "pip", "install"]
    else:
        uv = shutil.which("uv") or shutil.which("uv", path=os.path.dirname(sys.executable)) or "uv"
        words = [uv, "pip", "install", "--python", sys.executable]
    return shlex.join([*words, *packages])
