"""A sweep from its plan to its tables and plots."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from operator import index
from pathlib import Path
from typing import Any

import numpy as np

from mjsim.errors import UsageError, did_you_mean
from mjsim.modules import load_runnable, require_modules
from mjsim.progress import say
from mjsim.report import require_formats
from mjsim.sweep.bundle import bundle_of
from mjsim.sweep.cluster import run_on_cluster
from mjsim.sweep.pool import run_on_processes, usable_cores
from mjsim.sweep.results import Sweep, write_results
from mjsim.sweep.store import Store
from mjsim.sweep.sweep_plan import SweepPlan
from mjsim.world import World, with_settings


def sweep(
    world: World | str | Path,
    *,
    seeds: Iterable[int],
    folder: str | Path,
    settings: Mapping[str, Sequence[Any]] | None = None,
    seconds: float | None = None,
    robot: str | None = None,
    workers: int | None = None,
    dask: str | None = None,
    keep: bool = False,
    formats: Sequence[str] = ("png",),
    progress: Callable[[float], None] | None = None,
) -> Sweep:
    """Run a world with many seeds and settings; return the table of all runs, and write it.

    The worker processes import the calling program, so it must keep its own code under `if __name__ == "__main__":`.

    Args:
        world: The world to simulate, or its file.
        seeds: One run each, in every case.
        folder: Destination of all files; an unfinished sweep in it is resumed.
        settings: Key of the world, such as 'robots.scout.odometry.noise.turn' -> its values; all combinations are run.
        seconds: Duration of each run, simulated [s]; by default that of the world.
        robot: The robot in the table; by default all robots.
        workers: Processes of this machine; by default one per core.
        dask: Address of the scheduler of a Dask cluster that runs it instead.
        keep: Whether to keep recordings, beside the results of each run.
        formats: Formats of the plots: 'png', 'pdf', 'svg'.
        progress: Called with the number of finished runs, at the start and after each.

    Raises:
        WorldError: The world is wrong.
        UsageError: A setting does not fit the world, or the folder holds another sweep.
    """
    world = world if isinstance(world, World) else load_runnable(world)
    plan = SweepPlan(
        seeds=tuple(map(index, seeds)),
        settings={key: _values(key, values) for key, values in (settings or {}).items()},
        seconds=seconds,
        robot=robot,
        keep=keep,
    )
    return run_plan(world, plan, Path(folder), workers=workers, dask=dask, formats=formats, progress=progress)


def run_plan(
    world: World,
    plan: SweepPlan,
    folder: Path,
    *,
    workers: int | None = None,
    dask: str | None = None,
    formats: Sequence[str] = ("png",),
    progress: Callable[[float], None] | None = None,
) -> Sweep:
    """Run the unfinished jobs of a plan in a folder; see `sweep`."""
    if workers is not None and workers < 1:
        raise UsageError(f"workers is {workers}; it must be at least 1")
    formats = require_formats(formats)
    robots = _robots(world, plan.robot)
    cases = list(_cases(world, plan))
    for case in cases:
        require_modules(case)
    if few := plan.too_few_seeds([robot.name for robot in world.robots if robot.base != "fixed"]):
        say(few)
    bundle = bundle_of(world, cases)
    store = Store(folder, plan.keep)
    with store.held():
        world_file = store.open(plan, bundle)
        jobs = list(plan.jobs())
        outcomes = {job: outcome for job in jobs if (outcome := store.outcome(job)) is not None}
        missing = [job for job in jobs if job not in outcomes]
        if progress is not None:
            progress(len(outcomes))
        if dask is not None:
            coming = run_on_cluster(dask, bundle, missing, store)
        else:
            coming = run_on_processes(world_file, missing, store, workers=workers or usable_cores())
        with closing(coming):
            for job, outcome in coming:
                outcomes[job] = outcome
                if not outcome.pop("died", False):
                    store.put(job, outcome)
                if progress is not None:
                    progress(len(outcomes))
        return write_results(store, plan, [outcomes[job] for job in jobs], robots, formats)


def _values(key: str, values: Sequence[Any]) -> tuple[Any, ...]:
    """Return the values of a setting, which may be an array, as Python values."""
    if isinstance(values, str):
        raise UsageError(f"the values of '{key}' are the text '{values}'; give them as a list")
    return tuple(value.item() if isinstance(value, np.generic) else value for value in values)


def _robots(world: World, requested: str | None) -> list[str]:
    """Return the names of the robots in the table."""
    names = [robot.name for robot in world.robots]
    if not names:
        raise UsageError(f"no robots in world '{world.name}'; a sweep needs at least one")
    if requested is not None and requested not in names:
        raise UsageError(f"no robot '{requested}' in this world{did_you_mean(requested, names)}")
    return names if requested is None else [requested]


def _cases(world: World, plan: SweepPlan) -> Iterator[World]:
    """Yield the world of each case, checked."""
    for case in plan.cases():
        changed = with_settings(world, case) if case else world
        changed.run.ticks(plan.seconds)
        yield changed
