"""Data of comparison plots over time and on the plan: few runs individually, or the distribution of many."""

from collections.abc import Sequence

import numpy as np

from mjsim.geometry import Array
from mjsim.report.comparison import Group

FEW = 3
"""Maximum number of runs of a group drawn individually; of more, the median and the middle 90 % are drawn."""


Curve = tuple[Array, Array]
"""Times [s] and values of one run, shape (N,) each."""


def on_one_clock(curves: Sequence[Curve]) -> tuple[Array, Array]:
    """Return times (T,) [s] and the values of runs at them, shape (runs, T); NaN where a run had ended."""
    if not curves:
        return np.zeros(0), np.zeros((0, 0))
    time = max((each for each, _ in curves), key=lambda each: float(each[-1]))
    return time, np.array([np.interp(time, *curve, left=np.nan, right=np.nan) for curve in curves])


def middle_of(curves: Sequence[Curve], *, share: float = 0.9) -> tuple[Array, Array]:
    """Return times (T,) [s], and lower bound, median and upper bound of the middle share of runs, shape (3, T)."""
    time, each = on_one_clock(curves)
    known = np.isfinite(each).any(axis=0)
    bounds = np.nanquantile(each[:, known], (0.5 - share / 2, 0.5, 0.5 + share / 2), axis=0)
    # NumPy drops the first axis where nothing is known.
    return time[known], bounds.reshape(3, -1)


def mean_of(curves: Sequence[Curve]) -> tuple[Array, Array]:
    """Return times (T,) [s] and the mean of the runs, shape (T,)."""
    time, each = on_one_clock(curves)
    known = np.isfinite(each).any(axis=0)
    return time[known], np.nanmean(each[:, known], axis=0)


def shared_seed(groups: Sequence[Group]) -> int | None:
    """Return the first seed for which most groups have a path; None if no path was kept."""
    counts: dict[int, int] = {}
    for group in groups:
        for seed in (seed for seed, series in group.series.items() if series.truth is not None):
            counts[seed] = counts.get(seed, 0) + 1
    return max(sorted(counts), key=lambda each: counts[each]) if counts else None
