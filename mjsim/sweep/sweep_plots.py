"""The plots of a sweep: errors against the settings, and errors and NEES over time."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mjsim.geometry import Array
from mjsim.plan import GROUPS
from mjsim.report import (
    NEUTRAL,
    ODOMETRY,
    STATES,
    draw_band,
    drawing_files,
    mean_of,
    middle_of,
    plot_text,
    scale_nees,
    sheet,
)
from mjsim.sweep.seed_means import interval_of_mean
from mjsim.sweep.sweep_plan import SweepPlan
from mjsim.sweep.sweep_table import Row
from mjsim.sweep.sweep_worker import Outcome

MAX_SHADES = 3
"""Maximum number of cases for which ranges are drawn beside medians."""
ERROR_KEYS, DEAD_RECKONING = "position_error_m.rmse", "odometry_error_m.rmse"
Series = Mapping[str, Sequence[float | None]]


def plots(
    plan: SweepPlan, rows: Sequence[Row], outcomes: Sequence[Outcome], robots: Sequence[str], formats: Sequence[str]
) -> dict[str, bytes]:
    """Return the plots as files by name; none for a robot without a driver, or whose runs all failed."""
    files: dict[str, bytes] = {}
    for robot in robots:
        own = [row for row in rows if row["robot"] == robot and row.get(ERROR_KEYS) is not None]
        if not own:
            continue
        series = [
            [each["series"][robot] for each in outcomes if each["case"] == case and robot in each["series"]]
            for case in range(len(plan.cases()))
        ]
        drawn = {
            "settings": settings_plot(plan, own),
            "error": error_plot(plan, series),
            "nees": nees_plot(plan, series),
        }
        for figure in drawn.values():
            figure.axes[0].set_title(f"{robot}: {figure.axes[0].get_title()}")
        files |= drawing_files({f"{robot}_{name}": figure for name, figure in drawn.items()}, formats)
    return files


def settings_plot(plan: SweepPlan, rows: Sequence[Row]) -> Figure:
    """Draw the position error of each run, and the means with their intervals, against the setting that varies most.

    Args:
        plan: Plan of the sweep.
        rows: Rows of one robot, for successful runs.
    """
    figure, (above, below) = sheet(2, height=6.4)
    key = max(plan.settings, key=lambda name: len(plan.settings[name]), default=None)
    values: Sequence[Any] = plan.settings[key] if key is not None else ("",)
    places = np.arange(len(values), dtype=float)
    others = [name for name in plan.settings if name != key]
    groups = list(dict.fromkeys(_label({name: row[name] for name in others}) for row in rows))
    for axes, figure_name in ((above, ERROR_KEYS), (below, DEAD_RECKONING)):
        for lane, group in enumerate(groups):
            offset = (lane - (len(groups) - 1) / 2) * 0.7 / len(groups)
            found = [_column(rows, figure_name, key, value, others, group) for value in values]
            joined = all(isinstance(value, int | float) and not isinstance(value, bool) for value in values)
            _draw_lane(axes, places + offset, found, GROUPS[lane % len(GROUPS)], group, joined=joined)
        axes.set_ylim(bottom=0.0)
        axes.grid(visible=False, axis="x")
    above.set(
        ylabel="position error, rmse [m]", title=f"the estimate of each run, means and 95 % intervals ({_count(plan)})"
    )
    below.set(ylabel="position error, rmse [m]", xlabel=key or "", title="Odometry alone")
    below.set_xticks(places, [plot_text(_word(value)) if key else "all runs" for value in values])
    below.set_xlim(-0.6, len(values) - 0.4)
    if groups != [""]:
        _legend(below)
    return figure


def error_plot(plan: SweepPlan, series: Sequence[Sequence[Series]]) -> Figure:
    """Draw the median position error over time with the range of 80 % of the runs, per case; also odometry's."""
    figure, (axes,) = sheet(1, height=4.8)
    drawn = _drawn(plan, series)
    for label, color, runs in drawn:
        time, (low, middle, high) = middle_of(_curves(runs, "position_error_m"), share=0.8)
        if len(drawn) <= MAX_SHADES:
            axes.fill_between(time, low, high, color=color, alpha=0.15, lw=0)
        axes.plot(time, middle, color=color, lw=1.5, label=label or "estimate")
    shade = ", 80 % of them in the shade" if len(drawn) <= MAX_SHADES else ""
    if len(drawn) == 1:
        time, (_, middle, _) = middle_of(_curves(drawn[0][2], "odometry_error_m"))
        axes.plot(time, middle, color=ODOMETRY, lw=1.2, ls="--", label="odometry")
    title = f"position error, median of the runs{shade} ({_count(plan)})"
    axes.set(xlabel="time [s]", ylabel="position error [m]", title=title)
    axes.margins(x=0.0)
    axes.set_ylim(bottom=0.0)
    _legend(axes)
    return figure


