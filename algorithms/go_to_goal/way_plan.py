"""Plans paths to goals on a grid of all obstacles seen, and replans when something changes on the path."""

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array, Pose

from ..scans.distance_grid import DistanceGrid
from .body_discs import BodyDiscs
from .cost_to_go import MAX_PRICE, UNREACHED, CostToGo, Planner, time_per_metre
from .range_views import RangeView

REPLAN, REFRESH = 0.28, 1.0
"""Time between plans while something changes on the way, and while it changes elsewhere [s]."""
BESIDE = 0.4
"""Changes nearer than this to the sides of the robot on its way are planned for at once [m]."""
BEYOND = 2.5
"""Cells are planned up to this time farther from the goal than the robot [s]."""
MARGIN = 3.0
"""How far the planning grid reaches beyond start, goals and map, to drive around obstacles [m]."""
CELLS = 90_000
"""Largest number of cells of the planning grid; beyond, they are larger."""
SIGHT, RAYS = 8.0, 180
"""Range [m] and number of beams of a scan that mark cells as seen."""
EXPLAINED = 0.15
"""Hits within this distance of a wall of the map belong to that wall [m]."""
BARRIER, BEFORE = 30.0, 0.2
"""Time per metre through obstacles where there is no way around them, and distance at which a robot stops before them
[s/m, m]."""
AVOIDED = 30.0
"""Largest factor on the time where the robot got stuck."""


