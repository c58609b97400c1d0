"""Drives in a room of landmarks in which a robot is pushed, slips, or is carried away, worked out without MuJoCo."""

import dataclasses
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.random import Generator
from threadpoolctl import threadpool_limits

from mjsim.geometry import Array, Pose, wrap_angle
from mjsim.interface import BeaconInfo, Estimator, HasPath, Observation, Odometry, RobotInfo, SaysLost, Sighting

from .landmark_rooms import DT, FAULTS, ROOMS, SIZE, LandmarkRoom

EVERY, REACH, FOV = 5, 6.0, math.radians(60.0)
"""Ticks between sightings, and how far [m] and wide [rad] landmarks are seen."""
R = np.diag([0.05, math.radians(1.0)]) ** 2


ROBOT = RobotInfo(
    name="scout",
    drive="differential",
    max_speed=0.7,
    max_turn=1.7,
    max_acceleration=1.0,
    max_turn_acceleration=5.0,
    wheels=("wheel_left", "wheel_right"),
    wheel_radius=0.0975,
    track=0.33,
    radius=0.22,
    dt=DT,
    prior=Pose(2.0, 2.0, 0.0),
    prior_covariance=np.zeros((3, 3)),
)


@dataclasses.dataclass(frozen=True)
class Disturbance:
    """What moves a robot without its odometry telling."""

    time: float = 60.0
    seconds: float = DT
    by: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Added to x, y [m] and heading [rad], evenly over that time."""
    to: tuple[float, float, float] | None = None
    """The pose that it is carried to."""
    after: tuple[tuple[float, float], ...] = ()
    """Where it drives from there, before it goes on [m]."""
    every: float = math.inf
    """Until it happens again [s]."""

    def acts(self, time: float) -> bool:
        """Return whether it happens at a time [s]."""
        since = time - self.time
        return since >= 0.0 and (since % self.every if since else 0.0) < self.seconds


DISTURBED = {
    "pushed by 0.87 m in 2.5 s": Disturbance(seconds=2.5, by=(0.0, 0.87, 0.0)),
    "pushed by 2.1 m and turned": Disturbance(seconds=2.0, by=(-1.5, 1.5, 0.3)),
    "turned by 30 degrees": Disturbance(seconds=1.0, by=(0.0, 0.0, math.pi / 6.0)),
    "turned by 90 degrees": Disturbance(seconds=1.0, by=(0.0, 0.0, math.pi / 2.0)),
    "carried away": Disturbance(to=(9.0, 5.0, 2.0)),
}
CASES: dict[str, tuple[LandmarkRoom, Disturbance | None]] = {
    **{name: (room, None) for name, room in ROOMS.items()},
    "clutter": (ROOMS["clutter"], DISTURBED["carried away"]),
    **{name: (ROOMS["plain"], disturbance) for name, disturbance in DISTURBED.items()},
    "pushed by 0.3 m every 20 s": (ROOMS["plain"], Disturbance(20.0, 1.0, (0.2, 0.2, 0.0), every=20.0)),
    **{name: (LandmarkRoom(faults=faults), None) for name, faults in FAULTS.items()},
}
"""Rooms and what happens in them."""


@dataclasses.dataclass(frozen=True, eq=False)
class Errors:
    """How an estimator did, one value a tick."""

    time: Array
    position: Array
    """[m]"""
    nees: Array
    seen: Array
    """Number of sightings."""
    lost: Array
    """Whether the estimator says so."""

    path: float = math.nan
    """Mean error of the final trajectory, if there is one [m]."""

    def surely_wrong(self) -> float:
        """Return the time with an error beyond all that the covariance allows [s]: 25 is 1 in 60,000."""
        return float(DT * np.sum(self.nees > 25.0))

    def longest_wrong(self) -> float:
        """Return the longest time without a break in which the estimate was surely wrong [s]."""
        right = np.flatnonzero(np.concatenate([[True], self.nees <= 25.0, [True]]))
        return float(DT * (np.diff(right).max() - 1))

    def seconds_lost(self) -> float:
        """Return the time in which the estimator said that it is lost [s]."""
        return float(DT * np.sum(self.lost))


def landmarks(number: int, rng: Generator) -> dict[str, Array]:
    """Return landmarks near the walls, at least 1.5 m apart."""
    places: list[Array] = []
    while len(places) < number:
        place = rng.uniform(0.3, np.array(SIZE) - 0.3)
        near = np.min([place, SIZE - place]) < 0.8
        if near and all(np.hypot(*(place - other)) > 1.5 for other in places):
            places.append(place)
    return {f"l{i}": place for i, place in enumerate(places)}


@threadpool_limits.wrap(limits=1, user_api="blas")
def drive(
    estimators: Mapping[str, Estimator],
    seed: int,
    disturbance: Disturbance | None = None,
    *,
    room: LandmarkRoom = ROOMS["plain"],
    seconds: float = 100.0,
) -> dict[str, Errors]:
    """Drive round a room; return the errors of estimators that all got the same observations."""
    rng = np.random.default_rng([seed, 1])
    places = landmarks(8, np.random.default_rng([seed, 7])) if room.places is None else room.places
    catalogue = {name: BeaconInfo(name, None, 0.3, 0.3) for name in places}
    inside = np.full(2, 0.6), np.array(room.size) - 0.6

    def seen(moment: Moment) -> Observation:
        """Return odometry and, when they are due, sightings."""
        looks = _looks(moment.truth, places, moment.time, rng) if moment.tick % EVERY == 0 else ()
        shown = (look for look in looks if room.shows(places[str(look.name)], moment.time, moment.truth[:2]))
        odometry = room.faults.of_odometry(moment.odometry, moment.time)
        return Observation(moment.time, DT, odometry, sightings=tuple(map(room.faults.of_sighting, shown)))

    moments = driven(room.corners, inside, rng, disturbance, seconds)
    robot = dataclasses.replace(ROBOT, prior=Pose(*room.corners[-1], 0.0))
    return compared(estimators, ((moment.truth, seen(moment)) for moment in moments), robot, catalogue, seed)


class Moment(NamedTuple):
    """A tick of a drive."""

    tick: int
    time: float
    """[s]"""
    truth: Array
    """Pose of the robot, shape (3,) [m, m, rad]."""
    odometry: Odometry
    """Since the last tick."""


def driven(
    corners: Sequence[tuple[float, float]],
    inside: tuple[Array, Array],
    rng: Generator,
    disturbance: Disturbance | None,
    seconds: float,
) -> Iterator[Moment]:
    """Yield the ticks of a drive round and round.

    Args:
        corners: Where to, the last one first the start [m].
        inside: Least and largest position of the robot, shape (2,) each [m].
        rng: Of the errors of odometry.
        disturbance: What happens on the way.
        seconds: How long it takes.
    """
    truth, corner, after = np.array([*corners[-1], 0.0]), 0, list[tuple[float, float]]()
    for tick in range(round(seconds / DT)):
        time = tick * DT
        goal = after[0] if after else corners[corner]
        if np.hypot(*(goal - truth[:2])) < 0.3:
            corner, after = corner if after else (corner + 1) % len(corners), after[1:]
        step = _step(truth, after[0] if after else corners[corner])
        c, s = math.cos(truth[2]), math.sin(truth[2])
        truth = truth + np.array([c * step[0], s * step[0], step[2]])
        if disturbance is not None and disturbance.acts(time):
            truth = truth + np.array(disturbance.by) * DT / disturbance.seconds
            truth = truth if disturbance.to is None else np.array(disturbance.to)
            after = list(disturbance.after)
        truth[:2] = np.clip(truth[:2], *inside)
        yield Moment(tick, time, truth, _odometry(step, rng))


def compared(
    estimators: Mapping[str, Estimator],
    drive: Iterable[tuple[Array, Observation]],
    robot: RobotInfo,
    catalogue: Mapping[str, BeaconInfo],
    seed: int,
) -> dict[str, Errors]:
    """Return the errors of estimators that all get the observations of a drive, which come with the true poses."""
    for estimator in estimators.values():
        estimator.start(robot, catalogue, np.random.default_rng(seed + 100))
    rows: dict[str, list[tuple[float, ...]]] = {name: [] for name in estimators}
    truths: list[Array] = []
    for truth, seen in drive:
        truths.append(truth)
        for name, estimator in estimators.items():
            belief = estimator.update(seen)
            off = belief.pose.as_array() - truth
            off[2] = wrap_angle(float(off[2]))
            nees = off @ np.linalg.solve(belief.covariance + 1e-12 * np.eye(3), off)
            lost = isinstance(estimator, SaysLost) and estimator.lost()
            rows[name].append((seen.time, np.hypot(*off[:2]), nees, len(seen.sightings), lost))
    return {name: Errors(*np.array(own).T, path=_path(estimators[name], truths)) for name, own in rows.items()}


def _path(estimator: Estimator, truths: Sequence[Array]) -> float:
    """Return the mean error of the final trajectory of an estimator that has a pose for each tick [m]."""
    if not isinstance(estimator, HasPath):
        return math.nan
    path = np.array([pose.as_array() for _, pose in estimator.path()])
    return float(np.hypot(*(path - truths)[:, :2].T).mean()) if len(path) == len(truths) else math.nan


def _step(truth: Array, corner: tuple[float, float]) -> Array:
    """Return how a robot moves in a tick to a corner (forward, left, turn)."""
    off = wrap_angle(math.atan2(corner[1] - truth[1], corner[0] - truth[0]) - truth[2])
    return DT * np.array([0.4 if abs(off) < 0.5 else 0.05, 0.0, min(max(1.5 * off, -0.8), 0.8)])


def _odometry(step: Array, rng: Generator) -> Odometry:
    deviations = np.sqrt([1e-4 * abs(step[0]), 1e-8, 4e-4 * abs(step[2]) + 4e-6 * abs(step[0])])
    return Odometry(*(step + rng.normal(0.0, deviations)).tolist(), np.diag(deviations**2))


def _looks(truth: Array, places: Mapping[str, Array], time: float, rng: Generator) -> tuple[Sighting, ...]:
    """Return sightings of what is in view; noise is drawn for all, seen or not."""
    looks = []
    errors = rng.normal(0.0, np.sqrt(np.diag(R)), (len(places), 2))
    for (name, place), noise in zip(places.items(), errors, strict=True):
        dx, dy = place - truth[:2]
        distance, bearing = math.hypot(dx, dy), wrap_angle(math.atan2(dy, dx) - truth[2])
        if distance < REACH and abs(bearing) < FOV / 2.0:
            looks.append(Sighting(time, name, distance + noise[0], wrap_angle(bearing + noise[1]), R))
    return tuple(looks)
