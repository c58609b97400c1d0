"""Computes the statistics of a recording for `statistics.json`; docs/statistics.md describes each."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mjsim.geometry import Array, roll_and_pitch
from mjsim.record import Recording, Track, read_recording
from mjsim.report import metrics
from mjsim.report.arm_statistics import arm_figures
from mjsim.report.consistency import nees_figures, nis_figures, normalised_innovations, picture_share
from mjsim.report.coverage import coverage, reachable_region
from mjsim.views import Viewed
from mjsim.world import MoveEvent, Robot, World, hung

PATH_FIGURES = ("position_error_m", "heading_error_deg", "ate_m", "rpe_m")
ODOMETRY_FIGURES = ("odometry_error_m", "odometry_heading_error_deg", "odometry_ate_m", "odometry_rpe_m")
FINAL_FIGURES = ("path_error_m", "path_heading_error_deg", "path_ate_m", "path_rpe_m")
ESTIMATE_FIGURES = (
    *(key for pair in zip(PATH_FIGURES, ODOMETRY_FIGURES, strict=True) for key in pair),
    *FINAL_FIGURES,
    *("rpe_deg", "nees", "nis", "landmark_error_m", "transient", "recovery"),
)
"""Keys of the statistics that need an estimate."""


class Statistics(dict[str, Any], Viewed):
    """The statistics of each robot by name, and those of the run under 'run'; notebooks show a table."""


def statistics(
    recording: Recording | str | Path, *, begin: float | None = None, end: float | None = None
) -> Statistics:
    """Return the statistics of each robot by name, and those of the run under 'run'.

    The keys are those of `statistics.json`, which has the robots one level down, under 'robots'.

    Args:
        recording: The recording of a run, or its file.
        begin: Start of the section [s]; by default that of the run.
        end: End of the section [s]; by default that of the run.

    Raises:
        UsageError: There is no tick between these times, or the file cannot be read.
        RecordingError: The file is not a recording.
    """
    run = recording if isinstance(recording, Recording) else read_recording(recording)
    figures = statistics_file(run.between(begin, end))
    return Statistics(figures["robots"], run=figures["run"])


@np.errstate(over="ignore", invalid="ignore")  # An estimate may be anywhere; values that overflow are reported as None.
def statistics_file(recording: Recording) -> dict[str, Any]:
    """Return the content of `statistics.json`: {"run": {...}, "robots": {name: {...}}}."""
    seconds = float(recording.time[-1] - recording.time[0]) + _period(recording)
    requested = recording.metadata.get("seconds")
    figures = {
        "run": {
            "world": recording.world.name,
            "seed": recording.seed,
            "sim_seconds": seconds,
            "asked_seconds": None if requested is None else float(requested),
            "whole": recording.whole,
            "wall_seconds": recording.wall_seconds,
            "real_time_factor": seconds / recording.wall_seconds if recording.wall_seconds > 0.0 else None,
            "milliseconds": _module_times(recording),
        },
        "robots": {
            name: robot_statistics(
                recording.world,
                name,
                track,
                lifted=lifts(recording, name),
                estimated=recording.has_estimator(name),
            )
            | _arms(recording, name)
            for name, track in recording.robots.items()
        },
    }
    plain: dict[str, Any] = _plain(figures)
    return plain


def robot_statistics(
    world: World, name: str, track: Track, *, lifted: Sequence[float] = (), estimated: bool = True
) -> dict[str, Any]:
    """Return the statistics of one robot; those of an estimate are None for a robot without a driver.

    Args:
        world: Its world.
        name: Name of the robot.
        track: Its recorded data.
        lifted: Times at which it was moved elsewhere [s]: these moves are not driven distance, but the error still
            counts.
        estimated: Whether an estimator gave the estimate, not dead reckoning.
    """
    placed = np.isfinite(track.truth).all(axis=1)
    positions, times = track.truth[placed, :2], track.time[placed]
    steps = np.linalg.norm(np.diff(positions, axis=0), axis=1)
    steps[np.isin(times[1:], lifted)] = 0.0
    robot = next(robot for robot in world.robots if robot.name == name)
    believed = None if stands(world, name) else known_part(track)
    return {
        **(
            dict.fromkeys(ESTIMATE_FIGURES)
            if believed is None
            else _estimate_figures(world, track, believed, lifted=lifted, estimated=estimated)
        ),
        **_pose_figures(track.truth_pose[placed]),
        "distance_m": float(steps.sum()) if len(positions) else None,
        "coverage": coverage(world, positions, radius=robot.body.radius) if len(positions) else None,
        "coverage_area": swept_share(world, robot, track.truth[placed]) if len(positions) else None,
        "bumps": sum(event.kind == "bump" for event in track.events),
        "falls": sum(event.kind == "fall" for event in track.events),
        "fault": next((event.text for event in track.events if event.kind == "fault"), None),
        "ticks": 0 if believed is None else len(believed.time),
    }


def stands(world: World, name: str) -> bool:
    """Return whether the base of a robot is fixed, so that there is nothing to estimate."""
    return any(robot.name == name and robot.base == "fixed" for robot in world.robots)


def _arms(recording: Recording, name: str) -> dict[str, Any]:
    """Return the statistics of a robot's arms under 'arms'; nothing for a robot without arms."""
    found = {
        joints.partition("/")[2]: arm_figures(track)
        for joints, track in recording.joints.items()
        if joints.partition("/")[0] == name and not joints.endswith("/drive")
    }
    return {"arms": found} if found else {}


