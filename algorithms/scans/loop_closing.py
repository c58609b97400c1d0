"""Loop closure: searches for new submaps in older ones; only unambiguous matches are accepted."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mjsim.geometry import Array, wrap_angle

from ..estimation.pose_graph import PoseGraph, compose, step_between
from ..estimation.pose_matrices import inverse
from .scan_matching import BESIDE, CUT, WEIGHED, Match, WallField
from .scan_search import CLEAR, GATE, RADIUS, THROUGH, hypotheses, is_ambiguous
from .scan_walls import Surface, rotation

MIN_WALL_ELEMENTS = 40
"""Minimum number of elements on old walls for a loop: 4 m of wall."""
MAX_SEARCH = np.array([16.0, 16.0, 0.8])
"""Maximum search window [m, m, rad]."""
NARROWEST = np.array([0.3, 0.3, 0.06])
"""Minimum search window [m, m, rad]."""
FLOOR = np.diag([0.015, 0.015, 0.004]) ** 2
"""Covariance of a loop in addition to that of the match: walls are not exactly straight [m^2, rad^2]."""
SURE = np.array([0.6, 0.6, 0.15])
"""If three standard deviations of the shift by a loop are below this, the loop needs no confirmation [m, m, rad]."""
APART, NEIGHBOURS = 6.0, 12
"""Two loops confirm each other if their places are at least this far apart [m], and at most this many parts: a place
that is mistaken for another one is still mistaken a step further on."""
TELLING = 0.25
"""Maximum standard deviation of the position of loops that confirm each other [m]."""
TOLERANCE, GROWTH = np.array([0.05, 0.05, 0.02]), np.array([0.01, 0.01, 0.0])
"""Standard deviation of the step between two loops in the map [m, m, rad], and its growth with their distance [1]."""
CONTRARY = 9.0
"""Normalised squared difference above which two loops contradict each other."""
MISFIT = 100.0
"""Normalised squared error above which a loop is removed."""

UNSEEN = 0.5
"""Cost of an element where no old wall is near, relative to one beside an old wall: the old part may not have seen it.
With equal costs, a wrong place along a corridor that overlaps more of the old part wins over the right one."""
BEHIND = 0.25
"""As in `scan_search`, but larger, for places with less overlap."""
KEPT = 50
"""Number of hypotheses that the search keeps, in the smallest windows: niches along a corridor hardly count in a coarse
grid."""


@dataclass(frozen=True, slots=True, eq=False)
class Loop:
    """A step from an old part of the map to a new one, from a match of their walls."""

    old: int
    new: int
    step: Array
    """Pose of the new part in the frame of the old one, shape (3,)."""
    information: Array
    """Inverse of the step's covariance, shape (3, 3)."""
    certain: bool
    """Whether it needs no confirmation by another loop."""


def find_loop(
    old: int,
    new: int,
    walls: Surface,
    scan: Surface,
    guess: Array,
    covariance: Array,
    *,
    share: float,
    through: Callable[[Array], float],
) -> Loop | None:
    """Return the pose of a new part of the map relative to an old one; None if there is no unique match.

    Args:
        old: Number of the old part.
        new: Number of the new one.
        walls: Walls of the old part and its neighbours, in the frame of the old part.
        scan: Walls of the new part, in its own frame.
        guess: Guess of the step between them, shape (3,).
        covariance: Covariance of the guess, shape (3, 3).
        share: Minimum ratio of elements on old walls to elements near them.
        through: Returns for a step the share of walls of one part that scans of the other have seen through.
    """
    thin = scan.thinned(250)
    if min(len(walls.points), len(thin.points)) < MIN_WALL_ELEMENTS:
        return None
    covariance = _bent(covariance)
    reach = 3.0 * np.sqrt(np.diag(covariance))
    window = np.clip(reach, NARROWEST, MAX_SEARCH)
    information = inverse(covariance + FLOOR)
    near = _within_reach(walls, thin, guess, window)
    if len(near.points) < MIN_WALL_ELEMENTS:
        return None
    found = hypotheses(
        WallField(near), thin, guess, information, window, limit=6, behind=BEHIND, kept=KEPT, unseen=UNSEEN
    )
    elements = len(thin.points)
    found = sorted((_judged(match, elements, UNSEEN) for match in found), key=lambda match: match.cost)
    best = found[0]
    if not _fits(best, elements, share) or is_ambiguous(found) or _is_outdone(found, elements, share):
        return None
    if through(best.pose) > THROUGH:
        return None
    difference = best.pose - guess
    difference[2] = wrap_angle(float(difference[2]))
    if difference @ information @ difference > GATE:
        return None
    own = inverse(best.seen + 1e-3 * np.eye(3)) + FLOOR
    return Loop(old, new, best.pose, inverse(own), is_certain(covariance, own))


def is_certain(covariance: Array, own: Array) -> bool:
    """Return whether a loop cannot move the map so far that it needs confirmation.

    Args:
        covariance: Covariance of the step between its ends without it, shape (3, 3).
        own: Covariance of the step by the loop alone, shape (3, 3).
    """
    shift = covariance @ inverse(covariance + own) @ covariance
    return bool((3.0 * np.sqrt(np.diag(shift)) < SURE).all())


def _within_reach(walls: Surface, scan: Surface, guess: Array, window: Array) -> Surface:
    """Return the walls that a scan may lie on or near within a window around a guess; others only cost time."""
    points = scan.moved(guess).points
    margin = window[:2] + window[2] * np.hypot(*scan.points.T).max() + BESIDE + RADIUS
    inside = ((walls.points > points.min(axis=0) - margin) & (walls.points < points.max(axis=0) + margin)).all(axis=1)
    return Surface(walls.points[inside], walls.normals[inside], walls.noise[inside])


