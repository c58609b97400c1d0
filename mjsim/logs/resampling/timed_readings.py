"""Readings of one sensor of a log: all times are known, and each reading is loaded on request."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Generic, Protocol, TypeVar, overload

import numpy as np
from numpy.typing import NDArray

from mjsim.errors import MAX_MESSAGE_LENGTH
from mjsim.geometry import Array
from mjsim.interface import ImuReading

TOGETHER = 0.02
"""Maximum time difference of depth and colour of one picture, as in the tools of TUM RGB-D [s]."""


class Stamped(Protocol):
    """A reading with a stamp."""

    @property
    def stamp(self) -> float:
        """When it was taken [s]."""


T = TypeVar("T", bound=Stamped)


class DamagedReadingError(Exception):
    """A reading cannot be decoded; the message says where it is and what is wrong."""


@dataclass(slots=True)
class Damage:
    """Readings that turn out to be damaged when they are loaded, and are left out."""

    counts: Counter[str] = field(default_factory=Counter)
    """What they are, such as 'readings of front' -> their number."""
    reasons: dict[str, str] = field(default_factory=dict)
    """What they are -> where the first one is and what is wrong with it."""

    def add(self, what: str, error: DamagedReadingError) -> None:
        """Count a reading."""
        self.counts[what] += 1
        self.reasons.setdefault(what, f"{error}")

    def notes(self) -> dict[str, str]:
        """Return the metadata about them, which is complete after the last reading."""
        facts = {f"damaged {what} left out": str(count) for what, count in self.counts.items()}
        firsts = {f"first of the damaged {what} left out": why for what, why in self.reasons.items()}
        return {fact: value[:MAX_MESSAGE_LENGTH] for fact, value in (*facts.items(), *firsts.items())}


@dataclass(frozen=True, slots=True, eq=False)
class Readings(Generic[T]):
    """Readings in order of time."""

    stamps: Array
    """By the log's clock, shape (N,), ascending [s]."""
    take: Callable[[int], T]
    """Index -> reading; most efficient if indices ascend. Raises `DamagedReadingError`."""

    def __len__(self) -> int:
        """Return the number of readings."""
        return len(self.stamps)


class InertialTable(Sequence[ImuReading]):
    """Inertial readings in one array, in order of time; as separate values an hour of them fills a gigabyte."""

    def __init__(self, tables: Mapping[str, Array]) -> None:
        """Join the readings of all sensors.

        Args:
            tables: By sensor, rows of stamp [s], acceleration x, y, z [m/s^2] and turn x, y, z [rad/s], shape (N, 7).
        """
        self.names = tuple(name for name, rows in tables.items() if len(rows))
        """Sensors with readings."""
        rows = np.concatenate([np.zeros((0, 7)), *(tables[name] for name in self.names)])
        order = np.argsort(rows[:, 0], kind="stable")
        counts = [len(tables[name]) for name in self.names]
        self._rows, self._sensors = rows[order], np.repeat(np.arange(len(counts), dtype=np.uint16), counts)[order]

    @property
    def stamps(self) -> Array:
        """When they were measured, ascending, shape (N,) [s]."""
        return self._rows[:, 0]

    def __len__(self) -> int:
        """Return the number of readings."""
        return len(self._rows)

    @overload
    def __getitem__(self, number: int) -> ImuReading: ...
    @overload
    def __getitem__(self, number: slice) -> list[ImuReading]: ...
    def __getitem__(self, number: int | slice) -> ImuReading | list[ImuReading]:
        """Return a reading, or several."""
        if isinstance(number, slice):
            return [self[k] for k in range(*number.indices(len(self)))]
        row = self._rows[number]
        return ImuReading(float(row[0]), row[1:4], row[4:], self.names[int(self._sensors[number])])


def stamps_of(readings: Sequence[Stamped]) -> Array:
    """Return the stamps of readings, shape (N,) [s]."""
    if isinstance(readings, InertialTable):
        return readings.stamps
    return np.array([each.stamp for each in readings], dtype=float)


def sensors_of(readings: Sequence[ImuReading]) -> list[str]:
    """Return the names of the sensors of readings, sorted."""
    return sorted(readings.names if isinstance(readings, InertialTable) else {each.name for each in readings})


def kept(readings: Sequence[T]) -> Readings[T]:
    """Return readings held in memory."""
    return Readings(stamps_of(readings), lambda number: readings[number])


def rising(stamps: Array) -> NDArray[np.intp]:
    """Return the indices of readings in order of time, the first for each time, shape (K,).

    Args:
        stamps: As they were logged, shape (N,) [s].
    """
    _, first = np.unique(stamps, return_index=True)
    return np.asarray(first, dtype=np.intp)


def partners(stamps: Array, others: Array, *, tolerance: float) -> NDArray[np.intp]:
    """Return for each reading the index of its partner from another sensor, -1 for none, shape (N,).

    Pairs within the tolerance are formed in order of their time difference; each reading is in one pair.

    Args:
        stamps: Stamps of one sensor, ascending, shape (N,) [s].
        others: Stamps of the other, ascending, shape (M,) [s].
        tolerance: [s]

    References:
        Sturm and others, A benchmark for the evaluation of RGB-D SLAM systems, IROS 2012: `associate.py`.
    """
    begins = np.searchsorted(others, stamps - tolerance, side="right")
    ends = np.searchsorted(others, stamps + tolerance, side="left")
    pairs = [
        (abs(float(stamps[row] - others[other])), row, other)
        for row, (begin, end) in enumerate(zip(begins.tolist(), ends.tolist(), strict=True))
        for other in range(begin, end)
    ]
    found = np.full(len(stamps), -1, dtype=np.intp)
    taken: set[int] = set()
    for _, row, other in sorted(pairs):
        if found[row] < 0 and other not in taken:
            found[row] = other
            taken.add(other)
    return found
