"""Drives to goals: plans on the map, and replans when the path is blocked."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.random import Generator

from mjsim.geometry import Array
from mjsim.interface import Command, Estimate, Observation, RobotInfo, ShownLines, WorldMap

from .distance_grid import DistanceGrid
from .grid_search import a_star, shown_path, straightened
from .level_scan import LevelLidar
from .waypoints import Waypoints

RING = np.arange(16) * (2.0 * np.pi / 16)
FORGET = 20.0
"""Time for which an obstacle that is not on the map is remembered [s]; people walk on."""
PATIENCE = 2.0
"""Time between attempts if there is no path [s]."""
NEW_THING = 0.15
"""Distance from all walls of the map beyond which a hit is not explained by the map [m]."""


class GoToGoal:
    """Drives to goals by the shortest path with clearance from walls, and stops at the last.

    Without a map (`map: unknown`), unseen space counts as free. Hits of lidars and proximity rays that the map's walls
    do not explain are kept as obstacles for a while; if one blocks the path ahead, a new path is planned; if there is
    none, the robot waits.

    References:
        Latombe, Robot Motion Planning (1991), chapter 4, cell decomposition; A* in `grid_search`.
    """

    def __init__(
        self,
        goals: Sequence[Sequence[float]],
        *,
        speed: float = 0.5,
        clearance: float = 0.1,
        tolerance: float = 0.1,
        cell: float = 0.1,
    ) -> None:
        """Set the goals.

        Args:
            goals: Each (x, y) [m], in the frame of the estimate; a single pair is one goal.
            speed: On straight lines, if the robot can [m/s].
            clearance: Clearance between the robot's rim and walls [m].
            tolerance: Distance at which a goal counts as reached [m].
            cell: Side of a cell of the planning grid [m].
        """
        self._goals = np.atleast_2d(np.asarray(goals, dtype=float))
        if self._goals.ndim != 2 or self._goals.shape[1:] != (2,):
            raise ValueError(f"goals has shape {self._goals.shape}; give at least one [x, y]")
        self._speed, self._clearance, self._tolerance, self._cell = speed, clearance, tolerance, cell

    def start(self, robot: RobotInfo, map: WorldMap | None, rng: Generator) -> None:
        """Take the map; the first path is planned later."""
        self._robot, self._rng = robot, rng
        lidars = [name for name, sensor in robot.sensors.items() if sensor.kind == "lidar"]
        self._lidars = [LevelLidar(robot, name) for name in lidars]
        ends = np.concatenate([self._goals, [[robot.prior.x, robot.prior.y]]])
        corners = np.concatenate([ends, map.segments.reshape(-1, 2) if map else ends])
        # A margin to drive around obstacles outside the walls.
        low, high = corners.min(axis=0) - 3.0, corners.max(axis=0) + 3.0
        frame = np.array([low, (high[0], low[1]), high, (low[0], high[1])])
        walls = map.segments if map is not None else np.zeros((0, 2, 2))
        self._walls = DistanceGrid.from_segments(
            np.concatenate([walls, np.stack([frame, np.roll(frame, -1, axis=0)], axis=1)]), cell=self._cell, margin=0.5
        )
        self._left = [goal for goal in self._goals]
        self._unmapped, self._since = np.zeros((0, 2)), np.zeros(0)
        self._grid, self._path = self._walls, np.zeros((0, 2))
        self._shown: tuple[ShownLines, ...] = ()
        self._follow: Waypoints | None = None
        self._tried = -np.inf

    def command(self, seen: Observation, belief: Estimate) -> Command:
        """Return the twist along the path; zero at the last goal, and without a path."""
        place = np.array([belief.pose.x, belief.pose.y])
        while self._left and np.hypot(*(self._left[0] - place)) < self._tolerance:
            self._left, self._follow = self._left[1:], None
        if not self._left:
            return Command()
        self._remember(seen, belief)
        if self._follow is not None and self._is_blocked(place):
            self._follow = None
        if self._follow is None and seen.time >= self._tried + PATIENCE:
            self._plan(seen.time, belief)
        return Command() if self._follow is None else self._follow.command(seen, belief)

    def show(self) -> tuple[ShownLines, ...]:
        """Return the planned path, in the frame of the estimate, if there is one."""
        return self._shown if self._follow is not None else ()

    def _remember(self, seen: Observation, belief: Estimate) -> None:
        """Store hits where the map has no wall."""
        hit = np.isfinite(seen.proximity)
        reach = seen.proximity[hit] + self._robot.radius
        hits = [np.stack([reach * np.cos(RING[hit]), reach * np.sin(RING[hit])], axis=-1)]
        scans = [lidar.update(seen) for lidar in self._lidars]
        hits += [scan.points() for scan in scans if scan is not None]
        points = belief.pose.transform(np.concatenate(hits))
        points = points[self._walls.at(points) > NEW_THING]
        cells, first = np.unique(np.floor(points / self._cell).astype(int), axis=0, return_index=True)
        recent = self._since > seen.time - FORGET
        if len(cells):
            # One point per cell: points seen again are replaced.
            again = np.isin(_keys(np.floor(self._unmapped / self._cell).astype(int)), _keys(cells))
            recent &= ~again
        self._unmapped = np.concatenate([self._unmapped[recent], points[first]])
        self._since = np.concatenate([self._since[recent], np.full(len(first), seen.time)])

    def _is_blocked(self, place: Array) -> bool:
        """Return whether an unknown obstacle is on the path within 3 m."""
        if not len(self._unmapped):
            return False
        nearby = self._unmapped[np.hypot(*(self._unmapped - place).T) < 3.0]
        steps = np.diff(self._path, axis=0)
        lengths = np.maximum(np.sum(steps**2, axis=1), 1e-12)
        share = np.clip(np.sum((nearby[:, None] - self._path[:-1]) * steps, axis=2) / lengths, 0.0, 1.0)
        distances = np.hypot(*np.moveaxis(nearby[:, None] - self._path[:-1] - share[..., None] * steps, -1, 0))
        # Only segments still ahead: from the one nearest to the robot on.
        own = np.clip(np.sum((place - self._path[:-1]) * steps, axis=1) / lengths, 0.0, 1.0)
        current = int(np.argmin(np.hypot(*(place - self._path[:-1] - own[:, None] * steps).T)))
        return bool((distances[:, current:] < self._robot.radius + 0.5 * self._clearance).any())

    def _plan(self, time: float, belief: Estimate) -> None:
        """Plan a path to the next goal among walls and known obstacles."""
        self._tried = time
        occupied = self._walls.distance < 0.5 * self._cell
        rows, columns = np.moveaxis(self._walls.cells(self._unmapped), -1, 0)
        occupied[rows, columns] = True
        grid = DistanceGrid(occupied, lower=self._walls.lower, cell=self._cell)
        place, clearance = np.array([belief.pose.x, belief.pose.y]), self._robot.radius + self._clearance
        path = a_star(grid, place, self._left[0], clearance=clearance, shyness=1.0)
        if path is None or len(path) < 2:
            return
        self._path = straightened(grid, path, clearance=clearance)
        self._shown = shown_path(self._path)
        self._follow = Waypoints(self._path[1:].tolist(), speed=self._speed, tolerance=self._tolerance, lookahead=0.4)
        self._follow.start(replace(self._robot, prior=belief.pose), None, self._rng)


def _keys(cells: Array) -> Array:
    """Return one number for each pair of integers (n, 2)."""
    return np.asarray(cells[:, 0].astype(np.int64) * 2**24 + cells[:, 1])
