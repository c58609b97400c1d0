"""Runs functions that decode files of strangers in a child process with limits."""

import contextlib
import functools
import logging
import math
import os
import pickle
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from mjsim.closing import ENDING, Closes
from mjsim.errors import MjsimError, Problem, RecordingError, UsageError, WorldError, one_line
from mjsim.guarded.limits import Allowance, limits_for
from mjsim.guarded.request import LENGTH, Call, Permission
from mjsim.guarded.wire import WireError, receive

STARTING = 60.0
"""Time for a child to start and to import its libraries [s]."""
LOOKING = 0.1
"""Time between two looks at the clock [s]."""
KEPT = (
    *("LANG", "LC_ALL", "LC_CTYPE", "TZ", "HOME", "PATH", "SYSTEMROOT", "LD_LIBRARY_PATH", "DYLD_LIBRARY_PATH"),
    *("VIRTUAL_ENV", "PYTHONHOME", "PYTHONPATH", "ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH", "XDG_CACHE_HOME"),
)
"""Environment variables that a child gets."""
ALONE = {
    **dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OPENCV_FOR_THREADS_NUM"), "1"),
    "MALLOC_ARENA_MAX": "1",
}
"""Environment variables that give it one thread."""
_LOG = logging.getLogger(__name__)


def guarded(
    function: str,
    *arguments: Any,
    about: str | Path,
    size: int | None = None,
    folders: Sequence[str | Path] | None = None,
    **keywords: Any,
) -> Any:
    """Return the value of a function that decodes a file, called in a child process of its own.

    Args:
        function: The function, as 'module:name'.
        arguments: Its arguments; they are pickled.
        about: Path of the file, or another name for it, for messages.
        size: Size of what is decoded, with which the limits grow [bytes]; by default that of the file.
        folders: Folders and files that may be read; by default the folder of the file.
        keywords: Further arguments of the function.

    Returns:
        Its value, which must be None, a number, text, bytes, an array of numbers, or made of these; see `Plain`.

    Raises:
        MjsimError: What the function raised, if it is an error of mjsim.
        UsageError: It raised something else, crashed, or needed too much time or memory.
    """
    with _reader(function, about, size, folders) as reader:
        return reader.call(function, *arguments, about=about, size=_size(about, size), **keywords)


def guarded_parts(
    function: str,
    *arguments: Any,
    about: str | Path,
    size: int | None = None,
    folders: Sequence[str | Path] | None = None,
    scratch: bool = False,
    **keywords: Any,
) -> Iterator[Any]:
    """Yield the values of a generator function as they are made, in a child process of its own; see `guarded`.

    The child runs ahead by what the pipe holds, about 64 kB. One message costs about 50 microseconds: yield batches.

    Args:
        function: The generator function, as 'module:name'.
        arguments: Its arguments; they are pickled.
        about: Path of the file, or another name for it, for messages.
        size: Size of what is decoded [bytes]; by default that of the file.
        folders: Folders and files that may be read; by default the folder of the file.
        scratch: Whether it may make temporary files, in a private folder that is deleted afterwards.
        keywords: Further arguments of the function.

    Raises:
        MjsimError: As from `guarded`, when the place is reached.
    """
    with _reader(function, about, size, folders, scratch=scratch) as reader:
        yield from reader.parts(function, *arguments, about=about, size=_size(about, size), **keywords)


