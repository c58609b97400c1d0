"""A map of scans in submaps (parts): scans are fixed within a part, and a graph of the parts closes loops."""

from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from mjsim.geometry import Array

from ..estimation.ekf_models import odometry_motion
from ..estimation.pose_graph import COMMON, PoseGraph, carried, compose, composed, step_between
from ..estimation.pose_matrices import inverse
from .free_space import Views, both_seen_through, seen_through
from .level_scan import LevelScan
from .loop_closing import MAX_SEARCH, MIN_WALL_ELEMENTS, GraphLoops, find_loop
from .map_search import FRAGMENT, Fragment, MapSearch
from .odometry_bias import OdometryBias
from .scan_search import Fit, MatchedPose, Through
from .scan_walls import Surface, placed

LOCAL = 6
"""Number of recent scans whose walls a new one is matched to."""
PART = 8
"""Maximum number of scans in a part of the map."""
DOUBTFUL = 0.05
"""A step whose turn has a larger standard deviation begins a part if the scan has enough walls for a loop: no loop
could correct it within a part, whose scans are fixed to each other [rad]."""
LENGTH = 2.0
"""Minimum length of a part when the robot drives straight [m]."""
RECENT = 4
"""Number of parts after which a part counts as old."""
TRIED = 3
"""Number of old parts that a new one is compared with; twice as many if the drift may exceed 1 m."""
UNSOLVED = 16
"""Maximum number of parts added before covariances are computed again."""
NOTABLE, SLIGHT = 0.1, np.diag([1e-4, 1e-4, 1e-6])
"""The graph is solved again when corrections of odometry move the newest part by this normalised squared error, or
relative to this covariance."""
MAX_WALLS = 200
"""Maximum number of wall elements of a part that are compared with the free space of another one."""
SETTLED = 0.005
"""The graph is iterated while poses move by more than this [m, rad]."""


@dataclass(frozen=True, slots=True, eq=False)
class Keyframe:
    """A scan of the map."""

    level_scan: LevelScan
    surface: Surface
    """The walls that it shows, in the robot's frame."""
    part: int
    """Number of its part in the map."""
    place: "UncertainPlace"
    """Pose in the frame of the part."""


@dataclass(frozen=True, slots=True, eq=False)
class UncertainPlace:
    """A pose whose uncertainty depends on the systematic errors of odometry."""

    at: Array
    """The pose without systematic errors, shape (3,)."""
    slopes: Array
    """Its derivative by the errors of odometry, shape (3, 6)."""

    def given(self, errors: Array) -> Array:
        """Return the pose for given errors of odometry (6,), shape (3,)."""
        return self.at + self.slopes @ errors


