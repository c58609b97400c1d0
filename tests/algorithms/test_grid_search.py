"""A* on grids, against Dijkstra's algorithm on an explicit graph."""

import itertools
import math
import sys
import time

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from mjsim.algorithms.paths.grid_search import a_star, length
from mjsim.algorithms.scans.distance_grid import DistanceGrid


def rooms(rng, size):
    """Return a map with walls, doors and blocks in the manner of the MovingAI benchmarks: True where occupied."""
    taken = rng.random((size, size)) < rng.uniform(0.0, 0.25)
    for at in range(8, size, 8):
        taken[at], taken[:, at] = True, True
    for row, column in itertools.product(range(0, size, 8), repeat=2):
        taken[min(row + int(rng.integers(1, 8)), size - 1), column] = False
        taken[row, min(column + int(rng.integers(1, 8)), size - 1)] = False
    return taken


def graph_of(free):
    """Return the graph of the free cells: to each neighbour, diagonally only if both cells beside are free."""
    rows, columns = free.shape
    starts, ends, lengths = [], [], []
    for (r, c), (down, right) in itertools.product(np.argwhere(free).tolist(), itertools.product((-1, 0, 1), repeat=2)):
        y, x = r + down, c + right
        if (down or right) and 0 <= y < rows and 0 <= x < columns and free[y, x] and free[r, x] and free[y, c]:
            starts.append(r * columns + c)
            ends.append(y * columns + x)
            lengths.append(math.hypot(down, right))
    return coo_matrix((lengths, (starts, ends)), shape=(free.size,) * 2).tocsr()


def differences(seed, size, pairs):
    """Return differences of the lengths of both paths, one for each random pair of free cells [cells]."""
    rng = np.random.default_rng(seed)
    taken = rooms(rng, size)
    grid, graph, free = DistanceGrid(taken, lower=np.zeros(2), cell=1.0), graph_of(~taken), np.argwhere(~taken)
    found = []
    for _ in range(pairs):
        start, goal = free[rng.choice(len(free), 2, replace=False)]
        shortest = dijkstra(graph, indices=int(start[0]) * size + int(start[1]))[int(goal[0]) * size + int(goal[1])]
        path = a_star(grid, start[::-1] + 0.5, goal[::-1] + 0.5, clearance=0.5)
        found.append(0.0 if path is None and math.isinf(shortest) else length(path) - shortest)
    return np.array(found)


def test_its_paths_are_as_short_as_those_of_dijkstra():
    np.testing.assert_allclose(differences(0, 24, 12), 0.0, atol=1e-9)


@pytest.mark.slow
def test_its_paths_are_the_shortest_on_three_hundred_pairs_of_cells():
    found = np.concatenate([differences(seed, 40, 30) for seed in range(10)])
    assert len(found) == 300
    np.testing.assert_allclose(found, 0.0, atol=1e-9)


@pytest.mark.slow
def test_it_expands_a_third_of_the_cells_of_dijkstra_for_the_same_lengths():
    rng = np.random.default_rng(0)
    taken = rooms(rng, 64)
    grid, free = DistanceGrid(taken, lower=np.zeros(2), cell=1.0), np.argwhere(~taken)
    counts, seconds, lengths = np.zeros(2), np.zeros(2), np.zeros(2)
    for _ in range(60):
        start, goal = free[rng.choice(len(free), 2, replace=False)][:, ::-1] + 0.5
        for column, guided in enumerate((True, False)):
            expanded, began = set(), time.process_time()
            path = a_star(grid, start, goal, clearance=0.5, guided=guided, expanded=expanded)
            seconds[column] += time.process_time() - began
            counts[column] += len(expanded)
            lengths[column] += 0.0 if path is None else length(path)
    sys.stdout.write(f"A*, Dijkstra: {counts / 60} cells, {1e3 * seconds / 60} ms a path\n")
    assert lengths[0] == pytest.approx(lengths[1])
    assert counts[0] < 0.4 * counts[1]


def test_it_cuts_no_corner():
    taken = np.zeros((5, 5), dtype=bool)
    taken[2, :2] = True
    path = a_star(
        DistanceGrid(taken, lower=np.zeros(2), cell=1.0), np.array([1.5, 1.5]), np.array([1.5, 3.5]), clearance=0.5
    )
    assert length(path) == pytest.approx(4.0)
    assert [2.5, 2.5] in path.tolist()
