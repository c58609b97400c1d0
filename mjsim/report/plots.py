"""The plots of a report, drawn with matplotlib; each function returns one figure."""

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from mjsim.geometry import Array, ellipse_points
from mjsim.plan import GROUPS, INKS, draw_plan
from mjsim.record import Track
from mjsim.report import metrics
from mjsim.report.consistency import STATES, chi_square_bounds, normalised_innovations
from mjsim.report.statistics import landmark_figures
from mjsim.world import World

TRUTH, ESTIMATE, ODOMETRY = INKS["truth"].light, INKS["estimate"].light, INKS["odometry"].light
MAP, BUMP, FINAL, NEUTRAL = INKS["seen"].light, INKS["bump"].light, INKS["final"].light, INKS["ink"].light
"""Colours of the plan; final paths, and lines that show no path, have their own."""
TRUTH_LINE_WIDTH = 4.5
"""Width of a true path, which is light, below a thin estimate: both are visible where they coincide."""
MAX_BARS = 30
"""Maximum number of landmarks in a plot."""


def path_plot(world: World, track: Track, name: str) -> Figure:
    """Draw the plan with the true, estimated and dead-reckoned path, 95 % ellipses, and the map."""
    figure, (axes,) = sheet(1, height=7.0)
    draw_plan(axes, world)
    draw_paths(axes, track, name)
    every = max(1, len(track.time) // 40)
    draw_ellipses(axes, track.estimate[::every], track.covariance[::every], ESTIMATE)
    draw_map(axes, track)
    axes.set(title="Path and map, with 95 % ellipses")
    axes.autoscale_view()
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.08), ncols=6, frameon=False)
    return figure


def draw_paths(axes: Axes, track: Track, name: str) -> None:
    """Draw the dead-reckoned, true, estimated and final path of a robot."""
    axes.plot(*track.odometry[:, :2].T, color=ODOMETRY, lw=1.0, label="odometry")
    draw_truth(axes, track.truth)
    axes.plot(*track.estimate[:, :2].T, color=ESTIMATE, lw=1.1, label=name)
    if len(track.path):
        axes.plot(*track.path[:, 1:3].T, color=FINAL, lw=1.1, ls="--", label="final path")


def draw_truth(axes: Axes, truth: Array, *, color: str = TRUTH, label: str = "truth") -> None:
    """Draw a true path, wide and light; `truth` has shape (N, 2 or 3) [m]."""
    axes.plot(*truth[:, :2].T, color=color, lw=TRUTH_LINE_WIDTH, alpha=0.4, label=label)


def error_plot(world: World, track: Track, name: str) -> Figure:
    """Draw the errors in x, y and heading over time between their 3-sigma bounds."""
    figure, panels = sheet(3, height=7.0)
    draw_bounds(panels, track, name)
    panels[0].set_title("Errors and 3-sigma bounds")
    panels[-1].set_xlabel("time [s]")
    return figure


def draw_bounds(panels: Sequence[Axes], track: Track, name: str) -> None:
    """Draw the errors in x, y and heading, each in a panel, between their 3-sigma bounds."""
    errors = track.estimate - track.truth
    errors[:, 2] = metrics.heading_errors(track.truth, track.estimate)
    sigmas = np.sqrt(np.maximum(np.einsum("nii->ni", track.covariance), 0.0))
    scales, labels = (1.0, 1.0, 180.0 / np.pi), ("x error [m]", "y error [m]", "heading error [deg]")
    for axes, column, label in zip(panels, range(3), labels, strict=True):
        error, bound = errors[:, column] * scales[column], 3.0 * sigmas[:, column] * scales[column]
        axes.fill_between(track.time, -bound, bound, color=ESTIMATE, alpha=0.15, lw=0, label="3-sigma bounds")
        axes.plot(track.time, error, color=ESTIMATE, lw=1.0, label=f"{name} - truth")
        axes.axhline(0.0, color=NEUTRAL, lw=0.5)
        axes.set_ylabel(label)
        # A few uncertain ticks, as after a robot seemed lost, do not determine the scale.
        top = 1.1 * max(float(np.abs(error).max()), float(np.percentile(bound, 99.0)))
        if top > 0.0 and float(bound.max()) > 3.0 * top:
            axes.set_ylim(-top, top)
    panels[0].legend(loc="upper left", frameon=False, ncols=2)


