"""A map of scans in parts: within a part scans stay as they lie, and a graph of the parts closes loops."""

from collections import deque
from dataclasses import dataclass

import numpy as np

from mjsim.geometry import Array

from .ekf_models import odometry_motion
from .level_scan import LevelScan
from .loop_closing import Loop, agree, find_loop
from .pose_graph import PoseGraph, carried, compose, step_between
from .scan_matching import Surface, joined
from .scan_search import Laid

LOCAL = 6
"""Scans back that make up the walls on which a new one is laid."""
PART = 8
"""Scans that make up a part of the map."""
RECENT = 4
"""Parts back from which on a place counts as an old one."""
TRIED = 3
"""Old parts that a new one is compared with; twice as many where the robot may have drifted by more than 1 m."""
MISFIT = 100.0
"""Squared error, in units, of a loop that is given up."""
UNSOLVED = 16
"""So many parts may be added before covariances are worked out anew."""
SETTLED = 0.005
"""The graph is solved on while poses move by more than this [m, rad]."""


@dataclass(frozen=True, slots=True, eq=False)
class Keyframe:
    """A scan that stays in the map."""

    looked: LevelScan
    surface: Surface
    """The walls that it shows, in the robot's frame."""
    part: int
    """Of the map."""
    place: Array
    """Its pose in the frame of the part, shape (3,)."""


