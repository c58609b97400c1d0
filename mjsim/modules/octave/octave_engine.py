"""Calls a function in Octave, with binary doubles over two pipes."""

import os
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.random import Generator

from mjsim.errors import one_line
from mjsim.interface import Tree, answer_of, doubles_of, quoted
from mjsim.modules.foreign import ON_3_AND_4, Answer, Ended, Engine, Process, ShownOutput, Workplace
from mjsim.modules.hosts import Failed
from mjsim.modules.octave.installed import TOOLBOX
from mjsim.modules.octave.m_files import read_function

DRIVER = Path(__file__).parent / "driver"
FLAGS = ("--norc", "--no-history", "--no-line-editing", "--no-window-system", "--quiet")
_SILENCED_WARNINGS = ("possible-matlab-short-circuit-operator", "function-name-clash")
"""Warnings about valid MATLAB code; the first would be printed at every call."""
_SHADOWING = "warning('{}','Octave:shadowed-function');".format
"""Warnings about functions that replace Octave's: those of the toolbox do so on purpose, a user's own may not."""
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
"""Small matrices are faster with one thread, and sums are the same on every machine."""
FIGURES = "MJSIM_FIGURES"
"""Environment variable with folders of functions that record figures, if the run draws them."""
MIN_START_TIMEOUT = 30.0
"""Minimum time limit for the start of Octave, which reads its own files first: seconds on a busy machine [s]."""
MAX_TEXT_LENGTH = 240
"""Maximum length of an error text [characters]."""
_MAX_LAYOUTS = 250
"""Maximum number of layouts that Octave caches."""
_SEED_COUNT = 16
"""Number of values that seed each random generator."""
_PARSE = re.compile(r"parse error(?: near line (\d+) of file ([^\n]*))?:?\s*([^\n]+)(?:\s+>>> *([^\n]*))?")
_COLUMN = re.compile(r" near line \d+, column \d+$| \(note: variable '\w+' shadows function\)$")
_UNKNOWN = re.compile(r"robot\(\S*\): out of bound 0 ")
"""Error of a function that indexes an empty field of its robot."""


