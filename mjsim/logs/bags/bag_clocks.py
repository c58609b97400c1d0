"""Clock jumps during the recording of a bag: corrects the times in headers."""

from array import array
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.inventory import Fate, told

MIN_JUMP = 1.0
"""Minimum jump of a clock; smaller differences may be delays [s]."""
MIN_STEP_BACK = 0.02
"""Minimum jump of a clock back in time, of a topic whose stamps then do not ascend [s]."""
AGREEING_MESSAGES = 3
"""Number of messages before and after a jump that must agree, so that a single wrong time is not a jump."""
MIN_OTHER_CLOCK = 1e8
"""Minimum difference of clocks that have different starts, such as that of a simulation and one since 1970 [s]."""
CENTRAL = 0.1, 0.9
"""Fractions of the messages of a topic between which its span is measured [1]."""
RECORDER = "the recorder"
TIME_ROUNDING = 1e-6
"""Rounding of times since 1970 [s]."""
MIN_SPAN_RATIO = 0.5
"""Minimum ratio of the recorder's time span to that of the headers for its clock to be trusted [1]."""


class Clocks:
    """The clocks of the headers of each topic, compared with the clock of the recorder."""

    def __init__(self, set_back: Sequence[tuple[float, float]] = ()) -> None:
        """Start without jumps.

        Args:
            set_back: When the clock of the recorder was set back, and by how much: those of headers may have been, too;
                its own times continue there [s].
        """
        self._set_back = set_back
        self._seen: dict[str, array[float]] = {}
        self._jumps: dict[str, tuple[list[float], list[float]]] = {}

    def time(self, topic: str, recorded: float, stamp: float) -> float:
        """Return the stamp of a message, corrected for jumps of its clock [s].

        Args:
            topic: Name of the clock.
            recorded: When the message was recorded [s].
            stamp: Stamp in its header [s].
        """
        if topic in self._jumps:
            since, steps = self._jumps[topic]
            stamp -= steps[bisect_right(since, recorded)]
        self._seen.setdefault(topic, array("d")).extend((recorded, stamp))
        return stamp

    def stamps_at(self, recorded: Array) -> Array:
        """Return stamps for messages without headers, interpolated between others recorded then; shape (N,) [s].

        A recorder may use wall-clock time while headers have simulated time. The topic with the most messages is used.

        Args:
            recorded: When messages were recorded, shape (N,) [s].
        """
        pairs = np.array(max(self._seen.values(), key=len, default=[])).reshape(-1, 2)
        if not len(pairs) or abs(float(np.median(pairs[:, 1] - pairs[:, 0]))) < MIN_JUMP:
            return recorded
        times, stamps = pairs[np.argsort(pairs[:, 0], kind="stable")].T
        return np.asarray(np.interp(recorded, times, stamps), dtype=float)

    def settle(self) -> Mapping[str, str]:
        """Find the jumps in all messages seen, for the next pass, and return notes about them.

        Clocks are taken as right in the longest time without a jump: some robots get the time only after they have
        started.
        """
        notes = {f"clock of {RECORDER}": _set_back_note(self._set_back)} if self._set_back else dict[str, str]()
        ends: list[float] = []
        for topic, numbers in self._seen.items():
            pairs = np.array(numbers).reshape(-1, 2)
            recorded, stamps = pairs[np.argsort(pairs[:, 0], kind="stable")].T
            rows, steps = _jumps(recorded, stamps, self._set_back)
            ends += [float(recorded[0]), float(recorded[-1])]
            if len(rows):
                self._jumps[topic] = recorded[rows].tolist(), list(accumulate(steps.tolist(), initial=0.0))
                listed = ", ".join(f"{step:+.{1 if abs(step) > MIN_JUMP else 2}f} s" for step in steps[:5].tolist())
                notes[f"clock of {topic}"] = told(
                    Fate.MENDED, f"set {len(rows)} times ({listed}); the jumps are removed"
                )
        right = _longest([*ends, *(time for since, _ in self._jumps.values() for time in since)])
        for since, offsets in self._jumps.values():
            offsets[:] = [offset - offsets[bisect_right(since, right)] for offset in offsets]
        notes |= self._to_one_clock()
        self._seen.clear()
        return notes

    def _to_one_clock(self) -> Mapping[str, str]:
        """Move topics on another clock, of a simulation or since 1970, to that of most messages; return notes."""
        ahead = {}
        for topic, numbers in self._seen.items():
            recorded, stamps = np.array(numbers).reshape(-1, 2).T
            since, offsets = self._jumps.get(topic, ([], [0.0]))
            stamps = stamps - np.array(offsets)[np.searchsorted(since, recorded, "right")]
            # A single wrong time, such as a first stamp of 0, does not count.
            if np.ptp(np.quantile(recorded, CENTRAL)) >= MIN_SPAN_RATIO * np.ptp(np.quantile(stamps, CENTRAL)):
                ahead[topic] = float(np.median(stamps - recorded))
        usual = max(ahead, key=lambda topic: len(self._seen[topic]), default="")
        notes = {}
        for topic, each in ahead.items():
            if abs(shift := each - ahead[usual]) > MIN_OTHER_CLOCK:
                since, offsets = self._jumps.get(topic, ([], [0.0]))
                self._jumps[topic] = since, [offset + shift for offset in offsets]
                notes[f"start of the clock of {topic}"] = told(
                    Fate.MENDED,
                    f"{shift:+.6g} s from that of {usual}; shifted by the difference of their recording times",
                )
        return notes


