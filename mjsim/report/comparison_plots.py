"""The plots of a comparison; each function returns one figure, or None if there is nothing to draw."""

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Drawing

from mjsim.plan import GROUPS, draw_plan
from mjsim.report.comparison import Compared, Comparison, Group
from mjsim.report.consistency import STATES
from mjsim.report.drawings import plot_text
from mjsim.report.figures import FIGURES, ReportFigure
from mjsim.report.over_time import FEW, mean_of, middle_of, shared_seed
from mjsim.report.plots import NEUTRAL, draw_band, draw_truth, scale_nees, sheet

MAX_PAIRS = 10
"""Maximum number of pairs of groups whose differences are drawn; tables have all."""
MIN_BOX_RUNS = 5
"""Minimum number of runs for boxes."""
KEYS = ("position_error_m.mean", "heading_error_deg.mean", "ate_m.rmse", "nees.mean", "landmark_error_m.aligned_rms")
"""Statistics shown as boxes."""


def error_plot(comparison: Comparison) -> Drawing | None:
    """Draw the position error of all groups over time."""
    figure, (axes,) = sheet(1, height=4.2)
    if not _draw_errors(axes, comparison.groups):
        return None
    axes.set(xlabel="time [s]", ylabel="position error [m]", title="Localization error, not aligned")
    axes.set_ylim(bottom=0.0)
    _legend(figure, axes)
    return figure


def nees_plot(comparison: Comparison) -> Drawing | None:
    """Draw the NEES of all groups over time, averaged over runs, with the band of a consistent estimator."""
    figure, (axes,) = sheet(1, height=4.2)
    drawn = [group for group in comparison.groups if group.series and not group.no_nees]
    if not drawn:
        return None
    count = max(len(group.series) for group in drawn)
    draw_band(axes, STATES, runs=count, color=NEUTRAL)
    for color, width, group in _styled(comparison.groups):
        time, values = mean_of([(series.time, series.nees) for series in group.series.values()])
        if len(time) and not group.no_nees:
            axes.plot(time, values, color=color, lw=width, label=plot_text(group.label))
    averaged = "one run each" if count == 1 else f"averaged over up to {count} runs"
    axes.set(xlabel="time [s]", ylabel="NEES", title=f"Consistency, {averaged}")
    scale_nees(axes)
    _legend(figure, axes)
    return figure


def path_plot(comparison: Comparison) -> Drawing | None:
    """Draw the true and estimated paths, in the runs of the first seed that most groups have."""
    figure, (axes,) = sheet(1, height=7.0)
    seed = shared_seed(comparison.groups)
    if seed is None:
        return None
    shown = [
        (color, width, plot_text(group.label), group.series[seed])
        for color, width, group in _styled(comparison.groups)
        if seed in group.series
    ]
    truths = [series.truth for *_, series in shown if series.truth is not None]
    same_truth = all(np.array_equal(truths[0], other) for other in truths)
    if same_truth:
        draw_truth(axes, truths[0], color=NEUTRAL)
    worlds = [series.world for *_, series in shown if series.world is not None]
    if worlds:
        draw_plan(axes, worlds[0])
    for color, width, label, series in shown:
        if series.truth is None or series.estimate is None:
            continue
        if not same_truth:
            draw_truth(axes, series.truth, color=color, label=f"{label}: truth")
        axes.plot(*series.estimate.T, color=color, lw=width, label=label)
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal", title=f"Paths of seed {seed}, not aligned")
    _legend(figure, axes)
    return figure


def box_plot(comparison: Comparison) -> Drawing | None:
    """Draw box plots of key statistics over the runs of each group; None if no group has five runs."""
    groups = comparison.groups
    figures = [f for f in FIGURES if f.key in KEYS and any(len(g.values[f.key]) >= MIN_BOX_RUNS for g in groups)]
    if not figures:
        return None
    drawing = Drawing(figsize=(9.6, 0.9 + len(figures) * (0.6 + 0.32 * len(groups))), dpi=110, layout="constrained")
    panels = np.atleast_1d(drawing.subplots(len(figures), 1))
    for axes, figure in zip(panels, figures, strict=True):
        _draw_boxes(axes, figure, groups)
    panels[0].set_title("Each point is a run; boxes span the quartiles, lines mark the median")
    return drawing


