"""A process of a module: gets requests, gives answers, and is terminated reliably with all its children."""

import fcntl
import os
import secrets
import select
import signal
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from mjsim.closing import Closes
from mjsim.modules.foreign.module_output import ShownOutput

EXIT_SECONDS = 0.5
"""Time for a process to end by itself after the last request [s]."""
MAX_BYTES = 1 << 28
"""Maximum size of one answer."""
_PIPE_BYTES = 1 << 20
"""Capacity of a pipe, if the system allows it [bytes]; enough for a picture."""
_POLL_SECONDS = 0.05
"""Interval for checking a process that does not answer [s]."""
_MARK = "MJSIM_MODULE"
"""Environment variable that identifies children that left the process group."""
_SIGNALS = tuple(getattr(signal, f"SIG{name}") for name in ("HUP", "INT", "QUIT", "PIPE", "TERM", "CHLD", "XFSZ"))
"""A process starts with default handlers of these signals, even if this one ignores some, as under nohup."""
_MAX_KILL_ROUNDS = 20
"""Maximum number of searches for processes that left the group: while they are killed, they may start others."""
_KEEP = (
    "{ exec 0<&3 3<&- 1>/dev/null 2>&1; read -r _; read -r me _ </proc/self/stat; "
    f'for e in $(grep -lsF "{_MARK}=${_MARK}" /proc/[0-9]*/environ); do '
    'p=${e#/proc/}; p=${p%/*}; [ "$p" = "$me" ] || kill -9 "$p"; done; kill -9 0; } & '
    'exec 3<&-; cd -- "$1" || exit 126; shift; '
)
"""Kills the group, and processes that left it, once the parent has ended for any reason: this closes descriptor 3."""
_TOO_MANY = b"gave more answers than it was asked for, so that some were those to earlier requests\n"
ON_STANDARD = _KEEP + 'exec "$@"'
"""Requests on standard input, answers on standard output."""
ON_3_AND_4 = _KEEP + 'exec "$@" 3<&0 4>&1 0</dev/null 1>&2'
"""Requests on descriptor 3, answers on 4: standard output is free for the module."""


class Ended(Exception):  # noqa: N818  # what happened, not a fault of ours
    """A process ended, or was killed, before it answered; the text describes how, as a sentence without its subject."""


