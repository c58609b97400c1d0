"""Means over seeds, and how certain they are."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.special import stdtrit

from mjsim.geometry import Array
from mjsim.report import CONFIDENCE, fewest_pairs, largest, mean_interval
from mjsim.sweep.plan import SweepPlan
from mjsim.sweep.table import Row, figure_names

INTERVAL = (
    f"{CONFIDENCE:.0%} interval of the mean over the seeds: bootstrap (BCa) from {fewest_pairs()} runs on, of fewer"
    " Student's t as far as the figure can go, none of one"
)
"""What the intervals of a summary are, for people."""


def interval_of_mean(values: Array, *, most: float = np.inf) -> tuple[float, float] | None:
    """Return the bounds between which the mean lies with a confidence of 95 %; None of one value.

    No figure can be below 0. A bootstrap never leaves the range of its values; what of Student's interval a figure
    cannot reach is cut off, which leaves the confidence as it is: the mean cannot lie there.

    Args:
        values: Independent, one a seed, shape (n,).
        most: What the figure can be at most, such as 1 of a share.

    References:
        `mjsim.report.paired` for the bootstrap, as in comparisons; Student, The Probable Error of a Mean, Biometrika
        6 (1908), for too few values to be drawn from.
    """
    n = len(values)
    if n < 2:
        return None
    drawn = mean_interval(values)
    if drawn is not None:
        return drawn
    mean = float(values.mean())
    half = float(stdtrit(n - 1, 0.5 + CONFIDENCE / 2)) * float(values.std(ddof=1)) / n**0.5
    return max(mean - half, 0.0), min(mean + half, most)


def spread(values: Array, *, most: float = np.inf) -> dict[str, float | int | None]:
    """Return count, mean with its interval, standard deviation, median, min and max of a figure, shape (n,)."""
    low, high = interval_of_mean(values, most=most) or (None, None)
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


def summary_of(plan: SweepPlan, rows: Sequence[Row]) -> dict[str, Any]:
    """Return what summary.json holds: for each case and robot the spread of each figure over the seeds."""
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
            }
        )
    return {"confidence": CONFIDENCE, "interval": INTERVAL, "cases": cases}


def summary_rows(summary: Mapping[str, Any]) -> list[Row]:
    """Return the summary as rows of a table: one for each case, robot and figure."""
    return [
        {"case": case["case"], **case["settings"], "robot": robot, "failed": case["failed"], "figure": name, **figure}
        for case in summary["cases"]
        for robot, figures in case["robots"].items()
        for name, figure in figures.items()
    ]


def _figures(rows: Sequence[Row], names: Sequence[str]) -> dict[str, Any]:
    columns = {name: [row[name] for row in rows if row[name] is not None] for name in names}
    return {name: spread(np.array(each, dtype=float), most=largest(name)) for name, each in columns.items() if each}
