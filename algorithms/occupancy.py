"""Occupancy grids: log-odds of free and occupied cells, filled from lidar scans."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from mjsim.geometry import Array, Pose
from mjsim.interface import BeaconInfo, Estimate, Observation, RobotInfo, Scan, ShownGrid

from .estimation.ekf_models import odometry_motion
from .scans.distance_grid import DistanceGrid
from .scans.level_scan import LevelLidar

FREE, HIT = -0.4, 1.7
"""Log-odds added to a cell by a beam that passes it, and by one that ends in it: occupied with 40 %, with 85 %."""
SURE = 8.0
"""Bound of the log-odds, so that an opened door is recognised after some scans."""


class OccupancyGrid:
    """Log-odds that a cell is occupied; the grid grows where the robot looks.

    The cell of row r and column c has its centre at `lower + cell * (c + 1/2, r + 1/2)`.

    References:
        Thrun, Burgard, Fox, Probabilistic Robotics (2005), table 9.1.
    """

    def __init__(self, *, cell: float = 0.05, farthest: float = 8.0) -> None:
        """Start with nothing known.

        Args:
            cell: Side of a cell [m].
            farthest: Distance along a beam up to which cells count as free, whatever the lidar's range [m].
        """
        self.cell, self.farthest = cell, farthest
        self.lower: Array = np.zeros(2)
        self.log_odds: Array = np.zeros((0, 0))
        """Shape (rows, columns); 0 for unknown."""

    def add(self, world_from_lidar: Pose, scan: Scan) -> None:
        """Add a scan taken from a pose."""
        angles, ranges = scan.angles() + world_from_lidar.heading, scan.ranges
        valid = ~np.isneginf(ranges) & ~np.isnan(ranges)
        angles, ranges = angles[valid], ranges[valid]
        origin = np.array([world_from_lidar.x, world_from_lidar.y])
        directions = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        reach = np.minimum(np.where(np.isinf(ranges), scan.range_max, ranges), self.farthest)
        self._grow(origin, float(np.max(reach, initial=0.0)) + self.cell)
        hits = ranges <= self.farthest
        ends = self._index(origin + ranges[hits, None] * directions[hits])
        # Samples a cell apart along each beam; a cell counts once a scan, and where a beam ends it is not free.
        steps = np.arange(0.0, float(np.max(reach, initial=0.0)), self.cell)
        along, beam = np.meshgrid(steps, np.arange(len(reach)))
        passed = along < reach[beam] - 0.5 * self.cell
        free = self._index(origin + along[passed][:, None] * directions[beam[passed]])
        flat = self.log_odds.ravel()
        ended = np.unique(ends)
        flat[np.setdiff1d(free, ended)] += FREE
        flat[ended] += HIT
        np.clip(flat, -SURE, SURE, out=flat)

    def distances(self, *, unknown_is_wall: bool = False) -> DistanceGrid:
        """Return the distance of each cell from occupied cells, and from unknown ones if these count as walls."""
        occupied = self.log_odds > 0.0
        return DistanceGrid(
            occupied | (self.log_odds == 0.0) if unknown_is_wall else occupied, lower=self.lower, cell=self.cell
        )

    def _index(self, points: Array) -> NDArray[np.intp]:
        """Return the indices in the flattened grid of the cells of points (n, 2) [m]."""
        columns, rows = np.floor((points - self.lower) / self.cell).astype(np.intp).T
        return np.asarray(rows * self.log_odds.shape[1] + columns)

    def _grow(self, origin: Array, reach: float) -> None:
        """Extend the grid to everything within range of a place, in steps of 4 m so that it happens rarely."""
        block = round(4.0 / self.cell)
        low = np.floor((origin - reach) / self.cell).astype(int) // block * block
        high = -(-np.ceil((origin + reach) / self.cell).astype(int) // block) * block
        if self.log_odds.size:
            have = np.round(self.lower / self.cell).astype(int)
            low, high = np.minimum(low, have), np.maximum(high, have + self.log_odds.shape[::-1])
            if (low == have).all() and (high - low == self.log_odds.shape[::-1]).all():
                return
        grown = np.zeros((high - low)[::-1])
        if self.log_odds.size:
            column, row = have - low
            grown[row : row + self.log_odds.shape[0], column : column + self.log_odds.shape[1]] = self.log_odds
        self.lower, self.log_odds = low * self.cell, grown


def shown_grid(grid: OccupancyGrid) -> ShownGrid:
    """Return a grid for display: its known part, as probabilities from 0 for free to 1 for occupied."""
    rows, columns = (np.flatnonzero((grid.log_odds != 0.0).any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        return ShownGrid(name="map", cells=np.full((1, 1), np.nan), resolution=grid.cell)
    known = grid.log_odds[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    cells = np.where(known == 0.0, np.nan, 1.0 / (1.0 + np.exp(-known)))
    x, y = (grid.lower + grid.cell * np.array([columns[0], rows[0]])).tolist()
    return ShownGrid(name="map", cells=cells, resolution=grid.cell, origin=Pose(x, y, 0.0))


class OccupancyMapping:
    """Maps with known poses: takes the pose from odometry, and adds lidar scans to `grid`."""

    def __init__(self, *, lidar: str | None = None, **grid: Any) -> None:
        """Set the rules.

        Args:
            lidar: Name of the lidar; None for the first.
            grid: Keys of `OccupancyGrid`.
        """
        self._lidar = lidar
        self.grid = OccupancyGrid(**grid)

    def start(self, robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], rng: Generator) -> None:
        """Begin at the robot's prior with an empty grid.

        Raises:
            ValueError: The robot has no such lidar.
        """
        self._scans = LevelLidar(robot, self._lidar)
        self.grid = OccupancyGrid(cell=self.grid.cell, farthest=self.grid.farthest)
        self._pose, self._covariance = robot.prior.as_array(), np.array(robot.prior_covariance, dtype=float)
        self._motion = odometry_motion()

    def update(self, seen: Observation) -> Estimate:
        """Return the pose of odometry; add the scan if there is one."""
        moved = seen.odometry
        self._pose, F, G = self._motion(self._pose, np.array([moved.forward, moved.left, moved.turn]))
        self._covariance = F @ self._covariance @ F.T + G @ moved.covariance @ G.T
        if (level_scan := self._scans.update(seen)) is not None:
            self.grid.add(Pose.from_array(self._pose) @ level_scan.robot_from_lidar, level_scan.scan)
        return Estimate(Pose.from_array(self._pose), self._covariance)
