"""The parent's side of the child process that decodes files: starts, calls, watches and ends it."""

import contextlib
import functools
import logging
import math
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from mjsim.closing import THREAD_TIMEOUT
from mjsim.errors import MjsimError, Problem, UsageError, WorldError, one_line, printable
from mjsim.guarded.limits import Allowance
from mjsim.guarded.plain_values import WireError, receive
from mjsim.guarded.request import LENGTH, OWN_ERRORS, Call, Permission
from mjsim.sentences import Sentence

START_TIMEOUT = 60.0
"""Time for a child to start and to import its libraries [s]."""
POLL_SECONDS = 0.1
"""Interval for checking the time limit [s]."""
MAX_RENEWALS = 10_000
"""Maximum number of times that a call may restart its time limit."""
KEPT = (
    *("LANG", "LC_ALL", "LC_CTYPE", "TZ", "HOME", "PATH", "SYSTEMROOT", "LD_LIBRARY_PATH", "DYLD_LIBRARY_PATH"),
    *("VIRTUAL_ENV", "PYTHONHOME", "PYTHONPATH", "XDG_CACHE_HOME"),
)
"""Environment variables that a child gets."""
ALONE = {
    **dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OPENCV_FOR_THREADS_NUM"), "1"),
    "MALLOC_ARENA_MAX": "1",
    "MUJOCO_GL": "disable",
}
"""Environment variables that give it one thread, and no window."""
_LOG = logging.getLogger(__name__)


class ShortOfMemoryError(UsageError):
    """A file needs more memory than its child may use."""


@dataclass(frozen=True, slots=True)
class About:
    """Parts of a message about a file."""

    name: str
    advice: str
    """What may be wrong, or what to do."""

    def error(self, cause: str) -> UsageError:
        """Return the error of a file that cannot be read."""
        return UsageError(Sentence("'{name}' cannot be read: {cause}; {advice}", self.name, cause, self.advice))


class Child:
    """A running child."""

    def __init__(self, function: str, allowance: Allowance, *, folders: tuple[Path, ...], scratch: Path | None) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", "mjsim.guarded.child"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=_environment(scratch),
            # The terminal's Ctrl-C reaches the parent alone, which then ends the child.
            start_new_session=sys.platform != "win32",
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._requests, self._answers = self._process.stdin, self._process.stdout
        self._watch = _Watch(self._process)
        self._ready = False
        self.used = False
        """Whether it has read a file before, which may have left something in its memory."""
        self._ask(Permission(function, allowance, folders, scratch, os.getpid()))

    @property
    def running(self) -> bool:
        """Whether it takes further calls."""
        return self._process.poll() is None and not self._watch.expired

    def kill(self) -> None:
        """End the process, whatever it does."""
        self._watch.stop()
        with contextlib.suppress(ProcessLookupError):
            self._process.kill()
        with contextlib.suppress(OSError):
            self._requests.close()
        self._answers.close()
        self._process.wait(THREAD_TIMEOUT)

    def answers(self, call: Call, allowance: Allowance, about: About) -> Iterator[Mapping[str, Any]]:
        """Yield the answers to a call; the last one has the key 'value'.

        Raises:
            MjsimError: The call failed.
        """
        try:
            if not self._ready:
                _say_missing(", ".join(map(str, self._timed(START_TIMEOUT, Allowance().answer)["missing"])))
                self._ready = True
            _limit(self._process.pid, allowance)
            with self._watch.over(allowance.seconds):
                self._ask(call)
            yield from self._answered(allowance, about)
        except EOFError:
            raise about.error(self._cause(allowance)) from None
        except (WireError, KeyError) as error:
            _LOG.debug("answer of a reader: %s", error)
            self.kill()
            raise about.error("its reader gave no valid answer") from None

    def _answered(self, allowance: Allowance, about: About) -> Iterator[Mapping[str, Any]]:
        left, renewals = allowance.seconds, 0
        while True:
            before = self._watch.clock()
            answer = self._timed(left, allowance.answer)
            if not isinstance(answer, Mapping):
                raise WireError(Sentence("a {name} as an answer", type(answer).__name__))
            left = max(left - (self._watch.clock() - before), POLL_SECONDS)
            further = allowance.seconds if "working" in answer else allowance.each
            if left < further and renewals < MAX_RENEWALS:
                left, renewals = further, renewals + 1
                _limit(self._process.pid, replace(allowance, seconds=left))
            if "working" in answer:
                continue
            _raise_error(answer, about, allowance)
            yield answer
            if "value" in answer:
                return

    def _ask(self, request: Permission | Call) -> None:
        data = pickle.dumps(request)
        with contextlib.suppress(BrokenPipeError):  # the next answer tells why
            self._requests.write(LENGTH.pack(len(data)))
            self._requests.write(data)
            self._requests.flush()

    def _timed(self, seconds: float, limit: int) -> Any:
        """Return the next answer; the child is ended if it takes longer."""
        with self._watch.over(seconds):
            return receive(self._answers, limit=limit)

    def _cause(self, allowance: Allowance) -> str:
        """Return why the child ended."""
        with contextlib.suppress(subprocess.TimeoutExpired):  # it closed its pipe, yet it runs
            self._process.wait(1.0)
        self.kill()
        code = self._process.returncode
        if self._watch.expired or code == -getattr(signal, "SIGXCPU", 0):
            return f"it took longer than {allowance.seconds:.0f} s"
        if code >= 0:
            return f"its reader ended with exit code {code}"
        with contextlib.suppress(ValueError):
            return f"its reader crashed ({signal.Signals(-code).name})"
        return f"its reader crashed (signal {-code})"


