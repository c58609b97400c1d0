"""Exact shortest paths among walls, along a visibility graph of their corners."""

import itertools

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from mjsim.geometry import Array

ROUNDING = 4
"""Straight segments per quarter circle around a corner."""


def shortest_path(segments: Array, start: Array, goal: Array, *, clearance: float) -> Array | None:
    """Return the shortest path of a disc among walls.

    Walls are inflated by the clearance; the shortest path consists of straight lines between corners of the inflated
    walls. Round corners are approximated by straight segments outside the true arc, so that the clearance holds.

    Args:
        segments: Faces of walls and obstacles, shape (n, 2, 2) [m].
        start: Start of the path, shape (2,) [m].
        goal: End of the path, shape (2,) [m].
        clearance: Radius of the disc [m], above 0.

    Returns:
        Corners of the path including start and goal, shape (n, 2) [m]; None if there is no path.

    References:
        Lozano-Perez, Wesley, An Algorithm for Planning Collision-Free Paths Among Polyhedral Obstacles, CACM 22(10),
        1979. de Berg et al., Computational Geometry (2008), chapter 15.
    """
    # The corners of a polygon around a circle are farther out by 1/cos of half the angle of a side.
    outside = clearance / np.cos(np.pi / (4 * ROUNDING))
    grown = shapely.union_all(shapely.buffer(shapely.linestrings(segments), outside, quad_segs=ROUNDING))
    grown = shapely.simplify(grown, 1e-9)
    if not shapely.is_empty(grown) and shapely.contains_properly(grown, shapely.points([start, goal])).any():
        return None
    corners = np.concatenate([[start, goal], shapely.get_coordinates(grown)])
    corners = corners[np.sort(np.unique(corners, axis=0, return_index=True)[1])]
    pairs = np.array(list(itertools.combinations(range(len(corners)), 2)))
    lines = shapely.linestrings(corners[pairs])
    # Contact is allowed: shrink slightly, so that a line along an edge does not count as inside.
    shapely.prepare(inner := shapely.buffer(grown, -1e-7))
    seen = pairs[~shapely.intersects(inner, lines)]
    lengths = np.hypot(*(corners[seen[:, 0]] - corners[seen[:, 1]]).T)
    graph = coo_array((lengths, seen.T), shape=(len(corners), len(corners))).tocsr()
    distance, before = dijkstra(graph, directed=False, indices=0, return_predecessors=True)
    if not np.isfinite(distance[1]):
        return None
    indices = [1]
    while indices[-1] != 0:
        indices.append(int(before[indices[-1]]))
    return np.asarray(corners[indices[::-1]])
