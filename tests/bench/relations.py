"""Relations between scans at places that a robot returned to, from matches over all headings: what maps are judged by.

References:
    Kuemmerle et al., On Measuring the Accuracy of SLAM Algorithms, Autonomous Robots 27, 2009.
"""

import time
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from mjsim.algorithms import LidarSlam
from mjsim.algorithms.estimation.pose_graph import step_between
from mjsim.algorithms.scans.scan_matching import WallField
from mjsim.algorithms.scans.scan_search import hypotheses, is_ambiguous
from mjsim.algorithms.scans.scan_walls import Surface
from mjsim.geometry import Array, wrap_angle
from mjsim.record import Recording
from mjsim.sim import Simulation

LATER, NEAR = 60, 1.0
"""Scans between the two, and how far apart they are by the path that chooses them [m]."""
WINDOW, FREE = np.array([2.0, 2.0, np.pi]), 1e-4 * np.eye(3)
"""Where the second scan is sought around that [m, m, rad], and how little that counts."""
SHARE, CONFLICT, SHARP = 0.7, 0.1, 3e3
"""Least share of a scan on the other's walls, largest one beside them, and least information [1/m^2, 1/rad^2]."""


class Relation(NamedTuple):
    """The pose of a scan in the frame of an earlier one."""

    one: int
    other: int
    step: Array
    """Shape (3,) [m, m, rad]."""


def relations(scans: Sequence[Surface], path: Array) -> Iterator[Relation]:
    """Yield those of scans, by their walls, whose matches are unique; the path (n, 3) only tells which pairs to try."""
    for other in range(LATER, len(scans)):
        away = np.hypot(*(path[: other - LATER + 1, :2] - path[other, :2]).T)
        one = int(away.argmin())
        walls, scan = scans[one], scans[other]
        if away[one] < NEAR and min(len(walls.points), len(scan.points)) > LATER:
            guess = step_between(path[one], path[other])
            found = hypotheses(WallField(walls), scan, guess, FREE, WINDOW, limit=6)
            sharp = np.linalg.eigvalsh(found[0].seen)[0] > SHARP
            if sharp and found[0].share > SHARE and found[0].conflict < CONFLICT and not is_ambiguous(found):
                yield Relation(one, other, found[0].pose)


def errors_of(found: Sequence[Relation], path: Array) -> Array:
    """Return by how much a path (n, 3) misses relations: of position and of heading, shape (k, 2) [m, rad]."""
    off = np.array([step_between(path[each.one], path[each.other]) - each.step for each in found]).reshape(-1, 3)
    return np.column_stack([np.hypot(off[:, 0], off[:, 1]), [abs(wrap_angle(float(turn))) for turn in off[:, 2]]])


class LogScore(NamedTuple):
    """How well LidarSlam did in a log."""

    costs: list[float]
    """Processor time of each tick that brought a keyframe [s]."""
    online: Array
    """Errors of position in the relations, of the estimates when the scans came, shape (k,) [m]."""
    final: Array
    """The same of the final map [m]."""
    lost: float
    """[s]"""


def score_in_log(log: Recording) -> LogScore:
    """Return how well LidarSlam does on what the first robot of a recording observed."""
    slam, costs, online, lost = LidarSlam(), list[float](), list[Array](), 0.0
    with Simulation(log.world) as sim:
        name, robot = next(iter(sim.robots.items()))
    slam.start(robot, {}, np.random.default_rng(0))
    for seen in log.observations(name):
        begin = time.process_time()
        belief = slam.update(seen)
        lost += slam.lost() * seen.dt
        if len(slam.keyframes) > len(online):
            online.append(belief.pose.as_array())
            costs.append(time.process_time() - begin)
    slam.path()
    found = list(relations([each.surface for each in slam.keyframes], slam.poses()))
    return LogScore(costs, *(errors_of(found, path)[:, 0] for path in (np.array(online), slam.poses())), lost)
