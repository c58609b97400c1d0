"""Coverage of the floor by a robot."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.world import World

CELL_SIDE = 0.5
"""Side of a cell [m]."""
REACH_MARGIN = 0.15
"""Margin of the robot at a reachable cell [m]."""


def coverage(world: World, positions: Array, *, radius: float) -> float | None:
    """Return the proportion of the reachable cells that the robot's footprint has touched.

    Args:
        world: Its world.
        positions: Positions of the robot, shape (N, 2) [m]; the first is its start.
        radius: Radius of its body [m].

    Returns:
        In [0, 1]; None in a world without walls, where the reachable area is unbounded. A cell of 0.5 m is reachable if
        the robot could drive from its start to the cell's centre with a margin of 0.15 m.
    """
    import shapely

    from mjsim.world import solid

    region = reachable_region(world, positions, radius=radius)
    if region is None:
        return None
    west, south, east, north = solid(world).bounds
    columns = np.arange(np.floor(west / CELL_SIDE), np.ceil(east / CELL_SIDE)) * CELL_SIDE
    rows = np.arange(np.floor(south / CELL_SIDE), np.ceil(north / CELL_SIDE)) * CELL_SIDE
    x, y = (corner.ravel() for corner in np.meshgrid(columns, rows))
    reachable = shapely.contains_xy(region, x + CELL_SIDE / 2, y + CELL_SIDE / 2)
    if not reachable.any():
        return None
    cells = shapely.box(x[reachable], y[reachable], x[reachable] + CELL_SIDE, y[reachable] + CELL_SIDE)
    return float(np.mean(_touched(cells, positions, radius)))


def reachable_region(world: World, positions: Array, *, radius: float) -> Any:
    """Return where a robot can drive from its start with its centre and a margin, a polygon [m].

    Args:
        world: Its world.
        positions: Positions of the robot, shape (N, 2) [m]; the first is its start.
        radius: Radius of its body [m].

    Returns:
        A polygon of shapely; None in a world without walls.
    """
    import shapely

    from mjsim.world import solid

    things = solid(world)
    if things.is_empty:
        return None
    room = shapely.box(*things.bounds).difference(things.buffer(radius + REACH_MARGIN))
    return _part_with(room, positions[0])


def _touched(cells: Any, positions: Array, radius: float) -> NDArray[np.bool_]:
    """Return which cells a round footprint has touched: their nearest point was within its radius of its centre.

    The path is processed in pieces, since the outline of the whole path would grow with every lap.
    """
    import shapely

    pieces = shapely.points(positions[:1])
    if len(positions) > 1:
        path = np.asarray(shapely.LineString(positions).simplify(0.005).coords)
        # This query finds nothing near a segment of length zero; its point is the end of another segment, or the first
        # one.
        pieces = np.append(pieces, shapely.linestrings(np.stack([path[:-1], path[1:]], axis=1)))
    tree = shapely.STRtree(pieces)
    touched = np.zeros(len(cells), dtype=bool)
    touched[tree.query(cells, predicate="dwithin", distance=radius)[0]] = True
    return touched


def _part_with(room: Any, start: Array) -> Any:
    """Return the connected part of the free space that contains the start, or is closest to it."""
    import shapely

    parts = shapely.get_parts(room)
    if not len(parts):
        return room
    return parts[int(np.argmin(shapely.distance(parts, shapely.Point(start))))]
