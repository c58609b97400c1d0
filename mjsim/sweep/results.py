"""Results of a sweep in its folder."""

import importlib.util
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mjsim.sentences import number_of
from mjsim.sweep.seed_means import INTERVAL, summary_of, summary_rows
from mjsim.sweep.store import Store
from mjsim.sweep.sweep_plan import SweepPlan
from mjsim.sweep.sweep_table import csv_text, no_nees, parquet, rows_of
from mjsim.sweep.sweep_worker import Outcome
from mjsim.views import Viewed

KEY_FIGURES = {
    "position_error_m.rmse": "position error [m]",
    "odometry_error_m.rmse": "odometry [m]",
    "heading_error_deg.rmse": "heading [deg]",
    "nees.mean": "NEES",
}
"""Statistic -> header of its column in the short table."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class Sweep(Viewed):
    """Results of a sweep; its folder has the same as files."""

    folder: Path
    rows: Sequence[Mapping[str, Any]]
    """The table: one row per robot and run, with case, seed, settings, robot, error, and statistics such as
    'position_error_m.rmse'."""
    summary: Mapping[str, Any]
    """Content of summary.json."""
    failed: Mapping[str, str]
    """Name of each failed run -> error."""

    def __repr__(self) -> str:
        """Return its folder, and how many rows its table has."""
        failed = number_of(len(self.failed), "failed run")
        return f"<Sweep in '{self.folder}': {number_of(len(self.rows), 'row')}, {failed}>"


def write_results(
    store: Store, plan: SweepPlan, outcomes: Sequence[Outcome], robots: Sequence[str], formats: Sequence[str]
) -> Sweep:
    """Write table, summary, clock and plots; return the results. A Parquet table needs the extra pyarrow.

    Args:
        store: Destination.
        plan: Plan of the sweep.
        outcomes: One per job, in the order of the jobs.
        robots: Robots in the table.
        formats: Formats of the plots.

    Raises:
        UsageError: A file cannot be written.
    """
    from mjsim.sweep.sweep_plots import plots

    rows = rows_of(plan, outcomes, robots)
    summary = summary_of(plan, rows, no_nees=no_nees(outcomes))
    store.write("table.csv", csv_text(rows))
    if importlib.util.find_spec("pyarrow"):
        store.write("table.parquet", parquet(rows))
    else:
        (store.folder / "table.parquet").unlink(missing_ok=True)
    store.write("summary.json", (json.dumps(summary, indent=1) + "\n").encode())
    if flat := summary_rows(summary):
        store.write("summary.csv", csv_text(flat))
    store.write("clock.csv", csv_text([_clock(outcome) for outcome in outcomes]))
    for name, data in plots(plan, rows, outcomes, robots, formats).items():
        store.write(f"plots/{name}", data)
    names = [job.name for job in plan.jobs()]
    failed = {name: each["error"] for name, each in zip(names, outcomes, strict=True) if each["error"] is not None}
    return Sweep(folder=store.folder, rows=rows, summary=summary, failed=failed)


def key_lines(summary: Mapping[str, Any]) -> list[str]:
    """Return the key results of a summary as lines for a terminal: means with confidence intervals."""
    lines = []
    for case in summary["cases"]:
        settings = ", ".join(f"{key} {json.dumps(value)}" for key, value in case["settings"].items()) or "all runs"
        for robot, figures in case["robots"].items():
            counted = f"{case['runs'] - case['failed']} of {case['runs']} runs"
            lines.append(f"{settings}: {robot}, {counted}")
            lines += [
                f"  {head:<22}{_interval(figures[name])}" for name, head in KEY_FIGURES.items() if name in figures
            ]
            if robot in case["no_nees"]:
                lines.append(f"  {KEY_FIGURES['nees.mean']:<22}{case['no_nees'][robot]}")
    return [*lines, f"[{INTERVAL}]"]


def _interval(figure: Mapping[str, Any]) -> str:
    bounds = f"  [{figure['low']:.4g}, {figure['high']:.4g}]" if figure["low"] is not None else ""
    return f"{figure['mean']:>9.4g}{bounds}"


def _clock(outcome: Outcome) -> dict[str, Any]:
    """Return the wall-clock times of a run, which differ between executions."""
    clock = outcome["clock"]
    keys = ("total_seconds", "wall_seconds", "real_time_factor")
    return {"case": outcome["case"], "seed": outcome["seed"], **{key: clock.get(key) for key in keys}}