def distance_plot(world: World, track: Track, name: str) -> Figure:
    """Draw the position error of the estimate and of dead reckoning over time, and when the robot bumped."""
    figure, (axes,) = sheet(1, height=3.6)
    draw_distances(axes, track, name)
    axes.set(title="Localization error, not aligned")
    axes.set_ylim(bottom=0.0)
    return figure


def draw_distances(axes: Axes, track: Track, name: str) -> None:
    """Draw the position errors of dead reckoning and of the estimate over time, and the bumps."""
    for poses, color, label in ((track.odometry, ODOMETRY, "odometry"), (track.estimate, ESTIMATE, name)):
        axes.plot(track.time, metrics.position_errors(track.truth, poses), color=color, lw=1.2, label=label)
    bumps = [event.time for event in track.events if event.kind == "bump"]
    if bumps:
        axes.plot(bumps, np.zeros(len(bumps)), "|", color=BUMP, ms=14, mew=1.6, label="bump", clip_on=False)
    axes.set(xlabel="time [s]", ylabel="position error [m]")
    axes.legend(loc="upper left", frameon=False, ncols=3)


def nees_plot(world: World, track: Track, name: str) -> Figure:
    """Draw NEES and NIS over time with their 95 % bands; each innovation is a point of the NIS."""
    rows, nis = normalised_innovations(track)
    figure, panels = sheet(2 if len(nis) else 1, height=5.6 if len(nis) else 3.6)
    nees = metrics.normalised_errors(track.truth, track.estimate, track.covariance)
    draw_band(panels[0], STATES)
    panels[0].plot(track.time, nees, color=ESTIMATE, lw=1.0, label="NEES of x, y, heading")
    panels[0].set_ylabel("NEES")
    panels[0].set_title(f"Consistency of {name}", loc="left")
    if len(nis):
        draw_band(panels[1], 2)
        panels[1].plot(track.time[rows], nis, ".", color=ESTIMATE, ms=2.5, alpha=0.5, label="NIS of a sighting")
        panels[1].set_ylabel("NIS")
    for axes in panels:
        scale_nees(axes)
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), frameon=False, ncols=3)
    panels[-1].set_xlabel("time [s]")
    return figure


def scale_nees(axes: Axes) -> None:
    """Make the axis of a NEES or NIS linear up to 1 and logarithmic beyond, with plain numbers."""
    axes.set_yscale("symlog", linthresh=1.0)
    top = max(axes.get_ylim()[1], 12.0)
    axes.set_yticks([tick for tick in (0, 1, 3, 10, 30, 100, 300, 1e3, 1e4, 1e5, 1e6) if tick <= top])
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_locator(NullLocator())
    axes.set_ylim(0.0, top)


def draw_band(axes: Axes, freedom: int, *, runs: int = 1, color: str = MAP) -> None:
    """Draw the expected value of a NEES or NIS, and the 95 % band of its mean over runs.

    References:
        Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation (2001), eq. 5.4.2-7.
    """
    low, high = chi_square_bounds(freedom, count=runs)
    axes.axhspan(low, high, color=color, alpha=0.15, lw=0, label=f"95 % band, {low:.2f} to {high:.2f}")
    axes.axhline(freedom, color=color, lw=0.8, label=f"expected, {freedom}")


