"""Drives to goals with sensed obstacles: plans around those seen so far, and chooses among sampled motions."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.random import Generator

from mjsim.geometry import Array, Pose
from mjsim.interface import Command, Estimate, Observation, RobotInfo, Shown, WorldMap

from ..paths.grid_search import shown_path
from ..scans.distance_grid import DistanceGrid
from .blocked_reason import reason
from .cost_to_go import UNREACHED, CostToGo
from .goals import check_options, checked_goals
from .moving_things import MOSTLY, MovingThings
from .obstacle_map import ObstacleMap, sampled
from .obstacle_memory import ObstacleMemory
from .path_integral import Leads, MotionPrices, PathIntegral
from .pose_approach import SPEED, PoseApproach
from .range_views import RangeView, Views, touched
from .recovery import SILENT, Around, Attempt, Recovery, Toward
from .scan_alignment import ScanAlignment
from .shown_plan import shown_plan
from .way_out import BLIND, WayOut
from .way_plan import EXPLAINED, WayPlan
from .wheel_slip import SLIPPING, WheelSlip

FINE = 0.025
"""Side of the cells in which obstacles are remembered [m]."""
FORGET, TOUCHED = 60.0, 10.0
"""Time for which an obstacle that is not seen again is remembered, and one that was touched if there is no progress
[s]."""
LOOK, SLOW_LOOK, SPACING = 0.08, 0.16, 0.16
"""Minimum and maximum time between scans that are used, and distance that a robot drives in between [s, s, m]."""
ROOM, AHEAD, UNHURRIED = 0.1, 0.15, 0.32
"""A motion is in the open with at least this clearance, plus this time at its speed; then it is chosen anew only after
the third [m, s, s]."""
SHOW = 0.2
"""Time between two changes of the shown items [s]."""
RARELY = 1.0
"""Minimum time between two ticks that only plan, and choose no motion [s]."""
SOON = 1.5
"""With less time to the goal than this, motions are chosen with each scan [s]."""
BACKWARDS = 0.4
"""Maximum speed while it backs out or looks around [m/s]."""
SETTLED = 0.6
"""Time after which an obstacle counts as static [s]."""
MOVING_RANGE = 5.0
"""Range in which things that move are looked for [m]."""
WINDOW = 2.0
"""How far the robot drives with the same selection of near walls [m]."""


class GoToGoal:
    """Drives to goals around obstacles that its sensors see, as fast as the robot can, and stops at the last goal.

    Obstacles come from the map, if there is one, and from lidars, proximity rays, depth cameras and 3-D lidars. The
    time to the goal is planned on a grid, where unseen space counts as free but doubtful; sampled motions of the
    robot's true shape and limits lead down this time. Without progress the robot backs out, looks around, forgets
    obstacles that it does not see, and tries other ways, a long body by a search for its shape; after 5 s it also says
    why. Dead reckoning is corrected by scans. It takes goals while it runs, and arrives at the heading of a goal.

    References:
        Williams et al. 2018 in `path_integral`; Dijkstra 1959 in `cost_to_go`.
    """

    def __init__(
        self,
        goals: Sequence[Sequence[float]],
        *,
        speed: float | None = None,
        clearance: float = 0.1,
        tolerance: float = 0.1,
        tolerance_deg: float = 4.0,
        cell: float = 0.05,
        show_all: bool = False,
    ) -> None:
        """Set the goals.

        Args:
            goals: Each [x, y] [m], or [x, y, heading] [m, deg], in the frame of the estimate; one alone may be given
                without the outer brackets.
            speed: Maximum speed [m/s]; None for the robot's own.
            clearance: Preferred clearance between the robot's rim and walls [m].
            tolerance: Distance at which a goal counts as reached [m].
            tolerance_deg: Difference at which the heading of a goal counts as reached.
            cell: Side of a cell of the planning grid; in large maps it is doubled until the grid is small enough [m].
            show_all: Whether to show goals, costs and sampled motions too, five times a second, not only the path.
        """
        self._goals = checked_goals(goals)
        check_options(clearance, speed=speed, tolerance=tolerance, tolerance_deg=tolerance_deg, cell=cell)
        self._speed, self._clearance, self._tolerance, self._cell = speed, clearance, tolerance, cell
        self._tolerance_turn, self._show_all = math.radians(tolerance_deg), show_all

    def start(self, robot: RobotInfo, map: WorldMap | None, rng: Generator) -> None:
        """Store the map; the first path is planned later."""
        self._robot = robot
        self._views = Views(robot)
        self._memory, self._touched = (ObstacleMemory(FINE, seconds=FORGET) for _ in range(2))
        top = min(robot.max_speed, math.inf if self._speed is None else self._speed)
        self._slow_pause = min(max(SPACING / top, LOOK), SLOW_LOOK)
        self._local = PathIntegral(robot, rng, top=top)
        self._walls = sampled(map.segments, cell=FINE) if map is not None else np.zeros((0, 2))
        self._near, self._around = self._walls, np.full(2, math.inf)
        known = DistanceGrid.from_segments(map.segments) if len(self._walls) and map is not None else None
        body = self._local.body
        sizes = {"half_width": body.half_width, "gap": self._clearance, "cell": self._cell}
        self._way = WayPlan(self._walls, known, top=top, **sizes)
        self._place: Array = np.array([robot.prior.x, robot.prior.y])
        self._lay_out(self._place)
        self._left, self._is_there, self._is_new = list(self._goals), False, False
        self._approach = None if math.isinf(robot.max_curvature) else PoseApproach(robot, body, top=top)
        long = body.is_long or not math.isinf(robot.max_curvature)
        self._way_out = WayOut(robot, body, bend=self._local.bend, top=top) if long else None
        if long:
            self._way.stand(robot.prior, body)
        self._leaders = [part for part in (self._approach, self._way_out) if part is not None]
        self._recovery, self._slip, self._moving = Recovery(searches=long), WheelSlip(), MovingThings()
        self._looked = self._begun = -math.inf
        self._alignment: ScanAlignment | None = ScanAlignment(robot.prior)
        self._reckoned = self.pose = robot.prior
        self._standing = ObstacleMap(self._goals[-1, :2], self._walls, cell=FINE, half=FINE)
        self._twist, self._scan = np.zeros(3), np.zeros((0, 2))
        self._reason: str | None = None
        self._jammed = self._is_open = self._is_slow = False
        self._now, self._chosen, self._shown_at = 0.0, -math.inf, -math.inf
        self._shown: tuple[Shown, ...] = ()

    def command(self, seen: Observation, belief: Estimate) -> Command:
        """Return the next twist; zero at the last goal, and while every motion would collide."""
        self._now, views = seen.time, self._views.update(seen)
        self.pose = pose = self._pose(seen, belief.pose, views)
        # Remembering half the scans of a fast lidar suffices.
        views = views if seen.time >= self._looked + self._pause - 1e-6 else []
        self._looked = seen.time if views else self._looked
        self._look(seen, pose, views)
        place = self._place
        if self._is_new:
            self._is_new = False
            self._restart(seen.time)
        while self._left and self._arrives(pose, seen.time):
            self._left, self._way.field, self._is_there = self._left[1:], None, False
            self._restart(seen.time)
        if not self._left:
            self._reason = None
            return Command()
        if self._is_there:
            return self._face(pose, seen.time)
        if (command := self._approached(pose, seen)) is not None:
            return command
        way, stuck = self._way, self._recovery.stuck
        # The first plan takes this whole tick, but not each tick if goals keep coming.
        is_first = way.field is None and seen.time > self._begun + RARELY
        self._begun = seen.time if is_first else self._begun
        field = way.to(self._left[0][:2], place, seen.time, points=self._obstacles, stuck=stuck, busy=bool(views))
        self._slip.update(pose, seen.odometry, views, seen.time)
        # Slipping wheels do not count as progress.
        driven = self._slip.held or pose
        seconds = float(field.at(driven.as_array()[:2]))
        if self._recovery.update(driven, seconds, seen.time, area=way.seen_area, barred=way.is_barred):
            self._memory.forget(seen.time - 1.0, kept=self._views.hidden(pose, self._memory.points))
            self._touched.forget(seen.time - TOUCHED)
            way.begin()
        is_lost = self._approach is not None and self._approach.since(seen.time) > SILENT
        is_lost |= self._slip.lasts(seen.time) > SLIPPING or self._recovery.silent(seen.time)
        self._reason = self._why() if is_lost else None
        if (command := self._led_out(pose, seen, field)) is not None:
            return command
        self._local.shift(self._robot.dt)
        if views and not is_first and self._is_hurried(seen.time):
            self._choose(seen, pose, field)
        elif self._twist.any():
            self._twist = self._local.planned
        forward, left, turn = self._twist.tolist()
        return Command(forward=forward, left=left, turn=turn)

    def show(self) -> tuple[Shown, ...]:
        """Return the planned path, in the frame of the estimate, if there is one; with `show_all` more."""
        if not self._left or self._way.field is None:
            self._shown_at = -math.inf
            return ()
        if self._now < self._shown_at + SHOW - 1e-6:
            return self._shown
        self._shown_at, path = self._now, self._way.field.path(self._place)
        path = path[:0] if self._way.is_barred else path
        path = next((part.left for part in self._leaders if len(part.left)), path)
        more = shown_plan(self._way, self._local, self._left, self._place) if self._show_all else ()
        self._shown = (*more, *(shown_path(path) if len(path) > 1 else ()))
        return self._shown

    def blocked(self) -> str | None:
        """Return why the robot does not get nearer to its goal, after 5 s; None while it does."""
        return self._reason

    @property
    def is_done(self) -> bool:
        """Whether no goal is left."""
        return not self._left

    def take_goal(self, x: float, y: float, heading: float | None = None) -> None:
        """Drive to this goal instead of all others; repeating the current goal changes nothing.

        Args:
            x: x in the frame of the estimate [m].
            y: y in the frame of the estimate [m].
            heading: Heading at the goal [rad]; None for any.
        """
        goal = np.array([[x, y, math.nan if heading is None else heading]])
        if np.array_equal(self._left, goal, equal_nan=True):
            return
        self._goals = goal
        self._left, self._is_there, self._is_new = list(self._goals), False, True
        self._lay_out(self._place)

    def _restart(self, now: float) -> None:
        """Begin with a new goal at a time [s]."""
        self._recovery.restart(now)
        for part in self._leaders:
            part.restart()

    def _arrives(self, pose: Pose, now: float) -> bool:
        """Return whether the robot is at its goal and faces where it should; note if it turns on the spot there."""
        x, y, heading = self._left[0].tolist()
        is_near = math.hypot(x - pose.x, y - pose.y) < self._tolerance
        if math.isnan(heading):
            return is_near
        if is_near and self._approach is None and not self._is_there:
            self._recovery.restart(now)
            self._is_there = True
        return (is_near or self._is_there) and abs(
            math.remainder(heading - pose.heading, math.tau)
        ) < self._tolerance_turn

    def _approached(self, pose: Pose, seen: Observation) -> Command | None:
        """Return the command that leads a car to the heading of its goal; None while it drives as usual."""
        approach, goal, speed = self._approach, self._left[0], seen.odometry.forward / seen.dt
        self._is_slow = approach is not None and math.isfinite(goal[2]) and approach.is_near(pose, goal, seen.time)
        if approach is None or not self._is_slow or abs(speed) > 1.5 * SPEED:
            return None
        near = np.concatenate([self._walls, self._obstacles])
        map = ObstacleMap(self._place, near, cell=FINE, half=approach.reach)
        command = approach.command(pose, speed, goal, map, seen.time)
        self._local.reset()
        self._twist = np.array([command.forward, 0.0, command.turn])
        self._recovery.restart(seen.time)
        self._reason = self._why() if approach.since(seen.time) > SILENT else None
        return command

    def _led_out(self, pose: Pose, seen: Observation, field: CostToGo) -> Command | None:
        """Return the command that leads a long body where the goal is nearer; None while it drives as usual."""
        if self._way_out is None or self._recovery.attempt is not Attempt.SEARCH:
            return None
        near, speed = np.concatenate([self._near, self._obstacles]), seen.odometry.forward / seen.dt
        command = self._way_out.command(pose, speed, field, near, self._unseen(pose))
        self._stop()
        if command is None:
            self._recovery.drive(seen.time, dead_end=self._way_out.dead_end)
            self._way.begin()
            return Command()
        self._twist = np.array([command.forward, 0.0, command.turn])
        return command

    def _unseen(self, pose: Pose) -> Array:
        """Return places around a long body that no sensor has seen or faces, shape (n, 2) [m]."""
        if self._way_out is None:
            return np.zeros((0, 2))
        points = self._way.unseen_around(self._place, half=self._local.body.reach + BLIND)
        return points[self._views.hidden(pose, points)]

    def _face(self, pose: Pose, now: float) -> Command:
        """Return the command that turns the robot to the heading of its goal, on the side where there is room."""
        apart = math.remainder(float(self._left[0][2]) - pose.heading, math.tau)
        near = np.concatenate([self._near, self._obstacles])
        obstacles = ObstacleMap(self._place, near, cell=FINE, half=self._local.body.reach + 0.2)
        rate = self._local.turn(pose, apart, obstacles)
        if rate is not None:
            self._recovery.restart(now)
        self._reason = self._why() if rate is None and self._recovery.silent(now) else None
        self._stop()
        return Command(turn=rate or 0.0)

    def _lay_out(self, place: Array) -> None:
        """Lay out the planning grid around a place (2,) of the robot [m], what is remembered, and the goals."""
        self._way.lay_out(self._goals[-1, :2], np.concatenate([self._goals[:, :2], [place], self._obstacles]))

    def _pose(self, seen: Observation, estimate: Pose, views: list[RangeView]) -> Pose:
        """Return the pose used for driving: the estimate, or dead reckoning corrected by scans."""
        odometry = seen.odometry
        if self._alignment is None:
            return estimate
        self._reckoned = self._reckoned @ Pose(odometry.forward, odometry.left, odometry.turn)
        apart = self._reckoned.inverse() @ estimate
        if math.hypot(apart.x, apart.y) + abs(apart.heading) > 1e-6:
            # An estimator is more accurate.
            self._alignment = None
            return estimate
        self._alignment.move(odometry)
        for view in views[1:]:
            points = view.points()
            keep = np.abs(points).max(axis=1, initial=0.0) < 0.95 * MOVING_RANGE
            keep &= ~self._moving.near(self._alignment.pose.transform(points))
            self._alignment.align(points[keep], self._standing)
        return self._alignment.pose

    def _look(self, seen: Observation, pose: Pose, views: list[RangeView]) -> None:
        """Remember what the sensors see."""
        odometry = seen.odometry
        if self._alignment is None:
            for memory in (self._memory, self._touched):
                memory.track(pose, Pose(odometry.forward, odometry.left, odometry.turn))
        if seen.bump:
            # No sensor sees this point, so none contradicts it.
            self._touched.add(pose, [], pose.transform(touched(self._robot, np.array(seen.bump))), seen.time)
        self._place = np.array([pose.x, pose.y])
        if len(self._walls) and not np.abs(self._place - self._around).max() < WINDOW:
            half = max(self._local.reach, MOVING_RANGE) + WINDOW
            self._around = self._place
            self._near = self._walls[np.abs(self._walls - self._place).max(axis=1) < half]
        if views:
            self._remember(pose, views, seen.time)
        for view in views:
            self._way.see(pose, view, seen.time)
        if not self._way.contains(self._place):
            self._lay_out(self._place)
        measured = np.array([odometry.forward, odometry.left, odometry.turn]) / seen.dt
        limits = np.array([self._robot.max_speed, max(self._robot.max_left, 0.1), self._robot.max_turn])
        surprise = np.abs(measured - self._twist) > 0.25 * limits
        self._twist = np.where(surprise, measured, self._twist)

    @property
    def _obstacles(self) -> Array:
        """Obstacles that have been seen or touched, shape (n, 2) [m]."""
        return np.concatenate([self._memory.points, self._touched.points])

    def _remember(self, pose: Pose, views: list[RangeView], now: float) -> None:
        """Remember the hits of a scan, and follow what moves."""
        self._scan = points = pose.transform(np.concatenate([view.points() for view in views]))
        standing = np.concatenate([self._near, self._memory.older(now - SETTLED)])
        self._standing = ObstacleMap(self._place, standing, cell=2.0 * FINE, half=MOVING_RANGE)
        x, y = points.T
        fresh = (np.abs(points - self._place).max(axis=1) < MOVING_RANGE) & (self._standing.at(x, y) > EXPLAINED)
        fresh[fresh] = ~self._way.unseen(points[fresh])
        # Many new points mean that the estimate is wrong.
        if len(views) > 1 and np.count_nonzero(fresh) < MOSTLY * len(points):
            self._moving.update(points[fresh], pose, now)
        self._memory.add(pose, views, points, now)

    def _is_hurried(self, now: float) -> bool:
        """Return whether to choose a motion now: always, or in the open from time to time."""
        waits = self._is_open and now < self._chosen + UNHURRIED - 1e-6 and self._recovery.attempt is Attempt.DRIVE
        return not waits or bool(self._moving.tracked) or self._local.apart(self._scan) < 0.5 * self._room

    @property
    def _pause(self) -> float:
        """Time between scans that are used [s]."""
        if self._moving.tracked:
            return LOOK
        return SLOW_LOOK if self._is_open else self._slow_pause

    @property
    def _room(self) -> float:
        """Clearance with which a motion is in the open [m]."""
        return ROOM + AHEAD * math.hypot(self._twist[0], self._twist[1])

    def _choose(self, seen: Observation, pose: Pose, field: CostToGo) -> None:
        """Choose the next twist by the local planner."""
        near = np.concatenate([self._near, self._obstacles, self._unseen(pose)])
        obstacles = ObstacleMap(self._place, near, cell=FINE, half=self._local.reach)
        attempt, prices = self._recovery.attempt, MotionPrices(top=SPEED if self._is_slow else math.inf)
        self._chosen, self._is_open = seen.time, False
        leads: Leads = field
        if attempt is Attempt.BACK:
            leads, prices = Toward(self._recovery.target), MotionPrices(reverse=0.0, top=BACKWARDS)
        elif attempt is Attempt.LOOK:
            leads, prices = Around(pose.heading), MotionPrices(top=BACKWARDS)
        elif self._way.ends(self._place) or float(field.at(self._place)) >= UNREACHED:
            self._stop()
            return
        prices = replace(prices, things=tuple(self._moving.predicted(pose, seen.time)))
        twist = self._local.twist(pose, self._twist, obstacles, leads, prices)
        self._jammed = twist is None
        self._twist = np.zeros(3) if twist is None else twist
        # A fast robot may meet moving things before the next choice.
        if self._slow_pause > LOOK and twist is not None and attempt is Attempt.DRIVE and not prices.things:
            self._is_open = self._local.clearance > self._room and float(field.at(self._place)) > SOON

    def _stop(self) -> Command:
        """Return the command to stand still."""
        self._local.reset()
        self._twist = np.zeros(3)
        return Command()

    def _why(self) -> str:
        """Return why the robot does not get nearer to its goal."""
        parks = self._approach is not None and self._approach.since(self._now) > SILENT
        slips, barred = self._slip.held is not None, self._way.is_barred
        return reason(self._left[0], turns=self._is_there, parks=parks, slips=slips, jammed=self._jammed, barred=barred)