class Reader(Closes):
    """A child process with limits that decodes files, one after another; it is started with the first call.

    A file that ends the child costs a line and a new child, so that the next file is read. Not for several threads.
    """

    def __init__(
        self,
        function: str,
        *,
        folders: Sequence[str | Path] = (),
        scratch: bool = False,
        limits: Allowance | None = None,
    ) -> None:
        """Describe the child.

        Args:
            function: One of its functions, 'module:name'; its module is imported before the limits hold.
            folders: Folders and files that may be read; none are needed for what is passed as bytes.
            scratch: Whether it may make temporary files, in a private folder that is deleted afterwards.
            limits: Its limits of memory; by default those for small files.
        """
        self._function, self._limits = function, limits or Allowance()
        self._folders = tuple(Path(folder).absolute() for folder in folders)
        self._scratch = tempfile.TemporaryDirectory(prefix="mjsim-") if scratch else None
        self._child: _Child | None = None

    def call(self, function: str, /, *arguments: Any, about: str | Path, size: int = 0, **keywords: Any) -> Any:
        """Return the value of a function; see `guarded`."""
        answers = self._answers(Call(function, arguments, keywords), str(about), limits_for(size))
        # A function that gives parts here is asked for none of them.
        return next((answer["value"] for answer in answers if "value" in answer), None)

    def parts(
        self,
        function: str,
        /,
        *arguments: Any,
        about: str | Path,
        size: int = 0,
        limits: Allowance | None = None,
        **keywords: Any,
    ) -> Iterator[Any]:
        """Yield the values of a generator function; see `guarded_parts`. Who stops early ends the child."""
        for answer in self._answers(Call(function, arguments, keywords), str(about), limits or limits_for(size)):
            if "part" in answer:
                yield answer["part"]

    def close(self) -> None:
        """End the child, and delete its temporary files."""
        self._end()
        if self._scratch is not None:
            self._scratch.cleanup()

    def start(self) -> None:
        """Start the child, unless it runs: it imports its libraries while the caller does something else."""
        if self._child is not None and not self._child.running:
            self._end()
        if self._child is None:
            scratch = None if self._scratch is None else Path(self._scratch.name)
            self._child = _Child(Permission(self._function, self._limits, self._folders, scratch, os.getpid()))

    def _end(self) -> None:
        child, self._child = self._child, None
        if child is not None:
            child.kill()

    def _answers(self, call: Call, about: str, limits: Allowance) -> Iterator[Mapping[str, Any]]:
        """Yield the answers to a call up to its value; the child ends if it failed, or if the caller stops early."""
        whole = False
        self.start()
        child = self._child
        assert child is not None, "it was started"
        try:
            for answer in child.answers(call, limits, about):
                whole = "value" in answer
                yield answer
        except MjsimError:
            whole = child.running
            raise
        finally:
            if not whole:
                self._end()


def _reader(
    function: str, about: str | Path, size: int | None, folders: Sequence[str | Path] | None, *, scratch: bool = False
) -> Reader:
    if folders is None:
        folders = [about.parent] if isinstance(about, Path) else []
    return Reader(function, folders=folders, scratch=scratch, limits=limits_for(_size(about, size)))


def _size(about: str | Path, size: int | None) -> int:
    """Return a size, or that of the file; 0 if there is none, which its reader will say."""
    if size is None and isinstance(about, Path):
        with contextlib.suppress(OSError):
            return about.stat().st_size
    return size or 0


