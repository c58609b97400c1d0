"""The five classic experiments: each records a shipped world of `worlds/classic`, and evaluates the recording."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib import resources
from pathlib import Path
from types import MappingProxyType

import numpy as np
from threadpoolctl import threadpool_limits

from mjsim.errors import UsageError, did_you_mean
from mjsim.experiments import experiment_plots as plots
from mjsim.experiments.experiment_page import FILES, finished, write_page
from mjsim.experiments.finding import Result, at_least, at_most, exactly, within
from mjsim.experiments.offline import triangulated
from mjsim.geometry import Array
from mjsim.output import free_paths
from mjsim.record import Recording, Track
from mjsim.report import STATES, chi_square_bounds, metrics, statistics
from mjsim.run import drivers_of, run, ticks
from mjsim.sim import Simulation
from mjsim.world import World, load_world, solid

ROBOT = "scout"
"""Name of the robot in every classic world."""
MONTE_CARLO_RUNS = 20
"""Number of runs for checking whether errors are as large as predicted."""
CORNER_SIDE = 0.5
"""Side of the square in each corner of the room that a robot with full coverage touches [m]."""

Progress = Callable[[str, float], None]
"""Called with the name of the current experiment and its progress, 0 to 1."""


def bump(recording: Recording) -> Result:
    """Evaluate a robot that drives into a wall: it bumps, stops, turns back and forth, and passes through nothing."""
    track = recording.robots[ROBOT]
    first = next((event.time for event in track.events if event.kind == "bump"), np.inf)
    after = track.truth[track.time > first + 1.0]
    travel = np.hypot(*(after[:, :2] - after[:1, :2]).T) if len(after) else np.array([np.inf])
    turned = np.ptp(np.unwrap(after[:, 2])) if len(after) else 0.0
    return Result(
        name="bump",
        title="1. Into the wall",
        question="Avoidance off, commanded only to drive forward: what does the robot do?",
        findings=(
            at_least("bumps", sum(event.kind == "bump" for event in track.events), 1),
            at_most("distance travelled after the bump [m]", travel.max(), 0.05),
            at_least("turns back and forth by [deg]", np.degrees(turned), 1.0),
            at_most("deepest penetration of a wall [m]", _deepest(recording), 0.005),
        ),
        pictures=(
            plots.path_plot("bump", "The path into the wall", recording),
            plots.wriggling("bump", "Speed and heading: it stops, and turns back and forth", track, first),
        ),
    )


def odometry(recording: Recording, repeats: tuple[Array, Array, Array]) -> Result:
    """Evaluate whether the error of dead reckoning grows as its covariance predicts.

    Args:
        recording: Recording of one run.
        repeats: Truth (R, N, 3), estimate (R, N, 3) and covariance (R, N, 3, 3) of R runs with other seeds.
    """
    truth, estimate, covariance = repeats
    runs, rows = truth.shape[:2]
    nees = metrics.normalised_errors(
        truth.reshape(-1, 3), estimate.reshape(-1, 3), covariance.reshape(-1, 3, 3)
    ).reshape(runs, rows)
    low, high = chi_square_bounds(STATES, count=runs)
    mean = nees[:, rows // 20 :].mean(axis=0)
    error = np.sqrt(np.mean(np.sum((estimate - truth)[..., :2] ** 2, axis=-1), axis=0))
    sigma = np.sqrt(np.mean(covariance[..., 0, 0] + covariance[..., 1, 1], axis=0))
    quarter = rows // 4
    return Result(
        name="odometry",
        title="2. Odometry alone",
        question="No beacons: do the error and its predicted covariance grow together?",
        findings=(
            at_least("error at the end, relative to that after a quarter", error[-1] / error[quarter], 1.5),
            at_least(
                "predicted deviation at the end, relative to that after a quarter", sigma[-1] / sigma[quarter], 1.5
            ),
            within("error at the end, relative to the predicted deviation", error[-1] / sigma[-1], 0.7, 1.3),
            at_least(
                f"fraction of time when the NEES of {runs} runs is in its 95 % band", _share(mean, low, high), 0.8
            ),
        ),
        pictures=(
            plots.path_plot("odometry", "Dead-reckoned and true path, with 95 % ellipses", recording),
            plots.growth("odometry", f"Error of {runs} runs, and prediction", recording.time, repeats),
        ),
    )


def avoidance(recording: Recording) -> Result:
    """Evaluate whether a robot commanded to drive straight ahead gets everywhere without a bump."""
    track = recording.robots[ROBOT]
    figures = statistics(recording)[ROBOT]
    return Result(
        name="avoidance",
        title="3. Avoidance",
        question="Avoidance on, commanded only to drive forward: does it reach every corner without a bump?",
        findings=(
            at_least("minutes driven", track.time[-1] / 60.0, 10),
            exactly("bumps", figures["bumps"], 0),
            exactly("corners of the room that it reached", _corners(recording.world, track), 4),
            at_least("cells of the reachable floor that it touched", figures["coverage"], 0.75),
            at_least("area of the reachable floor that it swept", figures["coverage_area"], 0.5),
        ),
        pictures=(plots.trail("avoidance", "The path in 15 minutes", recording),),
    )


def triangulation(recording: Recording) -> Result:
    """Evaluate the accuracy of positions triangulated from recorded pictures."""
    fixes = triangulated(recording, ROBOT, "front")
    errors = np.hypot(*(fixes.position - fixes.truth).T)
    return Result(
        name="triangulation",
        title="4. Triangulation",
        question="Recorded pictures, triangulated offline: how large is the position error?",
        findings=(
            at_least("positions triangulated", len(errors), 100),
            at_most("error, mean [m]", errors.mean(), 0.10),
            at_most("error, largest [m]", errors.max(), 0.50),
            exactly("pictures confused with another", fixes.wrong, 0),
        ),
        pictures=(
            plots.fixes("triangulation", "True and triangulated positions", recording, fixes),
            plots.fix_errors("triangulation", "Error of each position", fixes),
        ),
    )


def slam(recording: Recording) -> Result:
    """Evaluate localisation and mapping of a robot without prior knowledge of the room."""
    track, figures = recording.robots[ROBOT], statistics(recording)[ROBOT]
    errors = metrics.position_errors(track.truth, track.estimate)
    drift = metrics.position_errors(track.truth, track.odometry)
    last = track.time > 2.0 / 3.0 * track.time[-1]
    beacons = len(recording.world.beacons)
    return Result(
        name="slam",
        title="5. SLAM",
        question="Unknown room: does the robot localise itself and map the pictures on the walls?",
        findings=(
            at_most("position error, mean [m]", errors.mean(), 0.10),
            at_most("on the last lap, relative to odometry", errors[last].mean() / drift[last].mean(), 0.25),
            exactly("pictures in the map", figures["landmark_error_m"]["count"], beacons),
            at_most("error of the map, aligned [m]", figures["landmark_error_m"]["aligned_rms"], 0.05),
        ),
        pictures=(
            plots.path_plot("slam", "Overview: path and map, with 95 % ellipses", recording),
            plots.enlarged("slam", "Enlarged view: the robot and what it sees", recording),
            plots.transient("slam", "Transient localization error, with 3-sigma bounds", track),
        ),
    )


def _odometry_in_full(recording: Recording) -> Result:
    return odometry(recording, repeated(recording.world, MONTE_CARLO_RUNS))


EXPERIMENTS: Mapping[str, Callable[[Recording], Result]] = MappingProxyType(
    {
        "bump": bump,
        "odometry": _odometry_in_full,
        "avoidance": avoidance,
        "triangulation": triangulation,
        "slam": slam,
    }
)
"""Name -> function that evaluates a recording of `worlds/classic/NAME.yaml`."""


def run_experiments(
    folder: str | Path, *, only: Sequence[str] = (), progress: Progress | None = None, overwrite: bool = False
) -> tuple[Result, ...]:
    """Run the classic experiments, and write a page with their findings, plots and recordings after each.

    If the folder has such a page, experiments on it are not run again, and the others are added.

    Args:
        folder: Output folder for `index.html`, `results.json`, and a folder per experiment; created if necessary.
        only: Names of the experiments to run; by default all.
        progress: Called with the progress.
        overwrite: Whether the files of earlier runs may be replaced.

    Raises:
        UsageError: The experiment does not exist, or a file exists or cannot be written.
        MjsimError: A run failed.
    """
    for name in only:
        if name not in EXPERIMENTS:
            raise UsageError(f"no experiment '{name:.40}'{did_you_mean(name, EXPERIMENTS)}")
    place, chosen = Path(folder), only or list(EXPERIMENTS)
    done = {} if overwrite else finished(place)
    if done is None:
        free_paths(folder, [*FILES, *(f"{name}/run.mcap" for name in chosen)], overwrite=overwrite)
    results = dict(done or {})
    write_page(place, list(results.values()), overwrite=overwrite or done is not None)
    for name in chosen:
        if name not in results:
            record = place / name / "run.mcap"
            record.parent.mkdir(parents=True, exist_ok=True)
            results[name] = EXPERIMENTS[name](recorded(name, record, progress, overwrite=True))
            write_page(place, [results[each] for each in EXPERIMENTS if each in results], overwrite=True)
    return tuple(results[name] for name in chosen)


def recorded(name: str, path: Path, progress: Progress | None = None, *, overwrite: bool = False) -> Recording:
    """Run the world of an experiment and return the recording."""
    with classic_world(name) as world, Simulation(world) as sim:
        return run(
            sim,
            record=path,
            overwrite=overwrite,
            progress=False,
            watch=None if progress is None else lambda tick: progress(name, tick.time / world.run.seconds),
        )


def repeated(world: World, runs: int) -> tuple[Array, Array, Array]:
    """Run a world with other seeds, without recording.

    Returns:
        Truth (runs, N, 3), estimate (runs, N, 3), and its covariance (runs, N, 3, 3).
    """
    rows: list[list[tuple[Array, Array, Array]]] = []
    with Simulation(world) as sim, threadpool_limits(1, user_api="blas"):
        for seed in range(2, runs + 2):
            sim.reset(seed)
            rows.append([])
            for tick in ticks(sim, drivers_of(world)):
                if tick.time >= world.run.seconds:
                    break
                belief = tick.orders[ROBOT].estimate
                rows[-1].append((tick.truth[ROBOT].as_array(), belief.pose.as_array(), belief.covariance))
    truth, estimate, covariance = (np.array([[row[k] for row in each] for each in rows]) for k in range(3))
    return truth, estimate, covariance


@contextmanager
def classic_world(name: str) -> Iterator[World]:
    """Yield the shipped world of an experiment."""
    with resources.as_file(resources.files("mjsim.worlds") / "classic" / f"{name}.yaml") as path:
        yield load_world(path)


def _deepest(recording: Recording) -> float:
    """Return the maximum penetration of a round body into anything solid [m]; 0 if there was none."""
    import shapely

    radius = recording.world.robots[0].body.radius
    distances = shapely.distance(solid(recording.world), shapely.points(recording.robots[ROBOT].truth[:, :2]))
    return float(max(0.0, radius - distances.min()))


def _corners(world: World, track: Track) -> int:
    """Return the number of corners of the room's outer wall that the robot's body touched."""
    import shapely

    corners, half = np.array(world.walls[0].points), world.walls[0].thickness / 2.0
    (west, south), (east, north) = corners.min(axis=0) + half, corners.max(axis=0) - half
    swept = shapely.LineString(track.truth[:, :2]).buffer(world.robots[0].body.radius)
    squares = [
        shapely.box(x, y, x + CORNER_SIDE, y + CORNER_SIDE)
        for x in (west, east - CORNER_SIDE)
        for y in (south, north - CORNER_SIDE)
    ]
    return sum(bool(swept.intersects(square)) for square in squares)


def _share(values: Array, low: float, high: float) -> float:
    return float(np.mean((values >= low) & (values <= high)))
