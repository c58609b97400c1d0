"""One run of a sweep, on whichever machine: a world file and a job in, an outcome out."""

import functools
import os
import random
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from mjsim.errors import ModuleFault, PhysicsFault, UsageError
from mjsim.record import Recording, Track
from mjsim.report import metrics
from mjsim.report.statistics import statistics_file
from mjsim.run import run
from mjsim.sweep.modules import INSTALLED
from mjsim.sweep.plan import Job
from mjsim.world import World, load_world
from mjsim.world.settings import with_settings

MOST_POINTS = 400
"""Points of a series over time that are kept of each run."""
THREADS = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1", "LP_NUM_THREADS": "1"}
"""What keeps a worker on one core: BLAS, and OpenGL drawn in software."""

Outcome = dict[str, Any]
"""What becomes of a job, fit for JSON: `case`, `seed`, `error` (None when all went well), `run` and `robots` as in
statistics.json, `series` (by robot: time, nees, position_error_m, odometry_error_m), `clock` (wall-clock figures)."""


def run_job(world_file: Path, job: Job, *, record: Path) -> Outcome:
    """Run a job and return its outcome; what fails by the fault of a module or of physics is an outcome, too.

    Args:
        world_file: Of the unpacked bundle.
        job: What to run.
        record: Where the recording goes.

    Raises:
        MjsimError: What would fail every run on this machine: no way to draw pictures, no room for the recording.
    """
    from mjsim.sim import Simulation

    settle()
    began = time.perf_counter()
    outcome = empty_outcome(job)
    _seed_the_rest(job.seed)
    try:
        with _own_modules(world_file.parent), Simulation(_world(world_file, job.settings), seed=job.seed) as sim:
            recording = run(sim, seconds=job.seconds, record=record)
        outcome |= _figures(recording)
    except (ModuleFault, PhysicsFault, UsageError) as error:
        outcome["error"] = str(error)
    except SystemExit as error:
        outcome["error"] = f"a module ended the program with exit code {error.code}"
    outcome["clock"]["total_seconds"] = time.perf_counter() - began
    return outcome


def empty_outcome(job: Job, *, error: str | None = None) -> Outcome:
    """Return the outcome of a job that gave no figures."""
    return {"case": job.case, "seed": job.seed, "error": error, "run": {}, "robots": {}, "series": {}, "clock": {}}


def died(job: Job, times: int) -> Outcome:
    """Return the outcome of a job that no process survived; it is not kept, and so tried again the next time."""
    return empty_outcome(job, error=f"its process died {times} times") | {"died": True}


@functools.cache  # A fact of the process.
def settle() -> None:
    """Keep this process to one core; what else runs here are other workers."""
    os.environ |= THREADS
    cv2.setNumThreads(1)
    # The folder of a bundle holds what the sweep was made of and nothing else.
    sys.dont_write_bytecode = True


@functools.lru_cache(maxsize=1)  # Runs of a case follow each other, and a world is never changed.
def _world(world_file: Path, settings: tuple[str, ...]) -> World:
    return with_settings(load_world(world_file), settings)


def _seed_the_rest(seed: int) -> None:
    """Begin the generators that modules should not use, but do, the same in every run."""
    random.seed(seed)
    np.random.seed(seed % 2**32)  # noqa: NPY002 - it is this one that such modules use
    cv2.setRNGSeed(seed % 2**31)


@contextmanager
def _own_modules(folder: Path) -> Iterator[None]:
    """Let the user's modules be imported in the block, and found as new by the next run, whatever it is of."""
    folder = folder.resolve()
    path, known = list(sys.path), set(sys.modules)
    sys.path.append(str(folder / INSTALLED))
    try:
        yield
    finally:
        sys.path[:] = path
        for name in set(sys.modules).difference(known):
            file = getattr(sys.modules[name], "__file__", None)
            if file is not None and Path(file).is_relative_to(folder):
                del sys.modules[name]


def _figures(recording: Recording) -> Outcome:
    figures = statistics_file(recording)
    clock = {key: figures["run"].pop(key) for key in ("wall_seconds", "real_time_factor", "milliseconds")}
    series = {name: _series(track) for name, track in recording.robots.items() if np.isfinite(track.estimate).all()}
    return {**figures, "series": series, "clock": clock}


def _series(track: Track) -> dict[str, list[float | None]]:
    """Return NEES and errors over time, at no more than MOST_POINTS ticks."""
    rows = slice(None, None, -(-len(track.time) // MOST_POINTS))
    truth, estimate = track.truth[rows], track.estimate[rows]
    columns = {
        "time": track.time[rows],
        "nees": metrics.normalised_errors(truth, estimate, track.covariance[rows]),
        "position_error_m": metrics.position_errors(truth, estimate),
        "odometry_error_m": metrics.position_errors(truth, track.odometry[rows]),
    }
    return {name: [float(x) if np.isfinite(x) else None for x in values] for name, values in columns.items()}
