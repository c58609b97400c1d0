"""Obstacles that were seen, in small cells: kept while nothing contradicts them, dropped when seen through."""

import math

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array, Pose

from .range_views import RangeView

SURE = 4
"""Maximum excess of hits over contradictions in a cell."""
HALF = 1 << 23
"""Cells are counted from minus this to this along x and y."""
JUMP, JUMP_TURN = 0.05, math.radians(2.0)
"""Change of the estimate in a tick, beyond odometry, that moves the obstacles along [m, rad]."""


class ObstacleMemory:
    """Cells hit by sensors, in the frame of the estimate.

    A cell counts each scan that hits it and loses one for each that sees through it, so noise in front of a surface
    disappears. Cells not hit for some time are forgotten: things move, and the estimate drifts. If the estimate jumps,
    the obstacles move with the robot, because they were measured from it.

    References:
        Thrun, Burgard, Fox, Probabilistic Robotics (2005), section 9.2, with counts in place of log-odds.
    """

    def __init__(self, cell: float, *, seconds: float) -> None:
        """Start without obstacles.

        Args:
            cell: Side of a cell [m].
            seconds: Time without a hit after which a cell is forgotten [s].
        """
        self.cell, self._seconds = cell, seconds
        self._keys: NDArray[np.int64] = np.zeros(0, dtype=np.int64)
        self._counts: NDArray[np.int64] = np.zeros(0, dtype=np.int64)
        self._stamps, self._births = np.zeros(0), np.zeros(0)
        self._before: Pose | None = None
        self._began = False
        self.points: Array = np.zeros((0, 2))
        """Centres of the cells, shape (n, 2) [m]."""

    def track(self, pose: Pose, moved: Pose) -> None:
        """Follow the estimate.

        Args:
            pose: Estimate at this tick.
            moved: Motion since the last tick by odometry.
        """
        before, self._before = self._before, pose
        if before is None:
            return
        expected = before @ moved
        offset, jump = expected.inverse() @ pose, pose @ expected.inverse()
        if math.hypot(offset.x, offset.y) > JUMP or abs(jump.heading) > JUMP_TURN:
            self._store(_keys(jump.transform(self.points), self.cell), self._counts, self._stamps, self._births)

    def older(self, than: float) -> Array:
        """Return the centres of the cells that were first hit before a time [s], or by the first scan, (n, 2) [m]."""
        return self.points[self._births < than]

    def add(self, pose: Pose, views: list[RangeView], points: Array, now: float) -> None:
        """Add a scan.

        Args:
            pose: Pose of the robot.
            views: Obstacles that they see through are dropped.
            points: Its hits, in the frame of the estimate, shape (n, 2) [m].
            now: [s]
        """
        hits = np.unique(_keys(points, self.cell))
        robot = pose.inverse().transform(self.points)
        through = np.zeros(len(self.points), dtype=bool)
        for view in views:
            through |= view.is_free(robot, self.cell)
        again = np.isin(self._keys, hits, assume_unique=True)
        counts = np.where(again, np.minimum(self._counts + 1, SURE), self._counts - through)
        stamps = np.where(again, now, self._stamps)
        keep = (counts > 0) & (stamps > now - self._seconds)
        fresh = hits[~np.isin(hits, self._keys, assume_unique=True)]
        self._store(
            np.concatenate([self._keys[keep], fresh]),
            np.concatenate([counts[keep], np.ones(len(fresh), dtype=np.int64)]),
            np.concatenate([stamps[keep], np.full(len(fresh), now)]),
            np.concatenate([self._births[keep], np.full(len(fresh), now if self._began else -math.inf)]),
        )

        self._began = True

    def forget(self, before: float, *, kept: NDArray[np.bool_] | None = None) -> None:
        """Forget the cells not hit since a time [s], except those in `kept`."""
        keep = self._stamps >= before
        if kept is not None:
            keep |= kept
        self._store(self._keys[keep], self._counts[keep], self._stamps[keep], self._births[keep])

    def _store(self, keys: NDArray[np.int64], counts: NDArray[np.int64], stamps: Array, births: Array) -> None:
        self._keys, first = np.unique(keys, return_index=True)
        self._counts, self._stamps, self._births = counts[first], stamps[first], births[first]
        cells = np.stack([(self._keys >> 24) - HALF, (self._keys & (2 * HALF - 1)) - HALF], axis=-1)
        self.points = (cells + 0.5) * self.cell


def _keys(points: Array, cell: float) -> NDArray[np.int64]:
    """Return one number for the cell of each point, shape (n, 2)."""
    cells = np.floor(points / cell).astype(np.int64) + HALF
    return np.asarray((cells[:, 0] << 24) | cells[:, 1])
