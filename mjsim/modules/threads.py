"""Threads that modules start: their exceptions end the run, like those of the modules themselves."""

import _thread
import signal
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import FrameType

from mjsim.errors import ModuleFault
from mjsim.modules.boundary import error_text, is_of_users


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
        faults.append(ModuleFault(f"thread '{name}' of a module {error_text(error)}"))
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
