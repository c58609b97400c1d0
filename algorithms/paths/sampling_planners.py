"""Sampling-based path planners: RRT* and the probabilistic roadmap."""

import math
from collections.abc import Callable

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from mjsim.geometry import Array

Indices = NDArray[np.intp]
IsClear = Callable[[Array, Array], bool]
"""Whether one can go straight from one point to another, each (2,) [m]."""


def rrt_star(
    is_clear: IsClear,
    start: Array,
    goal: Array,
    *,
    lower: Array,
    upper: Array,
    rng: Generator,
    samples: int = 2000,
    reach: float = 1.0,
    goal_share: float = 0.05,
) -> Array | None:
    """Return a path that converges to the shortest with the number of samples.

    Args:
        is_clear: Whether one can go straight from one point to another.
        start: Start of the path, shape (2,) [m].
        goal: End of the path, shape (2,) [m].
        lower: Lower left corner of the region searched, shape (2,) [m].
        upper: Upper right corner, shape (2,) [m].
        rng: Random number generator.
        samples: Number of samples.
        reach: Longest branch [m].
        goal_share: Proportion of samples that are the goal itself.

    Returns:
        Corners of the path, shape (n, 2) [m]; None if no path was found.

    References:
        Karaman, Frazzoli, Sampling-based Algorithms for Optimal Motion Planning, IJRR 30(7), 2011, algorithm 6; the
        radius of rewiring from its theorem 38.
    """
    start, goal = np.asarray(start, dtype=float), np.asarray(goal, dtype=float)
    tree = _Tree(start, samples + 1)
    # gamma > 2 sqrt(1 + 1/2) sqrt(area / pi) in the plane.
    gamma = 2.0 * math.sqrt(1.5 * float(np.prod(np.asarray(upper) - lower)) / math.pi)
    for _ in range(samples):
        sample = goal if rng.random() < goal_share else rng.uniform(lower, upper)
        nearest = tree.nearest(sample)
        offset = sample - tree.places[nearest]
        distance = float(np.hypot(*offset))
        place = sample if distance <= reach else tree.places[nearest] + offset * (reach / distance)
        if distance == 0.0 or not is_clear(tree.places[nearest], place):
            continue
        radius = min(reach, gamma * math.sqrt(math.log(tree.size + 1) / (tree.size + 1)))
        around = [int(i) for i in tree.within(place, radius) if i != nearest and is_clear(tree.places[i], place)]
        tree.add(place, [nearest, *around])
    ends = [int(i) for i in tree.within(goal, reach) if is_clear(tree.places[i], goal)]
    if not ends:
        return None
    best = min(ends, key=lambda i: tree.cost[i] + math.dist(tree.places[i], goal))
    path = tree.path_to(best)
    return path if np.array_equal(path[-1], goal) else np.concatenate([path, [goal]])


class _Tree:
    """Nodes, each with its parent and the length of the path to it, in preallocated arrays."""

    def __init__(self, root: Array, room: int) -> None:
        self.places = np.full((room, 2), np.inf)
        self.cost = np.zeros(room)
        self.places[0], self.size = root, 1
        self._parent = np.zeros(room, dtype=int)
        self._children: list[list[int]] = [[] for _ in range(room)]

    def nearest(self, place: Array) -> int:
        return int(np.argmin(((self.places[: self.size] - place) ** 2).sum(axis=1)))

    def within(self, place: Array, radius: float) -> Indices:
        return np.flatnonzero(((self.places[: self.size] - place) ** 2).sum(axis=1) <= radius**2)

    def add(self, place: Array, around: list[int]) -> None:
        """Add a node below the neighbour with the shortest path to it; rewire neighbours where that shortens theirs."""
        steps = np.hypot(*(self.places[around] - place).T)
        best = int(np.argmin(self.cost[around] + steps))
        new, self.size = self.size, self.size + 1
        self.places[new] = place
        self._hang(new, around[best], float(self.cost[around[best]] + steps[best]))
        for neighbour, step in zip(around, steps.tolist(), strict=True):
            shorter = float(self.cost[new]) + step
            if shorter < self.cost[neighbour]:
                self._children[self._parent[neighbour]].remove(neighbour)
                self._hang(neighbour, new, shorter)

    def _hang(self, child: int, parent: int, cost: float) -> None:
        """Set the parent of a node, and shorten the paths to all nodes below it by as much."""
        self._parent[child] = parent
        self._children[parent].append(child)
        gain, below = cost - float(self.cost[child]), [child]
        while below:
            place = below.pop()
            self.cost[place] += gain
            below += self._children[place]

    def path_to(self, place: int) -> Array:
        indices = [place]
        while indices[-1] != 0:
            indices.append(int(self._parent[indices[-1]]))
        return np.asarray(self.places[indices[::-1]])