class OctaveEngine(Engine):
    """An Octave process for one function."""

    counts_last = True

    def __init__(
        self, octave: str, file: Path, place: Workplace, *, who: str, patience: float, paths: Sequence[Path]
    ) -> None:
        """Store how to start it.

        Args:
            octave: The program.
            file: File of the function, relative to the folder of the world.
            place: That folder.
            who: Robot and role, as a prefix of its output.
            patience: Time limit of a call [s].
            paths: Folders with other functions.
        """
        self._octave, self._file, self._place, self._who = octave, file, place, who
        self._patience, self._paths = patience, paths
        self._process: Process | None = None
        self._layouts: dict[str, int] = {}
        self._fields: Sequence[str] = ()

    def start(self, robot: Mapping[str, Tree], rng: Generator, fields: Sequence[str]) -> bool:
        """Start Octave, let it read the file, and send it the data of its robot; return whether it needs pictures."""
        self.close()
        self._folder = self._place.enter().resolve()
        self._function = read_function(self._folder / self._file)
        self._layouts, self._fields = {}, fields
        words = [self._octave, *FLAGS, "--eval", self._begin()]
        self._process = Process(words, self._folder, shell=ON_3_AND_4, output=ShownOutput(self._who), more=ONE_THREAD)
        seeds = rng.integers(2**32, size=(_SEED_COUNT, 5)).astype(float)
        self._send(1, {"robot": robot, "fields": list(fields), "seeds": seeds})
        return _names_pictures(self._folder, [self._file.parent, *self._paths])

    def call(self, method: str, given: Mapping[str, Tree]) -> Answer:
        """Return the function's answer."""
        return answer_of(self._send(2, given), self._fields)

    def close(self) -> None:
        """End Octave."""
        if self._process is not None:
            self._process.close()
            self._process = None
        self._place.leave()

    def _begin(self) -> str:
        """Return the code that Octave evaluates at its start."""
        own = [self._folder / path for path in (*self._paths, self._file.parent)]
        adds = "".join(f"warning('off','Octave:{name}');" for name in _SILENCED_WARNINGS)
        figures = [Path(folder) for folder in os.environ.get(FIGURES, "").split(":") if folder]
        adds += f"{_SHADOWING('off')}{_added([*figures, TOOLBOX, DRIVER])}{_SHADOWING('on')}{_added(own)}"
        file = quoted(str(self._folder / self._file))
        return f"{adds}mjsim_serve({quoted(self._file.stem)},{file},'/dev/fd/3','/dev/fd/4')"

    def _send(self, kind: int, tree: Tree) -> bytes:
        """Send a request and return the doubles of the answer."""
        if self._process is None:
            raise Failed("is called after its run has ended; start another run")
        try:
            patience = max(self._patience, MIN_START_TIMEOUT) if kind == 1 else self._patience
            answer = self._process.exchange(self._request(kind, tree), _whole, patience=patience)
        except Ended as ended:
            raise Failed(f"{ended}{self._blame(str(ended))}") from ended
        if np.frombuffer(answer[8:16])[0] == 1.0:
            text = bytes(np.frombuffer(answer[16:]).astype(np.uint8)).decode(errors="replace")
            raise Failed(self._error_text(text))
        return answer[16:]

    def _request(self, kind: int, tree: Tree) -> bytes:
        try:
            made = doubles_of(tree)
        except ValueError as error:
            raise Failed(f"cannot receive the data sheet of its robot: {error}") from error
        code = b""
        if made.code not in self._layouts:
            if len(self._layouts) == _MAX_LAYOUTS:
                self._layouts = {}
            self._layouts[made.code] = len(self._layouts) + 1
            code = made.code.encode()
        numbers, ends = made.numbers()
        pictures = b"".join(each.tobytes() for each in made.bytes)
        counts = (kind, self._layouts[made.code], len(code), len(ends), len(numbers), len(pictures))
        return b"".join((np.array(counts, dtype=float).tobytes(), code, ends.tobytes(), numbers.tobytes(), pictures))

    def _error_text(self, text: str) -> str:
        """Return the text of an error, with its location in the user's files."""
        message, _, frames = text.partition("\n\x01")
        if parse := _PARSE.match(message):
            line, file, description, context = parse.groups()
            context = f" near '{one_line(context)[:60]}'" if context else ""
            place = f"{Path(file).name}:{line}" if file else self._function.place
            return f"raised a parse error: {one_line(description)}{context} ({place})"
        shortened = _COLUMN.sub("", one_line(message))
        if "no graphics toolkits" in shortened:
            shortened = "figures of modules are drawn in recorded runs of the commands and the studio only"
        if _UNKNOWN.search(shortened):
            shortened += "; positions of beacons and walls are [] unless the world has map: known"
        shortened = shortened if len(shortened) <= MAX_TEXT_LENGTH else f"{shortened[:MAX_TEXT_LENGTH]}..."
        return f"raised an error: {shortened}{self._frame_place(frames.splitlines())}"

    def _frame_place(self, frames: Sequence[str]) -> str:
        """Return the innermost frame in a file of the user's; if there is none, that of the function."""
        for frame in frames:
            line, _, rest = frame.partition("\t")
            name, _, file = rest.partition("\t")
            if file and Path(file).is_relative_to(self._folder) and int(line) > 0:
                inner = name.rpartition(">")[2].rpartition("/")[2]
                return f" ({Path(file).relative_to(self._folder).as_posix()}:{line} in {inner})"
        return f" ({self._function.place} in {self._function.name})"

    def _blame(self, how: str) -> str:
        """Return where the file terminates Octave, if that is what happened; otherwise the location of the function."""
        leaves = self._function.exit_line if how.startswith("ended with exit code") else None
        place = f"{self._file.name}:{leaves}" if leaves else self._function.place
        return f" ({place} in {self._function.name})"


def _added(folders: Iterable[Path]) -> str:
    """Return the code that adds folders to Octave's path."""
    return "".join(f"addpath({quoted(str(folder))});" for folder in folders)


def _whole(got: bytearray) -> int:
    """Return the length of a complete answer, 0 while it is incomplete."""
    if len(got) < 8:
        return 0
    size = 8 * (1 + int(np.frombuffer(got[:8])[0]))
    return size if len(got) >= size else 0


def _names_pictures(folder: Path, paths: Sequence[Path]) -> bool:
    """Return whether a file that the function may call contains the word `cameras`: rendering pictures takes time."""
    files = {file for path in paths for file in (folder / path).rglob("*.m")}
    return any(b"cameras" in file.read_bytes() for file in files)