def _pose_figures(poses: Array) -> dict[str, Any]:
    """Return height, roll and pitch of the base over the run; None if its pose was never known.

    Args:
        poses: World frame, (x, y, z, qx, qy, qz, qw), shape (N, 7).
    """
    keys = ("height_m", "roll_deg", "pitch_deg")
    if not len(poses):
        return dict.fromkeys(keys)
    roll, pitch = np.degrees(roll_and_pitch(poses[:, 3:])).T
    return dict(zip(keys, map(metrics.error_summary, (poses[:, 2], roll, pitch)), strict=True))


def known_part(track: Track) -> Track | None:
    """Return the ticks at which both truth and estimate are known; None if there are none."""
    known = np.isfinite(track.truth).all(axis=1) & np.isfinite(track.estimate).all(axis=1)
    if not known.any():
        return None
    if known.all():
        return track
    return track.at(np.flatnonzero(known))


def lifts(recording: Recording, name: str) -> list[float]:
    """Return the times at which a robot was moved elsewhere during the recording [s]."""
    moves = [event for event in recording.events if isinstance(event, MoveEvent) and event.move == name]
    return [event.time for event in moves if event.time >= recording.time[0]]


def _estimate_figures(
    world: World, track: Track, part: Track, *, lifted: Sequence[float], estimated: bool
) -> dict[str, Any]:
    """Return the statistics under the keys of ESTIMATE_FIGURES, for the part of a track with truth and estimate."""
    errors = metrics.position_errors(part.truth, part.estimate)
    turned = np.abs(np.degrees(metrics.heading_errors(part.truth, part.estimate)))
    wheels = part.odometry if np.isfinite(part.odometry).all() else None
    return {
        **dict.fromkeys(ESTIMATE_FIGURES),
        **_path_figures(part.truth, part.estimate, PATH_FIGURES),
        **({} if wheels is None else _path_figures(part.truth, wheels, ODOMETRY_FIGURES)),
        **_final_figures(part),
        "rpe_deg": metrics.error_summary(np.degrees(metrics.relative_turn_errors(part.truth, part.estimate))),
        "nees": nees_figures(
            metrics.normalised_errors(part.truth, part.estimate, part.covariance), estimated=estimated
        ),
        "nis": nis_figures(normalised_innovations(track)[1]) | {"pictures": picture_share(track)},
        "landmark_error_m": landmark_figures(world, track),
        "transient": transient_errors(part.time, errors, turned),
        "recovery": recoveries(part.time, errors, lifted),
    }


def _path_figures(truth: Array, poses: Array, keys: tuple[str, str, str, str]) -> dict[str, Any]:
    """Return the errors of a path in position and heading, its ATE and its RPE, under the given keys."""
    figures = (
        metrics.summary(metrics.position_errors(truth, poses)),
        metrics.summary(np.degrees(metrics.heading_errors(truth, poses))),
        metrics.error_summary(metrics.absolute_trajectory_errors(truth, poses)),
        metrics.error_summary(metrics.relative_pose_errors(truth, poses)),
    )
    return dict(zip(keys, figures, strict=True))


