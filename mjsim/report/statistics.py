"""A recording -> the figures of `statistics.json`."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from mjsim.geometry import Array
from mjsim.record import Recording, Track
from mjsim.report import metrics
from mjsim.report.coverage import coverage
from mjsim.world import World
from mjsim.world.events import MoveEvent
from mjsim.world.hung import hung

ESTIMATE_FIGURES = (
    "position_error_m",
    "odometry_error_m",
    "heading_error_deg",
    "ate_m",
    "rpe_m",
    "nees",
    "nis",
    "landmark_error_m",
)
"""Keys of the figures that need an estimate."""


def statistics(recording: Recording) -> dict[str, Any]:
    """Return the figures of each robot by its name, and those of the run under 'run'.

    The keys are those of `statistics.json`, which holds the robots one level down, under 'robots'.
    """
    figures = statistics_file(recording)
    return {**figures["robots"], "run": figures["run"]}


def statistics_file(recording: Recording) -> dict[str, Any]:
    """Return what `statistics.json` holds: {"run": {...}, "robots": {name: {...}}}."""
    seconds = float(recording.time[-1] - recording.time[0]) + _period(recording.time)
    return {
        "run": {
            "world": recording.world.name,
            "seed": recording.seed,
            "sim_seconds": seconds,
            "wall_seconds": recording.wall_seconds,
            "real_time_factor": seconds / recording.wall_seconds if recording.wall_seconds > 0.0 else None,
            "milliseconds": _module_times(recording),
        },
        "robots": {
            name: robot_statistics(recording.world, name, track, lifted=_lifted(recording, name))
            for name, track in recording.robots.items()
        },
    }


def robot_statistics(world: World, name: str, track: Track, *, lifted: Sequence[float] = ()) -> dict[str, Any]:
    """Return the figures of one robot; those of an estimate are None for a robot that nothing drove.

    Args:
        world: Where it was.
        name: Of the robot.
        track: What was recorded of it.
        lifted: When it was put down elsewhere [s]: it did not drive there, but its error goes on being counted.
    """
    steps = np.linalg.norm(np.diff(track.truth[:, :2], axis=0), axis=1)
    steps[np.isin(track.time[1:], lifted)] = 0.0
    radius = next(robot.body.radius for robot in world.robots if robot.name == name)
    believed = np.isfinite(track.estimate).all()
    return {
        **(_estimate_figures(world, track) if believed else dict.fromkeys(ESTIMATE_FIGURES)),
        "distance_m": float(steps.sum()),
        "coverage": coverage(world, track.truth[:, :2], radius=radius),
        "bumps": sum(event.kind == "bump" for event in track.events),
    }


def _lifted(recording: Recording, name: str) -> list[float]:
    return [event.time for event in recording.events if isinstance(event, MoveEvent) and event.move == name]


def _estimate_figures(world: World, track: Track) -> dict[str, Any]:
    """Return the figures under the keys of ESTIMATE_FIGURES."""
    figures = (
        metrics.summary(metrics.position_errors(track.truth, track.estimate)),
        metrics.summary(metrics.position_errors(track.truth, track.odometry)),
        metrics.summary(np.degrees(metrics.heading_errors(track.truth, track.estimate))),
        _spread(metrics.absolute_trajectory_errors(track.truth, track.estimate)),
        _spread(metrics.relative_pose_errors(track.truth, track.estimate)),
        nees_figures(metrics.normalised_errors(track.truth, track.estimate, track.covariance)),
        _nis(track),
        landmark_figures(world, track),
    )
    return dict(zip(ESTIMATE_FIGURES, figures, strict=True))


def nees_figures(nees: Array) -> dict[str, Any]:
    """Return mean, share in the 95 % band of chi-square (3), and how many ticks had a singular covariance."""
    regular = nees[np.isfinite(nees)]
    low, high = metrics.CHI_SQUARE_95[3]
    return {
        "mean": float(regular.mean()) if len(regular) else None,
        "in_band": float(np.mean((regular >= low) & (regular <= high))) if len(regular) else None,
        "singular": int(len(nees) - len(regular)),
    }


def landmark_figures(world: World, track: Track) -> dict[str, Any]:
    """Return errors of the last map against where the beacons hang; `false` counts names that hang nowhere.

    Beacons on robots and on what moves have no place that a map could hold, and are left out.
    """
    places = {item.beacon.name: (item.place.x, item.place.y) for item in hung(world) if item.fixed}
    moving = {item.beacon.name for item in hung(world) if not item.fixed}
    last = track.landmarks.mean[-1]
    mapped = [
        (n, last[k]) for k, n in enumerate(track.landmarks.names) if n not in moving and np.isfinite(last[k]).all()
    ]
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
        figures["aligned_max"] = float(np.max(aligned))
        figures["aligned_each"] = {n: float(e) for (n, _), e in zip(known, aligned, strict=True)}
    return figures


def _nis(track: Track) -> dict[str, Any]:
    values = [metrics.normalised_innovation(nu, S) for tick in track.innovations for _, nu, S in tick]
    return {"mean": float(np.mean(values)) if values else None, "count": len(values)}


def _spread(errors: Array) -> dict[str, float | None]:
    if not len(errors):
        return {"rmse": None, "mean": None, "median": None, "max": None, "min": None, "std": None}
    return {
        "rmse": float(np.sqrt(np.mean(errors**2))),
        "mean": float(errors.mean()),
        "median": float(np.median(errors)),
        "max": float(np.max(errors)),
        "min": float(np.min(errors)),
        "std": float(errors.std()),
    }


def _module_times(recording: Recording) -> dict[str, dict[str, float]]:
    """Return mean and 99 % quantile of the wall-clock time of each module and part of the loop [ms]."""
    return {
        name: {"mean": float(1e3 * np.nanmean(times)), "p99": float(1e3 * np.nanquantile(times, 0.99))}
        for name, times in recording.module_seconds.items()
        if np.isfinite(times).any()
    }


def _period(times: Array) -> float:
    return float(np.median(np.diff(times))) if len(times) > 1 else 0.0
