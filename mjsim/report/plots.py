"""The plots of a report, drawn with matplotlib; each function returns one figure."""

from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from mjsim.geometry import ellipse_points
from mjsim.record import Track
from mjsim.report import metrics
from mjsim.report.consistency import STATES, chi_square_bounds
from mjsim.world import World

TRUTH, ESTIMATE, ODOMETRY, MAP = "#333333", "#0072b2", "#e69f00", "#009e73"
"""Colours that people with colour blindness tell apart (Okabe and Ito, 2008)."""


def path_plot(world: World, track: Track) -> Figure:
    """Draw the plan with the true, estimated and dead-reckoned path, 95 % ellipses, and the map."""
    figure, (axes,) = _figure(1, height=7.0)
    _draw_walls(axes, world)
    axes.plot(*track.odometry[:, :2].T, color=ODOMETRY, lw=1.0, label="odometry")
    axes.plot(*track.truth[:, :2].T, color=TRUTH, lw=1.6, label="truth")
    axes.plot(*track.estimate[:, :2].T, color=ESTIMATE, lw=1.2, label="estimate")
    every = max(1, len(track.time) // 40)
    outlines = [
        ellipse_points(mean[:2], covariance[:2, :2])
        for mean, covariance in zip(track.estimate[::every], track.covariance[::every], strict=True)
    ]
    axes.add_collection(PolyCollection(outlines, facecolors="none", edgecolors=ESTIMATE, linewidths=0.7, alpha=0.8))
    _draw_map(axes, world, track)
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal", title="Path and map, with 95 % ellipses")
    axes.autoscale_view()
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.08), ncols=6, frameon=False)
    return figure


def error_plot(world: World, track: Track) -> Figure:
    """Draw the errors in x, y and heading over time between their 3-sigma bounds."""
    figure, panels = _figure(3, height=7.0)
    errors = track.estimate - track.truth
    errors[:, 2] = metrics.heading_errors(track.truth, track.estimate)
    sigmas = np.sqrt(np.maximum(np.einsum("nii->ni", track.covariance), 0.0))
    scales = (1.0, 1.0, 180.0 / np.pi)
    for axes, column, label in zip(
        panels, range(3), ("x error [m]", "y error [m]", "heading error [deg]"), strict=True
    ):
        error, bound = errors[:, column] * scales[column], 3.0 * sigmas[:, column] * scales[column]
        axes.fill_between(track.time, -bound, bound, color=ESTIMATE, alpha=0.15, lw=0, label="3-sigma bounds")
        axes.plot(track.time, error, color=ESTIMATE, lw=1.0, label="estimate - truth")
        axes.axhline(0.0, color=TRUTH, lw=0.5)
        axes.set_ylabel(label)
    panels[0].set_title("Transient errors and what the estimator says of them")
    panels[0].legend(loc="upper left", frameon=False, ncols=2)
    panels[-1].set_xlabel("time [s]")
    return figure


def distance_plot(world: World, track: Track) -> Figure:
    """Draw the position error of the estimate and of dead reckoning over time."""
    figure, (axes,) = _figure(1, height=3.6)
    for poses, color, label in ((track.odometry, ODOMETRY, "odometry"), (track.estimate, ESTIMATE, "estimate")):
        axes.plot(track.time, metrics.position_errors(track.truth, poses), color=color, lw=1.2, label=label)
    axes.set(xlabel="time [s]", ylabel="position error [m]", title="Localization error, not aligned")
    axes.set_ylim(bottom=0.0)
    axes.legend(loc="upper left", frameon=False)
    return figure


def nees_plot(world: World, track: Track) -> Figure:
    """Draw the NEES over time with its 95 % band."""
    figure, (axes,) = _figure(1, height=3.6)
    low, high = chi_square_bounds(STATES)
    nees = metrics.normalised_errors(track.truth, track.estimate, track.covariance)
    axes.axhspan(low, high, color=MAP, alpha=0.15, lw=0, label=f"95 % band, {low:.2f} to {high:.2f}")
    axes.axhline(3.0, color=MAP, lw=0.8, label="expected, 3")
    axes.plot(track.time, nees, color=ESTIMATE, lw=1.0, label="NEES of x, y, heading")
    axes.set(xlabel="time [s]", ylabel="NEES", title="Consistency of the estimate", yscale="symlog")
    axes.set_ylim(bottom=0.0)
    axes.legend(loc="upper left", frameon=False, ncols=3)
    return figure


PLOTS: tuple[tuple[str, Callable[[World, Track], Figure]], ...] = (
    ("path", path_plot),
    ("error", distance_plot),
    ("bounds", error_plot),
    ("nees", nees_plot),
)
"""Name of the file and what draws it, in the order in which a page shows them."""


def _figure(rows: int, *, height: float) -> tuple[Figure, list[Axes]]:
    figure = Figure(figsize=(9.6, height), dpi=110, layout="constrained")
    panels = list(np.atleast_1d(figure.subplots(rows, 1, sharex=True)))
    for axes in panels:
        axes.grid(color="#dddddd", lw=0.6)
        axes.set_axisbelow(True)
        axes.spines[["top", "right"]].set_visible(False)
    return figure, panels


def _draw_walls(axes: Axes, world: World) -> None:
    from mjsim.world.plan import segments

    axes.add_collection(LineCollection(list(segments(world)), colors="#888888", linewidths=0.8, label="walls"))


def _draw_map(axes: Axes, world: World, track: Track) -> None:
    if world.beacons:
        axes.plot(*np.array([b.at for b in world.beacons]).T, "+", color=TRUTH, ms=6, mew=0.8, label="beacons")
    mean, covariance = track.landmarks.mean[-1:], track.landmarks.covariance[-1:]
    mapped = np.isfinite(mean).all(axis=2)
    if mapped.any():
        axes.plot(*mean[mapped].T, ".", color=MAP, ms=4, label="landmarks")
        outlines = [ellipse_points(m, c) for m, c in zip(mean[mapped], covariance[mapped], strict=True)]
        axes.add_collection(PolyCollection(outlines, facecolors="none", edgecolors=MAP, linewidths=0.8))