class _Watch:
    """Ends a process that keeps its parent waiting for too long."""

    def __init__(self, process: "subprocess.Popen[bytes]") -> None:
        self.expired = False
        self._process, self._until = process, math.inf
        self._stopped = threading.Event()
        threading.Thread(target=self._look, name="guarded reader", daemon=True).start()

    @contextlib.contextmanager
    def over(self, seconds: float) -> Iterator[None]:
        """Limit the time of a block, without that for which the process waits for a processor [s]."""
        self._until = self.clock() + seconds
        try:
            yield
        finally:
            self._until = math.inf

    def clock(self) -> float:
        """Return a time that stands still while the process waits for a processor [s]."""
        return time.monotonic() - _queued(self._process.pid)

    def stop(self) -> None:
        """Stop watching."""
        self._stopped.set()

    def _look(self) -> None:
        while not self._stopped.wait(POLL_SECONDS):
            if time.monotonic() > self._until and self.clock() > self._until:
                self.expired = True
                self._process.kill()
                return


def _queued(process: int) -> float:
    """Return for how long the main thread of a process has waited for a processor [s]; 0 where that is not known.

    References:
        Linux, Documentation/scheduler/sched-stats.rst: /proc/PID/schedstat.
    """
    try:
        return int(Path(f"/proc/{process}/schedstat").read_text().split()[1]) * 1e-9
    except (OSError, LookupError, ValueError):
        return 0.0


def _environment(scratch: Path | None) -> Mapping[str, str]:
    """Return the environment of a child: only what its libraries need, and the location of mjsim."""
    kept = {name: os.environ[name] for name in KEPT if name in os.environ} | ALONE
    root = str(Path(__file__).parents[2])
    kept["PYTHONPATH"] = os.pathsep.join([*filter(None, [kept.get("PYTHONPATH")]), root])
    return kept if scratch is None else kept | {"TMPDIR": str(scratch)}


def _limit(process: int, allowance: Allowance) -> None:
    """Give a process the memory and the processor time of a call, where the system lets a parent do so.

    References:
        prlimit(2), proc_pid_stat(5).
    """
    if sys.platform != "linux":
        return
    import resource

    from mjsim.guarded.lockdown import memory_limits

    with contextlib.suppress(OSError, ValueError):
        words = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
        used = (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")
        for which, value in ((resource.RLIMIT_CPU, math.ceil(used + allowance.seconds)), *memory_limits(allowance)):
            hard = resource.prlimit(process, which)[1]
            resource.prlimit(process, which, (value if hard == resource.RLIM_INFINITY else min(value, hard), hard))


@functools.cache
def _say_missing(missing: str) -> None:
    """Log, once in a process, which limits this system does not have."""
    if missing:
        _LOG.warning("files are read with fewer limits here: none on %s; Linux 5.13 and later have them", missing)


def _raise_error(answer: Mapping[str, Any], about: About, allowance: Allowance) -> None:
    """Raise the error in an answer."""
    if "traceback" in answer:
        _LOG.debug("in the reader of '%s':\n%s", about.name, answer["traceback"])
    if "memory" in answer:
        raise ShortOfMemoryError(str(about.error(f"it needs more than {allowance.memory / 1e6:.0f} MB")))
    if "failed" in answer:
        raise about.error(one_line(str(answer["failed"]))[:160])
    try:
        own = _own_error(answer)
    except (LookupError, TypeError, ValueError) as error:
        raise WireError(Sentence("{name}: {error}", type(error).__name__, error)) from None
    if own is not None:
        raise own
    if "fault" in answer:
        raise RuntimeError(
            Sentence(
                "the reader of '{name}' has a bug: {fault}\n{other_fault}",
                about.name,
                answer["fault"],
                answer["traceback"],
            )
        )


def _own_error(answer: Mapping[str, Any]) -> MjsimError | None:
    """Return the error of mjsim in an answer; None if it has none."""
    if "problems" in answer:
        return WorldError([Problem(str(a), int(b), int(c), str(d)) for a, b, c, d in answer["problems"]])
    if "error" in answer:
        # It may quote the file.
        message = str(answer["message"])
        safe = message if message.isprintable() else "\n".join(map(printable, message.split("\n")))
        return OWN_ERRORS[answer["error"]](safe)
    return None
