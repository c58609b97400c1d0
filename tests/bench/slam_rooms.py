"""Rooms in which estimators are measured beside the textbook's: different shapes, sensors and noise."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.random import Generator

from mjsim.algorithms.ekf_slam.ekf_slam import EkfSlam
from mjsim.algorithms.textbook import TextbookEkfSlam
from mjsim.geometry import Array
from mjsim.interface import BeaconInfo, Estimate, Estimator, Observation, RobotInfo
from mjsim.record import Recording
from mjsim.report.metrics import absolute_trajectory_errors, normalised_errors, position_errors
from mjsim.run import drivers_of, replay, run
from mjsim.sim import Simulation
from mjsim.world import parse_world

ROBOT = "scout"


@dataclass(frozen=True, slots=True, kw_only=True)
class Room:
    """A world to record in, its robot being 'scout'."""

    text: str
    """The world."""
    nameless: bool = False
    """Whether estimators are kept from reading the names of beacons; the textbook is told them."""


def _reflectors(places: Iterable[tuple[float, float]]) -> str:
    return "\n".join(f"  - {{name: r{k}, at: [{x}, {y}]}}" for k, (x, y) in enumerate(places))


def _pictures(places: Iterable[tuple[str, float, float, float]]) -> str:
    return "\n".join(
        f"  - {{name: {name}, image: posters/{name}.jpg, at: [{x}, {y}], heading_deg: {heading}}}"
        for name, x, y, heading in places
    )


def _world(
    name: str,
    corners: list[list[float]],
    beacons: str,
    *,
    at: tuple[float, float],
    sensor: str,
    points: list[list[float]],
    drive: str = "{speed: 0.02, turn: 0.05}",
    odometry: str = "{distance: 0.01, turn: 0.05}",
    seconds: int = 60,
    laps: int = 2,
    speed: float = 0.6,
    observer: str = "",
) -> str:
    return f"""mjsim: 1
name: {name}
walls:
  - {{points: {corners}, closed: true}}
beacons:
{beacons}
robots:
  - name: scout
    preset: pioneer3dx
    at: [{at[0]}, {at[1]}]
    drive: {{noise: {drive}}}
    odometry: {{noise: {odometry}}}
    sensors: [{sensor}]
run:
  seconds: {seconds}
  drivers:
    scout:
      {observer}
      navigator: {{use: "mjsim.algorithms.waypoints:Waypoints", points: {points}, laps: {laps}, speed: {speed}}}
