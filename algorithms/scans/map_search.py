"""Search for a lost robot with a lidar: its last scans are compared with the old walls, region by region."""

from collections import deque
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from mjsim.geometry import Array, wrap_angle

from ..estimation.pose_graph import compose, step_between
from ..estimation.pose_matrices import inverse
from .free_space import Views, both_seen_through
from .loop_closing import FLOOR
from .scan_matching import Match, WallField
from .scan_search import CLEAR, THROUGH, hypotheses, is_ambiguous
from .scan_walls import Surface, placed

FRAGMENT = 10
"""Number of scans of a lost robot that are compared together."""
FEWEST, COMPARED = 60, 250
"""Minimum number of wall elements on old walls, and maximum number that are compared."""
WINDOW = np.array([5.0, 5.0, np.pi])
"""Search window about the middle of a region [m, m, rad]."""
APART, RADIUS, PARTS = 4.0, 9.0, 8
"""Distance between the middles of two regions, distance of parts from the middle [m], and maximum number of them."""
ANY = np.diag([10.0, 10.0, 4.0]) ** 2
"""Prior covariance of a place within a region."""
SHARE, ON = 0.75, 0.95
"""Minimum ratio of elements on old walls to all, and to those near old walls."""
SAME = np.array([0.5, 0.5, 0.15])
"""Places that differ by less are the same [m, m, rad]."""
MOVED = 0.5, 0.5
"""Motion or turn between the two matches that confirm a place [m, rad]."""


class Fragment(NamedTuple):
    """The last scans of a lost robot, in the frame of the newest one."""

    walls: Surface
    views: Views
    newest: Array
    """Pose of the newest one as if the robot were not lost, world frame, shape (3,)."""
    first: Array
    """The same of the first one since the robot is lost."""

    def carried(self, newest: Array) -> Array:
        """Return the pose of the first scan for a pose of the newest one, shape (3,)."""
        return compose(newest, step_between(self.newest, self.first))


class FoundPlace(NamedTuple):
    """Where a fragment lies on the map."""

    old: int
    """Number of an old part of the map."""
    step: Array
    """Pose of the newest scan in its frame, shape (3,)."""
    information: Array
    """Inverse of the covariance of that, shape (3, 3)."""


class Candidate(NamedTuple):
    """A place that the scans of a lost robot fit."""

    region: int
    """Number of the old part where it was found."""
    first: Array
    """Pose of the first scan since the robot is lost, world frame, shape (3,)."""
    newest: Array
    """Pose of the newest scan then, world frame, shape (3,)."""
    cost: float
    """Cost of the match, for `COMPARED` elements."""
    information: Array
    """Inverse of the covariance of the newest pose, shape (3, 3)."""


class MapSearch:
    """Goes through the map of a lost robot, one region at each call, the nearest first.

    A place is accepted after all regions were searched, if scans from two places on the way fit it, and no other place
    fits as well.

    References:
        Olson, Real-Time Correlative Scan Matching, ICRA 2009, over all headings.
    """

    def __init__(self, begin: int) -> None:
        """Start at the part of the map that is the first one since the robot is lost."""
        self.begin = begin
        """Its number."""
        self._regions, self._again, self._cycles = deque[int](), deque[int](), 0
        self._candidates: list[Candidate] = []

    def find(
        self, fragment: Fragment, poses: Array, walls: Sequence[Surface], views: Callable[[Sequence[int], Array], Views]
    ) -> FoundPlace | None:
        """Return where a fragment lies; None if that is not known yet.

        Args:
            fragment: The last scans.
            poses: Poses of the old parts, world frame, shape (n, 3).
            walls: Walls of each part, in its frame.
            views: Returns some scans of some parts, with the poses of the robot in a frame.
        """
        if not self._regions:
            self._regions = deque(_regions(poses, fragment.newest))
            self._cycles += 1
        region = self._again.popleft() if self._again else self._regions.popleft()
        found = _placed_in(region, fragment, poses, walls, views)
        if found is not None:
            if not any(_is_same(found.first, other.first) for other in self._candidates):
                self._again.append(region)
            self._candidates.append(found)
        if not self._candidates or (self._cycles < 2 and self._regions):
            return None
        best = min(self._candidates, key=lambda each: each.cost)
        same = [each for each in self._candidates if _is_same(each.first, best.first)]
        rivals = [each.cost for each in self._candidates if not _is_same(each.first, best.first)]
        if min(rivals, default=np.inf) < best.cost + CLEAR or not any(_is_apart(best, each) for each in same):
            return None
        last = same[-1]
        newest = compose(last.first, step_between(fragment.first, fragment.newest))
        return FoundPlace(last.region, step_between(poses[last.region], newest), last.information)


def _regions(poses: Array, middle: Array) -> list[int]:
    """Return parts of the map at some distance from each other, the nearest to a pose (3,) first."""
    chosen: list[int] = []
    for k in np.argsort(np.hypot(*(poses[:, :2] - middle[:2]).T)).tolist():
        if not chosen or np.hypot(*(poses[chosen, :2] - poses[k, :2]).T).min() > APART:
            chosen.append(k)
    return chosen


def _placed_in(
    region: int,
    fragment: Fragment,
    poses: Array,
    walls: Sequence[Surface],
    views: Callable[[Sequence[int], Array], Views],
) -> Candidate | None:
    """Return where a fragment lies in a region; None if it fits nowhere, or in two places."""
    away = np.hypot(*(poses[:, :2] - poses[region, :2]).T)
    near = [k for k in np.argsort(away, kind="stable").tolist() if away[k] < RADIUS][:PARTS]
    old = placed([walls[k] for k in near], step_between(poses[region], poses[near]))
    scan = fragment.walls.thinned(COMPARED)
    if min(len(old.points), len(scan.points)) < FEWEST:
        return None
    found = hypotheses(WallField(old), scan, np.zeros(3), inverse(ANY), WINDOW, limit=6)
    best = found[0]
    if not _fits(best, len(scan.points)) or is_ambiguous(found):
        return None
    moved = [(compose(best.pose, pose), scan) for pose, scan in fragment.views]
    if (
        max(both_seen_through(scan.moved(best.pose), moved, old.thinned(COMPARED), views(near, poses[region])))
        > THROUGH
    ):
        return None
    newest, cost = compose(poses[region], best.pose), best.cost * COMPARED / len(scan.points)
    information = inverse(inverse(best.seen + 1e-3 * np.eye(3)) + FLOOR)
    return Candidate(region, fragment.carried(newest), newest, cost, information)


def _fits(match: Match, elements: int) -> bool:
    """Return whether enough of a fragment is on old walls, and little beside them."""
    on = match.share / (match.share + match.conflict + 1e-9)
    return match.share * elements > FEWEST and match.share > SHARE and on > ON


def _is_same(one: Array, other: Array) -> bool:
    """Return whether two poses (3,) are the same place."""
    x, y, heading = (one - other).tolist()
    return bool((np.abs([x, y, wrap_angle(heading)]) < SAME).all())


def _is_apart(one: Candidate, other: Candidate) -> bool:
    """Return whether the robot was elsewhere, or looked elsewhere, when it was found again."""
    x, y, heading = (one.newest - other.newest).tolist()
    return bool(np.hypot(x, y) > MOVED[0] or abs(wrap_angle(heading)) > MOVED[1])
