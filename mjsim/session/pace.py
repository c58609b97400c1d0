"""Pacing: when the next tick is due in real time."""

import time

MAX_DELAY = 1.0
"""A run delayed by more than this [s] does not catch up, but continues from where it is."""


class Pace:
    """Holds a run to a multiple of real time; without a factor it runs as fast as possible."""

    def __init__(self, factor: float | None) -> None:
        """Start; the first tick is due at once."""
        self.factor = factor
        """Simulated seconds per second; None for as fast as possible."""
        self._anchor: tuple[float, float] | None = None

    def forget(self) -> None:
        """Restart the pace with the next tick, after a pause or a change of the factor."""
        self._anchor = None

    def left(self, simulated: float) -> float:
        """Return the time to wait for a tick at a simulated time [s]; 0 if it is due."""
        if self.factor is None:
            return 0.0
        now = time.perf_counter()
        if self._anchor is None:
            self._anchor = now, simulated
        began, first = self._anchor
        left = began + (simulated - first) / self.factor - now
        if left < -MAX_DELAY:
            self._anchor = now, simulated
        return max(left, 0.0)
