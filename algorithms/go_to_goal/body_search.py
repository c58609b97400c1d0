"""Searches a path for the whole body of a robot: poses in place of points, its curves, forwards and backwards."""

import heapq
import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array, Pose
from mjsim.interface import RobotInfo

from .body_discs import BodyDiscs
from .cost_to_go import CostToGo
from .obstacle_map import ObstacleMap

CELL, HEADINGS = 0.1, 48
"""Poses in one cell of this side are the same if they are in one of so many sectors of headings, too [m]."""
HALF = 5.0
"""How far it searches to all sides [m]."""
LENGTH, TURN, SWEPT = 0.12, 0.14, 0.12
"""Maximum length and turn of a move, and distance that a part of the body is swept between two tests [m, rad, m]."""
SPEED, RATE = 0.4, 0.6
"""Speeds that moves are priced with [m/s, rad/s]."""
REVERSED, CHANGED, STEERED = 1.6, 1.0, 0.4
"""Factor on the price of a move backwards, and prices of a change of direction, and of the curvature by its maximum
[s]."""
CLOSE, PRESSED = 0.12, 3.0
"""Clearance below which a move costs more, up to so much more at none [m, 1]."""
GREED = 2.0
"""Factor on the time to the goal in the order of the search: moves are slower than that time assumes."""
MAX_SECONDS = 60.0
"""Longer times to the goal count as this in it [s]."""
BUCKET = 0.1
"""Poses whose prices differ by less are expanded together [s]."""
PORTIONS, MAX_POSES = 6, 35_000
"""Maximum number of such portions in a tick, and of poses in a search."""
PORTION, SPAN = 400, 10
"""So many poses are expanded together, if their prices differ by at most so many buckets."""
ASTRAY = 4.0
"""Price of an end at which the robot does not face the way to the goal [s]."""
CLOSER = 0.004
"""Parts nearer than the room at the start may come nearer by this [m]."""


Entry = tuple[NDArray[np.intp], Array, Array, NDArray[np.intp]]
"""Numbers of poses in the queue, their prices [s], the poses (n, 3), and the numbers of the moves that lead there."""


@dataclass(frozen=True, slots=True, eq=False)
class Move:
    """A short arc, or a turn on the spot."""

    way: float
    """1 forwards, -1 backwards, 0 on the spot."""
    bend: float
    """[1/m]"""
    steps: Array
    """Poses on it, in the frame of its start, shape (n, 3) [m, m, rad]."""
    price: float
    """[s]"""


def moves_of(robot: RobotInfo, *, bend: float, fine: float = 1.0) -> list[Move]:
    """Return the moves of a robot that may bend up to a curvature [1/m], by a factor shorter."""
    moves = []
    for way in (1.0, -1.0):
        for share in (0.0, 0.5, -0.5, 1.0, -1.0):
            curvature = share * bend
            length = min(LENGTH, TURN / max(abs(curvature), 1e-9)) / fine
            price = length / SPEED + 0.5 * abs(curvature) * length / RATE
            steps = _arc(way * length, curvature, reach=robot.radius)
            moves.append(Move(way, curvature, steps, price * (REVERSED if way < 0.0 else 1.0)))
    if math.isinf(robot.max_curvature) and robot.drive != "tricycle":
        for turn in (TURN / fine, -TURN / fine):
            count = max(2, math.ceil(abs(turn) * robot.radius / SWEPT))
            turned = turn * np.arange(1, count + 1) / count
            steps = np.stack([np.zeros(count), np.zeros(count), turned], axis=-1)
            moves.append(Move(0.0, 0.0, steps, abs(turn) / RATE))
    return moves