def _bent(covariance: Array) -> Array:
    """Return the covariance (3, 3) of a step with the second-order effect of its heading on its position.

    An uncertain heading h moves the end of a path of length r on an arc, which is h^2 r / 2 off its tangent. h r is the
    part of the position's standard deviation due to the heading.
    """
    x, y, heading = np.diag(covariance).tolist()
    return covariance + np.diag([0.25 * heading * (x + y)] * 2 + [0.0])


def _judged(match: Match, elements: int, unseen: float) -> Match:
    """Return a match with another cost of elements where no old wall is near, relative to those beside one."""
    far = 1.0 - match.share - match.conflict
    return replace(match, cost=match.cost - (1.0 - unseen) * WEIGHED * CUT**2 * far * elements)


def _is_outdone(found: list[Match], elements: int, share: float) -> bool:
    """Return whether another match fits and clearly contradicts old walls less than the first.

    The first is then judged better only because it overlaps more of the old walls.
    """
    # The costs already include unseen elements at the lower rate.
    best, *others = [_judged(match, elements, 1.0 - UNSEEN) for match in found]
    return any(_fits(match, elements, share) and match.cost < best.cost - CLEAR for match in others)


def _fits(match: Match, elements: int, share: float) -> bool:
    """Return whether enough of a scan is on walls, and little of it beside them."""
    on = match.share * elements
    return on >= MIN_WALL_ELEMENTS and match.share > 0.3 and match.share / (match.share + match.conflict + 1e-9) > share


def confirmed_by(
    loop: Loop, others: Sequence[Loop], poses: Array, *, apart: float = APART, neighbours: int = NEIGHBOURS
) -> list[Loop]:
    """Return the loops that confirm one; none if they are too near, or if as many places contradict as agree.

    Args:
        loop: A loop.
        others: Loops that need confirmation.
        poses: Poses of all parts of the map, shape (n, 3); right for neighbours.
        apart: Minimum distance of the places of two loops that confirm each other [m].
        neighbours: Maximum number of parts between them.
    """
    compared = [
        (other, *_difference(loop, other, poses)) for other in others if _are_neighbours(loop, other, neighbours)
    ]
    agreeing = [other for other, squared, telling in compared if telling and squared < CONTRARY]
    against = {other.new for other, squared, _ in compared if squared >= CONTRARY}
    apart = any(np.hypot(*(poses[loop.new] - poses[other.new])[:2]) > apart for other in agreeing)
    return agreeing if apart and len({other.new for other in agreeing}) > len(against) else []


class GraphLoops:
    """Loops of a pose graph: closed when they are certain or confirmed, removed when they do not fit."""

    def __init__(self, graph: PoseGraph, *, settled: float, apart: float = APART, neighbours: int = NEIGHBOURS) -> None:
        """Start without loops.

        Args:
            graph: The graph.
            settled: The graph is iterated while poses move by more than this [m, rad].
            apart: As for `confirmed_by`.
            neighbours: As for `confirmed_by`.
        """
        self._graph, self._settled, self._apart, self._neighbours = graph, settled, apart, neighbours
        self.closed = 0
        """Number of closed loops."""
        self.moving = False
        """Whether the graph has to be iterated."""
        self._unconfirmed: list[Loop] = []

    def consider(self, loop: Loop) -> None:
        """Close a loop if it is certain or others confirm it; otherwise remember it."""
        witnesses = confirmed_by(
            loop, self._unconfirmed, self._graph.poses, apart=self._apart, neighbours=self._neighbours
        )
        if not loop.certain and not witnesses:
            self._unconfirmed.append(loop)
            return
        for each in (loop, *witnesses):
            self.close(each.old, each.new, each.step, each.information)
        self._unconfirmed = [other for other in self._unconfirmed if other not in witnesses]

    def close(self, old: int, new: int, step: Array, information: Array) -> None:
        """Close a loop."""
        self._graph.add_step(old, new, step, information)
        self.closed, self.moving = self.closed + 1, True

    def settle(self, before: Array) -> None:
        """Compare the poses before an iteration with those of now; once they rest, remove loops that do not fit."""
        self.moving = bool(np.abs(step_between(before, self._graph.poses)).max() > self._settled)
        if not self.moving:
            dropped = self._graph.drop_misfits(MISFIT)
            self.closed, self.moving = self.closed - dropped, dropped > 0


def _are_neighbours(one: Loop, other: Loop, neighbours: int) -> bool:
    """Return whether two loops join the same parts of the path."""
    return abs(one.old - other.old) <= neighbours and 0 < abs(one.new - other.new) <= neighbours


def _difference(one: Loop, other: Loop, poses: Array) -> tuple[float, bool]:
    """Return the normalised squared difference of two loops between neighbours, and whether both fix the position."""
    by_one, by_other = compose(poses[one.old], one.step), compose(poses[other.old], other.step)
    # Where the second new part lies, by each of the two loops.
    way = step_between(poses[one.new], poses[other.new])
    difference = compose(by_one, way) - by_other
    difference[2] = wrap_angle(float(difference[2]))
    own = _in_world(one, poses) + _in_world(other, poses)
    telling = bool(np.linalg.eigvalsh(own[:2, :2])[1] < TELLING**2)
    covariance = own + np.diag((TOLERANCE + GROWTH * np.hypot(*way[:2])) ** 2)
    return float(difference @ inverse(covariance) @ difference), telling


def _in_world(loop: Loop, poses: Array) -> Array:
    """Return the covariance of the step of a loop in the axes of the world, shape (3, 3)."""
    R = np.eye(3)
    R[:2, :2] = rotation(float(poses[loop.old, 2]))
    return np.asarray(R @ inverse(loop.information) @ R.T)
