"""Functions for code in the child process: progress, where it runs, and which limits are missing."""

from collections.abc import Callable, Sequence
from contextvars import ContextVar

REPORT: ContextVar[Callable[[], None] | None] = ContextVar("REPORT", default=None)
"""Sends messages to the parent; None outside of a child."""
MISSING: ContextVar[Sequence[str]] = ContextVar("MISSING", default=())
"""Limits that this system lacks, in words; empty outside of a child."""


def still_working() -> None:
    """Restart the time limit of this call; does nothing outside of the guarded reader."""
    if (report := REPORT.get()) is not None:
        report()


def in_child() -> bool:
    """Return whether this runs in the guarded reader."""
    return REPORT.get() is not None


def missing_limits() -> Sequence[str]:
    """Return the limits that this system lacks, in words; call it in the guarded reader."""
    return list(MISSING.get())
