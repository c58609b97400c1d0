"""Lets a function that takes minutes for a small file tell that it goes on."""

from collections.abc import Callable
from contextvars import ContextVar

REPORT: ContextVar[Callable[[], None] | None] = ContextVar("REPORT", default=None)
"""What tells the parent; None outside of a child."""


def still_working() -> None:
    """Let the time of this call begin anew; outside of the guarded reader this does nothing."""
    if (report := REPORT.get()) is not None:
        report()


def in_child() -> bool:
    """Return whether this runs in the guarded reader."""
    return REPORT.get() is not None
