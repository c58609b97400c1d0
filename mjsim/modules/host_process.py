"""Guards the process of a command in which modules run.

An exception in a thread that a module starts ends the run, like one of the module itself; afterwards the process is
restored.
"""

import _thread
import locale
import os
import signal
import sys
import threading
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import Any, NoReturn, TextIO

import numpy as np

from mjsim.errors import ModuleFault
from mjsim.modules.boundary import error_text, is_of_users
from mjsim.progress import say
from mjsim.sentences import Sentence

HANDLED = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
"""Signals whose handlers are restored."""
_SUBREAPER = 36
"""PR_SET_CHILD_SUBREAPER of Linux: orphaned descendants become children of this process."""
_MAX_KILL_ROUNDS = 20
"""Maximum number of searches for descendants: while they are killed they may start others."""
_MAX_NAMED_PROCESSES = 3
"""Number of processes that the message names."""


@contextmanager
def hosting() -> Iterator[None]:
    """Host modules in a block, in the main thread of a command.

    Errors in their threads end the block with a ModuleFault. At its end, the working directory, standard output and
    error, signal handlers, umask, locale, recursion limit and NumPy's error handling are restored, and processes that
    the modules left behind are killed, with all their descendants (Linux). `os._exit` and `os.exec*` are errors.
    """
    with _children_ended(), _process_kept(), thread_faults(), exit_refused():
        yield


@contextmanager
def exit_refused() -> Iterator[None]:
    """Make `os._exit` and `os.exec*` errors in a block: they would end a run in silence, as if it were complete.

    In copies of the process, such as `os.fork` makes, they keep their meaning.
    """
    process = os.getpid()

    def refusing(usual: Callable[..., NoReturn]) -> Callable[..., NoReturn]:
        def refuse(*arguments: Any) -> NoReturn:
            if os.getpid() != process:
                usual(*arguments)
            raise RuntimeError(Sentence("os.{name} ends the whole program; return, or raise an error", usual.__name__))

        return refuse

    with ExitStack() as stack:
        for name in ("_exit", "execv", "execve"):
            usual = getattr(os, name)
            stack.callback(setattr, os, name, usual)
            setattr(os, name, refusing(usual))
        yield


@contextmanager
def _process_kept() -> Iterator[None]:
    """Restore what a block changes in this process."""
    folder, numeric, limit = os.getcwd(), np.geterr(), sys.getrecursionlimit()
    language, handlers = locale.setlocale(locale.LC_ALL), {number: signal.getsignal(number) for number in HANDLED}
    mask = os.umask(0o077)
    os.umask(mask)
    with ExitStack() as stack:
        for number, name in ((1, "stdout"), (2, "stderr")):
            stack.enter_context(_stream_kept(number, name))
        try:
            yield
        finally:
            sys.setrecursionlimit(limit)
            os.umask(mask)
            np.seterr(**numeric)
            locale.setlocale(locale.LC_ALL, language)
            for number, handler in handlers.items():
                signal.signal(number, handler)
            with suppress(OSError):  # The folder may be gone.
                os.chdir(folder)


@contextmanager
def _stream_kept(number: int, name: str) -> Iterator[None]:
    """Restore a standard stream that a block replaces or closes."""
    stream: TextIO = getattr(sys, name)
    spare = os.dup(number)
    try:
        yield
    finally:
        with suppress(OSError):
            if not _is_open(number):
                os.dup2(spare, number)
            os.close(spare)
        if stream.closed:
            stream = open(number, "w", encoding=stream.encoding, errors=stream.errors, closefd=False)  # noqa: SIM115
        setattr(sys, name, stream)


def _is_open(number: int) -> bool:
    try:
        os.fstat(number)
    except OSError:
        return False
    return True


@contextmanager
def _children_ended() -> Iterator[None]:
    """Kill the processes that a block started and left behind, and their descendants."""
    before = {pid for pid, _ in _children()}
    with _adopting():
        try:
            yield
        finally:
            if ended := Counter(_ended(before)):
                named = [name if count == 1 else f"{name} ({count})" for name, count in sorted(ended.items())]
                more = f" and {len(named) - _MAX_NAMED_PROCESSES} more" if len(named) > _MAX_NAMED_PROCESSES else ""
                say(f"ended what modules left running: {', '.join(named[:_MAX_NAMED_PROCESSES])}{more}")


def _ended(before: set[int]) -> list[str]:
    """Kill the children of this process except some, until there are no more; return their names."""
    names = []
    for _ in range(_MAX_KILL_ROUNDS):
        found = [(pid, name) for pid, name in _children() if pid not in before]
        for pid, name in found:
            with suppress(OSError):
                if os.waitid(os.P_PID, pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is None:
                    names.append(name)
                os.kill(pid, signal.SIGKILL)
                os.waitpid(pid, 0)
        if not found:
            break
    return names


@contextmanager
def _adopting() -> Iterator[None]:
    """Make orphaned descendants children of this process, on Linux."""
    if not sys.platform.startswith("linux"):
        yield
        return
    import ctypes

    control = ctypes.CDLL(None).prctl
    control(_SUBREAPER, 1, 0, 0, 0)
    try:
        yield
    finally:
        control(_SUBREAPER, 0, 0, 0, 0)


def _children() -> Iterator[tuple[int, str]]:
    """Yield id and name of each child of this process, as Linux shows them."""
    me = os.getpid()
    for place in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):  # It has ended meanwhile.
            head, _, rest = place.read_text(encoding="utf-8", errors="replace").rpartition(")")
            if int(rest.split()[1]) == me:
                yield int(place.parent.name), head.partition("(")[2]


@contextmanager
def thread_faults() -> Iterator[None]:
    """End a block with a ModuleFault when a thread of a module raises in it; for the main thread of a command.

    The fault has no robot and no tick. The block is interrupted as by Ctrl-C, so that a recording is closed properly.
    `sys.exit` in a thread ends only that thread, as usual in Python.
    """
    faults: list[ModuleFault] = []
    usual = threading.excepthook

    def note(raised: threading.ExceptHookArgs) -> None:
        error = raised.exc_value
        if error is None or isinstance(error, SystemExit) or not is_of_users(error):
            usual(raised)
            return
        name = raised.thread.name if raised.thread is not None else "without a name"
        faults.append(ModuleFault(Sentence("thread '{name}' of a module {error_text}", name, error_text(error))))
        _thread.interrupt_main()

    threading.excepthook = note
    try:
        with _interruptible(faults):
            yield
    except KeyboardInterrupt:
        if not faults:
            raise
    finally:
        threading.excepthook = usual
    if faults:
        raise faults[0]


@contextmanager
def _interruptible(faults: Sequence[ModuleFault]) -> Iterator[None]:
    """Let a fault interrupt the block even if Ctrl-C is ignored, as in jobs that a shell starts with '&'."""
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
        yield
        return

    def interrupt(number: int, frame: FrameType | None) -> None:
        if faults:
            raise KeyboardInterrupt

    signal.signal(signal.SIGINT, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
