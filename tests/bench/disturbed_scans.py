"""A robot with a lidar that slips, is pushed, or is carried away, worked out without MuJoCo."""

import dataclasses
import math
from collections.abc import Mapping

import numpy as np
from threadpoolctl import threadpool_limits

from mjsim.geometry import Array, Pose
from mjsim.interface import Estimator, Observation, Scan, SensorInfo, TakesMap, WorldMap

from .disturbed import DT, ROBOT, Disturbance, Errors, Moment, compared, driven

CORNERS = ((11.5, 2.0), (11.5, 8.0), (2.5, 8.0), (2.5, 2.0))
"""Where the robot drives round and round in a hall [m]."""
EVERY, BEAMS, REACH, NOISE = 5, 181, 12.0, 0.01
"""Ticks between scans, their beams over 180 degrees, their range [m] and its noise [m]."""
HALL = [(0, 0), (14, 0), (14, 4.5)], [(14, 5.5), (14, 10), (9, 10), (9, 10.8), (7, 10.8), (7, 10), (0, 10), (0, 0)]
ROOM = [(14, 4.5), (14.2, 4.5), (14.2, 0), (22, 0), (22, 8), (20, 10), (14.2, 10), (14.2, 5.5), (14, 5.5)]
"""Beside the hall, behind a door: the robot was never there [m]."""
THINGS = [(4, 4, 1.2, 0.8), (8.5, 4.3, 0.6, 1.6), (0.4, 5.5, 0.8, 1.0), (13.6, 7, 0.8, 0.5), (5, 0.3, 2.0, 0.6)]
THINGS += [(6, 6, 0.4, 0.4), (12.5, 9.8, 1.0, 0.4), (16.5, 2, 1.5, 0.7), (20, 5, 0.6, 2.5), (17, 8.5, 0.8, 0.8)]
"""Boxes: their middle and their size [m]."""
TIME = 90.0
"""When it happens: in the second lap [s]."""
DISTURBED = {
    **{
        f"turned by {degrees} degrees": Disturbance(time=TIME, seconds=1.0, by=(0.0, 0.0, math.radians(degrees)))
        for degrees in (30, 60, 90, 135, 180)
    },
    **{
        f"pushed by {metres:g} m": Disturbance(time=TIME, seconds=1.0, by=(-0.8 * metres, 0.6 * metres, 0.0))
        for metres in (0.5, 1.0, 2.0, 3.0)
    },
    "carried to a mapped place": Disturbance(time=TIME, to=(3.5, 7.5, 2.0), after=((2.5, 6.0), (2.5, 2.0))),
    "carried to another room": Disturbance(
        time=TIME, to=(18.5, 7.0, 0.5), after=((18.5, 5.0), (15.5, 5.0), (12.5, 5.0), (11.5, 8.0), (2.5, 8.0))
    ),
}


def drive(
    estimators: Mapping[str, Estimator], seed: int, disturbance: Disturbance | None = None, *, seconds: float = 150.0
) -> dict[str, Errors]:
    """Drive round the hall; return the errors of estimators that all got the same observations."""
    rng, walls = np.random.default_rng([seed, 2]), _walls()
    lidar = SensorInfo(kind="lidar", robot_from_sensor=np.eye(4), rate_hz=1.0 / (EVERY * DT))
    for estimator in estimators.values():
        if isinstance(estimator, TakesMap):
            estimator.take_map(WorldMap(walls, {}))
    robot = dataclasses.replace(ROBOT, prior=Pose(*CORNERS[-1], 0.0), sensors={"scan": lidar})

    def seen(moment: Moment) -> Observation:
        """Return odometry and, when it is due, a scan."""
        due = moment.tick % EVERY == 0
        scans = {"scan": _scan(moment, walls, rng)} if due else {}
        return Observation(moment.time, DT, moment.odometry, scans=scans)

    inside = np.array([0.5, 0.5]), np.array([21.5, 9.5])
    moments = driven(CORNERS, inside, rng, disturbance, seconds)
    with threadpool_limits(limits=1, user_api="blas"):
        return compared(estimators, ((moment.truth, seen(moment)) for moment in moments), robot, {}, seed)


def _walls() -> Array:
    """Return both ends of each wall, shape (n, 2, 2) [m]."""
    lines = [np.array(line, dtype=float) for line in (*HALL, ROOM)]
    unit = 0.5 * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)])
    lines += [np.array([x, y]) + unit * (width, depth) for x, y, width, depth in THINGS]
    return np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in lines])


def _scan(moment: Moment, walls: Array, rng: np.random.Generator) -> Scan:
    """Return where beams meet walls."""
    angles = np.linspace(-0.5 * np.pi, 0.5 * np.pi, BEAMS)
    way = np.stack([np.cos(angles + moment.truth[2]), np.sin(angles + moment.truth[2])], axis=-1)[:, None]
    begin, along = walls[:, 0] - moment.truth[:2], walls[:, 1] - walls[:, 0]
    across = _cross(way, along)
    with np.errstate(divide="ignore", invalid="ignore"):
        distance, share = _cross(begin, along) / across, _cross(begin, way) / across
    met = np.where((distance > 0.0) & (share >= 0.0) & (share <= 1.0), distance, np.inf).min(axis=1)
    ranges = np.where(met < REACH, met + rng.normal(0.0, NOISE, BEAMS), np.inf)
    return Scan(moment.time, ranges, float(angles[0]), np.pi / (BEAMS - 1), 0.05, REACH)


def _cross(one: Array, other: Array) -> Array:
    """Return the third component of the cross product of planar vectors (..., 2)."""
    return np.asarray(one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0])
