"""Combines outcomes into one table, with the same bytes for the same sweep whatever order it ran in."""

import csv
import io
import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from mjsim.report import lacks_estimator
from mjsim.sweep.sweep_plan import SweepPlan
from mjsim.sweep.sweep_worker import Outcome

KEYS = ("case", "seed", "robot", "error")
"""Columns of every table besides settings and results."""
EACH = frozenset({"each", "aligned_each"})
"""Results by landmark, which are left out of the table; their totals are included."""

Row = dict[str, Any]
"""One robot of one run: case, seed, settings by key, robot, error, results such as 'nees.mean'."""


def rows_of(plan: SweepPlan, outcomes: Sequence[Outcome], robots: Sequence[str]) -> list[Row]:
    """Return the rows of a table, by case, seed and robot; all have the same keys in the same order.

    Args:
        plan: Plan of the sweep.
        outcomes: One per job, in the order of the jobs.
        robots: Robots in the table.
    """
    cases = plan.cases()
    found = [{name: _flat(outcome, name) for name in robots} for outcome in outcomes]
    names = list(dict.fromkeys(itertools.chain(*(figures for each in found for figures in each.values()))))
    return [
        {
            "case": outcome["case"],
            "seed": outcome["seed"],
            **cases[outcome["case"]],
            "robot": robot,
            "error": outcome["error"],
            **{name: each[robot].get(name) for name in names},
        }
        for outcome, each in zip(outcomes, found, strict=True)
        for robot in robots
    ]


def no_nees(outcomes: Iterable[Outcome]) -> dict[tuple[int, str], str]:
    """Return the reason why no run has a NEES, by case and robot, where that is so."""
    reasons: dict[tuple[int, str], set[str | None]] = {}
    for outcome in outcomes:
        for robot, figures in outcome["robots"].items():
            nees = figures.get("nees")
            if nees is not None:
                reasons.setdefault((outcome["case"], robot), set()).add(nees.get("reason"))
    return {key: next(iter(each)) or "" for key, each in reasons.items() if len(each) == 1 and None not in each}


def figure_names(plan: SweepPlan, rows: Sequence[Row]) -> list[str]:
    """Return the columns of a table with results."""
    return [name for name in rows[0] if name not in KEYS and name not in plan.settings]


def parquet(rows: Sequence[Row]) -> bytes:
    """Return the rows as a Parquet file."""
    import pyarrow
    from pyarrow import parquet as pq

    columns = {name: pyarrow.array(values, type=kind) for name, kind, values in _typed(rows)}
    file = io.BytesIO()
    # Everything that could differ between two writes is fixed; a Parquet file contains no time stamp.
    pq.write_table(
        pyarrow.table(columns), file, version="2.6", compression="zstd", compression_level=3, row_group_size=100_000
    )
    return file.getvalue()


def csv_text(rows: Sequence[Row]) -> bytes:
    """Return rows as CSV; None is an empty field."""
    file = io.StringIO()
    writer = csv.DictWriter(file, fieldnames=list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return file.getvalue().encode()


def _flat(outcome: Outcome, robot: str) -> Row:
    """Return the results of one robot by names such as 'nees.mean', without wall-clock times."""
    figures = outcome["robots"].get(robot)
    if figures is None:
        return {}
    shown = {key: value for key, value in figures.items() if not (key == "nees" and lacks_estimator(figures))}
    return {"sim_seconds": outcome["run"]["sim_seconds"], **dict(_leaves(shown, ""))}


def _leaves(figures: Mapping[str, Any], before: str) -> Iterator[tuple[str, float]]:
    for key, value in figures.items():
        if isinstance(value, Mapping) and key not in EACH:
            yield from _leaves(value, f"{before}{key}.")
        elif isinstance(value, (int, float)):
            yield f"{before}{key}", value


def _typed(rows: Sequence[Row]) -> Iterator[tuple[str, Any, list[Any]]]:
    """Yield name, type and values of each column: integers, numbers, booleans, or text."""
    import json

    import pyarrow

    for name in rows[0]:
        values = [row[name] for row in rows]
        kinds = {type(value) for value in values if value is not None}
        if kinds == {bool}:
            yield name, pyarrow.bool_(), values
        elif kinds == {int} and all(abs(value) < 2**63 for value in values if value is not None):
            yield name, pyarrow.int64(), values
        elif kinds and kinds <= {int, float}:
            yield name, pyarrow.float64(), [None if value is None else float(value) for value in values]
        else:
            texts = [value if value is None or isinstance(value, str) else json.dumps(value) for value in values]
            yield name, pyarrow.string(), texts
