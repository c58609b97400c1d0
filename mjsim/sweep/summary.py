"""Means over seeds, and how sure they are."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.special import stdtrit

from mjsim.geometry import Array
from mjsim.sweep.plan import Plan
from mjsim.sweep.table import Row, figure_names

CONFIDENCE = 0.95


def interval_of_mean(values: Array) -> tuple[float, float]:
    """Return the bounds between which the mean lies with a confidence of 95 %; both the mean for one value.

    Args:
        values: Independent, one a seed, shape (n,).

    References:
        Student, The Probable Error of a Mean, Biometrika 6 (1908).
    """
    mean, n = float(values.mean()), len(values)
    if n < 2:
        return mean, mean
    half = float(stdtrit(n - 1, 0.5 + CONFIDENCE / 2)) * float(values.std(ddof=1)) / n**0.5
    return mean - half, mean + half


def spread(values: Array) -> dict[str, float | int]:
    """Return count, mean with its interval, standard deviation, median, min and max of a figure, shape (n,)."""
    low, high = interval_of_mean(values)
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


def summary_of(plan: Plan, rows: Sequence[Row]) -> dict[str, Any]:
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
    return {"confidence": CONFIDENCE, "cases": cases}


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
    return {name: spread(np.array(values, dtype=float)) for name, values in columns.items() if values}
