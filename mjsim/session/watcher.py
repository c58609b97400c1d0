"""Watchers of a run: each gets the newest tick and skips those it has no time for."""

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mjsim.record import Tick


class Watcher:
    """Gives the newest tick of a session, each at most once; never blocks the run, however slow it is."""

    def __init__(self, newer: Callable[[int, float | None], tuple[int, "Tick"] | None]) -> None:
        """Watch.

        Args:
            newer: Waits at most a time [s] for a tick after a number; returns its number and itself, None at the end.
        """
        self._newer = newer
        self._seen = 0

    def next(self, timeout: float | None = None) -> "Tick | None":
        """Wait for a tick that is newer than the last one, and return the newest; None when the run is over.

        Args:
            timeout: Maximum time [s]; by default without end.

        Raises:
            TimeoutError: Nothing came in that time.
            MjsimError: The run failed; raised after the last tick.
        """
        found = self._newer(self._seen, timeout)
        if found is None:
            return None
        self._seen, tick = found
        return tick

    def __iter__(self) -> Iterator["Tick"]:
        """Yield the newest tick again and again, until the run is over."""
        while (tick := self.next()) is not None:
            yield tick
