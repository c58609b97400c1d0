"""Receives messages from a bus in a separate thread."""

import threading
import time
from collections.abc import Callable
from typing import Any

from mjsim.closing import join
from mjsim.progress import say
from mjsim.ros import message_of

POLL_SECONDS = 0.2
"""Interval at which the thread checks whether to end [s]."""
MIN_WARNING_INTERVAL = 10.0
"""Minimum time between two lines about ignored messages of one type [s]: a peer may send any number of them."""


class Listener:
    """Passes messages on as they arrive; invalid messages are ignored."""

    def __init__(self, participant: Any, *, name: str) -> None:
        """Start without topics.

        Args:
            participant: Participant of the bus.
            name: Name of the thread.
        """
        from cyclonedds.core import WaitSet

        self._taken: list[tuple[Any, str, Callable[[Any], None]]] = []
        self._waiting: Any = WaitSet(participant)
        self._ignored: dict[str, tuple[float, int]] = {}
        """Type -> time of the last line about it [s], and number of messages ignored since."""
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._receive, name=name, daemon=True)

    def add(self, reader: Any, kind: str, take: Callable[[Any], None]) -> None:
        """Call a function with each message of a reader; to be used before `start`.

        Args:
            reader: Reader of the bus.
            kind: Type of its messages.
            take: Called in the listener's thread.
        """
        from cyclonedds.core import InstanceState, ReadCondition, SampleState, ViewState

        condition = ReadCondition(reader, SampleState.NotRead | ViewState.Any | InstanceState.Alive)
        self._waiting.attach(condition)
        self._taken.append((reader, kind, take))

    def start(self) -> None:
        """Start to receive, unless there are no topics: then every wait would return at once."""
        if self._taken:
            self._thread.start()

    def close(self) -> None:
        """End the thread and close the readers; a second call does nothing."""
        self._closing.set()
        if self._thread.is_alive() and threading.current_thread() is not self._thread:
            join(self._thread)
        self._taken, self._waiting = [], None

    def _receive(self) -> None:
        from cyclonedds.util import duration

        while not self._closing.is_set():
            self._waiting.wait(duration(seconds=POLL_SECONDS))
            for reader, kind, take in self._taken:
                for sample in reader.take(N=100):
                    if hasattr(sample, "cdr"):
                        self._take(kind, take, sample.cdr)

    def _take(self, kind: str, take: Callable[[Any], None], cdr: bytes) -> None:
        try:
            take(message_of(cdr, kind))
        except Exception as error:
            self._ignore(kind, error)

    def _ignore(self, kind: str, error: Exception) -> None:
        """Print that a message was ignored, unless a line about its type was printed recently."""
        last, more = self._ignored.get(kind, (-MIN_WARNING_INTERVAL, 0))
        now = time.monotonic()
        if now - last < MIN_WARNING_INTERVAL:
            self._ignored[kind] = last, more + 1
            return
        self._ignored[kind] = now, 0
        say(f"a message of type {kind} was ignored{f', and {more} before it' if more else ''}: {error}")
