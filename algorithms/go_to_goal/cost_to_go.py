"""Time to a goal from every cell of a grid, at a speed that depends on the clearance."""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from mjsim.geometry import Array

from ..paths.grid_search import STEPS

UNREACHED = 1e4
"""Time from cells without a path to the goal [s]."""
MAX_PRICE = 10.0
"""Largest cost of the cells of the robot and its goal, which must be passable [s/m]."""
DOUBT = 1.3
"""Factor on the time in unseen cells."""
TOUCH = 0.01
"""Obstacles may seem this much nearer than they are, on the grid [m]."""
TIGHT = 4.0
"""Additional cost of a metre where the body barely fits: it may not get through [s/m]."""
SLOWEST, GROWTH = 0.3, 3.5
"""Speed beside obstacles that nearly touch [m/s], and its growth with the clearance [1/s]."""


@dataclass(frozen=True, slots=True, eq=False)
class CostToGo:
    """Time to a goal from each cell, and the path there."""

    lower: Array
    """Corner of the grid with the smallest x and y, shape (2,) [m]."""
    cell: float
    """Side of a cell [m]."""
    seconds: Array
    """Shape (rows, columns) [s]; `UNREACHED` where there is no path."""
    slope: Array
    """Derivatives by x and y, shape (2, rows, columns) [s/m]."""
    before: NDArray[np.int32]
    """Next cell on the path to the goal, as a flat index; negative at the goal and where there is no path."""
    goal: Array
    """Shape (2,) [m]."""

    def at(self, points: Array) -> Array:
        """Return the times from points (..., 2), between cells interpolated [s]."""
        rows, columns = self.seconds.shape
        left, bottom = self.lower.tolist()
        u, v = (points[..., 0] - left) / self.cell - 0.5, (points[..., 1] - bottom) / self.cell - 0.5
        u, v = np.minimum(np.maximum(u, 0.0), columns - 1.001), np.minimum(np.maximum(v, 0.0), rows - 1.001)
        i, j = u.astype(np.intp), v.astype(np.intp)
        du, dv = u - i, v - j
        flat, first = self.seconds.ravel(), j * columns + i
        low = flat[first] * (1.0 - du) + flat[first + 1] * du
        high = flat[first + columns] * (1.0 - du) + flat[first + columns + 1] * du
        return np.asarray(low * (1.0 - dv) + high * dv)

    def direction(self, points: Array) -> tuple[Array, Array]:
        """Return the direction of fastest descent at points (..., 2): components along x and y, unnormalised."""
        rows, columns = self.seconds.shape
        i = np.clip(((points[..., 0] - self.lower[0]) / self.cell).astype(np.intp), 0, columns - 1)
        j = np.clip(((points[..., 1] - self.lower[1]) / self.cell).astype(np.intp), 0, rows - 1)
        flat = j * columns + i
        return -self.slope[0].ravel()[flat], -self.slope[1].ravel()[flat]

    def path(self, start: Array) -> Array:
        """Return the path from a point (2,) to the goal, shape (n, 2) [m]; only the point if there is none."""
        rows, columns = self.seconds.shape
        column, row = np.clip(((start - self.lower) / self.cell).astype(int), 0, (columns - 1, rows - 1))
        cells, next_cells = [int(row * columns + column)], self.before
        while (following := int(next_cells[cells[-1]])) >= 0 and len(cells) < rows * columns:
            cells.append(following)
        if self.seconds.ravel()[cells[0]] >= UNREACHED:
            return start[None]
        j, i = np.divmod(np.array(cells[1:-1], dtype=int), columns)
        inner = self.lower + (np.stack([i, j], axis=-1) + 0.5) * self.cell
        return np.concatenate([start[None], inner, self.goal[None]])