def _final_figures(part: Track) -> dict[str, Any]:
    """Return the errors of the final trajectory at its own times; empty without one, or without truth there."""
    truth = metrics.poses_at(part.path[:, 0], part.moments, part.truth)
    known = np.isfinite(truth).all(axis=1)
    return _path_figures(truth[known], part.path[known, 1:], FINAL_FIGURES) if known.any() else {}


def landmark_figures(world: World, track: Track) -> dict[str, Any]:
    """Return errors of the last map relative to the true positions; `false` counts landmarks that do not exist.

    Beacons on robots and on moving objects have no fixed position and are left out.
    """
    places, mapped = last_map(world, track)
    known = [(str(n), mean) for n, mean in mapped if n in places]
    figures: dict[str, Any] = {
        "rms": None,
        "aligned_rms": None,
        "count": len(mapped),
        "false": len(mapped) - len(known),
    }
    if known:
        truth = np.array([places[n] for n, _ in known])
        raw, aligned = metrics.landmark_errors(truth, np.array([mean for _, mean in known]))
        figures["rms"], figures["aligned_rms"] = (float(np.sqrt(np.mean(e**2))) for e in (raw, aligned))
        figures["max"], figures["aligned_max"] = float(np.max(raw)), float(np.max(aligned))
        figures["each"], figures["aligned_each"] = (
            {n: float(e) for (n, _), e in zip(known, errors, strict=True)} for errors in (raw, aligned)
        )
    return figures


def last_map(world: World, track: Track) -> tuple[dict[str, tuple[float, float]], list[tuple[Any, Array]]]:
    """Return the position of each fixed beacon by name [m], and (name, mean (2,) [m]) of each landmark at the end."""
    everything = tuple(hung(world))
    places = {item.beacon.name: (item.place.x, item.place.y) for item in everything if item.fixed}
    moving = {item.beacon.name for item in everything if not item.fixed}
    last = track.landmarks.mean[-1]
    mapped = [
        (n, last[k]) for k, n in enumerate(track.landmarks.names) if n not in moving and np.isfinite(last[k]).all()
    ]
    return places, mapped


def _module_times(recording: Recording) -> dict[str, dict[str, float]]:
    """Return mean and 99 % quantile of the wall-clock time of each module and part of the loop, and of a tick [ms]."""
    times = {name: seconds for name, seconds in recording.module_seconds.items() if np.isfinite(seconds).any()}
    if times:
        times["tick"] = np.nansum(list(times.values()), axis=0)
    return {
        name: {"mean": float(1e3 * np.nanmean(seconds)), "p99": float(1e3 * np.nanquantile(seconds, 0.99))}
        for name, seconds in times.items()
    }


def _period(recording: Recording) -> float:
    """Return the time from one tick to the next [s]."""
    if len(recording.time) > 1:
        return float(np.median(np.diff(recording.time)))
    return 1.0 / recording.world.run.rate_hz


def _plain(value: Any) -> Any:
    """Return statistics as JSON values, with None for numbers that are not finite."""
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


RUN_PARTS = 10
"""Number of parts of a run."""
MAX_RECOVERED_ERROR = 0.5
"""A lifted robot is localised again when its position error stays below this [m]."""


def transient_errors(time: Array, position: Array, heading: Array) -> dict[str, list[float]]:
    """Return the mean errors in each tenth of a run; a run with fewer ticks has fewer parts.

    Args:
        time: Time of each tick, shape (N,) [s].
        position: Position errors, shape (N,) [m].
        heading: Absolute heading errors, shape (N,) [deg].

    Returns:
        `until_s`, the end of each part, `position_error_m` and `heading_error_deg`, its mean errors.
    """
    parts = np.array_split(np.arange(len(time)), min(RUN_PARTS, len(time)))
    return {
        "until_s": [float(time[rows[-1]]) for rows in parts],
        "position_error_m": [float(position[rows].mean()) for rows in parts],
        "heading_error_deg": [float(heading[rows].mean()) for rows in parts],
    }