"""


ROOMS = {
    "plain": Room(
        text=_world(
            "plain",
            [[0, 0], [10, 0], [10, 8], [0, 8]],
            _reflectors([(9.9, 1.5), (9.9, 6.5), (7, 7.9), (3, 7.9), (0.1, 6.5), (0.1, 1.5), (3, 0.1), (7, 0.1)]),
            at=(2, 2),
            sensor="{beacons: ring, fov_deg: 240, rate_hz: 5, noise: {range: 0.05, bearing_deg: 1}}",
            points=[[8, 2], [8, 6], [2, 6], [2, 2]],
        )
    ),
    # An L of corridors, there and back: few landmarks, one or two in view, seen again after a long way.
    "corridor": Room(
        text=_world(
            "corridor",
            [[0, 0], [16, 0], [16, 12], [13, 12], [13, 3], [0, 3]],
            _reflectors([(3.5, 0.1), (7.5, 2.9), (12, 0.1), (15.9, 4.5), (13.1, 8), (14.5, 11.9)]),
            at=(1.2, 1.5),
            sensor="{beacons: front, range: [0.3, 5], fov_deg: 180, rate_hz: 5, noise: {range: 0.03, bearing_deg: 1}}",
            points=[[14.5, 1.5], [14.5, 10.5], [14.5, 1.5], [1.5, 1.5]],
            odometry="{distance: 0.02, turn: 0.03}",
            seconds=85,
            laps=1,
        )
    ),
    # A hall of 24 landmarks, a noisy sensor that looks often and misses every fifth.
    "hall": Room(
        text=_world(
            "hall",
            [[0, 0], [18, 0], [18, 14], [0, 14]],
            _reflectors(
                [(2.5 + 2.6 * k, 0.1) for k in range(6)]
                + [(17.9, 2.0 + 2.0 * k) for k in range(6)]
                + [(2.5 + 2.6 * k, 13.9) for k in range(6)]
                + [(0.1, 2.0 + 2.0 * k) for k in range(6)]
            ),
            at=(3, 3),
            sensor="{beacons: ring, range: [0.3, 7], rate_hz: 12.5, missed: 0.2, noise: {range: 0.15, bearing_deg: 3}}",
            points=[[15, 3], [15, 11], [3, 11], [3, 3]],
            odometry="{distance: 0.02, turn: 0.05}",
            seconds=75,
            laps=1,
        )
    ),
    # A small room crossed from corner to corner: the robot turns on the spot again and again, fast.
    "turns": Room(
        text=_world(
            "turns",
            [[0, 0], [5, 0], [5, 5], [0, 5]],
            _reflectors([(4.9, 1.2), (3.6, 4.9), (0.1, 3.9), (1.3, 0.1), (4.9, 4.2)]),
            at=(1, 1),
            sensor="{beacons: front, fov_deg: 120, rate_hz: 5, noise: {range: 0.05, bearing_deg: 2}}",
            points=[[4, 4], [1, 4], [4, 1], [1, 1], [1, 4], [4, 4], [4, 1], [1, 1]],
            drive="{speed: 0.03, turn: 0.1}",
            odometry="{distance: 0.02, turn: 0.1}",
            seconds=75,
        )
    ),
    # Four landmarks far away in a large hall, always all in view, and odometry that is worse than usual.
    "far": Room(
        text=_world(
            "far",
            [[0, 0], [20, 0], [20, 15], [0, 15]],
            _reflectors([(19.9, 4), (13, 14.9), (0.1, 10), (6, 0.1)]),
            at=(4, 4),
            sensor="{beacons: ring, range: [0.3, 25], rate_hz: 5, noise: {range: 0.1, bearing_deg: 0.5}}",
            points=[[16, 4], [14, 11], [5, 10], [4, 4]],
            odometry="{distance: 0.03, turn: 0.08}",
            seconds=75,
            laps=1,
        )
    ),
    # The sensor does not know which reflector is which.
    "nameless": Room(
        nameless=True,
        text=_world(
            "nameless",
            [[0, 0], [12, 0], [12, 9], [8, 9], [8, 6], [4, 6], [4, 9], [0, 9]],
            _reflectors(
                [
                    *((2, 0.1), (4.5, 0.1), (7, 0.1), (10, 0.1), (11.9, 3), (11.9, 7), (10, 8.9)),
                    *((8.1, 7.5), (6, 5.9), (3.9, 7.5), (2, 8.9), (0.1, 6), (0.1, 3)),
                ]
            ),
            at=(2, 2),
            sensor="{beacons: ring, range: [0.3, 6], rate_hz: 5, missed: 0.1, noise: {range: 0.04, bearing_deg: 1}}",
            points=[[10, 2], [10, 7], [10, 3.5], [2, 3.5], [2, 7], [2, 2]],
            seconds=70,
            laps=1,
        ),
    ),
    # Ten pictures in a large room, none, one or two of them in view of a camera, which finds them by itself.
    "pictures": Room(
        text=_world(
            "pictures",
            [[0, 0], [10, 0], [10, 8], [0, 8]],
            _pictures(
                [
                    ("lion", 9.94, 1.2, 180),
                    ("owl", 9.94, 3.2, 180),
                    ("pear", 9.94, 6.4, 180),
                    ("castle", 8.4, 7.94, -90),
                    ("whale", 5.6, 7.94, -90),
                    ("moon", 2.2, 7.94, -90),
                    ("cactus", 0.06, 6.6, 0),
                    ("rocket", 0.06, 3.8, 0),
                    ("tulip", 1.4, 0.06, 90),
                    ("key", 4.6, 0.06, 90),
                ]
            ),
            at=(2, 2),
            sensor="{camera: front, at: [0.1, 0, 1.0], width: 640, height: 480, fov_deg: 60, rate_hz: 12.5, noise: 0}",
            points=[[8, 2], [8, 6], [2, 6], [2, 2]],
            observer='observer: {use: "mjsim.algorithms.beacon_vision:BeaconVision", camera: front}',
            seconds=60,
        )
    ),
    # The same pictures in a small room: the robot turns near them, and each turn costs more than a picture errs.
    "near pictures": Room(
        text=_world(
            "near-pictures",
            [[0, 0], [8, 0], [8, 6], [0, 6]],
            _pictures(
                [
                    ("lion", 7.94, 0.8, 180),
                    ("owl", 7.94, 2.4, 180),
                    ("pear", 7.94, 4.6, 180),
                    ("castle", 7.2, 5.94, -90),
                    ("whale", 5.6, 5.94, -90),
                    ("moon", 2.2, 5.94, -90),
                    ("cactus", 0.06, 5.2, 0),
                    ("rocket", 0.06, 3.6, 0),
                    ("tulip", 0.8, 0.06, 90),
                    ("key", 2.4, 0.06, 90),
                ]
            ),
            at=(1.5, 1.5),
            sensor="{camera: front, at: [0.1, 0, 1.0], width: 640, height: 480, fov_deg: 60, rate_hz: 12.5, noise: 0}",
            points=[[6.5, 1.5], [6.5, 4.5], [1.5, 4.5], [1.5, 1.5]],
            observer='observer: {use: "mjsim.algorithms.beacon_vision:BeaconVision", camera: front}',
            seconds=60,
        )
    ),
}
"""By name."""


def ekf_slam(room: Room, jacobians: Literal["standard", "first-estimates", "invariant"]) -> Estimator:
    """Return `EkfSlam` for a room, with the settings that a user has who sets nothing else."""
    if room.nameless:
        return Nameless(EkfSlam(jacobians=jacobians, association="joint"))
    return EkfSlam(jacobians=jacobians)


class Nameless:
    """Keeps the names of beacons from an estimator."""

    def __init__(self, estimator: Estimator) -> None:
        """Take the estimator."""
        self._estimator = estimator

    def start(self, robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], rng: Generator) -> None:
        """Start it."""
        self._estimator.start(robot, catalogue, rng)

    def update(self, seen: Observation) -> Estimate:
        """Return what it believes."""
        bare = tuple(replace(sighting, name=None) for sighting in seen.sightings)
        return self._estimator.update(replace(seen, sightings=bare))


class SideBySide:
    """Gives each observation to several estimators, and believes the first; keeps what each believed."""

    def __init__(self, estimators: Mapping[str, Estimator]) -> None:
        """Take them."""
        self._estimators = estimators

    def start(self, robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], rng: Generator) -> None:
        """Start them, each with chance of its own."""
        self.beliefs: dict[str, list[tuple[Array, Array]]] = {name: [] for name in self._estimators}
        for estimator, own in zip(self._estimators.values(), rng.spawn(len(self._estimators)), strict=True):
            estimator.start(robot, catalogue, own)

    def update(self, seen: Observation) -> Estimate:
        """Return what the first believes."""
        estimates = [estimator.update(seen) for estimator in self._estimators.values()]
        for kept, estimate in zip(self.beliefs.values(), estimates, strict=True):
            kept.append((estimate.pose.as_array(), np.array(estimate.covariance)))
        return estimates[0]


@dataclass(frozen=True, slots=True, kw_only=True)
class Score:
    """How well an estimator did in a recording."""

    error: float
    """Mean position error, not aligned [m]."""
    nees: float
    """Mean of x, y and heading; 3 is honest, more is too sure."""
    ate: float
    """Root mean square of the position error after rigid alignment [m]."""

    @classmethod
    def of(cls, truth: Array, beliefs: Sequence[tuple[Array, Array]]) -> "Score":
        """Return that of poses (3,) and their covariances (3, 3) where the truth (N, 3) is known."""
        known = np.isfinite(truth).all(axis=1)
        poses, covariances = (np.array(each)[known] for each in zip(*beliefs[: len(truth)], strict=True))
        nees = normalised_errors(truth[known], poses, covariances)
        return cls(
            error=float(position_errors(truth[known], poses).mean()),
            nees=float(np.nanmean(nees)),
            ate=float(np.sqrt(np.mean(absolute_trajectory_errors(truth[known], poses) ** 2))),
        )


def scores_in_room(room: Room, others: Mapping[str, Estimator], *, seed: int) -> dict[str, Score]:
    """Drive in a room on the estimate of the textbook; return its score and those of others that saw the same.

    Args:
        room: Where.
        others: By their names; the textbook is 'textbook'.
        seed: Of the run.
    """
    world, panel = parse_world(room.text), SideBySide({"textbook": TextbookEkfSlam(), **others})
    driver = replace(drivers_of(world)[ROBOT], estimator=panel)
    with Simulation(world, seed=seed) as sim:
        recording = run(sim, drivers={ROBOT: driver}, pictures=False)
    return {name: Score.of(recording.robots[ROBOT].truth, own) for name, own in panel.beliefs.items()}


def scores_in_log(log: Recording, robot: str, estimators: Mapping[str, Estimator]) -> dict[str, Score]:
    """Return the scores of estimators on what a robot of a recording observed."""
    panel = SideBySide(estimators)
    replay(log, robot=robot, estimator=panel)
    return {name: Score.of(log.robots[robot].truth, own) for name, own in panel.beliefs.items()}
