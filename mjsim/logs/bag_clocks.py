"""Clock jumps during the recording of a bag: corrects the times in headers."""

from array import array
from bisect import bisect_right
from collections.abc import Mapping
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array

JUMP = 1.0
"""What a clock is set by, at least; less may be delays [s]."""
AGREE = 3
"""Messages before and behind a jump that agree, so that a single wrong time is none."""
TRUSTED = 0.5
"""Of the time that headers tell, what the recorder has to tell too for its clock to be believed [1]."""


class Clocks:
    """The clocks that stamp the messages of each topic, beside the clock of the recorder."""

    def __init__(self) -> None:
        """Begin with clocks that nobody sets."""
        self._seen: dict[str, array[float]] = {}
        self._jumps: dict[str, tuple[list[float], list[float]]] = {}

    def time(self, topic: str, recorded: float, stamp: float) -> float:
        """Return when a message was stamped, by the clock as it was before it was set [s].

        Args:
            topic: Whatever has a clock of its own.
            recorded: When the message was recorded [s].
            stamp: In its header [s].
        """
        if topic in self._jumps:
            since, steps = self._jumps[topic]
            stamp -= steps[bisect_right(since, recorded)]
        self._seen.setdefault(topic, array("d")).extend((recorded, stamp))
        return stamp

    def stamps_at(self, recorded: Array) -> Array:
        """Return what headers would tell of messages without, by those recorded about then; shape (N,) [s].

        A recorder may go by the clock of the wall while headers tell simulated time. The topic of most messages counts.

        Args:
            recorded: When messages were recorded, shape (N,) [s].
        """
        pairs = np.array(max(self._seen.values(), key=len, default=[])).reshape(-1, 2)
        if not len(pairs) or abs(float(np.median(pairs[:, 1] - pairs[:, 0]))) < JUMP:
            return recorded
        times, stamps = pairs[np.argsort(pairs[:, 0], kind="stable")].T
        return np.asarray(np.interp(recorded, times, stamps), dtype=float)

    def settle(self) -> Mapping[str, str]:
        """Find the jumps of all that was seen, for the next reading, and return what people are told of them."""
        notes = {}
        for topic, numbers in self._seen.items():
            pairs = np.array(numbers).reshape(-1, 2)
            recorded, stamps = pairs[np.argsort(pairs[:, 0], kind="stable")].T
            rows, steps = _jumps(recorded, stamps)
            if len(rows):
                self._jumps[topic] = recorded[rows].tolist(), list(accumulate(steps.tolist(), initial=0.0))
                told = ", ".join(f"{step:+.1f} s" for step in steps[:5].tolist())
                notes[f"clock of {topic}"] = f"set {len(rows)} times ({told}); its times go on as before"
        self._seen.clear()
        return notes


def _jumps(recorded: Array, stamps: Array) -> tuple[NDArray[np.intp], Array]:
    """Return before which messages a clock was set, and by how much [s].

    Args:
        recorded: When messages were recorded, ascending, shape (N,) [s].
        stamps: In their headers, shape (N,) [s].
    """
    ahead = stamps - recorded
    rows, steps = [], []
    for row in np.flatnonzero(np.abs(np.diff(ahead)) > JUMP) + 1:
        before, behind = ahead[max(row - AGREE, 0) : row], ahead[row : row + AGREE]
        step = float(np.median(behind) - np.median(before))
        whole = len(before) == len(behind) == AGREE and np.ptp(before) < JUMP and np.ptp(behind) < JUMP
        if whole and abs(step) > JUMP:
            rows.append(int(row))
            steps.append(step)
    told = np.abs(np.diff(stamps))
    told[np.array(rows, dtype=np.intp) - 1] = 0.0
    if not rows or np.ptp(recorded) < TRUSTED * told.sum():
        return np.zeros(0, dtype=np.intp), np.zeros(0)
    return np.array(rows, dtype=np.intp), np.array(steps)