def nees_plot(plan: SweepPlan, series: Sequence[Sequence[Series]]) -> Figure:
    """Draw the NEES over time, averaged over the runs of each case, with the 95 % band of such an average."""
    figure, (axes,) = sheet(1, height=4.8)
    draw_band(axes, STATES, runs=max(len(runs) for runs in series), color=NEUTRAL)
    for label, color, runs in _drawn(plan, series):
        axes.plot(*mean_of(_curves(runs, "nees")), color=color, lw=1.3, label=label or "mean of all runs")
    axes.set(
        xlabel="time [s]",
        ylabel="NEES of x, y, heading",
        title=f"consistency, the NEES averaged over the runs ({_count(plan)})",
    )
    scale_nees(axes)
    axes.margins(x=0.0)
    _legend(axes)
    return figure


def _draw_lane(axes: Axes, places: Array, found: Sequence[Array], color: str, label: str, *, joined: bool) -> None:
    """Draw one series of groups of values, each at its position: dots, mean and interval; join means of numbers."""
    for place, values in zip(places, found, strict=True):
        # Side by side in order, so that runs with equal errors are all visible.
        offsets = np.linspace(-0.05, 0.05, len(values)) if len(values) > 1 else np.zeros(len(values))
        axes.plot(place + offsets, values, "o", color=color, ms=3.5, mew=0, alpha=0.35)
    filled = [n for n, values in enumerate(found) if len(values)]
    means = np.array([found[n].mean() for n in filled])
    bounds = np.array([interval_of_mean(found[n]) or (found[n][0],) * 2 for n in filled]).T
    axes.errorbar(
        places[filled], means, yerr=np.abs(bounds - means), color=color, fmt="D-" if joined else "D", ms=5, lw=1.0,
        elinewidth=1.8, capsize=4, mec="white", mew=0.6, label=label,
    )  # fmt: skip


def _column(rows: Sequence[Row], name: str, key: str | None, value: Any, others: Sequence[str], group: str) -> Array:
    """Return a result of all runs with a value of the key and with this label of the other settings."""
    return np.array(
        [
            row[name]
            for row in rows
            if (key is None or row[key] == value) and _label({other: row[other] for other in others}) == group
        ],
        dtype=float,
    )


def _drawn(plan: SweepPlan, series: Sequence[Sequence[Series]]) -> list[tuple[str, str, Sequence[Series]]]:
    """Return label, colour and runs of the cases drawn over time: the first eight with runs."""
    cases = [(_label(case), runs) for case, runs in zip(plan.cases(), series, strict=True) if runs]
    return [(label, color, runs) for (label, runs), color in zip(cases, GROUPS, strict=False)]


def _curves(runs: Sequence[Series], name: str) -> list[tuple[Array, Array]]:
    """Return times [s] and values of runs, NaN where there is none, shape (N,) each."""
    return [(np.array(run["time"], dtype=float), np.array(run[name], dtype=float)) for run in runs]


def _label(case: Mapping[str, Any]) -> str:
    """Return the label of a case's settings, with the last two parts of each key; modules go by their classes."""
    return plot_text(", ".join(f"{_short(key)}{_word(value)}" for key, value in case.items()))


def _short(key: str) -> str:
    is_module = key.endswith((".use", ".estimator", ".observer", ".navigator"))
    return "" if is_module else f"{'.'.join(key.split('.')[-2:])} "


def _word(value: Any) -> str:
    """Return a value of a setting; a module as its class, with its other keys."""
    use = value.get("use") if isinstance(value, Mapping) else value
    if not isinstance(use, str) or ":" not in use:
        return json.dumps(value)
    others = value.items() if isinstance(value, Mapping) else ()
    return ", ".join([use.rpartition(":")[2], *(f"{key}={json.dumps(each)}" for key, each in others if key != "use")])


def _count(plan: SweepPlan) -> str:
    runs = "1 run" if len(plan.seeds) == 1 else f"{len(plan.seeds)} runs"
    return f"{runs} a case" if plan.settings else runs


def _legend(axes: Axes) -> None:
    """Put the legend below, in as many columns as its longest label allows."""
    longest = max(len(text) for text in axes.get_legend_handles_labels()[1])
    columns = max(1, min(3, 110 // (longest + 8)))
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=columns, frameon=False)
