"""Drives a car the last metres to a pose: plans with its turning circle, and follows the curve."""

import heapq
import itertools
import math
from collections.abc import Callable
from functools import partial

import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.interface import Command, RobotInfo

from ..paths.reeds_shepp import Curve, curves, length_of, poses_on
from .body_discs import BodyDiscs
from .curve_follower import SPACING, CurveFollower
from .obstacle_map import ObstacleMap

NEAR, NEAREST = 3.0, 1.0
"""Distance to the goal from which it plans [radii of the tightest turn], at least [m]."""
WIDER = 1.15
"""Factor on the radius of the tightest turn, to be able to correct."""
SPEED = 0.4
"""Speed on the curve [m/s]."""
STANDING = 0.03
"""Speed below which the robot stands [m/s]."""
OFF = 0.12
"""Distance from the curve at which it replans [m]."""
STEP = 0.15
"""Length of a piece of the search [radii]."""
PLACES, HEADINGS = 8.0, 60
"""Poses of the search in the same cell are the same: cells per radius, and in a turn."""
CUSP = 1.0
"""Cost of a change of direction [radii]."""
EXPANDED, BATCH = 1000, 8
"""Maximum number of expanded poses, in total and per tick."""
TRIED = 4
"""Number of shortest curves that are tried."""
PAUSE = 4.0
"""Time until the next search after one that found no path [s]."""

ROOM, DRIVEN_ROOM, CLOSER = 0.05, 0.01, 0.005
"""Clearance of the curve when it is planned and while it is driven; nearer obstacles at the start may come nearer by
the last [m]."""

TOUCH = 0.02
"""Obstacles may seem this much nearer than they are [m]."""

Clearance = Callable[[Array], Array]
"""Returns the clearances of poses, shape (n, 3) [m]."""


class PoseSearch:
    """A search for a curve between two poses, some steps at a time.

    It begins at the goal, where there is less room: a curve can be driven both ways.

    References:
        Dolgov, Thrun, Montemerlo, Diebel, Path Planning for Autonomous Vehicles in Unknown Semi-structured
        Environments, IJRR 29(5), 2010, section 2: hybrid A*, with shortest curves to the goal as heuristic and end.
    """

    def __init__(self, start: Pose, goal: Pose, *, radius: float, clearance: Clearance) -> None:
        """Begin.

        Args:
            start: [m, rad]
            goal: [m, rad]
            radius: Radius of the turns [m].
            clearance: Returns the clearances of poses.
        """
        self._start, self._radius, self._clearance = start, radius, clearance
        ends = np.stack([start.as_array(), goal.as_array()])
        self._room = min(ROOM, float(clearance(ends).min()) - CLOSER)
        self._count = itertools.count()
        self._queue: list[tuple[float, int, float, Pose, Curve, bool]] = [(0.0, 0, 0.0, goal, (), False)]
        if self._room < -TOUCH:
            self._queue = []
        self._closed = set[tuple[int, int, int]]()
        self.found: Curve | None = None
        """The curve from start to goal."""

    @property
    def is_over(self) -> bool:
        """Whether nothing is left to try."""
        return self.found is not None or not self._queue or len(self._closed) >= EXPANDED

    def advance(self, count: int) -> None:
        """Expand a number of poses."""
        for _ in range(count):
            if self.is_over:
                return
            _, _, cost, pose, way, is_priced = heapq.heappop(self._queue)
            cell = self._cell(pose)
            if cell in self._closed:
                continue
            if not is_priced:
                rest = list(itertools.islice(curves(pose, self._start, radius=self._radius), TRIED))
                whole = next((way + curve for curve in rest if self._fits(pose, curve)), None)
                self.found = None if whole is None else tuple((steer, -length) for steer, length in whole[::-1])
                self._push(cost + length_of(rest[0]), cost, pose, way, is_priced=True)
                continue
            self._closed.add(cell)
            self._expand(cost, pose, way)

    def _expand(self, cost: float, pose: Pose, way: Curve) -> None:
        """Add the poses after short pieces in all directions."""
        for steer, drive in itertools.product((1, 0, -1), (1, -1)):
            piece = (steer, STEP * drive)
            if way and way[-1] == (steer, -STEP * drive):
                continue
            if self._fits(pose, (piece,)):
                poses, _, _ = poses_on(pose, (piece,), radius=self._radius, spacing=math.inf)
                turns = bool(way) and way[-1][1] * drive < 0.0
                after = cost + STEP + CUSP * turns
                self._push(after, after, Pose.from_array(poses[-1]), (*way, piece), is_priced=False)

    def _push(self, total: float, cost: float, pose: Pose, way: Curve, *, is_priced: bool) -> None:
        heapq.heappush(self._queue, (total, next(self._count), cost, pose, way, is_priced))

    def _fits(self, pose: Pose, curve: Curve) -> bool:
        poses, _, _ = poses_on(pose, curve, radius=self._radius, spacing=0.05)
        return bool(self._clearance(poses[1:]).min() >= self._room)

    def _cell(self, pose: Pose) -> tuple[int, int, int]:
        size = self._radius / PLACES
        turn = math.floor(pose.heading / (2.0 * math.pi) * HEADINGS) % HEADINGS
        return math.floor(pose.x / size), math.floor(pose.y / size), turn