class Planner:
    """Computes costs to go on a grid of fixed size."""

    def __init__(self, lower: Array, upper: Array, cell: float) -> None:
        """Lay out the grid.

        Args:
            lower: Corner with the smallest x and y, shape (2,) [m].
            upper: Opposite corner, shape (2,) [m].
            cell: Side of a cell [m].
        """
        self.lower, self.cell = lower, cell
        columns, rows = (np.ceil((upper - lower) / cell).astype(int) + 1).tolist()
        self.shape = (rows, columns)
        self.upper = lower + cell * np.array([columns, rows])
        size = rows * columns
        self._shifts = [down * columns + right for down, right, _ in STEPS]
        ends = np.arange(size)[:, None] + self._shifts
        self._ends: NDArray[np.int32] = np.clip(ends, 0, size - 1).astype(np.int32).ravel()
        self._first: NDArray[np.int32] = np.arange(0, len(STEPS) * size + 1, len(STEPS), dtype=np.int32)
        self._times = np.full((size, len(STEPS)), math.inf)

    def drawn(self, points: Array) -> NDArray[np.bool_]:
        """Return the cells that contain points, shape (n, 2) [m]."""
        inside = (points >= self.lower).all(axis=1) & (points < self.upper).all(axis=1)
        taken = np.zeros(self.shape, dtype=bool)
        taken[self.cells(points[inside])] = True
        return taken

    def centres(self, cells: NDArray[np.bool_]) -> Array:
        """Return the centres of the marked cells of the grid, shape (n, 2) [m]."""
        return np.asarray(self.lower + (np.argwhere(cells)[:, ::-1] + 0.5) * self.cell)

    def near(self, path: Array, distance: float) -> NDArray[np.bool_]:
        """Return the cells within a distance [m] of a path, points (n, 2) [m]."""
        drawn = np.zeros(self.shape, dtype=np.uint8)
        corners = np.stack(self.cells(path)[::-1], axis=-1).astype(np.int32)
        cv2.polylines(drawn, [corners], False, 1, 1 + 2 * round(distance / self.cell))
        return np.asarray(drawn == 1)

    def cells(self, points: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Return rows and columns of points (n, 2) [m]; beyond the grid those of its edge."""
        rows, columns = self.shape
        i, j = ((points - self.lower) / self.cell).astype(np.intp).T
        return np.clip(j, 0, rows - 1), np.clip(i, 0, columns - 1)

    def contains(self, point: Array) -> bool:
        """Return whether a point (2,) is on the grid."""
        return bool((point >= self.lower).all() and (point < self.upper).all())

    def cost_to_go(self, price: Array, goal: Array, *, limit: float = math.inf) -> CostToGo:
        """Return the times to a goal.

        Args:
            price: Time per metre in each cell, infinite where the robot cannot be, shape (rows, columns) [s/m].
            goal: Shape (2,) [m]; its cell is passable, those at the edge of the grid are not.
            limit: Cells farther than this are left out [s].

        References:
            Dijkstra, A Note on Two Problems in Connexion with Graphs, Numerische Mathematik 1, 1959.
        """
        rows, columns = self.shape
        price, (j, i) = self._passable(price, goal)
        seconds, before = dijkstra(
            self._graph(price),
            indices=j * columns + i,
            return_predecessors=True,
            # Edges to impassable cells take an infinite time.
            limit=min(limit, UNREACHED),
        )
        grid = np.minimum(seconds, UNREACHED).reshape(rows, columns)
        return CostToGo(self.lower, self.cell, _extended(grid), self._slope(grid), before, goal)

    def is_connected(self, price: Array, goal: Array, place: Array) -> bool:
        """Return whether there is a path from a place (2,) to a goal (2,) [m] over the prices of `cost_to_go`."""
        price, cell = self._passable(price, goal)
        _, regions = cv2.connectedComponents(np.isfinite(price).astype(np.uint8), connectivity=8)
        ((j,), (i,)) = self.cells(place[None])
        return bool(regions[j, i] == regions[cell] > 0)

    def _passable(self, price: Array, goal: Array) -> tuple[Array, tuple[int, int]]:
        """Return prices that are infinite at the edge of the grid and finite at a goal (2,) [m], and its cell."""
        ((j,), (i,)) = self.cells(goal[None])
        price = np.pad(price[1:-1, 1:-1], 1, constant_values=math.inf)
        price[j, i] = min(price[j, i], MAX_PRICE)
        return price, (int(j), int(i))

    def _graph(self, price: Array) -> csr_matrix:
        """Return the times between neighbours; the cells at the edge of the grid are impassable."""
        flat = price.ravel()
        for column, (shift, (_, _, length)) in enumerate(zip(self._shifts, STEPS, strict=True)):
            size = len(flat) - abs(shift)
            start, end = max(0, -shift), max(0, shift)
            times = self._times[start : start + size, column]
            np.add(flat[start : start + size], flat[end : end + size], out=times)
            times *= 0.5 * length * self.cell
        return csr_matrix((self._times.ravel(), self._ends, self._first), shape=(len(flat), len(flat)))

    def _slope(self, seconds: Array) -> Array:
        """Return the derivatives of the times by x and y, shape (2, rows, columns), smoothed over neighbours [s/m]."""
        known = np.where(seconds < UNREACHED, seconds, 0.0)
        weight = cv2.blur((seconds < UNREACHED).astype(float), (3, 3))
        smooth = cv2.blur(known, (3, 3)) / np.maximum(weight, 1e-9)
        by_y, by_x = np.gradient(np.where(weight > 0.0, smooth, UNREACHED), self.cell)
        return np.stack([by_x, by_y])


def _extended(seconds: Array) -> Array:
    """Return times that grow steeply from reached cells into the next three unreached ones, for interpolation."""
    known = seconds
    for _ in range(3):
        beside = cv2.erode(known, np.ones((3, 3), np.uint8))
        known = np.where(known >= UNREACHED, np.minimum(beside + 1.0, UNREACHED), known)
    return np.asarray(known)


def time_per_metre(
    clearance: Array, *, half_width: float, gap: float, top: float, doubt: NDArray[np.bool_] | None = None
) -> Array:
    """Return the time that a metre takes in each cell [s/m].

    Args:
        clearance: Distance to the nearest obstacle, shape (rows, columns) [m].
        half_width: Half width of the robot [m].
        gap: Preferred distance between rim and obstacles [m].
        top: Maximum speed [m/s].
        doubt: Unseen cells: they take longer, since the path may end there.
    """
    free = clearance - half_width
    lacking = np.maximum(0.0, 1.0 - free / max(gap, 1e-3))
    price = (1.0 + lacking + TIGHT * lacking**2) / np.minimum(top, allowed_speed(free))
    if doubt is not None:
        price = np.where(doubt, DOUBT * price, price)
    return np.where(free > -TOUCH, price, math.inf)


def allowed_speed(clearance: Array) -> Array:
    """Return the speed at which a robot may pass obstacles at a clearance from its rim, shape (...) [m/s]."""
    return np.asarray(np.maximum(SLOWEST + GROWTH * clearance, SLOWEST))
