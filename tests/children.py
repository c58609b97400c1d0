"""Programs that tests start: each begins with signals at their defaults, and is killed with all that it started."""

import os
import queue
import signal
import subprocess
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import IO, Any, Literal

from tests.watchdog import offspring

LIMIT = 60.0
"""No line and no end of a program takes this long [s], on however loaded a machine."""
REAPED = 10.0
"""Time in which the system ends what was killed [s]."""
Stream = Literal["stdout", "stderr"]


class Child:
    """A program in a session of its own; what it says is read at once, so that it never waits for its reader."""

    def __init__(self, words: Sequence[Any], **more: Any) -> None:
        """Start it.

        Args:
            words: Program and arguments.
            more: For `Popen`; stdout and stderr are texts that can be read, unless they are led elsewhere.
        """
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        self.words = list(map(str, words))
        self.process = subprocess.Popen(self.words, text=True, start_new_session=True, **{**pipes, **more})
        self.pid = self.process.pid
        self._lines: dict[str, queue.Queue[str]] = {}
        for name, stream in (("stdout", self.process.stdout), ("stderr", self.process.stderr)):
            if stream is not None:
                self._lines[name] = queue.Queue()
                threading.Thread(target=_read, args=(stream, self._lines[name]), daemon=True).start()

    def line(self, of: Stream = "stdout", *, within: float = LIMIT) -> str:
        """Return the next line; the empty text at the end, as files do."""
        try:
            line = self._lines[of].get(timeout=within)
        except queue.Empty:
            raise AssertionError(f"no line on {of} within {within:g} s of {self.words}") from None
        if not line:
            self._lines[of].put("")
        return line

    def rest(self, of: Stream = "stdout", *, within: float = LIMIT) -> str:
        """Return all lines from here to the end."""
        return "".join(iter(lambda: self.line(of, within=within), ""))

    def ended(self, *, within: float = LIMIT) -> int:
        """Wait until it ends by itself; return its exit code."""
        try:
            return self.process.wait(within)
        except subprocess.TimeoutExpired:
            raise AssertionError(f"it did not end within {within:g} s: {self.words}") from None

    def say(self, text: str) -> None:
        """Write to its standard input, which must be a pipe."""
        assert self.process.stdin is not None
        self.process.stdin.write(text)
        self.process.stdin.flush()

    def runs(self) -> bool:
        """Return whether it has not ended."""
        return self.process.poll() is None

    def send(self, number: int) -> None:
        """Send a signal."""
        self.process.send_signal(number)

    def kill(self) -> None:
        """Kill it and all that it started, in sessions of their own too; a second call does nothing."""
        started = offspring(self.pid)
        with suppress(ProcessLookupError):
            os.killpg(self.pid, signal.SIGKILL)
        for pid in started:
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        if self.process.stdin is not None:
            with suppress(BrokenPipeError):
                self.process.stdin.close()
        self.ended(within=REAPED)


@contextmanager
def child(words: Sequence[Any], **more: Any) -> Iterator[Child]:
    """Start a program as `Child` does, and kill it with all that it started at the end of the block."""
    program = Child(words, **more)
    try:
        yield program
    finally:
        program.kill()


def completed(
    words: Sequence[Any], *, check: bool = True, within: float = LIMIT, **more: Any
) -> "subprocess.CompletedProcess[str]":
    """Run a program to its end.

    Args:
        words: Program and arguments.
        check: Whether it must succeed.
        within: The time that it has [s].
        more: As for `Child`.
    """
    with child(words, **more) as program:
        try:
            code = program.ended(within=within)
        except AssertionError as late:
            program.kill()
            late.add_note("".join(map(program.rest, program._lines)))
            raise
        out, err = (program.rest(of) if of in program._lines else "" for of in ("stdout", "stderr"))
    assert not check or code == 0, f"exit code {code} of {program.words}: {err or out}"
    return subprocess.CompletedProcess(program.words, code, out, err)


def _read(stream: IO[str], lines: "queue.Queue[str]") -> None:
    with suppress(ValueError, OSError), stream:
        for line in stream:
            lines.put(line)
    lines.put("")