def recoveries(time: Array, position: Array, lifted: Sequence[float]) -> list[dict[str, Any]]:
    """Return the time that the estimate took to recover after each lift.

    Args:
        time: Time of each tick, shape (N,) [s].
        position: Position errors, shape (N,) [m].
        lifted: Times of the lifts [s].

    Returns:
        One for each lift: `time_s`, and `after_s`, the time from the lift after which the error stayed below 0.5 m
        until the next lift or the end; None if it never did.
    """
    found = []
    for start, end in zip(lifted, [*lifted, np.inf][1:], strict=True):
        rows = (time >= start) & (time < end)
        times, lost = time[rows], np.flatnonzero(position[rows] > MAX_RECOVERED_ERROR)
        first = int(lost[-1]) + 1 if len(lost) else 0
        found.append({"time_s": start, "after_s": float(times[first]) - start if first < len(times) else None})
    return found


CELL_SIDE, MAX_CELLS = 0.01, 4_000_000
"""Side of a cell of the raster [m], and its maximum number of cells, above which cells are larger."""
STEP, TURN = 0.02, math.radians(3.0)
"""Poses nearer than this to the previous one are left out [m, rad]; the area between two poses is swept too."""
FRACTION_BITS = 8
"""Bits of a fraction of a cell in the drawing of polygons."""


def swept_share(world: World, robot: Robot, poses: Array) -> float | None:
    """Return the share of the reachable area that the robot's footprint has swept.

    Args:
        world: Its world.
        robot: The robot.
        poses: x, y, heading of the robot over time, shape (N, 3) [m, rad]; the first is its start.

    Returns:
        In [0, 1]; None in a world without walls. The reachable area is where the robot can drive from its start with
        its centre and a margin of 0.15 m; `coverage` counts cells of 0.5 m of it that the footprint has touched.
    """
    import cv2
    import shapely

    region = reachable_region(world, poses[:, :2], radius=robot.body.radius)
    if region is None or not region.area:
        return None
    west, south, east, north = region.bounds
    cell = max(CELL_SIDE, math.sqrt((east - west) * (north - south) / MAX_CELLS))
    shape = (math.ceil((north - south) / cell), math.ceil((east - west) / cell))
    reachable, swept = np.zeros(shape, dtype=np.uint8), np.zeros(shape, dtype=np.uint8)

    def pixels(points: Any) -> Any:
        # The centre of the first cell is at half a cell.
        return np.round(((points - (west, south)) / cell - 0.5) * 2**FRACTION_BITS).astype(np.int32)

    def fill(ring: Any, value: int) -> None:
        # OpenCV also fills the cells that a polygon's outline touches, half a cell too much.
        for part in shapely.get_parts(shapely.Polygon(ring).buffer(-cell / 2)):
            cv2.fillPoly(reachable, [pixels(np.array(part.exterior.coords))], value, shift=FRACTION_BITS)

    for part in shapely.get_parts(region):
        fill(part.exterior, 1)
        for hole in part.interiors:
            fill(hole, 0)
    outline = shapely.Polygon(robot.body.outline()).buffer(-cell / 2, join_style="mitre").exterior.coords
    corners = [_placed(np.array(outline), pose) for pose in _thinned(poses)]
    for before, after in zip(corners, corners[1:] or corners, strict=False):
        hull = cv2.convexHull(np.concatenate([before, after]).astype(np.float32))[:, 0]
        cv2.fillConvexPoly(swept, pixels(hull), 1, shift=FRACTION_BITS)
    return float((swept & reachable).sum() / reachable.sum()) if reachable.any() else None


def _thinned(poses: Array) -> Array:
    """Return poses without those that hardly differ from the one before."""
    kept = [0]
    for number, (x, y, heading) in enumerate(poses):
        x0, y0, heading0 = poses[kept[-1]]
        if math.hypot(x - x0, y - y0) > STEP or abs(heading - heading0) > TURN:
            kept.append(number)
    return poses[[*kept, len(poses) - 1]]


def _placed(outline: Array, pose: Array) -> Array:
    c, s = math.cos(pose[2]), math.sin(pose[2])
    return np.asarray(outline @ np.array([[c, s], [-s, c]]) + pose[:2])
