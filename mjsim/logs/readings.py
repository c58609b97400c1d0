"""Readings of one sensor of a log: their times are known at once, each of them is read when it is told."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array

TOGETHER = 0.02
"""Depth and colours that differ by less are of one picture, as the tools of TUM RGB-D have it [s]."""


class Stamped(Protocol):
    """A reading with a time."""

    @property
    def stamp(self) -> float:
        """When it was taken [s]."""


T = TypeVar("T", bound=Stamped)


@dataclass(frozen=True, slots=True, eq=False)
class Readings(Generic[T]):
    """Readings in the order of their times."""

    stamps: Array
    """Of the log's clock, shape (N,), ascending [s]."""
    take: Callable[[int], T]
    """Number, from 0 -> reading; numbers that ascend are quickest."""

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.stamps)


def kept(readings: Sequence[T]) -> Readings[T]:
    """Return readings that are in memory."""
    return Readings(np.array([each.stamp for each in readings], dtype=float), lambda number: readings[number])


def rising(stamps: Array) -> NDArray[np.intp]:
    """Return the numbers of readings in the order of time, of those of one time the first, shape (K,).

    Args:
        stamps: As they were logged, shape (N,) [s].
    """
    _, first = np.unique(stamps, return_index=True)
    return np.asarray(first, dtype=np.intp)


def partners(stamps: Array, others: Array, *, tolerance: float) -> NDArray[np.intp]:
    """Return for each reading the number of the one of another sensor that belongs to it, -1 for none, shape (N,).

    Of all pairs that differ by less than the tolerance, the closest is taken first; each reading is in one pair.

    Args:
        stamps: Of one sensor, ascending, shape (N,) [s].
        others: Of the other, ascending, shape (M,) [s].
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