class _Child:
    """A running child."""

    def __init__(self, start: Permission) -> None:
        self._limits, self._memory = start.limits, start.limits.memory
        self._until, self._expired = math.inf, False
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", "mjsim.guarded.child"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=_environment(start.scratch),
            # The terminal's Ctrl-C reaches the parent alone, which then ends the child.
            start_new_session=sys.platform != "win32",
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._requests, self._answers = self._process.stdin, self._process.stdout
        self._ended = threading.Event()
        threading.Thread(target=self._watch, name="guarded reader", daemon=True).start()
        self._begun = False
        self._ask(start)

    @property
    def running(self) -> bool:
        """Whether it takes further calls."""
        return self._process.poll() is None and not self._expired

    def kill(self) -> None:
        """End the process, whatever it does."""
        self._ended.set()
        with contextlib.suppress(ProcessLookupError):
            self._process.kill()
        with contextlib.suppress(OSError):
            self._requests.close()
        self._answers.close()
        self._process.wait(ENDING)

    def answers(self, call: Call, limits: Allowance, about: str) -> Iterator[Mapping[str, Any]]:
        """Yield the answers to a call; the last one has the key 'value'.

        Raises:
            MjsimError: The call failed.
        """
        left = limits.seconds
        try:
            if not self._begun:
                _say_missing(", ".join(map(str, self._timed(STARTING)["missing"])))
                self._begun = True
            _allow_time(self._process.pid, limits.seconds)
            self._ask(call)
            while True:
                before = time.monotonic()
                answer = self._timed(left)
                left -= time.monotonic() - before
                if left < limits.each:
                    left = limits.each
                    _allow_time(self._process.pid, left)
                _raise_error(answer, about, self._memory)
                yield answer
                if "value" in answer:
                    return
        except (EOFError, BrokenPipeError):
            raise UsageError(f"'{about}' cannot be read: {self._cause(limits)}") from None
        except (WireError, KeyError) as error:
            _LOG.debug("answer of a reader: %s", error)
            self.kill()
            raise UsageError(
                f"'{about}' cannot be read: its reader gave no valid answer; the file is damaged"
            ) from None

    def _ask(self, request: Permission | Call) -> None:
        data = pickle.dumps(request)
        with contextlib.suppress(BrokenPipeError):  # the next answer tells why
            self._requests.write(LENGTH.pack(len(data)))
            self._requests.write(data)
            self._requests.flush()

    def _timed(self, seconds: float) -> Any:
        """Return the next answer; the child is ended if it takes longer."""
        self._until = time.monotonic() + seconds
        try:
            return receive(self._answers, limit=self._memory)
        finally:
            self._until = math.inf

    def _watch(self) -> None:
        """End the child when its time is over."""
        while not self._ended.wait(LOOKING):
            if time.monotonic() > self._until:
                self._expired = True
                self._process.kill()
                return

    def _cause(self, limits: Allowance) -> str:
        """Return why the child ended."""
        with contextlib.suppress(subprocess.TimeoutExpired):  # it closed its pipe, yet it runs
            self._process.wait(1.0)
        self.kill()
        code = self._process.returncode
        if self._expired or code == -getattr(signal, "SIGXCPU", 0):
            return f"it took longer than {limits.seconds:.0f} s; the file is damaged, or too large"
        if code >= 0:
            return f"its reader ended with exit code {code}; the file is damaged"
        with contextlib.suppress(ValueError):
            return f"its reader crashed ({signal.Signals(-code).name}); the file is damaged"
        return f"its reader crashed (signal {-code}); the file is damaged"


def _environment(scratch: Path | None) -> Mapping[str, str]:
    """Return the environment of a child: nothing that its libraries do not need, and where mjsim is."""
    kept = {name: os.environ[name] for name in KEPT if name in os.environ} | ALONE
    root = str(Path(__file__).parents[2])
    kept["PYTHONPATH"] = os.pathsep.join([*filter(None, [kept.get("PYTHONPATH")]), root])
    return kept if scratch is None else kept | {"TMPDIR": str(scratch)}


def _allow_time(process: int, seconds: float) -> None:
    """Give a process some more processor time [s], where the system lets a parent do so.

    References:
        prlimit(2), proc_pid_stat(5).
    """
    if sys.platform != "linux":
        return
    import resource

    with contextlib.suppress(OSError, ValueError):
        words = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
        used = (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")
        hard = resource.prlimit(process, resource.RLIMIT_CPU)[1]
        resource.prlimit(process, resource.RLIMIT_CPU, (math.ceil(used + seconds), hard))


@functools.cache
def _say_missing(missing: str) -> None:
    """Log, once in a process, which limits this system does not have."""
    if missing:
        _LOG.warning("files are read without all limits here: none on %s; Linux 5.13 and later have them", missing)


def _raise_error(answer: Mapping[str, Any], about: str, memory: int) -> None:
    """Raise the error that an answer tells of."""
    if "traceback" in answer:
        _LOG.debug("in the reader of '%s':\n%s", about, answer["traceback"])
    if "memory" in answer:
        raise UsageError(f"'{about}' cannot be read: it needs more than {memory / 1e6:.0f} MB; make it smaller")
    if "failed" in answer:
        failure = one_line(str(answer["failed"]))[:160]
        raise UsageError(f"'{about}' cannot be read: {failure}; the file may be damaged")
    if "problems" in answer:
        raise WorldError(Problem(str(a), int(b), int(c), str(d)) for a, b, c, d in answer["problems"])
    if "error" in answer:
        kinds = {"UsageError": UsageError, "RecordingError": RecordingError}
        raise kinds[answer["error"]](str(answer["message"]))
    if "fault" in answer:
        raise RuntimeError(f"the reader of '{about}' is wrong: {answer['fault']}\n{answer['traceback']}")
