"""Drives to goals by what it sees: plans on the obstacles seen so far, and drives by sampled motions."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from mjsim.geometry import Array, Pose
from mjsim.interface import Command, Estimate, Observation, RobotInfo, ShownLines, WorldMap

from .cost_to_go import MOST_PRICE, UNREACHED, CostToGo, Planner, time_per_metre
from .distance_grid import DistanceGrid
from .grid_search import shown_path
from .moving_things import GATE, MovingThings
from .obstacle_map import ObstacleMap
from .obstacle_memory import ObstacleMemory
from .path_integral import Leads, MotionPrices, PathIntegral
from .range_views import RangeView, Views
from .recovery import Around, Attempt, Recovery, Toward
from .scan_alignment import ScanAlignment

FINE = 0.025
"""Side of the cells in which obstacles are remembered [m]."""
FORGET = 60.0
"""Time for which an obstacle that is not seen again is remembered [s]."""
REPLAN, REFRESH = 0.28, 1.0
"""Time between plans while something changes on the way, and while it changes elsewhere [s]."""
BESIDE = 0.4
"""Changes nearer than this to the sides of the robot on its way are planned for at once [m]."""
BEYOND = 2.5
"""Cells are planned up to this time farther from the goal than the robot [s]."""
LOOK = 0.08
"""Time between scans that are used [s]."""
MARGIN = 3.0
"""How far the planning grid reaches beyond start, goals and map, to drive around obstacles [m]."""
CELLS = 90_000
"""Largest number of cells of the planning grid; beyond, they are larger."""
SIGHT, RAYS = 8.0, 180
"""Range in which, and number of beams by which a scan says what has been seen [m]."""
BACKWARDS = 0.4
"""Maximum speed while it backs out or looks round [m/s]."""
SETTLED = 0.6
"""Time since which obstacles stand [s]."""
MOSTLY = 0.5
"""Share of fresh points above which a scan says nothing of what moves."""
MOVING_RANGE = 5.0
"""Range in which things that move are looked for [m]."""
WINDOW = 2.0
"""How far the robot drives with the same selection of near walls [m]."""
EXPLAINED = 0.15
"""Hits this near to a wall of the map are that wall [m]."""


class GoToGoal:
    """Drives to goals around what its sensors see, as fast as the robot can, and stops at the last.

    Obstacles come from the map, if there is one, and from lidars, proximity rays, depth cameras and 3-D lidars. The
    time to the goal is planned on a grid, where unseen space counts as free but doubtful; sampled motions of the
    robot's true shape and limits lead down this time. Without progress the robot backs out, looks round, forgets
    obstacles that it does not see, and tries other ways; after 5 s it also says why. Dead reckoning is corrected by
    scans.

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
        cell: float = 0.05,
    ) -> None:
        """Set the goals.

        Args:
            goals: Each (x, y) [m], in the frame of the estimate; a single pair is one goal.
            speed: Maximum speed [m/s]; None for the robot's own.
            clearance: Preferred clearance between the robot's rim and walls [m].
            tolerance: Distance at which a goal counts as reached [m].
            cell: Side of a cell of the planning grid; in large maps it is doubled until the grid is small enough [m].
        """
        self._goals = np.atleast_2d(np.asarray(goals, dtype=float))
        if self._goals.ndim != 2 or self._goals.shape[1:] != (2,):
            raise ValueError(f"goals has shape {self._goals.shape}; give at least one [x, y]")
        if not np.isfinite(self._goals).all():
            raise ValueError(f"goals is {self._goals.tolist()}; give finite numbers [m]")
        for key, value in {"speed": speed, "tolerance": tolerance, "cell": cell}.items():
            if value is not None and not value > 0:
                raise ValueError(f"{key} is {value}; it must be above 0")
        if not clearance >= 0:
            raise ValueError(f"clearance is {clearance}; it must not be below 0")
        self._speed, self._clearance, self._tolerance, self._cell = speed, clearance, tolerance, cell

    def start(self, robot: RobotInfo, map: WorldMap | None, rng: Generator) -> None:
        """Take the map; the first path is planned later."""
        self._robot = robot
        self._views, self._memory = Views(robot), ObstacleMemory(FINE, seconds=FORGET)
        self._local = PathIntegral(robot, rng, top=robot.max_speed if self._speed is None else self._speed)
        self._top = min(robot.max_speed, math.inf if self._speed is None else self._speed)
        self._walls = _sampled(map.segments) if map is not None else np.zeros((0, 2))
        self._near, self._around = self._walls, np.full(2, math.inf)
        self._known = DistanceGrid.from_segments(map.segments) if len(self._walls) and map is not None else None
        self._left = list(self._goals)
        self._lay_out(np.concatenate([self._goals, [[robot.prior.x, robot.prior.y]], self._walls]))
        self._recovery = Recovery()
        self._field: CostToGo | None = None
        self._planned, self._checked, self._looked = -math.inf, -math.inf, -math.inf
        self._noted = dict[str, float]()
        self._moving = MovingThings()
        self._alignment: ScanAlignment | None = ScanAlignment(robot.prior)
        self._reckoned = robot.prior
        self._standing = ObstacleMap(self._goals[-1], self._walls, cell=FINE, half=FINE)
        self._twist = np.zeros(3)
        self._reason: str | None = None
        self._jammed = self._is_shut = False

    def command(self, seen: Observation, belief: Estimate) -> Command:
        """Return the next twist; zero at the last goal, and while every motion would collide."""
        views = self._views.update(seen)
        pose = self._pose(seen, belief.pose, views)
        # Half the scans of a fast lidar suffice to remember.
        views = views if seen.time >= self._looked + LOOK - 1e-6 else []
        self._looked = seen.time if views else self._looked
        self._look(seen, pose, views)
        place = self._place
        while self._left and np.hypot(*(self._left[0] - place)) < self._tolerance:
            self._left, self._field = self._left[1:], None
            self._recovery.restart(seen.time)
        if not self._left:
            self._reason = None
            return Command()
        field = self._plan(place, seen.time)
        seconds = float(field.at(place))
        if self._is_shut and seconds >= UNREACHED:
            self._reason = self._why(seconds) if self._recovery.silent(seen.time) else None
            return self._stop()
        if self._recovery.update(pose, seconds, seen.time):
            self._memory.forget(seen.time - 1.0)
            self._planned = -math.inf
        self._reason = self._why(seconds) if self._recovery.silent(seen.time) else None
        self._local.shift(self._robot.dt)
        if views:
            self._choose(seen, pose, field)
        elif self._twist.any():
            self._twist = self._local.planned
        forward, left, turn = self._twist.tolist()
        return Command(forward=forward, left=left, turn=turn)

    def show(self) -> tuple[ShownLines, ...]:
        """Return the planned path, in the frame of the estimate, if there is one."""
        if not self._left or self._field is None:
            return ()
        path = self._field.path(self._place)
        return shown_path(path) if len(path) > 1 else ()

    def blocked(self) -> str | None:
        """Return why the robot does not get nearer to its goal, after 5 s; None while it does."""
        return self._reason

    def _pose(self, seen: Observation, estimate: Pose, views: list[RangeView]) -> Pose:
        """Return the pose that it drives by: the estimate, but dead reckoning is corrected by scans."""
        odometry = seen.odometry
        if self._alignment is None:
            return estimate
        self._reckoned = self._reckoned @ Pose(odometry.forward, odometry.left, odometry.turn)
        apart = self._reckoned.inverse() @ estimate
        if math.hypot(apart.x, apart.y) + abs(apart.heading) > 1e-6:
            # An estimator knows better.
            self._alignment = None
            return estimate
        self._alignment.move(odometry)
        for view in views[1:]:
            points = view.points()
            keep = np.abs(points).max(axis=1, initial=0.0) < 0.95 * MOVING_RANGE
            keep &= ~self._strange(self._alignment.pose.transform(points))
            self._alignment.align(points[keep], self._standing)
        return self._alignment.pose

    def _strange(self, points: Array) -> NDArray[np.bool_]:
        """Return which points (n, 2) [m] say nothing of where the robot is: what moves, or may unless that is most."""
        away = {thing: np.hypot(*(points - thing.place).T) < thing.radius + GATE for thing in self._moving.tracked}
        may = np.logical_or.reduce([np.zeros(len(points), dtype=bool), *away.values()])
        if np.count_nonzero(may) <= MOSTLY * len(points):
            return np.asarray(may)
        moves = [near for thing, near in away.items() if thing.moves]
        return np.asarray(np.logical_or.reduce([np.zeros(len(points), dtype=bool), *moves]))

    def _look(self, seen: Observation, pose: Pose, views: list[RangeView]) -> None:
        """Remember what the sensors see."""
        odometry = seen.odometry
        if self._alignment is None:
            self._memory.track(pose, Pose(odometry.forward, odometry.left, odometry.turn))
        self._place = np.array([pose.x, pose.y])
        if len(self._walls) and not np.abs(self._place - self._around).max() < WINDOW:
            half = max(self._local.reach, MOVING_RANGE) + WINDOW
            self._around = self._place
            self._near = self._walls[np.abs(self._walls - self._place).max(axis=1) < half]
        if views:
            self._remember(pose, views, seen.time)
        for view in views:
            if seen.time >= self._noted.get(view.name, -math.inf) + REPLAN - 1e-6:
                self._noted[view.name] = seen.time
                self._see(pose, view)
        if not self._planner.contains(self._place):
            self._lay_out(np.concatenate([self._goals, [self._place], self._walls, self._memory.points]))
        measured = np.array([odometry.forward, odometry.left, odometry.turn]) / seen.dt
        limits = np.array([self._robot.max_speed, max(self._robot.max_left, 0.1), self._robot.max_turn])
        surprise = np.abs(measured - self._twist) > 0.25 * limits
        self._twist = np.where(surprise, measured, self._twist)

    def _remember(self, pose: Pose, views: list[RangeView], now: float) -> None:
        """Remember the hits of a scan, and follow what moves."""
        points = pose.transform(np.concatenate([view.points() for view in views]))
        standing = np.concatenate([self._near, self._memory.older(now - SETTLED)])
        self._standing = ObstacleMap(self._place, standing, cell=2.0 * FINE, half=MOVING_RANGE)
        x, y = points.T
        fresh = (np.abs(points - self._place).max(axis=1) < MOVING_RANGE) & (self._standing.at(x, y) > EXPLAINED)
        fresh[fresh] = ~self._doubt[self._planner.cells(points[fresh])]
        # Where much is fresh, the estimate is wrong.
        if len(views) > 1 and np.count_nonzero(fresh) < MOSTLY * len(points):
            self._moving.update(points[fresh], pose, now)
        self._memory.add(pose, views, points, now)

    def _see(self, pose: Pose, view: RangeView) -> None:
        """Note the cells that beams have passed."""
        beams = np.linspace(0, len(view.ranges) - 1, min(RAYS, len(view.ranges))).astype(int)
        away = np.arange(0.5 * self._planner.cell, SIGHT, self._planner.cell)
        reached = np.minimum(view.ranges[beams], min(view.farthest, SIGHT))
        bearings = (view.first + view.step * beams)[:, None]
        passed = away < reached[:, None]
        x, y = (away * np.cos(bearings))[passed], (away * np.sin(bearings))[passed]
        at = pose.transform(view.robot_from_sensor.transform(np.stack([x, y], axis=-1)))
        self._doubt &= ~self._planner.drawn(at)

    def _lay_out(self, points: Array) -> None:
        """Lay out the planning grid around points (n, 2) [m]."""
        low, high = points.min(axis=0) - MARGIN, points.max(axis=0) + MARGIN
        cell = self._cell
        while np.prod((high - low) / cell) > CELLS:
            cell *= 2.0
        # The goal is in the middle of its cell.
        low = self._goals[-1] - (np.ceil((self._goals[-1] - low) / cell) + 0.5) * cell
        self._planner = Planner(low, high, cell)
        self._built = self._planner.drawn(self._walls)
        self._doubt: NDArray[np.bool_] = np.full(self._planner.shape, not len(self._walls))
        self._field = None

    def _plan(self, place: Array, now: float) -> CostToGo:
        """Return the times to the next goal, computed anew if there is news."""
        if self._field is not None and not self._is_due(self._field, place, now):
            return self._field
        self._planned = self._checked = now
        self._occupied, self._doubted = self._drawn(), self._doubt.copy()
        distances = DistanceGrid(self._occupied, lower=self._planner.lower, cell=self._planner.cell).distance
        price = time_per_metre(
            distances, half_width=self._local.body.half_width, gap=self._clearance, top=self._top, doubt=self._doubt
        )
        price = self._priced(price, place)
        # What is much farther from the goal than the robot does not matter.
        far = math.inf if self._field is None else float(self._field.at(place)) + BEYOND
        field = self._planner.cost_to_go(price, self._left[0], limit=far)
        if far < UNREACHED <= float(field.at(place)):
            field = self._planner.cost_to_go(price, self._left[0])
        self._field = field
        return field

    def _is_due(self, field: CostToGo, place: Array, now: float) -> bool:
        """Return whether to plan anew: something has changed on the way, or somewhere for a longer time."""
        if self._planned == -math.inf:
            return True
        if now < self._checked + REPLAN - 1e-6:
            return False
        self._checked = now
        if float(field.at(place)) >= UNREACHED:
            return True
        changed = self._drawn() != self._occupied
        if now >= self._planned + REFRESH:
            return bool(changed.any()) or not np.array_equal(self._doubt, self._doubted)
        return bool(changed[self._planner.near(field.path(place), BESIDE + self._local.body.half_width)].any())

    def _drawn(self) -> NDArray[np.bool_]:
        """Return the cells of the planning grid that walls and obstacles occupy."""
        points = self._memory.points
        if self._known is not None and len(points):
            points = points[self._known.at(points) > EXPLAINED]
        # Without a way between the walls alone there is none.
        self._is_shut = len(self._walls) > 0 and not len(points)
        return np.asarray(self._planner.drawn(points) | self._built)

    def _priced(self, price: Array, place: Array) -> Array:
        """Return prices that are finite where the robot is, and higher where it got stuck."""
        rows, columns = self._planner.shape
        cell = self._planner.cell
        x = self._planner.lower[0] + (np.arange(columns) + 0.5) * cell
        y = (self._planner.lower[1] + (np.arange(rows) + 0.5) * cell)[:, None]
        own = (x - place[0]) ** 2 + (y - place[1]) ** 2 < (self._local.body.half_width + cell) ** 2
        price = np.where(own, np.minimum(price, MOST_PRICE), price)
        for stuck in self._recovery.stuck:
            price = price * (1.0 + 3.0 * np.exp(-((x - stuck[0]) ** 2 + (y - stuck[1]) ** 2) / 0.3**2))
        return price

    def _choose(self, seen: Observation, pose: Pose, field: CostToGo) -> None:
        """Choose the next twist by the local planner."""
        near = np.concatenate([self._near, self._memory.points])
        obstacles = ObstacleMap(self._place, near, cell=FINE, half=self._local.reach)
        attempt, prices = self._recovery.attempt, MotionPrices()

        leads: Leads = field
        if attempt is Attempt.BACK:
            leads, prices = Toward(self._recovery.target), MotionPrices(reverse=0.0, top=BACKWARDS)
        elif attempt is Attempt.LOOK:
            leads, prices = Around(pose.heading), MotionPrices(top=BACKWARDS)
        elif float(field.at(self._place)) >= UNREACHED:
            self._stop()
            return
        prices = replace(prices, things=tuple(self._moving.predicted(pose, seen.time)))
        twist = self._local.twist(pose, self._twist, obstacles, leads, prices)
        self._jammed = twist is None
        self._twist = np.zeros(3) if twist is None else twist

    def _stop(self) -> Command:
        """Return the command to stand still."""
        self._local.reset()
        self._twist = np.zeros(3)
        return Command()

    def _why(self, seconds: float) -> str:
        """Return why the robot does not get nearer to its goal."""
        x, y = self._left[0].tolist()
        if self._jammed:
            return f"every motion would touch something; still trying to get to [{x:g}, {y:g}]"
        if seconds >= UNREACHED:
            return f"no way to [{x:g}, {y:g}] between the obstacles seen so far; looking for one"
        return f"no progress towards [{x:g}, {y:g}]; trying other ways"


def _sampled(segments: Array) -> Array:
    """Return points on segments (n, 2, 2), in every cell of the memory, shape (k, 2) [m]."""
    counts = 1 + np.ceil(np.hypot(*(segments[:, 1] - segments[:, 0]).T) / FINE).astype(int)
    which = np.repeat(np.arange(len(segments)), counts)
    share = np.concatenate([np.linspace(0.0, 1.0, count) for count in counts.tolist()]) if len(counts) else np.zeros(0)
    return np.asarray(segments[which, 0] + share[:, None] * (segments[which, 1] - segments[which, 0]))
