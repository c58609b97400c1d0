"""Filter by filter: a prediction and an update, and whole estimators on one run."""

import functools
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager

import numpy as np
from threadpoolctl import threadpool_limits

from mjsim.algorithms.constant import ConstantCommand
from mjsim.algorithms.ekf_slam.ekf_slam import EkfSlam, EkfSlamFilter, InvariantEkfSlamFilter, odometry_motion
from mjsim.algorithms.fastslam import FastSlam
from mjsim.algorithms.filterpy_slam import FilterpySlam
from mjsim.algorithms.lidar_slam import LidarSlam
from mjsim.algorithms.localization import EkfLocalization, UkfLocalization
from mjsim.algorithms.monte_carlo import MonteCarloLocalization
from mjsim.bench.figure import Clock, Figure, Once, Prepare
from mjsim.bench.scenes import gallery
from mjsim.interface import BeaconInfo, Estimator, Observation, RobotInfo, TakesMap, WorldMap
from mjsim.run import Driver, ticks
from mjsim.sim import Simulation
from mjsim.world import format_world, parse_world

SEEN = 10
"""Sightings an update."""
UPDATES = 150
"""Ticks of the run that estimators are given."""
SENSORS = (
    "{beacons: ring, rate_hz: 12.5, noise: {range: 0.05, bearing_deg: 1}}, {lidar: scan, beams: 180, rate_hz: 12.5}"
)


def filter_time(make: Callable[[], EkfSlamFilter], landmarks: int) -> Prepare:
    """Measure one predict and one update with 10 sightings, on one BLAS thread [ms]."""

    @contextmanager
    def prepare() -> Iterator[Once]:
        rng = np.random.default_rng(0)
        places = rng.uniform(-10.0, 10.0, (landmarks, 2))
        slam, motion = make(), odometry_motion()
        noise = np.diag([0.01, 0.01]) ** 2
        times = 50 if landmarks < 1000 else 10

        def look(names: np.ndarray) -> None:
            ahead = places[names]
            z = np.column_stack([np.hypot(*ahead.T), np.arctan2(ahead[:, 1], ahead[:, 0])])
            slam.update(names.tolist(), z, noise)

        look(np.arange(landmarks))

        def once(clock: Clock) -> float:
            with threadpool_limits(1, user_api="blas"):
                began = clock()
                for _ in range(times):
                    slam.predict(motion, np.zeros(3), np.eye(3) * 1e-6)
                    look(rng.choice(landmarks, SEEN, replace=False))
                return 1e3 * (clock() - began) / times

        yield once

    return prepare


@functools.cache  # One run for all estimators.
def observed() -> tuple[RobotInfo, Mapping[str, BeaconInfo], WorldMap | None, tuple[Observation, ...]]:
    """Return what a robot of the gallery is told as it drives a circle, with its beacons and its map."""
    world = gallery()
    bare = format_world(
        world.model_copy(update={"robots": (), "run": world.run.model_copy(update={"drivers": {}, "map": "known"})})
    )
    robot = f"{{name: scout, preset: pioneer3dx, at: [2.7, 1.9], sensors: [{SENSORS}]}}"
    with Simulation(parse_world(f"{bare}\nrobots: [{robot}]\n")) as sim:
        loop = ticks(sim, {"scout": Driver(navigator=ConstantCommand(forward=0.3, turn=0.4))})
        seen = tuple(next(loop).seen["scout"] for _ in range(UPDATES))
        return sim.robots["scout"], dict(sim.catalogue), sim.map, seen


def estimator_time(make: Callable[[], Estimator]) -> Prepare:
    """Measure an update of an estimator, mean over a run [ms]."""

    @contextmanager
    def prepare() -> Iterator[Once]:
        robot, catalogue, known, seen = observed()

        def once(clock: Clock) -> float:
            estimator = make()
            if isinstance(estimator, TakesMap):
                estimator.take_map(known)
            estimator.start(robot, catalogue, np.random.default_rng(0))
            with threadpool_limits(1, user_api="blas"):
                began = clock()
                for each in seen:
                    estimator.update(each)
                return 1e3 * (clock() - began) / len(seen)

        yield once

    return prepare


def _first_estimates() -> EkfSlamFilter:
    return EkfSlamFilter(jacobians="first-estimates")


ESTIMATORS: Mapping[str, Callable[[], Estimator]] = {
    "ekf-slam": EkfSlam,
    "fastslam": FastSlam,
    "filterpy-slam": FilterpySlam,
    "lidar-slam": LidarSlam,
    "ekf-localization": EkfLocalization,
    "ukf-localization": UkfLocalization,
    "monte-carlo": MonteCarloLocalization,
}
PREDICT_AND_UPDATE = "ms a predict and update"
FILTER_FIGURES = (
    *(Figure(f"filter-{n}", PREDICT_AND_UPDATE, filter_time(_first_estimates, n)) for n in (10, 100, 1000)),
    Figure("filter-100-standard", PREDICT_AND_UPDATE, filter_time(EkfSlamFilter, 100)),
    Figure("filter-100-invariant", PREDICT_AND_UPDATE, filter_time(InvariantEkfSlamFilter, 100)),
    *(Figure(name, "ms an update", estimator_time(make)) for name, make in ESTIMATORS.items()),
)