class PoseApproach:
    """Takes over near a goal with a heading, for robots that cannot turn on the spot."""

    def __init__(self, robot: RobotInfo, body: BodyDiscs, *, top: float) -> None:
        """Take the limits of the robot, its body and its maximum speed [m/s]."""
        self._body = body
        self._follower = CurveFollower(robot, bend=robot.max_curvature, top=min(top, SPEED))
        self._radius = WIDER / robot.max_curvature
        self._near = max(NEAR * self._radius, NEAREST)
        self.restart()

    @property
    def reach(self) -> float:
        """How far the curves may lead from where they begin [m]."""
        return 2.0 * self._near + self._body.reach

    def restart(self) -> None:
        """Begin with a new goal."""
        self._search: PoseSearch | None = None
        self._follower.stop()
        self._paused = -math.inf
        self._room = 0.0
        self._begun: float | None = None

    def is_near(self, pose: Pose, goal: Array, now: float) -> bool:
        """Return whether it plans, or drives, from here to a goal of x, y [m] and heading [rad]."""
        near = math.hypot(goal[0] - pose.x, goal[1] - pose.y) < self._near
        return now >= self._paused and (near or self._follower.is_busy)

    def since(self, now: float) -> float:
        """Return how long it has searched for a path [s]."""
        return 0.0 if self._begun is None else now - self._begun

    def command(self, pose: Pose, speed: float, goal: Array, map: ObstacleMap, now: float) -> Command:
        """Return the next twist.

        Args:
            pose: Pose of the robot.
            speed: Its current speed [m/s].
            goal: x, y [m] and heading [rad].
            map: Obstacles.
            now: [s]
        """
        clearance = partial(_clearance, self._body, map)
        if self._follower.is_busy:
            left = self._follower.left
            near = math.dist(left[0, :2], (pose.x, pose.y)) < OFF
            if near and float(clearance(left[::3]).min()) >= min(DRIVEN_ROOM, self._room):
                self._begun = None
                return self._follower.command(pose)
            self._follower.stop()
        self._begun = now if self._begun is None else self._begun
        if abs(speed) > STANDING:
            self._search = None
            return Command()
        if self._search is None:
            self._search = PoseSearch(pose, Pose.from_array(goal), radius=self._radius, clearance=clearance)
        self._search.advance(BATCH)
        if self._search.found is not None:
            curve = self._search.found
            poses, bends, ways = poses_on(pose, curve, radius=self._radius, spacing=SPACING)
            self._follower.begin(poses, bends, ways)
            self._room = float(clearance(poses).min()) - CLOSER
        elif self._search.is_over:
            self._paused = now + PAUSE
        if self._search.is_over:
            self._search = None
        return Command()

    @property
    def left(self) -> Array:
        """What is left of the curve, shape (n, 2) [m]."""
        return self._follower.left[:, :2]


def _clearance(body: BodyDiscs, map: ObstacleMap, poses: Array) -> Array:
    """Return the clearances of poses, shape (n, 3) [m]."""
    return body.clearance(poses[:, 0], poses[:, 1], poses[:, 2], map)
