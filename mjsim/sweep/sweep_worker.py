"""Executes one run of a sweep on any machine: from a world file and a job to an outcome."""

import time
from pathlib import Path
from typing import Any

import numpy as np

from mjsim.errors import ModuleFault, PhysicsFault, UsageError
from mjsim.geometry import Array
from mjsim.progress import say
from mjsim.record import Recording, Track
from mjsim.report import metrics, statistics_file
from mjsim.run import run
from mjsim.sweep.bench import bench, own_modules, seed_the_rest, settle
from mjsim.sweep.sweep_plan import Job

MAX_POINTS = 400
"""Maximum number of points of a time series kept for each run."""
Outcome = dict[str, Any]
"""Outcome of a job, as JSON values: `case`, `seed`, `error` (None on success), `run` and `robots` as in
statistics.json, `series` (by robot: time, nees, position_error_m, odometry_error_m, true and estimated x and y, and
whether an estimator gave the estimate), `clock` (wall-clock times)."""


def run_job(world_file: Path, job: Job, *, record: Path, pictures: bool) -> Outcome:
    """Run a job and return its outcome; failures of modules or physics are outcomes, too.

    Args:
        world_file: World of the unpacked bundle.
        job: The job.
        record: Path of the recording.
        pictures: Whether to record camera pictures; the results do not need them.

    Raises:
        MjsimError: A problem would fail every run on this machine: no OpenGL, no space for the recording.
    """
    from mjsim.toolbox import figures_told

    settle()
    began = time.perf_counter()
    outcome = empty_outcome(job)
    seed_the_rest(job.seed)
    try:
        with (
            own_modules(world_file.parent),
            bench().simulation(world_file, job) as sim,
            figures_told(sim.world.run, record.with_name(f"{job.name}.mcap"), overwrite=True, tell=_tell),
        ):
            recording = run(sim, seconds=job.seconds, record=record, pictures=pictures, progress=False)
        outcome |= _figures(recording)
    except (ModuleFault, PhysicsFault, UsageError) as error:
        outcome["error"] = str(error)
    outcome["clock"]["total_seconds"] = time.perf_counter() - began
    return outcome


def _tell(line: str) -> None:
    """Show what of a figure of a module could not be drawn; names of files are known."""
    if not Path(line).is_file():
        say(line)


def empty_outcome(job: Job, *, error: str | None = None) -> Outcome:
    """Return the outcome of a job without results."""
    return {"case": job.case, "seed": job.seed, "error": error, "run": {}, "robots": {}, "series": {}, "clock": {}}


def died(job: Job, times: int) -> Outcome:
    """Return the outcome of a job whose processes died; it is not stored, so a resumed sweep tries again."""
    return empty_outcome(job, error=f"its process died {times} times") | {"died": True}


def _figures(recording: Recording) -> Outcome:
    figures = statistics_file(recording)
    clock = {key: figures["run"].pop(key) for key in ("wall_seconds", "real_time_factor", "milliseconds")}
    series = {
        name: {**_series(track, estimated=recording.has_estimator(name)), "estimated": recording.has_estimator(name)}
        for name, track in recording.robots.items()
        if np.isfinite(track.estimate).all()
    }
    return {**figures, "series": series, "clock": clock}


def _series(track: Track, *, estimated: bool) -> dict[str, Any]:
    """Return NEES, errors and paths over time, at MAX_POINTS ticks at most; dead reckoning has no NEES."""
    rows = slice(None, None, -(-len(track.time) // MAX_POINTS))
    truth, estimate = track.truth[rows], track.estimate[rows]
    columns = {
        "time": track.time[rows],
        "nees": metrics.normalised_errors(truth, estimate, track.covariance[rows])
        if estimated
        else np.full(len(truth), np.nan),
        "position_error_m": metrics.position_errors(truth, estimate),
        "odometry_error_m": metrics.position_errors(truth, track.odometry[rows]),
        **_path("truth", truth),
        **_path("estimate", estimate),
    }
    return {name: [float(x) if np.isfinite(x) else None for x in values] for name, values in columns.items()}


def _path(name: str, poses: Array) -> dict[str, Array]:
    """Return x and y [m]; a tenth of a millimetre is enough for a drawing, and keeps the file of a run small."""
    return {f"{name}_{axis}_m": np.round(poses[:, column], 4) for column, axis in enumerate("xy")}