class Roadmap:
    """A probabilistic roadmap: connected samples, built once for many queries.

    References:
        Kavraki, Svestka, Latombe, Overmars, Probabilistic Roadmaps for Path Planning in High-Dimensional
        Configuration Spaces, IEEE T-RA 12(4), 1996. The number of neighbours grows as in Karaman and Frazzoli
        (2011), section 3.3.2 (k-PRM*), so that paths converge to the shortest.
    """

    def __init__(self, is_clear: IsClear, *, lower: Array, upper: Array, rng: Generator, places: int = 600) -> None:
        """Draw samples and connect neighbours.

        Args:
            is_clear: Whether one can go straight from one point to another.
            lower: Lower left corner of the region, shape (2,) [m].
            upper: Upper right corner, shape (2,) [m].
            rng: Random number generator.
            places: Number of free samples to draw.
        """
        self._is_clear = is_clear
        drawn: list[Array] = []
        for _ in range(100 * places):
            place = rng.uniform(lower, upper)
            if is_clear(place, place):
                drawn.append(place)
            if len(drawn) == places:
                break
        self._places = np.array(drawn).reshape(-1, 2)
        # k = e (1 + 1/2) log n in the plane.
        self._neighbours = max(2, math.ceil(1.5 * math.e * math.log(max(len(drawn), 2))))
        self._roads = self._joined(self._places, self._places)

    def path(self, start: Array, goal: Array) -> Array | None:
        """Return the shortest path over the roadmap, shape (n, 2) [m]; None if there is none."""
        ends = np.array([start, goal], dtype=float)
        number = len(self._places)
        joins = self._joined(ends, self._places)
        joins[:, 0] += number
        roads = np.concatenate([self._roads, joins])
        if self._is_clear(ends[0], ends[1]):
            roads = np.concatenate([roads, [(number, number + 1)]])
        places = np.concatenate([self._places, ends])
        lengths = np.hypot(*(places[roads[:, 0]] - places[roads[:, 1]]).T)
        graph = coo_array((lengths, roads.T), shape=(number + 2, number + 2)).tocsr()
        distance, before = dijkstra(graph, directed=False, indices=number, return_predecessors=True)
        if not np.isfinite(distance[number + 1]):
            return None
        indices = [number + 1]
        while indices[-1] != number:
            indices.append(int(before[indices[-1]]))
        return np.asarray(places[indices[::-1]])

    def _joined(self, ones: Array, others: Array) -> Indices:
        """Return the index pairs of near neighbours with a clear line between them, shape (n, 2)."""
        if not len(others):
            return np.zeros((0, 2), dtype=int)
        _, neighbours = cKDTree(others).query(ones, k=min(self._neighbours, len(others)))
        pairs = np.column_stack(
            [np.repeat(np.arange(len(ones)), np.atleast_2d(neighbours).shape[-1]), neighbours.ravel()]
        )
        if ones is others:
            pairs = np.unique(np.sort(pairs[pairs[:, 0] != pairs[:, 1]], axis=1), axis=0)
        clear = [self._is_clear(ones[i], others[j]) for i, j in pairs]
        return np.asarray(pairs[np.array(clear, dtype=bool)])