class PartsMap:
    """Scans of one robot, in parts of a few scans; the frame of a part is that of its first scan.

    References:
        Hess, Kohler, Rapp, Andor, Real-Time Loop Closure in 2D LIDAR SLAM, ICRA 2016, section IV and V.
    """

    def __init__(
        self, prior: Array, prior_covariance: Array, bias: OdometryBias, *, loop_distance: float, loop_share: float
    ) -> None:
        """Start without scans.

        Args:
            prior: Start of the robot, world frame, shape (3,) [m, m, rad].
            prior_covariance: Prior covariance of it, shape (3, 3).
            bias: Estimated systematic errors of odometry, updated by the caller.
            loop_distance: Maximum distance of an old part to be tried for a loop [m].
            loop_share: Minimum ratio of wall elements on old walls to those near them for a loop.
        """
        self._loop_distance, self._loop_share = loop_distance, loop_share
        self._prior_covariance = prior_covariance
        self._motion = odometry_motion()
        self.keyframes: list[Keyframe] = []
        self.graph = PoseGraph(prior[None])
        """The graph, whose poses are those of the parts."""
        self.loops = GraphLoops(self.graph, settled=SETTLED)
        self._bias, self._by_loops = bias, np.zeros(COMMON)
        self._solved_errors = bias.errors
        # Of the newest part: its covariance given the errors of odometry, and the derivative of its pose by them.
        self._covariance, self._slopes = prior_covariance, np.zeros((3, COMMON))
        self._forget_since()
        self._begins = [0]
        self._walls: list[Surface] = []
        self._untried: deque[tuple[int, int, Array]] = deque()
        self._search: MapSearch | None = None
        self._restart_motion()

    def _restart_motion(self) -> None:
        """Restart the accumulated motion at the frame of the newest part.

        Search windows for loops are conservative, as if the errors of matches persisted; the published covariance of
        the robot's pose has their actual errors.
        """
        self._place, self._cautious = UncertainPlace(np.zeros(3), np.zeros((3, COMMON))), np.zeros((3, 3))
        self._lasting, self._passing = np.zeros((3, 3)), np.zeros((3, 3))

    def _forget_since(self) -> None:
        """Restart the accumulated motion since the last solution: pose, conservative covariance, slopes."""
        self._since = np.zeros(3), np.zeros((3, 3)), np.zeros((3, COMMON))

    def add(self, level_scan: LevelScan, surface: Surface, matched: MatchedPose, slopes: Array) -> None:
        """Add a scan.

        Args:
            level_scan: The scan as received.
            surface: Its walls, in the robot's frame.
            matched: The robot in the frame of the previous scan, or of the prior.
            slopes: Derivative of that by the systematic errors of odometry, shape (3, 6).
        """
        errors = self._errors
        place = self._place.given(errors)
        _, self._passing = self._after(place, np.zeros((3, 3)), matched.pose, matched.own - matched.lasting)
        _, self._cautious = self._after(place, self._cautious, matched.pose, matched.own)
        pose, F, G = self._motion(place, matched.pose)
        slopes = F @ self._place.slopes + G @ slopes
        self._place = UncertainPlace(pose - slopes @ errors, slopes)
        self._lasting = F @ self._lasting @ F.T + G @ matched.lasting @ G.T
        doubtful = bool(self.keyframes) and matched.own[2, 2] > DOUBTFUL**2 and len(surface.points) >= MIN_WALL_ELEMENTS
        lost = matched.fit is Fit.LOST
        if len(self.keyframes) - self._begins[-1] >= PART or doubtful or lost:
            self._begin_part()
        if lost:
            self._untried.clear()
            self._search = MapSearch(len(self._begins) - 1)
        self.keyframes.append(Keyframe(level_scan, surface, len(self._begins) - 1, self._place))

    @property
    def lost(self) -> bool:
        """Whether the pose of the last scans relative to earlier ones is unknown."""
        return self._search is not None

    def belief(self) -> tuple[Array, Array]:
        """Return the pose of the newest scan in the world, shape (3,), and its covariance, shape (3, 3)."""
        pose, covariance, slopes = self._newest()
        return pose, _total(covariance, slopes, self._bias)

    def _newest(self) -> tuple[Array, Array, Array]:
        """Return the newest pose in the world, its covariance given the errors of odometry, and its slopes."""
        pose, F, G = self._motion(self.graph.poses[-1], self._place.given(self._errors))
        covariance = F @ self._covariance @ F.T + G @ self._part_covariance @ G.T
        return pose, covariance, F @ self._slopes + G @ self._place.slopes

    @property
    def _errors(self) -> Array:
        """Systematic errors of odometry, from consecutive scans and loops, shape (6,)."""
        return self._bias.errors + self._by_loops

    def poses(self) -> Array:
        """Return the poses of all scans in the world, shape (n, 3)."""
        return self._poses(self.keyframes) if self.keyframes else np.zeros((0, 3))

    def recent_walls(self) -> Surface:
        """Return the walls of the last few scans in the frame of the newest one; needs at least one scan."""
        last = self._recent()
        poses = self._poses(last)
        return placed([each.surface for each in last], step_between(poses[-1], poses))

    def through(self, level_scan: LevelScan, surface: Surface, walls: Surface) -> Through:
        """Return the share of walls of a new scan that the last few saw through, and vice versa.

        Args:
            level_scan: The new scan.
            surface: Its walls, in the robot's frame.
            walls: Those of the last few scans.
        """
        last = self._recent()
        poses = self._poses(last)
        views = [(pose, each.level_scan) for pose, each in zip(step_between(poses[-1], poses), last, strict=True)]
        thin, known = surface.thinned(MAX_WALLS), walls.thinned(MAX_WALLS)
        return lambda step: both_seen_through(thin.moved(step), [(step, level_scan)], known, views)

    def _recent(self) -> Sequence[Keyframe]:
        """Return the last few scans, without those from before the robot was lost."""
        begin = 0 if self._search is None else self._begins[self._search.begin]
        return self.keyframes[max(begin, len(self.keyframes) - LOCAL) :]

    def work(self) -> None:
        """Do one piece of pending work: compare a new part with an old one, or iterate the graph."""
        if self._search is not None:
            self._find(self._search)
        elif self._untried:
            self._try_loop(*self._untried.popleft())
        elif self.loops.moving or self._learnt():
            self._solve()

    def _learnt(self) -> bool:
        """Return whether corrections of odometry since the last solution move the newest part notably."""
        shift = self._slopes @ (self._bias.errors - self._solved_errors)
        known = _total(self._covariance, self._slopes, self._bias)
        return bool(shift @ inverse(known + SLIGHT) @ shift > NOTABLE)

    def finish(self) -> None:
        """Do all pending work."""
        self.loops.moving, self._search = len(self.graph.steps) > 0, None
        while self._untried or self.loops.moving:
            self.work()

    @property
    def _part_covariance(self) -> Array:
        """Covariance of the newest pose in its part: accumulated error, and error of the last match."""
        return self._lasting + self._passing

    def _poses(self, keyframes: Sequence[Keyframe]) -> Array:
        """Return the poses of k scans in the world, shape (k, 3), k at least one."""
        at, slopes = (np.array(each) for each in zip(*[(k.place.at, k.place.slopes) for k in keyframes], strict=True))
        return composed(self.graph.poses[[each.part for each in keyframes]], at + slopes @ self._errors)

    def _after(self, pose: Array, covariance: Array, step: Array, step_covariance: Array) -> tuple[Array, Array]:
        """Return a pose and its covariance after a step with independent covariance."""
        moved, F, G = self._motion(pose, step)
        return moved, F @ covariance @ F.T + G @ step_covariance @ G.T

    def _members(self, part: int) -> Sequence[Keyframe]:
        """Return the scans of a part."""
        end = self._begins[part + 1] if part + 1 < len(self._begins) else len(self.keyframes)
        return self.keyframes[self._begins[part] : end]

    def _begin_part(self) -> None:
        """Finish the current part, and start another at the newest pose."""
        part = len(self._begins) - 1
        members = self._members(part)
        errors = self._errors
        places = np.array([each.place.given(errors) for each in members])
        self._walls.append(placed([each.surface for each in members], places))
        old = self._nearby_parts(part) if self._search is None else []
        self._untried.extend(zip(old, [part] * len(old), self._step_covariances(old, part), strict=True))
        information = inverse(self._cautious + 1e-10 * np.eye(3))
        pose, self._covariance, self._slopes = self._newest()
        self.graph.add_pose(pose)
        self.graph.add_step(part, part + 1, self._place.at, information, self._part_covariance, self._place.slopes)
        since, covariance, slopes = self._since
        since, F, G = self._motion(since, self._place.given(errors))
        covariance = F @ covariance @ F.T + G @ self._cautious @ G.T
        self._since = since, covariance, F @ slopes + G @ self._place.slopes
        self._restart_motion()
        self._begins.append(len(self.keyframes))

    def _step_covariances(self, ones: list[int], other: int) -> list[Array]:
        """Return the covariances of the steps from old parts to the newest one, shape (3, 3) each.

        They are those of the last solution, propagated along the motion since.
        """
        if not ones:
            return []
        if max(ones) >= self.graph.solved or other - self.graph.solved > UNSOLVED:
            self.graph.factorise()
            self._forget_since()
        last, poses = self.graph.solved - 1, self.graph.poses
        until = self.graph.joint_step_covariances(ones, last)
        steps = step_between(poses[ones], poses[last])
        return [self._since_too(step, joint) for step, joint in zip(steps, until, strict=True)]

    def _since_too(self, step: Array, joint: Array) -> Array:
        """Return the covariance (3, 3) of a step propagated along the motion since the last solution.

        Args:
            step: Step to the newest part of that solution, shape (3,).
            joint: Covariance of it and of the systematic errors of odometry, shape (9, 9).
        """
        since, covariance, slopes = self._since
        _, F, G = self._motion(step, since)
        J = np.concatenate([F, G @ slopes], axis=1)
        return np.asarray(J @ joint @ J.T + G @ covariance @ G.T)

    def _nearby_parts(self, part: int) -> list[int]:
        """Return the old parts where a finished one might be, the nearest first."""
        old = part - RECENT
        if old < 1:
            return []
        middles = self._poses([(each := self._members(k))[len(each) // 2] for k in (*range(old), part)])
        distances = np.hypot(*(middles[:-1, :2] - middles[-1, :2]).T)
        known = _total(self._covariance, self._slopes, self._bias)
        drift = 2.0 * float(np.sqrt(np.trace(known[:2, :2])))
        chosen: list[int] = []
        for k in np.argsort(distances).tolist():
            if distances[k] > self._loop_distance + drift or len(chosen) == TRIED * (1 + (drift > 2.0)):
                break
            if all(abs(k - other) > 1 for other in chosen):
                chosen.append(k)
        return chosen

    def _try_loop(self, old: int, new: int, covariance: Array) -> None:
        """Compare a new part with an old one and its neighbours."""
        # A similar place elsewhere must not win only because walls of the right one are left out.
        reach = min(3.0 * float(np.sqrt(np.diag(covariance)[:2].max())), MAX_SEARCH[0])
        beside = 1 + int(reach / LENGTH)
        around = range(max(0, old - beside), min(new - RECENT, old + beside + 1))
        steps = step_between(self.graph.poses[old], self.graph.poses[around.start : around.stop])
        walls = placed(self._walls[around.start : around.stop], steps)
        guess = step_between(self.graph.poses[old], self.graph.poses[new])

        def through(step: Array) -> float:
            """Return the larger share of walls of either side that scans of the other saw through."""
            by_old = seen_through(
                self._walls[new].thinned(MAX_WALLS).moved(step), self._views(around, self.graph.poses[old], every=4)
            )
            by_new = [(compose(step, pose), scan) for pose, scan in self._views([new], self.graph.poses[new], every=2)]
            return max(by_old, seen_through(walls.thinned(MAX_WALLS), by_new))

        loop = find_loop(old, new, walls, self._walls[new], guess, covariance, share=self._loop_share, through=through)
        if loop is not None:
            self.loops.consider(loop)

    def _views(self, parts: Iterable[int], frame: Array, *, every: int) -> list[tuple[Array, LevelScan]]:
        """Return some scans of some parts, with the robot's pose in a frame, given in the world, shape (3,)."""
        members = [each for part in parts for each in self._members(part)[::every]]
        poses = self._poses(members)
        return [(pose, each.level_scan) for pose, each in zip(step_between(frame, poses), members, strict=True)]

    def _find(self, search: MapSearch) -> None:
        """Compare the scans of a lost robot with some more of the old walls; join them if they fit one place only."""
        begin, newest = search.begin, len(self._begins) - 1
        own = self.keyframes[max(self._begins[begin], len(self.keyframes) - FRAGMENT) :]
        poses = self._poses(own)
        fragment = Fragment(
            placed([each.surface for each in own], step_between(poses[-1], poses)),
            [(pose, each.level_scan) for pose, each in zip(step_between(poses[-1], poses), own, strict=True)][::2],
            poses[-1],
            self.graph.poses[begin],
        )
        found = search.find(fragment, self.graph.poses[:begin], self._walls, self._old_views)
        if found is None:
            return
        # Everything since then moves as one piece: Gauss-Newton would not converge from so far away.
        place = compose(self.graph.poses[found.old], found.step)
        since = composed(place, step_between(poses[-1], self.graph.poses[begin:]))
        self.graph.poses = np.concatenate([self.graph.poses[:begin], since])
        step = step_between(self.graph.poses[found.old], self.graph.poses[newest])
        self.loops.close(found.old, newest, step, found.information)
        self._search = None
        self._solve()

    def _old_views(self, parts: Iterable[int], frame: Array) -> Views:
        return self._views(parts, frame, every=4)

    def _solve(self) -> None:
        """Iterate the graph; when it has converged, remove loops that do not fit."""
        before = self.graph.poses
        self.graph.expect(self._bias.errors, self._bias.covariance)
        self.graph.solve(rounds=1)
        self._by_loops, self._solved_errors = self.graph.errors - self._bias.errors, self._bias.errors
        self._forget_since()
        self.loops.settle(before)
        newest = len(self.graph.poses) - 1
        # The graph fixes its first pose, whose uncertainty turns and shifts everything.
        by_first = carried(self.graph.poses[newest], self.graph.poses[0])
        joint = self.graph.joint_covariance(newest)
        self._slopes = np.asarray(np.linalg.solve(joint[3:, 3:], joint[3:, :3]).T)
        own = joint[:3, :3] - self._slopes @ joint[3:, :3]
        self._covariance = own + by_first @ self._prior_covariance @ by_first.T


def _total(own: Array, slopes: Array, bias: OdometryBias) -> Array:
    """Return the total covariance (3, 3) of a pose: its own, and that from the errors of odometry."""
    return np.asarray(own + slopes @ bias.covariance @ slopes.T)