def landmark_plot(world: World, track: Track, name: str) -> Figure | None:
    """Draw the error of each landmark at the end, as estimated and after alignment; None without a map."""
    errors = landmark_figures(world, track)
    if not errors.get("each"):
        return None
    names = sorted(errors["each"], key=lambda name: -errors["each"][name])[:MAX_BARS]
    figure, (axes,) = sheet(1, height=3.6)
    places = np.arange(len(names))
    for shift, key, color, label in ((-0.2, "each", ESTIMATE, "as estimated"), (0.2, "aligned_each", MAP, "aligned")):
        axes.bar(places + shift, [errors[key][name] for name in names], 0.4, color=color, label=label)
    axes.set_xticks(places, names, rotation=45 if len(names) > 8 else 0, ha="right" if len(names) > 8 else "center")
    some = "" if len(names) == len(errors["each"]) else f", the worst {MAX_BARS} of {len(errors['each'])}"
    axes.set(ylabel="error [m]", title=f"Landmarks at the end{some}")
    axes.grid(axis="x", visible=False)
    axes.legend(loc="upper right", frameon=False, ncols=2)
    return figure


PLOTS: tuple[tuple[str, Callable[[World, Track, str], Figure | None]], ...] = (
    ("path", path_plot),
    ("error", distance_plot),
    ("bounds", error_plot),
    ("nees", nees_plot),
    ("landmarks", landmark_plot),
)
"""Name of the file and its drawing function, in the order of the page; the latter takes the name of the estimate, and
returns None if there is nothing to draw."""


def joint_sheet(
    time: Array, names: Sequence[str], rows: Sequence[tuple[Array, str]], *, title: str = "Joints", height: float = 9.0
) -> tuple[Figure, Sequence[Axes]]:
    """Draw a line for each joint in panels over time.

    Args:
        time: Shape (N,) [s].
        names: Names of the joints drawn, the first ones of each row.
        rows: Values, shape (N, joints), and label of each panel.
        title: Title of the sheet.
        height: [in]
    """
    figure, panels = sheet(len(rows), height=height)
    for axes, (values, label) in zip(panels, rows, strict=True):
        for number, name in enumerate(names):
            axes.plot(time, values[:, number], color=GROUPS[number % len(GROUPS)], lw=1.2, label=name)
        axes.set_ylabel(label)
    panels[0].set_title(title, loc="left")
    panels[-1].set_xlabel("time [s]")
    return figure, panels


def joint_legend(axes: Axes) -> None:
    """Add the legend of joints above the right end of a panel."""
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=8, frameon=False, fontsize=8)


def sheet(rows: int, columns: int = 1, *, height: float) -> tuple[Figure, list[Axes]]:
    """Return an empty figure of a height [inches] and its panels, row by row; in a single column, they share x."""
    figure = Figure(figsize=(9.6, height), dpi=110, layout="compressed")  # also where x and y have the same scale
    panels = list(np.ravel(figure.subplots(rows, columns, sharex=columns == 1)))
    for axes in panels:
        axes.grid(color="#dddddd", lw=0.6)
        axes.set_axisbelow(True)
        axes.spines[["top", "right"]].set_visible(False)
    return figure, panels


def draw_map(axes: Axes, track: Track, *, larger: float = 1.0) -> None:
    """Draw the estimated landmarks at the end, with their ellipses magnified by a factor."""
    mean, covariance = track.landmarks.mean[-1:], track.landmarks.covariance[-1:]
    known = np.isfinite(mean).all(axis=2)
    if known.any():
        axes.plot(*mean[known].T, ".", color=MAP, ms=4, label="landmarks")
        draw_ellipses(axes, mean[known], larger**2 * covariance[known], MAP)


def draw_ellipses(axes: Axes, means: Array, covariances: Array, color: str) -> None:
    """Draw 95 % ellipses of positions, means of shape (n, 2 or 3), in a colour."""
    outlines = list(ellipse_points(means[:, :2], covariances[:, :2, :2])) if len(means) else []
    axes.add_collection(PolyCollection(outlines, facecolors="none", edgecolors=color, linewidths=0.8, alpha=0.9))
