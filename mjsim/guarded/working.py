"""Lets a function that takes minutes for a small file report that it is still working."""

from collections.abc import Callable
from contextvars import ContextVar

REPORT: ContextVar[Callable[[], None] | None] = ContextVar("REPORT", default=None)
"""What tells the parent; None outside of a child."""


def still_working() -> None:
    """Restart the time limit of this call; does nothing outside of the guarded reader."""
    if (report := REPORT.get()) is not None:
        report()


def in_child() -> bool:
    """Return whether this runs in the guarded reader."""
    return REPORT.get() is not None