class PartsMap:
    """Scans of one robot, in parts of a few each; a part's frame is that of its first scan.

    References:
        Hess, Kohler, Rapp, Andor, Real-Time Loop Closure in 2D LIDAR SLAM, ICRA 2016, section IV and V.
    """

    def __init__(self, prior: Array, prior_covariance: Array, *, loop_distance: float, loop_share: float) -> None:
        """Begin without scans.

        Args:
            prior: Where the robot starts, world frame, shape (3,) [m, m, rad].
            prior_covariance: Of it, shape (3, 3).
            loop_distance: How near an old part must be to be tried for a loop [m].
            loop_share: Of the walls seen near old ones, the share that must lie on them for a loop to count.
        """
        self._loop_distance, self._loop_share = loop_distance, loop_share
        self._prior_covariance = prior_covariance
        self._motion = odometry_motion()
        self.keyframes: list[Keyframe] = []
        self.graph = PoseGraph(prior[None])
        """Its poses are those of the parts."""
        self.loops = 0
        """How many are closed."""
        self._covariance = prior_covariance
        self._since: tuple[Array, Array] = (np.zeros(3), np.zeros((3, 3)))
        self._begins = [0]
        self._walls: list[Surface] = []
        self._untried: deque[tuple[int, int, Array]] = deque()
        self._unconfirmed: list[Loop] = []
        self._moving = False
        self._begin_way()

    def _begin_way(self) -> None:
        """Count the way from the newest part's frame from here.

        Loops are looked for in windows that are cautious, as if each match erred for itself; what is told of the
        robot's pose is what matches err by.
        """
        self._place, self._cautious = np.zeros(3), np.zeros((3, 3))
        self._lasting, self._passing = np.zeros((3, 3)), np.zeros((3, 3))

    def add(self, looked: LevelScan, surface: Surface, laid: Laid) -> None:
        """Add a scan.

        Args:
            looked: As it came.
            surface: The walls that it shows, in the robot's frame.
            laid: The robot in the frame of the scan before, or of the prior.
        """
        _, self._passing = self._after(self._place, np.zeros((3, 3)), laid.pose, laid.covariance - laid.lasting)
        _, self._cautious = self._after(self._place, self._cautious, laid.pose, laid.covariance)
        self._place, self._lasting = self._after(self._place, self._lasting, laid.pose, laid.lasting)
        if len(self.keyframes) - self._begins[-1] >= PART:
            self._begin_part()
        self.keyframes.append(Keyframe(looked, surface, len(self._begins) - 1, self._place))

    def belief(self) -> tuple[Array, Array]:
        """Return the pose of the newest scan in the world, shape (3,), and its covariance, shape (3, 3)."""
        return self._after(self.graph.poses[-1], self._covariance, self._place, self._spread)

    def poses(self) -> Array:
        """Return the poses of all scans in the world, shape (n, 3)."""
        return np.array([self._pose(each) for each in self.keyframes]).reshape(-1, 3)

    @property
    def recent(self) -> int:
        """How many scans show the recent walls."""
        return min(len(self.keyframes), LOCAL)

    def recent_walls(self) -> Surface:
        """Return the walls of the last few scans in the frame of the newest one; at least one scan is there."""
        last = self.keyframes[-LOCAL:]
        poses = np.array([self._pose(each) for each in last])
        steps = step_between(poses[-1], poses)
        return joined([each.surface.moved(step) for each, step in zip(last, steps, strict=True)])

    def work(self) -> None:
        """Do one piece of what waits: compare a new part with an old one, or solve the graph further."""
        if self._untried:
            self._try_loop(*self._untried.popleft())
        elif self._moving:
            self._solve()

    def finish(self) -> None:
        """Do all that waits."""
        while self._untried or self._moving:
            self.work()

    @property
    def _spread(self) -> Array:
        """Covariance of the newest place in its part: what adds up on the way, and what the last match errs by."""
        return self._lasting + self._passing

    def _pose(self, keyframe: Keyframe) -> Array:
        return compose(self.graph.poses[keyframe.part], keyframe.place)

    def _after(self, pose: Array, covariance: Array, step: Array, spread: Array) -> tuple[Array, Array]:
        """Return a pose and its covariance after a step with a covariance of its own."""
        moved, F, G = self._motion(pose, step)
        return moved, F @ covariance @ F.T + G @ spread @ G.T

    def _begin_part(self) -> None:
        """Finish the part at hand, and begin another at the newest place."""
        part, members = len(self._begins) - 1, self.keyframes[self._begins[-1] :]
        self._walls.append(joined([each.surface.moved(each.place) for each in members]))
        old = self._near(part)
        self._untried.extend(zip(old, [part] * len(old), self._step_covariances(old, part), strict=True))
        information = np.asarray(np.linalg.inv(self._cautious + 1e-10 * np.eye(3)), dtype=float)
        pose, self._covariance = self.belief()
        self.graph.add_pose(pose)
        self.graph.add_step(part, part + 1, self._place, information, self._spread)
        self._since = self._after(*self._since, self._place, self._cautious)
        self._begin_way()
        self._begins.append(len(self.keyframes))

    def _step_covariances(self, ones: list[int], other: int) -> list[Array]:
        """Return the covariances of the steps from old parts to the newest one, shape (3, 3) each.

        They are those of the last solution, carried on along the way since.
        """
        if not ones:
            return []
        if max(ones) >= self.graph.solved or other - self.graph.solved > UNSOLVED:
            self.graph.factorise()
            self._since = (np.zeros(3), np.zeros((3, 3)))
        last, poses = self.graph.solved - 1, self.graph.poses
        until = self.graph.step_covariances(ones, last)
        steps = step_between(poses[ones], poses[last])
        return [self._after(step, spread, *self._since)[1] for step, spread in zip(steps, until, strict=True)]

    def _near(self, part: int) -> list[int]:
        """Return the old parts of the map where a finished one might be, the nearest first."""
        old = part - RECENT
        if old < 1:
            return []
        middles = [compose(self.graph.poses[k], self._middle(k)) for k in (*range(old), part)]
        apart = np.hypot(*(np.array(middles)[:-1, :2] - middles[-1][:2]).T)
        drift = 2.0 * float(np.sqrt(np.trace(self._covariance[:2, :2])))
        chosen: list[int] = []
        for k in np.argsort(apart).tolist():
            if apart[k] > self._loop_distance + drift or len(chosen) == TRIED * (1 + (drift > 2.0)):
                break
            if all(abs(k - other) > 1 for other in chosen):
                chosen.append(k)
        return chosen

    def _middle(self, part: int) -> Array:
        """Return the pose of the middle scan of a finished part in its frame, shape (3,)."""
        return self.keyframes[self._begins[part] + PART // 2].place

    def _try_loop(self, old: int, new: int, covariance: Array) -> None:
        """Compare a new part with an old one and its neighbours."""
        around = range(max(0, old - 1), min(new - RECENT, old + 2))
        steps = step_between(self.graph.poses[old], self.graph.poses[around.start : around.stop])
        walls = joined([self._walls[k].moved(step) for k, step in zip(around, steps, strict=True)])
        guess = step_between(self.graph.poses[old], self.graph.poses[new])
        loop = find_loop(old, new, walls, self._walls[new], guess, covariance, share=self._loop_share)
        if loop is not None:
            self._consider(loop)

    def _consider(self, loop: Loop) -> None:
        """Close a loop if it is certain, or agrees with another; else remember it."""
        witnesses = [other for other in self._unconfirmed if agree(loop, other, self.graph.poses)]
        if not loop.certain and not witnesses:
            self._unconfirmed.append(loop)
            return
        for each in (loop, *witnesses):
            self.graph.add_step(each.old, each.new, each.step, each.information)
            self.loops += 1
        self._unconfirmed = [other for other in self._unconfirmed if other not in witnesses]
        self._moving = True

    def _solve(self) -> None:
        """Solve the graph further; when it is settled, give up the loops that do not fit."""
        before = self.graph.poses
        self.graph.solve(rounds=1)
        self._since = (np.zeros(3), np.zeros((3, 3)))
        self._moving = bool(np.abs(step_between(before, self.graph.poses)).max() > SETTLED)
        if not self._moving:
            dropped = self.graph.drop_misfits(MISFIT)
            self.loops, self._moving = self.loops - dropped, dropped > 0
        newest = len(self.graph.poses) - 1
        # The graph holds its first pose; how unsure that one is turns and shifts all.
        by_first = carried(self.graph.poses[newest], self.graph.poses[0])
        self._covariance = self.graph.covariance(newest) + by_first @ self._prior_covariance @ by_first.T
