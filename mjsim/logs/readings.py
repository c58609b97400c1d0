"""Readings of one sensor of a log: all times are known, and each reading is loaded on request."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Generic, Protocol, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.interface import CameraFrame

TOGETHER = 0.02
"""Maximum time difference of depth and colour of one picture, as in the tools of TUM RGB-D [s]."""


class Stamped(Protocol):
    """A reading with a stamp."""

    @property
    def stamp(self) -> float:
        """When it was taken [s]."""


T = TypeVar("T", bound=Stamped)


@dataclass(frozen=True, slots=True, eq=False)
class Readings(Generic[T]):
    """Readings in order of time."""

    stamps: Array
    """By the log's clock, shape (N,), ascending [s]."""
    take: Callable[[int], T]
    """Index -> reading; most efficient if indices ascend."""

    def __len__(self) -> int:
        """Return the number of readings."""
        return len(self.stamps)


def kept(readings: Sequence[T]) -> Readings[T]:
    """Return readings held in memory."""
    return Readings(np.array([each.stamp for each in readings], dtype=float), lambda number: readings[number])


def at_stamps(reading: T, moved: Callable[[float], float]) -> T:
    """Return a reading whose times were moved to another clock."""
    stamps = {"stamp": moved(reading.stamp)}
    if isinstance(reading, CameraFrame) and reading.depth_stamp is not None:
        stamps["depth_stamp"] = moved(reading.depth_stamp)
    changed: Any = replace(cast(Any, reading), **stamps)
    return cast(T, changed)


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
