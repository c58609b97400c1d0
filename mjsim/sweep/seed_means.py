"""Means over seeds, with confidence intervals."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
from scipy.special import stdtrit

from mjsim.geometry import Array
from mjsim.report import CONFIDENCE, fewest_pairs, largest, mean_interval
from mjsim.sweep.sweep_plan import SweepPlan
from mjsim.sweep.sweep_table import Row, figure_names

INTERVAL = (
    f"{CONFIDENCE:.0%} confidence interval of the mean over seeds: bootstrap (BCa) for {fewest_pairs()} runs or more,"
    f" Student's t for 2 to {fewest_pairs() - 1}, cut to values that the statistic can have"
)
"""Description of the intervals of a summary."""


def interval_of_mean(values: Array, *, upper: float = np.inf) -> tuple[float, float] | None:
    """Return the 95 % confidence interval of the mean; None for a single value.

    No statistic can be negative. A bootstrap interval never leaves the range of the values; Student's interval is cut
    to possible values, which does not change its confidence.

    Args:
        values: Independent, one per seed, shape (n,).
        upper: Maximum of the statistic, such as 1 for coverage.

    References:
        `mjsim.report.paired` for the bootstrap, as in comparisons; Student, The Probable Error of a Mean, Biometrika
        6 (1908), if there are too few values for the bootstrap.
    """
    n = len(values)
    if n < 2:
        return None
    drawn = mean_interval(values)
    if drawn is not None:
        return drawn
    mean = float(values.mean())
    half = float(stdtrit(n - 1, 0.5 + CONFIDENCE / 2)) * float(values.std(ddof=1)) / n**0.5
    return max(mean - half, 0.0), min(mean + half, upper)


def distribution(values: Array, *, upper: float = np.inf) -> dict[str, float | int | None]:
    """Return count, mean with its interval, standard deviation, median, min and max of values, shape (n,)."""
    low, high = interval_of_mean(values, upper=upper) or (None, None)
    return {
        "count": len(values),
        "mean": float(values.mean()),
        "low": low,
        "high": high,
        "std": float(values.std(ddof=1)) if len(values) > 1 else 0.0,
        "median": float(np.median(values)),
        "min": float(np.min(values)),
        "max": float(np.max(values)),
    }


def summary_of(
    plan: SweepPlan, rows: Sequence[Row], *, no_nees: Mapping[tuple[int, str], str] = MappingProxyType({})
) -> dict[str, Any]:
    """Return the content of summary.json: for each case and robot the spread of each statistic over the seeds.

    Args:
        plan: Plan of the sweep.
        rows: Its table.
        no_nees: By case and robot: the reason why no run has a NEES.
    """
    names = figure_names(plan, rows)
    robots = list(dict.fromkeys(row["robot"] for row in rows))
    cases = []
    for number, settings in enumerate(plan.cases()):
        own = [row for row in rows if row["case"] == number]
        cases.append(
            {
                "case": number,
                "settings": settings,
                "runs": len(plan.seeds),
                "failed": sum(row["error"] is not None for row in own if row["robot"] == robots[0]),
                "robots": {robot: _figures([row for row in own if row["robot"] == robot], names) for robot in robots},
                "no_nees": {robot: no_nees[number, robot] for robot in robots if (number, robot) in no_nees},
            }
        )
    return {"confidence": CONFIDENCE, "interval": INTERVAL, "cases": cases}


def summary_rows(summary: Mapping[str, Any]) -> list[Row]:
    """Return the summary as rows of a table: one per case, robot and statistic."""
    return [
        {"case": case["case"], **case["settings"], "robot": robot, "failed": case["failed"], "figure": name, **figure}
        for case in summary["cases"]
        for robot, figures in case["robots"].items()
        for name, figure in figures.items()
    ]


def _figures(rows: Sequence[Row], names: Sequence[str]) -> dict[str, Any]:
    columns = {name: [row[name] for row in rows if row[name] is not None] for name in names}
    return {
        name: distribution(np.array(each, dtype=float), upper=largest(name)) for name, each in columns.items() if each
    }
