"""Logs that were joined, or whose clock was set: their times continue from there."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array, wrap_angles
from mjsim.logs.resampling.resample import MIN_JUMP, joined

MAX_MESSAGE_DELAY, MAX_PAUSE = 2.0, 3600.0
"""Times of one log may go back by up to the first, as delays of messages differ, and ahead by up to the second [s]."""
AGREEING_MESSAGES = 5
"""Number of messages before and after, whose median decides."""
MAX_LATE_MESSAGES, MIN_LATE_SECONDS = 200, 1.0
"""Messages that were only written late: times return within this number of them, or they last less than this [s]."""
ASSUMED_GAP = 0.1
"""Time between the last message before and the first after, which is unknown [s]."""


class ForwardClock:
    """A clock that runs on where that of a log was set back, or far ahead."""

    def __init__(self, stamps: Sequence[float]) -> None:
        """Find where it was set.

        Args:
            stamps: Stamps of all messages in the order of the file [s].
        """
        times, rows = np.array(stamps), []
        steps = np.diff(times)
        for row in (np.flatnonzero((steps < -MAX_MESSAGE_DELAY) | (steps > MAX_PAUSE)) + 1).tolist():
            before, after = times[max(row - AGREEING_MESSAGES, 0) : row], times[row : row + AGREEING_MESSAGES]
            is_back = after.max() < before.min() and not _is_late(times[row : row + MAX_LATE_MESSAGES], before.max())
            if (
                is_back and np.median(after) < np.median(before) - MAX_MESSAGE_DELAY
            ) or after.min() > before.max() + MAX_PAUSE:
                rows.append(row)
        back = sum(steps[row - 1] < 0.0 for row in rows)
        self.about = f"set back {back} times and ahead by more than {MAX_PAUSE:g} s {len(rows) - back} times"
        """What was found."""
        self._rows: NDArray[np.intp] = np.array(rows, dtype=np.intp)
        self._shifts = [0.0]
        self.begins: list[float] = []
        """When each part except the first begins by this clock [s]."""
        parts = np.split(times, self._rows)
        for row, part in enumerate(parts[1:]):
            end = float(parts[row].max()) + self._shifts[-1]
            self.begins.append(end + ASSUMED_GAP)
            self._shifts.append(end + ASSUMED_GAP - float(part.min()))

    def time(self, number: int, stamp: float) -> float:
        """Return the time of a message, counted from 0 in the order of the file [s]."""
        return stamp + self._shifts[int(np.searchsorted(self._rows, number, side="right"))]

    def connected(self, track: Array) -> Array:
        """Return odometry that continues where it was when the clock was set back, if it jumped there; shape (K, 4).

        Args:
            track: Rows of time by this clock [s], x, y [m] and heading [rad], in order of time.
        """
        rows = np.searchsorted(track[:, 0], self.begins)
        rows = rows[(rows > 0) & (rows < len(track))]
        steps = track[rows, 1:] - track[rows - 1, 1:]
        far = (np.hypot(steps[:, 0], steps[:, 1]) > MIN_JUMP[0]) | (np.abs(wrap_angles(steps[:, 2])) > MIN_JUMP[1])
        return joined(track, rows[far]) if far.any() else track


def _is_late(part: Array, newest: float) -> bool:
    """Return whether messages were only written late, in which case the clock was not set back."""
    return bool(part.max() > newest or np.ptp(part) < MIN_LATE_SECONDS)