class BodySearch:
    """A search from a pose for the nearest one from which the rest of the way is shorter, some steps at a time.

    References:
        Dolgov, Thrun, Montemerlo, Diebel, Path Planning for Autonomous Vehicles in Unknown Semi-structured
        Environments, IJRR 29(5), 2010, section 2: hybrid A*; here many poses are expanded at once.
    """

    def __init__(
        self,
        start: Pose,
        body: BodyDiscs,
        map: ObstacleMap,
        field: CostToGo,
        *,
        moves: Sequence[Move],
        room: float,
        nearer: float,
        fine: float = 1.0,
    ) -> None:
        """Begin.

        Args:
            start: Pose of the robot.
            body: Its body.
            map: Obstacles.
            field: Times to the goal.
            moves: Moves of the robot.
            room: Clearance that is kept, if there is so much at the start [m].
            nearer: Its path ends where the goal is nearer by this time [s].
            fine: Factor by which poses are distinguished more finely.
        """
        self._start, self._body, self._map, self._field, self._moves = start, body, map, field, moves
        pose = start.as_array()
        now = body.clearances(pose[0], pose[1], pose[2], map)
        # What is close to one part may come as close to the others.
        self.floors = np.minimum(room, np.where(now < 0.0, now, max(float(now.min()) - CLOSER, 0.0)))
        self._low = pose[:2] - HALF
        self._cell, self._sectors = CELL / fine, round(HEADINGS * fine)
        self._count = math.ceil(2.0 * HALF / self._cell)
        self._closed: NDArray[np.bool_] = np.zeros(self._count**2 * self._sectors, dtype=bool)
        self._steps = np.array([move.steps[-1] for move in moves])
        self._prices = np.array([move.price for move in moves])
        self._swept = [self._discs(move) for move in moves]
        self._target = max(float(field.at(pose[:2])) - nearer, 0.3)
        self._ways = np.array([move.way for move in moves])
        self._bends = np.array([move.bend for move in moves])
        self._parents, self._kinds, self._total = [np.array([-1])], [np.array([-1])], 1
        self._queue = defaultdict[int, list[Entry]](list)
        self._heap = [0]
        self._queue[0].append((np.array([0]), np.zeros(1), pose[None], np.array([-1])))
        self._best: tuple[float, int] | None = None
        self._deepest: tuple[float, Array] = (math.inf, pose[:2])
        self.expanded = 0
        """Number of poses from which it went on."""
        self.is_over = False
        """Whether nothing is left to try."""

    @property
    def deepest(self) -> Array:
        """The place that it came to with the shortest time to the goal, shape (2,) [m]."""
        return self._deepest[1]

    @property
    def found(self) -> tuple[Array, Array, Array] | None:
        """The path: poses (n, 3), and curvature [1/m] and direction on the way to each of them; None without one."""
        if not self.is_over or self._best is None:
            return None
        return self._path(self._best[1])

    def advance(self, count: int) -> None:
        """Expand a number of poses, portions of about the same price together, and at most five such."""
        until = self.expanded + count
        for _ in range(PORTIONS):
            is_best = self._best is not None and bool(self._heap) and self._heap[0] * BUCKET >= self._best[0]
            self.is_over = not self._heap or is_best or self.expanded > MAX_POSES
            if self.expanded >= until:
                return
            if self.is_over:
                return
            entries, found, lowest = list[Entry](), 0, self._heap[0]
            while self._heap and found < PORTION and self._heap[0] <= lowest + SPAN:
                part = self._queue.pop(heapq.heappop(self._heap))
                entries += part
                found += sum(len(entry[0]) for entry in part)
            entry = [np.concatenate(parts) for parts in zip(*entries, strict=True)]
            self._expand(*(part[:PORTION] for part in entry))
            if found > PORTION:
                self._put(lowest, *(part[PORTION:] for part in entry))

    def _put(self, bucket: int, *entry: Any) -> None:
        """Put poses into a bucket of the queue."""
        if bucket not in self._queue:
            heapq.heappush(self._heap, bucket)
        self._queue[bucket].append(entry)

    def _expand(self, ids: NDArray[np.intp], prices: Array, poses: Array, kinds: NDArray[np.intp]) -> None:
        """Go on from poses with prices so far [s], after moves of some kinds."""
        order = np.argsort(prices, kind="stable")
        cells = self._cells(poses[order])
        _, first = np.unique(cells, return_index=True)
        own = order[first[~self._closed[cells[first]]]]
        if not len(own):
            return
        ids, prices, poses, kinds = ids[own], prices[own], poses[own], kinds[own]
        self._closed[self._cells(poses)] = True
        self.expanded += len(ids)
        self._end(ids, prices, poses)
        self._step(ids, prices, poses, kinds)

    def _end(self, ids: NDArray[np.intp], prices: Array, poses: Array) -> None:
        """Note the best pose from which the goal is nearer."""
        seconds = self._field.at(poses[:, :2])
        deepest = int(np.argmin(seconds))
        if seconds[deepest] < self._deepest[0]:
            self._deepest = float(seconds[deepest]), poses[deepest, :2]
        ends = np.flatnonzero((seconds <= self._target) & (ids > 0))
        if not len(ends):
            return
        ahead, left = self._field.direction(poses[ends, :2])
        faces = np.cos(poses[ends, 2] - np.arctan2(left, ahead)) > 0.3
        totals = prices[ends] + GREED * (seconds[ends] - self._target) + np.where(faces, 0.0, ASTRAY)
        best = int(np.argmin(totals))
        if self._best is None or totals[best] < self._best[0]:
            self._best = float(totals[best]), int(ids[ends[best]])

    def _step(self, ids: NDArray[np.intp], prices: Array, poses: Array, kinds: NDArray[np.intp]) -> None:
        """Add the poses after all moves that are free."""
        x, y, turn = self._steps.T
        c, s = np.cos(poses[:, 2, None]), np.sin(poses[:, 2, None])
        ends = np.stack(
            [poses[:, 0, None] + c * x - s * y, poses[:, 1, None] + s * x + c * y, poses[:, 2, None] + turn], axis=-1
        )
        fresh: NDArray[np.bool_] = np.asarray((np.abs(ends[..., :2] - (self._low + HALF)) < HALF - CELL).all(axis=-1))
        fresh[fresh] = ~self._closed[self._cells(ends[fresh])]
        least = np.full(fresh.shape, -np.inf)
        for number in range(len(self._moves)):
            own = np.flatnonzero(fresh[:, number])
            least[own, number] = self._least(number, poses[own])
        of, move = np.nonzero(least > -np.inf)
        if not len(of):
            return
        least = least[of, move]
        changes = (self._ways[kinds[of]] != self._ways[move]) & (kinds[of] >= 0)
        cost = self._prices[move] * (1.0 + PRESSED * np.clip(1.0 - least / CLOSE, 0.0, 1.0))
        steered = np.abs(self._bends[kinds[of]] - self._bends[move]) / self._bends.max()
        cost += prices[of] + CHANGED * changes + STEERED * steered
        poses = ends[of, move]
        self._push(poses, ids[of], move, cost)

    def _push(self, poses: Array, parents: NDArray[np.intp], kinds: NDArray[np.intp], cost: Array) -> None:
        """Add poses to the queue, with their prices so far [s]."""
        ids = np.arange(self._total, self._total + len(poses))
        self._total += len(poses)
        self._parents.append(parents)
        self._kinds.append(kinds)
        rest = np.clip(self._field.at(poses[:, :2]) - self._target, 0.0, MAX_SECONDS)
        buckets = ((cost + GREED * rest) / BUCKET).astype(int)
        order = np.argsort(buckets, kind="stable")
        names, starts = np.unique(buckets[order], return_index=True)
        for bucket, own in zip(names.tolist(), np.split(order, starts[1:]), strict=True):
            self._put(bucket, ids[own], cost[own], poses[own], kinds[own])

    def _least(self, number: int, poses: Array) -> Array:
        """Return the least clearances on a move from poses (n, 3), -inf where it is not free, shape (n,) [m]."""
        x, y, floors, radii = self._swept[number]
        c, s = np.cos(poses[:, 2, None]), np.sin(poses[:, 2, None])
        clear = self._map.at(poses[:, 0, None] + c * x - s * y, poses[:, 1, None] + s * x + c * y) - radii
        return np.where((clear >= floors).all(axis=1), clear.min(axis=1), -np.inf)

    def _discs(self, move: Move) -> tuple[Array, Array, Array, Array]:
        """Return the discs on a move: x and y in the frame of its start, the clearances that they keep, and radii."""
        a, b = self._body.centres.T
        c, s = np.cos(move.steps[:, 2, None]), np.sin(move.steps[:, 2, None])
        x, y = move.steps[:, 0, None] + c * a - s * b, move.steps[:, 1, None] + s * a + c * b
        count = len(move.steps)
        return x.ravel(), y.ravel(), np.tile(self.floors, count), np.tile(self._body.radii, count)

    def _cells(self, poses: Array) -> NDArray[np.intp]:
        """Return the flat indices of the cells of poses (n, 3)."""
        i, j = ((poses[:, :2] - self._low) / self._cell).astype(np.intp).T
        h = np.rint(poses[:, 2] * (self._sectors / (2.0 * math.pi))).astype(np.intp) % self._sectors
        return np.asarray((h * self._count + j) * self._count + i)

    def _path(self, last: int) -> tuple[Array, Array, Array]:
        """Return the path to a pose."""
        parents, kinds = np.concatenate(self._parents), np.concatenate(self._kinds)
        numbers = []
        while parents[last] >= 0:
            numbers.append(int(kinds[last]))
            last = int(parents[last])
        pose, parts = self._start, [self._start.as_array()[None]]
        bends, ways = list[float](), list[float]()
        for number in numbers[::-1]:
            move = self._moves[number]
            fine = _refined(move)
            parts.append(np.array([(pose @ Pose.from_array(step)).as_array() for step in fine]))
            bends += [move.bend] * len(fine)
            ways += [move.way] * len(fine)
            pose = pose @ Pose.from_array(fine[-1])
        return np.concatenate(parts), np.array([*bends[:1], *bends]), np.array([*ways[:1], *ways])


def _arc(length: float, curvature: float, *, reach: float) -> Array:
    """Return poses on an arc, so dense that no part within a reach is swept farther between two, shape (n, 3)."""
    count = max(1, math.ceil(abs(length) * (1.0 + abs(curvature) * reach) / SWEPT))
    return _points(length, curvature, count)


def _points(length: float, curvature: float, count: int) -> Array:
    """Return equidistant poses on an arc, without its start, shape (count, 3) [m, m, rad]."""
    along = length * np.arange(1, count + 1) / count
    turned = curvature * along
    if abs(curvature) < 1e-9:
        return np.stack([along, np.zeros(count), turned], axis=-1)
    return np.stack([np.sin(turned) / curvature, (1.0 - np.cos(turned)) / curvature, turned], axis=-1)


def _refined(move: Move) -> Array:
    """Return poses on a move that are at most 2 cm apart, shape (n, 3) [m, m, rad]."""
    if move.way == 0.0:
        return move.steps
    x, y, turned = move.steps[-1].tolist()
    length = move.way * (turned / (2.0 * math.sin(0.5 * turned)) if turned else 1.0) * math.hypot(x, y)
    return _points(length, move.bend, max(1, round(abs(length) / 0.02)))
