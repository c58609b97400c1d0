"""Exploration: drives to frontiers until everything reachable has been seen."""

from typing import Any

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from mjsim.geometry import Array, Pose
from mjsim.interface import Command, Estimate, Observation, RobotInfo, Shown, WorldMap

from .go_to_goal.go_to_goal import GoToGoal
from .occupancy import OccupancyGrid
from .paths.grid_search import a_star, length
from .scans.level_scan import LevelLidar

REPLAN, ARRIVED = 4.0, 0.5
"""Time after which a frontier is chosen again: on the way, and at the last one [s]."""
SAME = 0.2
"""A goal that moves by less stays as it is [m]."""


class Explore:
    """Builds an occupancy grid from a lidar and drives, by `GoToGoal`, to the frontier with the best gain per distance.

    References:
        Yamauchi, A Frontier-Based Approach for Autonomous Exploration, CIRA 1997.
    """

    def __init__(
        self,
        *,
        lidar: str | None = None,
        speed: float = 0.5,
        clearance: float = 0.1,
        smallest: float = 0.5,
        **grid: Any,
    ) -> None:
        """Set the rules.

        Args:
            lidar: Name of the lidar; None for the first.
            speed: Speed on straight lines, if the robot can [m/s].
            clearance: Clearance between the robot's rim and walls [m].
            smallest: Shorter frontiers are ignored [m].
            grid: Keys of `OccupancyGrid`.
        """
        self._lidar, self._speed, self._clearance, self._smallest = lidar, speed, clearance, smallest
        self.grid = OccupancyGrid(**({"cell": 0.1} | grid))

    def start(self, robot: RobotInfo, map: WorldMap | None, rng: Generator) -> None:
        """Start with an empty grid; the map, if there is one, is not used.

        Raises:
            ValueError: The robot has no such lidar.
        """
        self._robot = robot
        self._scans = LevelLidar(robot, self._lidar)
        self.grid = OccupancyGrid(cell=self.grid.cell, farthest=self.grid.farthest)
        self._goal = np.array([robot.prior.x, robot.prior.y])
        self._drive = GoToGoal(self._goal.tolist(), speed=self._speed, clearance=self._clearance)
        self._drive.start(robot, None, rng)
        self._planned = -np.inf
        self.done = False

    def command(self, seen: Observation, belief: Estimate) -> Command:
        """Return the twist that leads to the next frontier; zero when none is left."""
        command = self._drive.command(seen, belief)
        pose = self._drive.pose
        if (level_scan := self._scans.update(seen)) is not None:
            self.grid.add(pose @ level_scan.robot_from_lidar, level_scan.scan)
        if self.grid.log_odds.size and seen.time >= self._planned + (ARRIVED if self._drive.is_done else REPLAN):
            self._planned = seen.time
            self._plan(pose)
        return Command() if self.done else command

    def show(self) -> tuple[Shown, ...]:
        """Return the planned path, in the frame of the estimate, if there is one."""
        return () if self.done else self._drive.show()

    def blocked(self) -> str | None:
        """Return why the robot does not get nearer to a frontier, after 5 s; None while it does."""
        return None if self.done else self._drive.blocked()

    def frontiers(self) -> list[NDArray[np.intp]]:
        """Return the frontiers: connected cells that are free and border on unknown ones, (row, column) (n, 2) each."""
        known = self.grid.log_odds
        unknown = cv2.dilate((known == 0.0).astype(np.uint8), np.ones((3, 3), np.uint8))
        edge = ((known < 0.0) & (unknown == 1)).astype(np.uint8)
        number, region, sizes, _ = cv2.connectedComponentsWithStats(edge, connectivity=8)
        enough = [i for i in range(1, number) if sizes[i, cv2.CC_STAT_AREA] * self.grid.cell >= self._smallest]
        return [np.argwhere(region == i) for i in enough]

    def _plan(self, pose: Pose) -> None:
        """Choose a frontier by its size and the length of the path to it, and drive there."""
        distances = self.grid.distances()
        place, clearance = np.array([pose.x, pose.y]), self._robot.radius + self._clearance
        # The cells under the robot are free, even if a tilted scan marked them as occupied.
        best: tuple[float, Array] | None = None
        frontiers = sorted(self.frontiers(), key=len, reverse=True)[:6]
        for frontier in frontiers:
            goal = self._place_in(distances.centres(frontier), place, distances.at, clearance)
            path = None if goal is None else a_star(distances, place, goal, clearance=clearance, shyness=0.5)
            if path is None:
                continue
            gain = len(frontier) * self.grid.cell - 0.3 * length(path)
            if best is None or gain > best[0]:
                best = gain, path[-1]
        self.done = best is None
        if best is not None and (self._drive.is_done or np.hypot(*(best[1] - self._goal)) > SAME):
            self._goal = best[1]
            self._drive.take_goal(*self._goal.tolist())

    def _place_in(self, cells: Array, place: Array, distance: Any, clearance: float) -> Array | None:
        """Return the cell of a frontier clear of walls and closest to its centre; None if none is clear."""
        clear = cells[distance(cells) > clearance]
        if not len(clear):
            return None
        return np.asarray(clear[np.argmin(np.hypot(*(clear - cells.mean(axis=0)).T))])
