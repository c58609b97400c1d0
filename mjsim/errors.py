"""All errors of mjsim: each has a one-line message and the exit code of the command line.

MjsimError
├── WorldError        a world file is wrong; one line per problem (exit 2)
├── UsageError        a wrong name, value or file given by the user (exit 2)
├── RecordingError    a file that is not a recording, or lacks the requested data (exit 2)
├── ModuleFault       a module raised or returned an invalid value (exit 1)
├── PhysicsFault      the state of the simulation exploded (exit 1)
└── OpenGLError       no OpenGL backend works on this machine (exit 1)
"""

import contextlib
import difflib
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from mjsim.sentences import Sentence
from mjsim.traces import short_trace

MAX_MESSAGE_LENGTH = 400
"""Maximum length of a message [characters]; keys and lists of names in it are cut."""

MAX_WORDS = 1000
"""Number of names that a misspelt name is compared with, at most."""


class MjsimError(Exception):
    """Base class of all errors that are not bugs of mjsim."""

    exit_code: ClassVar[int] = 1
    """Exit code of a command that ends with this error."""

    def _render_traceback_(self) -> list[str]:
        """Return the lines that Python and notebooks print: no frames of mjsim."""
        return short_trace(self)


@dataclass(frozen=True, slots=True, order=True)
class Problem:
    """One problem in a text file, and its position."""

    file: str
    line: int
    """Counted from 1."""
    column: int
    """Counted from 1."""
    message: str
    """What is wrong with the value, and what would be right; always one line."""

    def __post_init__(self) -> None:
        """Keep the message on one line, printable and not too long."""
        object.__setattr__(self, "message", _shortened(printable(self.message)))

    def __str__(self) -> str:
        """Return 'file:line:column: message'."""
        return Sentence("{file}:{line}:{column}: {message}", self.file, self.line, self.column, self.message)


class WorldError(MjsimError):
    """A world file is wrong; `problems` lists all problems, sorted by position."""

    exit_code = 2

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems: Sequence[Problem] = tuple(sorted(problems))
        lines = list(map(str, self.problems))
        super().__init__(lines[0] if len(lines) == 1 else "\n".join(lines))


class UsageError(MjsimError):
    """The user named something that does not exist, or gave an invalid value."""

    exit_code = 2


class OutOfReachError(UsageError):
    """An arm's tool cannot reach a place."""

    def __init__(self, message: str, *, short: float, nearest: tuple[float, float, float] | None = None) -> None:
        self.short, self.nearest = short, nearest
        """Remaining distance [m], and the nearest place within reach, robot frame [m]."""
        super().__init__(message)


class RecordingError(MjsimError):
    """A file is not a recording, or does not contain the requested data."""

    exit_code = 2


# Faults at run time rather than user errors; the names are public.
class ModuleFault(MjsimError):  # noqa: N818
    """A user's module raised an exception or returned an invalid value; the message is always one line."""

    def __init__(self, message: str, *, robot: str | None = None) -> None:
        self.robot = robot
        super().__init__(one_line(message))


class PhysicsFault(MjsimError):  # noqa: N818
    """MuJoCo warned that the state of the simulation is no longer reliable."""


class OpenGLError(MjsimError):
    """No OpenGL backend works on this machine; the message says what to type to install one."""


def one_line(text: str) -> str:
    """Return a text on one line: white space is collapsed, control characters are escaped, and a long text is cut."""
    joined = " ".join(text.split())
    return _shortened(printable(text if text == joined else joined))


def _shortened(line: str) -> str:
    return line if len(line) <= MAX_MESSAGE_LENGTH else f"{line[:MAX_MESSAGE_LENGTH]}..."


def printable(text: str) -> str:
    """Return a text with its control characters escaped, including line breaks."""
    return text if text.isprintable() else "".join(map(_printable, text))


def _printable(character: str) -> str:
    return character if character.isprintable() else repr(character)[1:-1]


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return '; did you mean ...?' if a known word is similar, else a list of the known words.

    Considers only the first `MAX_WORDS` words, and skips empty and unprintable ones, such as some file names.
    """
    words = sorted(word for word in known if word and word.isprintable())[:MAX_WORDS]
    # A name that begins with the word is more likely meant than one that differs in a letter.
    begun = [each for each in words if word and each.startswith(word)]
    matches = difflib.get_close_matches(word, begun, n=1, cutoff=0.0) or difflib.get_close_matches(word, words, n=1)
    if matches:
        return Sentence("; did you mean '{word}'?", matches[0])
    return Sentence("; there are {words}", ", ".join(words)) if words else "; there are none"


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


def file_meant(path: Path, endings: Sequence[str], *, otherwise: str) -> str:
    """Return '; did you mean ...?' if a file beside a missing one has a similar name and ends as those that are read.

    Args:
        path: The missing file.
        endings: Endings of files that are read, in lower case.
        otherwise: What to name, if there is none.
    """
    found = []
    with contextlib.suppress(OSError):
        found = [item.name for item in path.parent.iterdir() if item.name.lower().endswith(tuple(endings))]
    # The ending alone must not make two names alike.
    stems = {name.partition(".")[0]: name for name in sorted(found)[:MAX_WORDS] if name.isprintable()}
    alike = difflib.get_close_matches(path.name.partition(".")[0], stems, n=1)
    return Sentence("; did you mean '{word}'?", stems[alike[0]]) if alike else f"; name {otherwise}"
