"""When the next tick is due on the clock."""

import time

LATEST = 1.0
"""A run that is later than this [s] is not hurried until it has caught up; it goes on from where it is."""


class Pace:
    """Holds a run to a multiple of real time; without a factor it goes as fast as it can."""

    def __init__(self, factor: float | None) -> None:
        """Begin; the first tick is due at once."""
        self.factor = factor
        """Simulated seconds a second; None for as fast as it goes."""
        self._anchor: tuple[float, float] | None = None

    def forget(self) -> None:
        """Restart the pace with the next tick: the run was paused, or its factor changed."""
        self._anchor = None

    def left(self, simulated: float) -> float:
        """Return how long to wait for a tick of a simulated time [s]; 0 when it is due."""
        if self.factor is None:
            return 0.0
        now = time.perf_counter()
        if self._anchor is None:
            self._anchor = now, simulated
        began, first = self._anchor
        left = began + (simulated - first) / self.factor - now
        if left < -LATEST:
            self._anchor = now, simulated
        return max(left, 0.0)