class WayPlan:
    """The time to the next goal from everywhere, at a speed that falls with the clearance; unseen space is doubtful."""

    def __init__(
        self, walls: Array, known: DistanceGrid | None, *, half_width: float, gap: float, top: float, cell: float
    ) -> None:
        """Start without a grid; `lay_out` follows.

        Args:
            walls: Points on the walls of the map, shape (n, 2) [m].
            known: Distances to these walls; None without a map.
            half_width: Half width of the robot [m].
            gap: Preferred distance between rim and obstacles [m].
            top: Maximum speed [m/s].
            cell: Side of a cell [m].
        """
        self._walls, self._known = walls, known
        self._half_width, self._gap, self._top, self._cell = half_width, gap, top, cell
        self.field: CostToGo | None = None
        """The times planned last; None before the first plan to a goal."""
        self._planned, self._checked = -math.inf, -math.inf
        self._is_put_off = self._is_farther = False
        self._noted = dict[str, float]()
        self._price: Array = np.zeros((0, 0))
        self._planner = Planner(np.zeros(2), np.zeros(2), cell)
        self._doubt: NDArray[np.bool_] = np.ones(self._planner.shape, dtype=bool)
        self.is_barred = False
        """Whether there is no free path: the times lead through obstacles, so that the robot gets near its goal."""

    def lay_out(self, goal: Array, points: Array) -> None:
        """Lay out the grid around points (n, 2), with a goal (2,) in the middle of its cell [m]."""
        points = np.concatenate([points, goal[None], self._walls])
        low, high = points.min(axis=0) - MARGIN, points.max(axis=0) + MARGIN
        cell, before, seen = self._cell, self._planner, ~self._doubt
        while np.prod((high - low) / cell) > CELLS:
            cell *= 2.0
        low = goal - (np.ceil((goal - low) / cell) + 0.5) * cell
        self._planner = Planner(low, high, cell)
        self._built = self._planner.drawn(self._walls)
        self._doubt = ~self._planner.drawn(before.centres(seen)) & (not len(self._walls))
        self.field = None

    @property
    def cell(self) -> float:
        """Side of a cell of the grid [m]."""
        return self._planner.cell

    @property
    def seen_area(self) -> float:
        """Area that has been seen and was unknown [m^2]."""
        return 0.0 if len(self._walls) else np.count_nonzero(~self._doubt) * self.cell**2

    def contains(self, place: Array) -> bool:
        """Return whether a place (2,) is on the grid."""
        return self._planner.contains(place)

    def unseen(self, points: Array) -> NDArray[np.bool_]:
        """Return whether the cells of points (n, 2) [m] have not been seen."""
        return self._doubt[self._planner.cells(points)]

    def stand(self, pose: Pose, body: BodyDiscs) -> None:
        """Note that the cells under a body are free."""
        steps = np.arange(-body.reach, body.reach, 0.5 * self.cell)
        at = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
        under = np.hypot(*np.moveaxis(at[:, None] - body.centres, -1, 0)) < body.radii
        self._doubt &= ~self._planner.drawn(pose.transform(at[under.any(axis=1)]))

    def unseen_around(self, place: Array, *, half: float) -> Array:
        """Return the centres of unseen cells at least two cells beyond the seen ones, in a square, shape (n, 2) [m]."""
        (top, bottom), (left, right) = (
            each.tolist() for each in self._planner.cells(place + np.array([[-half], [half]]))
        )
        part = self._doubt[top : bottom + 1, left : right + 1].astype(np.uint8)
        rows, columns = np.nonzero(cv2.erode(part, np.ones((5, 5), np.uint8)))
        return np.asarray(self._planner.lower + (np.stack([columns + left, rows + top], axis=-1) + 0.5) * self.cell)

    def see(self, pose: Pose, view: RangeView, now: float) -> None:
        """Note the cells that beams have passed, from time to time."""
        if now < self._noted.get(view.name, -math.inf) + REPLAN - 1e-6:
            return
        self._noted[view.name] = now
        beams = np.linspace(0, len(view.ranges) - 1, min(RAYS, len(view.ranges))).astype(int)
        away = np.arange(0.5 * self._planner.cell, SIGHT, self._planner.cell)
        reached = np.minimum(view.ranges[beams], min(view.farthest, SIGHT))
        bearings = (view.first + view.step * beams)[:, None]
        passed = away < reached[:, None]
        x, y = (away * np.cos(bearings))[passed], (away * np.sin(bearings))[passed]
        at = pose.transform(view.robot_from_sensor.transform(np.stack([x, y], axis=-1)))
        self._doubt &= ~self._planner.drawn(at)

    def begin(self) -> None:
        """Replan at the next call, since something unknown to the plan has changed."""
        self._planned = -math.inf

    def to(
        self,
        goal: Array,
        place: Array,
        now: float,
        *,
        points: Array,
        stuck: list[tuple[float, float]],
        busy: bool = False,
    ) -> CostToGo:
        """Return the times to a goal, computed anew if there is news.

        Args:
            goal: Shape (2,) [m].
            place: Place of the robot, shape (2,) [m].
            now: [s]
            points: Obstacles seen, shape (n, 2) [m].
            stuck: Places to avoid [m].
            busy: Whether this tick has other work; then they are computed at the next.
        """
        if self.field is not None:
            if busy and not self._is_put_off:
                self._is_put_off = True
                return self.field
            self._is_put_off = False
            if not self._is_due(self.field, place, now, points):
                return self.field
        self._planned = self._checked = now
        self._price = price = self._priced(goal, place, points, stuck)
        self.is_barred = not self._planner.is_connected(price, goal, place)
        if self.is_barred and self._grow(goal, place, points):
            self._price = price = self._priced(goal, place, points, stuck)
            self.is_barred = not self._planner.is_connected(price, goal, place)
        if self.is_barred:
            price, self.field = np.minimum(price, BARRIER), None
        # Cells much farther from the goal than the robot do not matter.
        before = None if self._is_farther else self.field
        far = math.inf if before is None else float(before.at(place)) + BEYOND
        field = self._planner.cost_to_go(price, goal, limit=far)
        self._is_farther = far < UNREACHED <= float(field.at(place))
        if before is not None and self._is_farther:
            self.begin()
            return before
        self.field = field
        return field

    def ends(self, place: Array) -> bool:
        """Return whether there is no free path, and a robot at a place (2,) [m] is as near to its goal as possible."""
        if not self.is_barred or self.field is None:
            return False
        ahead = self.field.path(place)[: 1 + math.ceil(BEFORE / self.cell)]
        return bool(np.isinf(self._price[self._planner.cells(ahead)]).any())

    def costs(self, place: Array, *, half: float) -> tuple[Array, Array]:
        """Return the costs used for planning around a place (2,), and the corner of the first cell, shape (2,) [m].

        Costs are 0 where the robot may be as fast as it can, and 1 where it cannot be.
        """
        (top, bottom), (left, right) = (
            each.tolist() for each in self._planner.cells(place + np.array([[-half], [half]]))
        )
        fastest = 1.0 / self._top
        cells = 1.0 - fastest / self._price[top : bottom + 1, left : right + 1]
        return np.clip(cells, 0.0, 1.0), self._planner.lower + self._planner.cell * np.array([left, top])

    def _is_due(self, field: CostToGo, place: Array, now: float, points: Array) -> bool:
        """Return whether to replan: something has changed on the path, or elsewhere for a longer time."""
        if self._planned == -math.inf:
            return True
        if now < self._checked + REPLAN - 1e-6:
            return False
        self._checked = now
        if self.is_barred:
            return True
        changed = self._drawn(points) != self._occupied
        if now >= self._planned + REFRESH:
            return bool(changed.any()) or not np.array_equal(self._doubt, self._doubted)
        return bool(changed[self._planner.near(field.path(place), BESIDE + self._half_width)].any())

    def _drawn(self, points: Array) -> NDArray[np.bool_]:
        """Return the cells of the grid that walls and obstacles occupy."""
        if self._known is not None and len(points):
            points = points[self._known.at(points) > EXPLAINED]
        return np.asarray(self._planner.drawn(points) | self._built)

    def _grow(self, goal: Array, place: Array, points: Array) -> bool:
        """Lay out a larger grid if obstacles, or paths around them, reach beyond its inner part; return whether it was.

        It grows by steps, since the cells of a large grid are coarse.
        """
        low, high = self._planner.lower + MARGIN, self._planner.upper - MARGIN
        corners = np.array(
            [
                np.minimum(low, np.maximum(points.min(axis=0, initial=math.inf), low - MARGIN)),
                np.maximum(high, np.minimum(points.max(axis=0, initial=-math.inf), high + MARGIN)),
            ]
        )
        if np.abs(corners - (low, high)).max() <= 2.0 * self._planner.cell:
            return False
        self.lay_out(goal, np.concatenate([corners, [place]]))
        return True

    def _priced(self, goal: Array, place: Array, points: Array, stuck: list[tuple[float, float]]) -> Array:
        """Return the time per metre in each cell: finite where robot and goal are, longer where it got stuck [s/m]."""
        self._occupied, self._doubted = self._drawn(points), self._doubt.copy()
        planner = self._planner
        distances = DistanceGrid(self._occupied, lower=planner.lower, cell=planner.cell).distance
        price = time_per_metre(distances, half_width=self._half_width, gap=self._gap, top=self._top, doubt=self._doubt)
        (rows, columns), (left, bottom) = planner.shape, planner.lower
        x, y = (
            left + (np.arange(columns) + 0.5) * planner.cell,
            bottom + (np.arange(rows)[:, None] + 0.5) * planner.cell,
        )
        own = (x - place[0]) ** 2 + (y - place[1]) ** 2 < (self._half_width + planner.cell) ** 2
        price = np.where(own, np.minimum(price, MAX_PRICE), price)
        avoided = np.ones_like(price)
        for a, b in stuck:
            avoided *= 1.0 + 3.0 * np.exp(-((x - a) ** 2 + (y - b) ** 2) / 0.3**2)
        return price * np.minimum(avoided, AVOIDED)
