"""Base class of resources that a `with` block closes, and waiting for threads with a limit."""

import threading
from abc import ABC, abstractmethod
from concurrent.futures import Future
from types import TracebackType
from typing import Self, TypeVar

from mjsim.errors import MjsimError

T = TypeVar("T")
THREAD_TIMEOUT = 30.0
"""Time limit for one of our threads to end after it was asked to [s]; ample even on a loaded machine."""


class Closes(ABC):
    """Holds a resource that must be released; a `with` block closes it at its end."""

    @abstractmethod
    def close(self) -> None:
        """Release the resource; a second call does nothing."""

    def __enter__(self) -> Self:
        """Return itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close, also if the block raised."""
        self.close()


def join(thread: threading.Thread, *, within: float = THREAD_TIMEOUT) -> None:
    """Wait for the end of a thread that was asked to end.

    Args:
        thread: The thread.
        within: Time limit [s].

    Raises:
        MjsimError: It did not end.
    """
    thread.join(within)
    if thread.is_alive():
        raise MjsimError(f"thread '{thread.name}' did not end within {within:g} s; a call in it does not return")


def awaited(future: "Future[T]", what: str, *, within: float) -> T:
    """Return the result of work in another thread.

    Args:
        future: The work; it is cancelled if it has not begun within the limit.
        what: Name of the result, for the message.
        within: Time limit [s].

    Raises:
        MjsimError: It was not ready in time; or whatever the work raised.
    """
    try:
        return future.result(within)
    except TimeoutError:
        if future.done() and not future.cancelled():
            raise
        future.cancel()
        raise MjsimError(f"{what} took longer than {within:g} s; try again when the machine is less busy") from None
