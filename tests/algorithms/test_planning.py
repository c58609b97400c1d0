"""Planners on problems whose shortest way is known."""

import itertools
import math

import numpy as np
import pytest
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from mjsim.algorithms.paths.grid_search import a_star, length, straightened
from mjsim.algorithms.paths.sampling_planners import Roadmap, rrt_star
from mjsim.algorithms.paths.visibility_graph import shortest_path
from mjsim.algorithms.scans.distance_grid import DistanceGrid


def ring(x0, y0, x1, y1):
    corners = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], dtype=float)
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)


ROOM = ring(0, 0, 8, 6)
# A wall from below that leaves a passage above it: the way leads over its upper end at (4, 4).
BARRIER = np.concatenate([ROOM, ring(3.9, 0, 4.1, 4)])
START, GOAL = np.array([1.0, 1.0]), np.array([7.0, 1.0])
RADIUS = 0.3


def shortest_known():
    """The way over the barrier's two upper corners: tangents and arcs of circles around them, by hand."""
    corner, far = np.array([3.9, 4.0]), math.dist((1.0, 1.0), (3.9, 4.0))
    tangent = math.sqrt(far**2 - RADIUS**2)
    # From the direction towards the corner to the tangent point as seen from the corner, until straight up.
    to_start = math.atan2(1.0 - corner[1], 1.0 - corner[0]) % (2 * math.pi)
    arc = to_start - math.acos(RADIUS / far) - math.pi / 2
    return 2 * (tangent + RADIUS * arc) + 0.2


def test_the_visibility_graph_finds_the_shortest_way():
    way = shortest_path(BARRIER, START, GOAL, clearance=RADIUS)
    assert length(way) == pytest.approx(shortest_known(), rel=0.005)
    assert length(way) >= shortest_known()
    walls = shapely.MultiLineString(BARRIER.tolist())
    assert shapely.LineString(way).distance(walls) > RADIUS - 1e-6


def test_a_star_is_as_cheap_as_what_scipy_finds_on_the_same_grid():
    grid = DistanceGrid.from_segments(BARRIER, cell=0.2)
    free = grid.distance > RADIUS
    number = np.arange(free.size).reshape(free.shape)
    edges = []
    for r, c in np.argwhere(free):
        for dr, dc in ((0, 1), (1, 0), (1, 1), (1, -1)):
            inside = 0 <= r + dr < free.shape[0] and 0 <= c + dc < free.shape[1]
            if inside and free[r + dr, c + dc] and free[r + dr, c] and free[r, c + dc]:
                edges.append((number[r, c], number[r + dr, c + dc], math.hypot(dr, dc) * 0.2))
    one, other, cost = np.array(edges).T
    graph = coo_array((cost, (one.astype(int), other.astype(int))), shape=(free.size, free.size)).tocsr()
    start, goal = (grid.centres(grid.cells(point)) for point in (START, GOAL))
    first, last = (number[tuple(grid.cells(point))] for point in (START, GOAL))
    expected = dijkstra(graph, directed=False, indices=first)[last]
    way = a_star(grid, start, goal, clearance=RADIUS)
    assert length(way) == pytest.approx(expected, abs=1e-9)


def test_a_straightened_way_is_nearly_the_shortest_and_keeps_clear():
    grid = DistanceGrid.from_segments(BARRIER, cell=0.05)
    way = straightened(grid, a_star(grid, START, GOAL, clearance=RADIUS), clearance=RADIUS)
    assert length(way) < 1.03 * shortest_known()
    assert len(way) < 12
    assert shapely.LineString(way).distance(shapely.MultiLineString(BARRIER.tolist())) > RADIUS - 0.08


def test_a_shy_way_keeps_farther_from_walls():
    grid = DistanceGrid.from_segments(BARRIER, cell=0.1)
    direct, shy = (a_star(grid, START, GOAL, clearance=RADIUS, shyness=s) for s in (0.0, 5.0))
    assert grid.at(shy).mean() > grid.at(direct).mean() + 0.1
    assert length(shy) > length(direct)


@pytest.fixture(scope="module")
def clear():
    grid = DistanceGrid.from_segments(BARRIER, cell=0.05)
    return lambda one, other: grid.is_clear(one, other, RADIUS)


@pytest.mark.slow
def test_rrt_star_comes_near_the_shortest_way(clear):
    lower, upper = np.zeros(2), np.array([8.0, 6.0])
    ways = [
        rrt_star(clear, START, GOAL, lower=lower, upper=upper, rng=np.random.default_rng(0), samples=samples)
        for samples in (300, 900)
    ]
    assert length(ways[1]) < 1.06 * shortest_known()
    assert length(ways[1]) <= length(ways[0])
    assert all(clear(one, other) for one, other in itertools.pairwise(ways[1]))
    np.testing.assert_array_equal(ways[1][[0, -1]], [START, GOAL])


@pytest.mark.slow
def test_the_roadmap_comes_near_the_shortest_way_and_answers_again(clear):
    roadmap = Roadmap(clear, lower=np.zeros(2), upper=np.array([8.0, 6.0]), rng=np.random.default_rng(0), places=400)
    way = roadmap.path(START, GOAL)
    assert length(way) < 1.08 * shortest_known()
    assert all(clear(one, other) for one, other in itertools.pairwise(way))
    np.testing.assert_array_equal(roadmap.path(GOAL, START), way[::-1])


def test_where_there_is_no_way_all_say_so(clear):
    shut = np.concatenate([ROOM, ring(3.9, 0, 4.1, 6)])
    grid = DistanceGrid.from_segments(shut, cell=0.1)

    def is_clear(one, other):
        return grid.is_clear(one, other, RADIUS)

    box = {"lower": np.zeros(2), "upper": np.array([8.0, 6.0]), "rng": np.random.default_rng(0)}
    assert a_star(grid, START, GOAL, clearance=RADIUS) is None
    assert shortest_path(shut, START, GOAL, clearance=RADIUS) is None
    assert rrt_star(is_clear, START, GOAL, samples=200, **box) is None
    assert Roadmap(is_clear, places=100, **box).path(START, GOAL) is None