def difference_plot(comparison: Comparison) -> Drawing | None:
    """Draw the mean differences of the errors of every two groups, with intervals, in per cent of the first's mean."""
    rows = [(item, scale) for item in comparison.differences if (scale := _scale(comparison, item)) is not None]
    pairs = list(dict.fromkeys((item.first, item.second) for item, _ in rows))[:MAX_PAIRS]
    if not pairs:
        return None
    own = [[(item, scale) for item, scale in rows if (item.first, item.second) == pair] for pair in pairs]
    height = 0.3 + sum(0.95 + 0.26 * len(each) for each in own)
    drawing = Drawing(figsize=(9.6, height), dpi=110, layout="constrained")
    panels = np.atleast_1d(drawing.subplots(len(pairs), 1, height_ratios=[3 + len(each) for each in own]))
    for axes, (first, second), each in zip(panels, pairs, own, strict=True):
        axes.set_title(plot_text(f"{second} less {first}"), fontsize=10)
        _draw_differences(axes, each)
    panels[-1].set_xlabel("mean difference of pairs [% of the first's mean]; grey: not decided")
    return drawing


def _draw_differences(axes: Axes, rows: Sequence[tuple[Compared, float]]) -> None:
    axes.axvline(0.0, color=NEUTRAL, lw=0.8)
    for row, (item, scale) in enumerate(rows):
        difference = item.difference
        color = {"first": GROUPS[0], "second": GROUPS[1], "": "#888888"}[difference.verdict]
        low, mean, high = (
            100.0 * float(value or 0.0) / scale for value in (difference.low, difference.mean, difference.high)
        )
        axes.plot([low, high], [row, row], color=color, lw=2.2, solid_capstyle="round")
        axes.plot(mean, row, "o", color=color, ms=5)
    axes.set_yticks(range(len(rows)), [item.figure.title for item, _ in rows])
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.grid(axis="x", color="#dddddd", lw=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


PLOTS: tuple[tuple[str, Callable[[Comparison], Drawing | None]], ...] = (
    ("errors", error_plot),
    ("differences", difference_plot),
    ("boxes", box_plot),
    ("nees", nees_plot),
    ("paths", path_plot),
)
"""Name of the file and its drawing function, in the order of the page."""


def _draw_errors(axes: Axes, groups: Sequence[Group]) -> bool:
    """Draw position errors of few runs, or the median and the middle 90 % of many; return whether there was any."""
    for color, width, group in _styled(groups):
        runs = [(series.time, series.position_error_m) for series in group.series.values()]
        if len(runs) <= FEW:
            for number, curve in enumerate(runs):
                axes.plot(*curve, color=color, lw=width, label=None if number else plot_text(group.label))
            continue
        time, (low, median, high) = middle_of(runs)
        axes.fill_between(time, low, high, color=color, alpha=0.15, lw=0)
        label = f"{plot_text(group.label)}: median of {len(runs)}, nine of ten"
        axes.plot(time, median, color=color, lw=width, label=label)
    return any(group.series for group in groups)


def _draw_boxes(axes: Axes, figure: ReportFigure, groups: Sequence[Group]) -> None:
    rng = np.random.default_rng(0)  # Points of one group are spread a little, always in the same way.
    for row, (color, _, group) in enumerate(_styled(groups)):
        values = np.array(list(group.values[figure.key].values()))
        if not len(values):
            continue
        axes.boxplot(
            values,
            positions=[row],
            orientation="horizontal",
            widths=0.55,
            showfliers=False,
            patch_artist=True,
            boxprops={"facecolor": f"{color}30", "edgecolor": color},
            medianprops={"color": color, "linewidth": 1.8},
            whiskerprops={"color": color},
            capprops={"color": color},
        )
        axes.plot(values, row + rng.uniform(-0.16, 0.16, len(values)), ".", color=color, ms=4, alpha=0.6)
    axes.set_yticks(range(len(groups)), [plot_text(group.label) for group in groups])
    axes.set_ylim(len(groups) - 0.4, -0.6)
    axes.set_xlabel(figure.heading)
    axes.grid(axis="x", color="#dddddd", lw=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def _scale(comparison: Comparison, item: Compared) -> float | None:
    """Return the mean of the first group, if the difference has an interval and is one of errors."""
    if item.difference.low is None or not item.figure.better or not item.figure.unit:
        return None
    first = next(group for group in comparison.groups if group.label == item.first)
    mean = first.spreads[item.figure.key].mean
    return mean if mean > 0.0 else None


def _styled(groups: Sequence[Group]) -> list[tuple[str, float, Group]]:
    """Return colour and width of the line of each group; later ones are thinner, so that equal lines all show."""
    widths = np.linspace(2.4, 1.0, len(groups)) if len(groups) > 1 else [1.4]
    return [
        (GROUPS[k % len(GROUPS)], float(width), group)
        for k, (width, group) in enumerate(zip(widths, groups, strict=True))
    ]


def _legend(figure: Drawing, axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2 if len(labels) > 2 else 3, frameon=False)
