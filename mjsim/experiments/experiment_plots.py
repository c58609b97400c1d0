"""The plots of the classic experiments, drawn with matplotlib."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path

from mjsim.experiments.finding import Plot
from mjsim.experiments.offline import Fixes
from mjsim.geometry import Array, Pose, ellipse_magnification
from mjsim.interface import Sighting
from mjsim.plan import draw_plan
from mjsim.record import Recording, Track
from mjsim.report import (
    BUMP,
    ESTIMATE,
    MAP,
    NEUTRAL,
    ODOMETRY,
    STATES,
    TRUTH,
    chi_square_bounds,
    draw_band,
    draw_bounds,
    draw_distances,
    draw_ellipses,
    draw_map,
    draw_truth,
    metrics,
    png_of,
    sheet,
)
from mjsim.world import World

ENLARGED_MARGIN = 0.3
"""Margin of the enlarged view around the robot and what it sees [m]."""
SHAPE = (1.5, 1.0)
"""Width and height of that view, in proportion."""


def path_plot(name: str, caption: str, recording: Recording) -> Plot:
    """Draw the plan with the true and the estimated path, and ellipses of the pose and of the landmarks."""
    (track,) = recording.robots.values()
    figure, axes = _plan(recording.world)
    draw_truth(axes, track.truth)
    axes.plot(*track.estimate[:, :2].T, color=ESTIMATE, lw=1.1, label="estimate")
    every = max(1, len(track.time) // 30)
    draw_ellipses(axes, track.estimate[every::every], track.covariance[every::every], ESTIMATE)
    draw_map(axes, track)
    _draw_ends(axes, track)
    return _picture(f"{name}_path", caption, figure)


def trail(name: str, caption: str, recording: Recording) -> Plot:
    """Draw the plan with the true path, and the area covered by the body."""
    import shapely

    (track,) = recording.robots.values()
    figure, axes = _plan(recording.world)
    swept = shapely.LineString(track.truth[:, :2]).simplify(0.01).buffer(recording.world.robots[0].body.radius)
    path = Path.make_compound_path(
        *(Path(shapely.get_coordinates(ring)) for ring in (swept.exterior, *swept.interiors))
    )
    axes.add_patch(PathPatch(path, facecolor=MAP, alpha=0.15, lw=0, label="floor covered"))
    axes.plot(*track.truth[:, :2].T, color=TRUTH, lw=0.8, label="truth")
    _draw_ends(axes, track)
    return _picture(f"{name}_path", caption, figure)


def wriggling(name: str, caption: str, track: Track, first: float) -> Plot:
    """Draw speed and heading over time, and the time of the first bump."""
    figure, (above, below) = sheet(2, height=4.6)
    speed = np.hypot(*np.diff(track.truth[:, :2], axis=0).T) / np.diff(track.time)
    above.plot(track.time[1:], speed, color=TRUTH, lw=0.9)
    above.set(ylabel="speed [m/s]")
    below.plot(track.time, np.degrees(np.unwrap(track.truth[:, 2])), color=TRUTH, lw=0.9)
    below.set(xlabel="time [s]", ylabel="heading [deg]")
    for axes in (above, below):
        axes.axvline(first, color=BUMP, lw=1.4, label="first bump")
    above.legend(frameon=False)
    return _picture(f"{name}_motion", caption, figure)


def growth(name: str, caption: str, time: Array, repeats: tuple[Array, Array, Array]) -> Plot:
    """Draw the errors of many runs with the predicted standard deviation, and their mean NEES with its bounds."""
    truth, estimate, covariance = repeats
    runs, rows = truth.shape[:2]
    times = time[:rows]
    errors = np.linalg.norm((estimate - truth)[..., :2], axis=-1)
    sigma = np.sqrt(np.mean(covariance[..., 0, 0] + covariance[..., 1, 1], axis=0))
    flat = truth.reshape(-1, 3), estimate.reshape(-1, 3), covariance.reshape(-1, 3, 3)
    nees = metrics.normalised_errors(*flat).reshape(runs, rows).mean(axis=0)
    figure, (above, below) = sheet(2, height=6.4)
    above.plot(times, errors.T, color=ODOMETRY, lw=0.5, alpha=0.5)
    above.plot([], [], color=ODOMETRY, lw=0.5, label="each run")
    above.plot(times, np.sqrt(np.mean(errors**2, axis=0)), color=NEUTRAL, lw=1.8, label="root mean square of the runs")
    above.plot(times, sigma, "--", color=ESTIMATE, lw=1.8, label="predicted")
    above.set(ylabel="position error [m]")
    above.set_ylim(bottom=0.0)
    above.legend(loc="upper left", frameon=False)
    draw_band(below, STATES, runs=runs)
    below.plot(times[1:], nees[1:], color=ESTIMATE, lw=1.0, label=f"NEES, mean of {runs} runs")
    below.set(xlabel="time [s]", ylabel="NEES")
    below.set_ylim(0.0, 2.0 * chi_square_bounds(STATES, count=runs)[1])
    below.legend(loc="upper left", frameon=False, ncols=2)
    return _picture(f"{name}_growth", caption, figure)


def fixes(name: str, caption: str, recording: Recording, found: Fixes) -> Plot:
    """Draw the true and the triangulated positions of pictures."""
    figure, axes = _plan(recording.world)
    (track,) = recording.robots.values()
    axes.plot(*track.truth[:, :2].T, color=TRUTH, lw=1.0, label="true path")
    pairs = np.stack([found.truth, found.position], axis=1)
    axes.add_collection(LineCollection(list(pairs), colors=NEUTRAL, linewidths=0.8))
    axes.plot(*found.position.T, ".", color=ESTIMATE, ms=6, label="triangulated")
    _draw_legend(axes)
    return _picture(f"{name}_fixes", caption, figure)


def fix_errors(name: str, caption: str, found: Fixes) -> Plot:
    """Draw the error of each triangulated position over time."""
    figure, (axes,) = sheet(1, height=3.2)
    errors = np.hypot(*(found.position - found.truth).T)
    axes.plot(found.time, 100.0 * errors, ".", color=ESTIMATE, ms=5)
    axes.axhline(100.0 * errors.mean(), color=NEUTRAL, lw=1.0, label=f"mean, {100.0 * errors.mean():.2f} cm")
    axes.set(xlabel="time [s]", ylabel="error [cm]", yscale="log")
    axes.legend(frameon=False)
    return _picture(f"{name}_errors", caption, figure)


def enlarged(name: str, title: str, recording: Recording) -> Plot:
    """Draw one instant of the last lap: the robot with its estimate, what it sees, and magnified ellipses.

    It is the instant at which the robot sees two beacons or more, as close as possible.
    """
    (track,) = recording.robots.values()
    body, row = recording.world.robots[0].body, _closest_sight(track)
    truth, estimate = Pose.from_array(track.truth[row]), Pose.from_array(track.estimate[row])
    factor = ellipse_magnification(track.covariance[row, :2, :2], 0.75 * body.radius)
    figure, axes = _plan(recording.world)
    draw_truth(axes, track.truth[: row + 1])
    axes.plot(*track.estimate[: row + 1, :2].T, color=ESTIMATE, lw=1.0, label="estimate")
    ends = estimate.transform(np.reshape([_seen_at(each) for each in track.sightings[row]], (-1, 2)))
    lines = LineCollection([np.stack([track.estimate[row, :2], end]) for end in ends], colors=MAP, linewidths=1.0)
    axes.add_collection(lines)
    for pose, color, reach in ((truth, TRUTH, 1.0), (estimate, ESTIMATE, 1.45)):
        axes.fill(*pose.transform(body.outline()).T, facecolor=(color, 0.15), edgecolor=color, lw=1.2)
        axes.plot(*pose.transform([[0.0, 0.0], [reach * body.radius, 0.0]]).T, color=color, lw=1.2)
    draw_map(axes, track, larger=factor)
    draw_ellipses(axes, track.estimate[row : row + 1], factor**2 * track.covariance[row : row + 1], ESTIMATE)
    shown = np.concatenate([truth.transform(body.outline()), ends])
    half = np.max((np.ptp(shown, axis=0) / 2.0 + ENLARGED_MARGIN) / SHAPE) * np.array(SHAPE)
    middle = (shown.min(axis=0) + shown.max(axis=0)) / 2.0
    axes.set(xlim=middle[0] + half[0] * np.array([-1, 1]), ylim=middle[1] + half[1] * np.array([-1, 1]))
    _draw_legend(axes)
    caption = f"{title} at {track.time[row]:.1f} s, with 95 % ellipses, magnified {factor} times"
    return _picture(f"{name}_enlarged", caption, figure)


def _closest_sight(track: Track) -> int:
    """Return the row of the last third with two sightings or more, the farthest of them as close as possible."""
    late = range(2 * len(track.time) // 3, len(track.time))
    ranges = [[seen.range for seen in sightings] for sightings in track.sightings]
    return min(late, key=lambda row: (-min(len(ranges[row]), 2), max(ranges[row], default=0.0)))


def _seen_at(seen: Sighting) -> tuple[float, float]:
    """Return the position of a sighting, robot frame [m]."""
    return seen.range * np.cos(seen.bearing), seen.range * np.sin(seen.bearing)


def transient(name: str, caption: str, track: Track) -> Plot:
    """Draw the errors in x, y and heading with their 3-sigma bounds, and the position error beside odometry's."""
    figure, panels = sheet(4, height=8.0)
    draw_bounds(panels[:3], track, "estimate")
    draw_distances(panels[3], track, "estimate")
    return _picture(f"{name}_transient", caption, figure)


def _plan(world: World) -> tuple[Figure, Axes]:
    figure, (axes,) = sheet(1, height=6.6)
    draw_plan(axes, world)
    return figure, axes


def _draw_ends(axes: Axes, track: Track) -> None:
    axes.plot(*track.truth[0, :2], "o", color=NEUTRAL, mfc="white", ms=8, label="start")
    axes.plot(*track.truth[-1, :2], "s", color=NEUTRAL, ms=7, label="end")
    _draw_legend(axes)


def _draw_legend(axes: Axes) -> None:
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.09), ncols=6, frameon=False)


def _picture(name: str, caption: str, figure: Figure) -> Plot:
    return Plot(name=name, caption=caption, png=png_of(figure))
