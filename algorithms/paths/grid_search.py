"""Shortest path on a grid (A*), and path straightening."""

import heapq
import itertools
import math

import numpy as np

from mjsim.geometry import Array
from mjsim.interface import ShownLines

from ..scans.distance_grid import DistanceGrid

STEPS = tuple((r, c, math.hypot(r, c)) for r in (-1, 0, 1) for c in (-1, 0, 1) if (r, c) != (0, 0))
"""Steps to the eight neighbours: rows, columns, length [cells]."""
PLANNED = "#9c36b5"
"""Colour of a shown path."""


def a_star(
    grid: DistanceGrid,
    start: Array,
    goal: Array,
    *,
    clearance: float,
    shyness: float = 0.0,
    guided: bool = True,
    expanded: set[int] | None = None,
) -> Array | None:
    """Return the cheapest path along the eight neighbours of each cell; diagonally only between two free cells.

    Args:
        grid: Distances to walls.
        start: Shape (2,) [m].
        goal: Shape (2,) [m].
        clearance: Minimum distance of the path from walls [m]; the cells of start and goal may be closer.
        shyness: Extra cost per metre at the clearance compared with far from walls; 0 for the shortest path.
        guided: Whether to expand cells nearer to the goal first; False for the algorithm of Dijkstra.
        expanded: Receives the flat indices of the expanded cells.

    Returns:
        Points of the path, shape (n, 2) [m], from start to goal; None if there is no path.

    References:
        Hart, Nilsson, Raphael, A Formal Basis for the Heuristic Determination of Minimum Cost Paths, IEEE TSSC 4(2),
        1968. The octile distance never overestimates the remaining cost, so the path is optimal on this grid.
    """
    rows, columns = grid.distance.shape
    first, last = (tuple(grid.cells(np.asarray(point)).tolist()) for point in (start, goal))
    free = grid.distance > clearance
    free[first] = free[last] = True
    # Plain lists: looking up one entry is many times faster than in an array.
    passable = free.ravel().tolist()
    price = (1.0 + shyness * clearance / np.maximum(grid.distance, clearance)).ravel().tolist()
    begin, end = first[0] * columns + first[1], last[0] * columns + last[1]
    cost, came_from, closed = {begin: 0.0}, {begin: begin}, set() if expanded is None else expanded
    queue = [(0.0, begin)]
    while queue:
        _, cell = heapq.heappop(queue)
        if cell == end:
            return _path_to(grid, came_from, end, start, goal)
        if cell in closed:
            continue
        closed.add(cell)
        row, column = divmod(cell, columns)
        for down, right, length in STEPS:
            r, c = row + down, column + right
            neighbour = r * columns + c
            if not (0 <= r < rows and 0 <= c < columns and passable[neighbour]) or neighbour in closed:
                continue
            # A diagonal step between two cells that are not both free would cut a corner.
            if down and right and not (passable[row * columns + c] and passable[r * columns + column]):
                continue
            total = cost[cell] + length * 0.5 * (price[cell] + price[neighbour])
            if total < cost.get(neighbour, math.inf):
                cost[neighbour], came_from[neighbour] = total, cell
                dr, dc = abs(r - last[0]), abs(c - last[1])
                octile = max(dr, dc) + (math.sqrt(2.0) - 1.0) * min(dr, dc)
                heapq.heappush(queue, (total + guided * octile, neighbour))
    return None


def _path_to(grid: DistanceGrid, came_from: dict[int, int], end: int, start: Array, goal: Array) -> Array:
    """Return the path to the end, from the start."""
    columns = grid.distance.shape[1]
    cells = [end]
    while came_from[cells[-1]] != cells[-1]:
        cells.append(came_from[cells[-1]])
    path = grid.centres(np.array([divmod(cell, columns) for cell in reversed(cells)], dtype=np.intp))
    return np.concatenate([[start], path[1:-1], [goal]])


def straightened(grid: DistanceGrid, path: Array, *, clearance: float) -> Array:
    """Return a path without unnecessary corners: pieces are replaced by straight lines where clearance allows.

    Args:
        grid: Distances to walls.
        path: Shape (n, 2) [m].
        clearance: Minimum distance of a straight piece from any wall [m].
    """
    corners, current = [0], 0
    while current < len(path) - 1:
        farthest = next(
            (i for i in range(len(path) - 1, current + 1, -1) if grid.is_clear(path[current], path[i], clearance)), 0
        )
        current = farthest or current + 1
        corners.append(current)
    return np.asarray(path[corners])


def length(path: Array) -> float:
    """Return the length of a path, points (n, 2) [m]."""
    return float(sum(math.dist(one, other) for one, other in itertools.pairwise(path.tolist())))


def shown_path(path: Array) -> tuple[ShownLines, ...]:
    """Return the shown items for a path, shape (n, 2), in the frame of the estimate [m]."""
    return (ShownLines(name="planned path", points=path, color=PLANNED),)
