"""Data of comparison plots over time and on the plan: few runs individually, or the distribution of many."""

from collections.abc import Callable, Sequence

import numpy as np

from mjsim.geometry import Array
from mjsim.report.comparison import Group, Series

FEW = 3
"""Maximum number of runs of a group drawn individually; of more, the median and the middle 90 % are drawn."""


def on_one_clock(runs: Sequence[Series], values: Callable[[Series], Array]) -> tuple[Array, Array]:
    """Return times (T,) [s] and the values of runs at them, shape (runs, T); NaN where a run had ended."""
    if not runs:
        return np.zeros(0), np.zeros((0, 0))
    time = max((series.time for series in runs), key=lambda each: float(each[-1]))
    rows = [np.interp(time, series.time, values(series), left=np.nan, right=np.nan) for series in runs]
    return time, np.array(rows)


def middle_of(runs: Sequence[Series], values: Callable[[Series], Array]) -> tuple[Array, Array]:
    """Return times (T,) [s] and the 5 % quantile, median and 95 % quantile of runs, shape (3, T)."""
    time, each = on_one_clock(runs, values)
    known = np.isfinite(each).any(axis=0)
    return time[known], np.nanquantile(each[:, known], (0.05, 0.5, 0.95), axis=0)


def mean_of(runs: Sequence[Series], values: Callable[[Series], Array]) -> tuple[Array, Array]:
    """Return times (T,) [s] and the mean of the runs, shape (T,)."""
    time, each = on_one_clock(runs, values)
    known = np.isfinite(each).any(axis=0)
    return time[known], np.nanmean(each[:, known], axis=0)


def shared_seed(groups: Sequence[Group]) -> int | None:
    """Return the first seed for which most groups have a path; None if no path was kept."""
    counts: dict[int, int] = {}
    for group in groups:
        for seed in (seed for seed, series in group.series.items() if series.truth is not None):
            counts[seed] = counts.get(seed, 0) + 1
    return max(sorted(counts), key=lambda each: counts[each]) if counts else None