class Process(Closes):
    """A process in its own process group; one request at a time."""

    def __init__(
        self,
        command: Sequence[str],
        folder: Path,
        *,
        shell: str,
        output: ShownOutput,
        more: Mapping[str, str] | None = None,
    ) -> None:
        """Start a process.

        Args:
            command: Program and arguments.
            folder: Its working directory.
            shell: `ON_STANDARD` or `ON_3_AND_4`.
            output: Called with its output.
            more: Additional environment variables.

        Raises:
            OSError: It cannot be started.
        """
        requests, self._request = os.pipe()
        self._answer, answers = os.pipe()
        self._log, log = os.pipe()
        life, self._life = os.pipe()
        theirs = (requests, answers, log, life)
        self._ours = [self._request, self._answer, self._log, self._life]
        words = ["sh", "-c", shell, "sh", str(folder), *command]
        # Duplicates with numbers above those that they get in the child.
        copies = [fcntl.fcntl(fd, fcntl.F_DUPFD_CLOEXEC, 10) for fd in theirs]
        places = [(os.POSIX_SPAWN_DUP2, fd, number) for number, fd in enumerate(copies)]
        self._mark = f"{_MARK}={secrets.token_hex(16)}"
        environment = {**os.environ, **(more or {}), _MARK: self._mark.partition("=")[2]}
        try:
            self._pid = os.posix_spawn(
                "/bin/sh", words, environment, file_actions=places, setsid=True, setsigmask=(), setsigdef=_SIGNALS
            )
        finally:
            for fd in (*theirs, *copies):
                os.close(fd)
        self._output, self._rest, self._open, self._asked = output, bytearray(), True, False
        for fd in self._ours:
            os.set_blocking(fd, False)
        for fd in self._ours[:2]:
            with suppress(OSError, AttributeError):  # Only Linux has it, and it limits the total.
                fcntl.fcntl(fd, fcntl.F_SETPIPE_SZ, _PIPE_BYTES)
        self._poll = select.poll()
        self._poll.register(self._answer, select.POLLIN)
        self._poll.register(self._log, select.POLLIN)

    def exchange(self, request: bytes, ends: Callable[[bytearray], int], *, patience: float) -> bytes:
        """Send a request and return the answer.

        Args:
            request: The complete request.
            ends: Returns the number of received bytes that form the answer; 0 while it is incomplete.
            patience: Time limit [s].

        Raises:
            Ended: It ended, or was killed because it was too slow or its answer too large.
        """
        deadline = time.monotonic() + patience
        self._take(0.0)  # A second answer may have arrived after the one that was read.
        if self._rest:
            self._stop(f"answered more than it was asked for: {bytes(self._rest[:60])!r}")
        self._asked = True
        left = self._write(memoryview(request))
        while not (size := ends(self._rest)):
            self._wait(deadline, patience, writes=bool(left))
            left = self._write(left)
        answer = bytes(self._rest[:size])
        del self._rest[:size]
        self._asked = False
        return answer

    def _write(self, left: memoryview) -> memoryview:
        """Write as much as the process accepts now; return the rest."""
        while left:
            try:
                left = left[os.write(self._request, left) :]
            except BlockingIOError:
                break
            except BrokenPipeError:
                return memoryview(b"")  # The end of the process is noticed where its answer is awaited.
        return left

    def _wait(self, deadline: float, patience: float, *, writes: bool) -> None:
        """Wait for the next data, or for the end of the process."""
        if writes:
            self._poll.register(self._request, select.POLLOUT)
        came = self._take(min(_POLL_SECONDS, deadline - time.monotonic()))
        if writes:
            self._poll.unregister(self._request)
        if len(self._rest) > MAX_BYTES:
            self._stop(f"answered more than {MAX_BYTES >> 20} MB")
        # Data written between the last check and its end are still in the pipe.
        if not came and self._has_ended() and not self._take(0.0):
            self._stop(self._end())
        if time.monotonic() >= deadline:
            self._stop(f"did not answer within {patience:g} s and was ended")

    def _take(self, seconds: float) -> bool:
        """Wait for a time for data; return whether part of an answer, or capacity for the request, became available."""
        came = False
        for fd, _ in self._poll.poll(max(0.0, seconds) * 1e3):
            if fd == self._request:
                came = True
                continue
            got = self._read(fd)
            if not got:
                self._poll.unregister(fd)  # No more data will arrive.
            elif fd == self._log:
                self._output.take(got)
            else:
                self._rest += got
                came = True
        return came

    def _read(self, fd: int) -> bytes:
        try:
            return os.read(fd, 1 << 20)
        except BlockingIOError:
            return b""

    def _has_ended(self) -> bool:
        found = os.waitid(os.P_PID, self._pid, os.WEXITED | os.WNOHANG | os.WNOWAIT)
        return found is not None

    def _end(self) -> str:
        """Return how a process ended by itself."""
        self._output.take(self._read(self._log))
        found = os.waitid(os.P_PID, self._pid, os.WEXITED | os.WNOHANG | os.WNOWAIT)
        if found is not None and found.si_code != os.CLD_EXITED:
            how = f"was ended by {signal.Signals(found.si_status).name}"
        else:
            how = f"ended with exit code {0 if found is None else found.si_status}"
        last = self._output.last()
        return f"{how} before it answered{f': {last}' if last else ''}"

    def _stop(self, problem: str) -> None:
        self._kill()
        raise Ended(problem)

    def close(self) -> None:
        """Wait briefly for it to end by itself; then kill it with all its children."""
        if self._open:
            os.close(self._request)
            self._ours = self._ours[1:]
            until = time.monotonic() + EXIT_SECONDS
            while not self._has_ended() and time.monotonic() < until:
                self._take(0.005)
            self._take(0.0)
            if self._rest and not self._asked:
                self._output.take(_TOO_MANY)
            self._kill()

    def _kill(self) -> None:
        """Kill the group and the processes that left it; its leader is reaped last, so that its id is not reused."""
        if self._open:
            self._open = False
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(self._pid, signal.SIGKILL)
            os.waitpid(self._pid, 0)
            _kill_marked(self._mark)
            self._output.take(self._read(self._log))
            self._output.close()
            for fd in self._ours:
                os.close(fd)


def _kill_marked(mark: str) -> None:
    """Kill the processes with a variable in their environment, as Linux shows it: daemons have a group of their own."""
    for _ in range(_MAX_KILL_ROUNDS):
        found = list(_marked(mark.encode()))
        for pid in found:
            with suppress(ProcessLookupError, PermissionError):
                os.kill(pid, signal.SIGKILL)
        if not found:
            return


def _marked(mark: bytes) -> Iterator[int]:
    """Yield the processes of this user that were started with a variable; those that have ended show none."""
    for place in Path("/proc").glob("[0-9]*/environ"):
        # It may have ended meanwhile, or belong to somebody else.
        with suppress(OSError):
            if mark in place.read_bytes().split(b"\0"):
                yield int(place.parent.name)