def _set_back_note(set_back: Sequence[tuple[float, float]]) -> str:
    listed = ", ".join(f"{-back:+.2f} s" for _, back in set_back[:5])
    return told(Fate.MENDED, f"set back {len(set_back)} times ({listed}); times continue from there")


def _longest(times: Sequence[float]) -> float:
    """Return the middle of the longest time between two times [s]."""
    ordered = np.sort(np.array(times))
    row = int(np.argmax(np.diff(ordered), axis=0)) if len(ordered) > 1 else 0
    return float(ordered[row : row + 2].mean()) if len(ordered) else 0.0


def _jumps(
    recorded: Array, stamps: Array, set_back: Sequence[tuple[float, float]] = ()
) -> tuple[NDArray[np.intp], Array]:
    """Return the messages before which a clock jumped, and the size of the jumps [s].

    Args:
        recorded: When messages were recorded, ascending, shape (N,) [s].
        stamps: Stamps in their headers, shape (N,) [s].
        set_back: As in `Clocks`.
    """
    ahead = stamps - recorded
    rows, steps = [], []
    candidates = set((np.flatnonzero((np.abs(np.diff(ahead)) > MIN_JUMP) | (np.diff(stamps) < 0.0)) + 1).tolist())
    expected = {int(np.searchsorted(recorded, time - TIME_ROUNDING)): back for time, back in set_back}
    for row in sorted(candidates | expected.keys()):
        before, behind = ahead[max(row - AGREEING_MESSAGES, 0) : row], ahead[row : row + AGREEING_MESSAGES]
        count = min(len(before), len(behind))
        if not count:
            continue
        step = float(np.median(behind) - np.median(before))
        # The recorder's clock was set back as much then; slow topics may have few messages on one side of that.
        is_known = abs(step + expected.get(row, np.inf)) < expected.get(row, 0.0) / 2.0
        if count < AGREEING_MESSAGES and not is_known:
            continue
        least = MIN_STEP_BACK if is_known or stamps[row] < stamps[row - 1] else MIN_JUMP
        spread = MIN_JUMP if abs(step) > MIN_JUMP else abs(step) / 2.0
        whole = np.ptp(before) < spread and np.ptp(behind) < spread
        if whole and abs(step) > least:
            rows.append(int(row))
            steps.append(step)
    increments = np.abs(np.diff(stamps))
    increments[np.array(rows, dtype=np.intp) - 1] = 0.0
    if not rows or np.ptp(recorded) < MIN_SPAN_RATIO * increments.sum():
        return np.zeros(0, dtype=np.intp), np.zeros(0)
    return np.array(rows, dtype=np.intp), np.array(steps)
