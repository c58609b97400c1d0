"""Occupancy grid of a world: solid cells in a horizontal section, and cells inside the walls."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mjsim.errors import UsageError
from mjsim.geometry import Array, Pose
from mjsim.models import MAX_PIXELS
from mjsim.sentences import Sentence
from mjsim.world.items import World
from mjsim.world.plan.polygons import SLICE, solid

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

MARGIN = 1.0
"""Margin around everything solid [m]."""
DOORWAY = 1.3
"""A gap between walls up to this width does not connect the inside to the outside [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """An occupancy grid; row 0 has the lowest y, column 0 the lowest x."""

    occupied: NDArray[np.bool_]
    """Shape (rows, columns)."""
    free: NDArray[np.bool_]
    """Shape (rows, columns); cells neither occupied nor free are unknown."""
    resolution: float
    """Side of a cell [m]."""
    world_from_grid: Pose
    """Pose of the grid: outer corner of row 0 and column 0, and direction of the rows [m, m, rad]."""

    def corners(self, cells: Array) -> Array:
        """Return points given in cells, (column, row) from the corner, in the world frame, shape (..., 2) [m]."""
        return self.world_from_grid.transform(np.asarray(cells) * self.resolution)

    def cells(self, points: Array) -> Array:
        """Return points of the world, shape (..., 2) [m], in cells, (column, row) from the corner."""
        return np.asarray(self.world_from_grid.inverse().transform(points) / self.resolution)


def grid_of(world: World, *, resolution: float = 0.05, height: float = SLICE, most_cells: int | None = None) -> Grid:
    """Return the map of a world as a horizontal lidar would build it, with cells at multiples of the resolution.

    A cell is occupied if its centre is in something solid; parts thinner than a cell are widened to one cell. Cells
    enclosed by walls are free, treating openings of any width and gaps up to the width of a doorway as closed; all
    other cells are unknown. In a world without an inside, or with a robot outside, all cells that are not occupied are
    free.

    Args:
        world: The world.
        resolution: Side of a cell [m].
        height: Height of the section above the floor [m].
        most_cells: If there would be more cells, the resolution is made coarser; by default UsageError is raised.

    Raises:
        UsageError: The resolution is out of range, nothing is solid at this height, or the map would have more than 40
            million cells.
    """
    if not 1e-3 <= resolution <= 10.0:
        raise UsageError(Sentence("resolution is {resolution:g} m; cells must be 0.001 to 10 m", resolution))
    shape = solid(world, height=height)
    if shape.is_empty:
        raise UsageError(
            Sentence("nothing of this world is solid {height:g} m above the floor; there is no map to write", height)
        )
    low_x, low_y, high_x, high_y = shape.bounds
    if most_cells is not None:
        area = (high_x - low_x + 2.0 * MARGIN) * (high_y - low_y + 2.0 * MARGIN)
        resolution = max(resolution, math.sqrt(area / most_cells))
    first = np.floor((np.array([low_x, low_y]) - MARGIN) / resolution)
    last = np.ceil((np.array([high_x, high_y]) + MARGIN) / resolution)
    columns, rows = (last - first).astype(int).tolist()
    if rows * columns > MAX_PIXELS:
        raise UsageError(
            Sentence("the map would have {count:.0f} million cells; make the resolution coarser", rows * columns / 1e6)
        )
    corner = first * resolution

    def drawn(part: "BaseGeometry") -> NDArray[np.bool_]:
        thin = thickened(part, resolution)
        shapes = [_faces(each) for each in (part, thin) if not each.is_empty]
        layers = [cells_within((faces - corner) / resolution, rows=rows, columns=columns) for faces in shapes]
        return np.asarray(np.logical_or.reduce(layers))

    occupied = drawn(shape)
    starts = np.array([robot.at for robot in world.robots]).reshape(-1, 2)
    closed = occupied | drawn(solid(_closed_walls(world), height=height))
    inside = _inside(closed, round(DOORWAY / 2 / resolution), (starts - corner) / resolution)
    return Grid(occupied, inside & ~occupied, resolution, Pose(float(corner[0]), float(corner[1]), 0.0))


def cells_within(faces: Array, *, rows: int, columns: int) -> NDArray[np.bool_]:
    """Return the cells whose centres lie inside closed outlines.

    Args:
        faces: Sides of the outlines, both ends of each, shape (n, 2, 2) [cells].
        rows: Number of rows of the grid.
        columns: Number of columns of the grid.

    Returns:
        Shape (rows, columns); a centre is inside if a ray to the left crosses an odd number of sides.
    """
    ends = np.sort(faces[:, :, 1], axis=1)
    first = np.clip(np.ceil(ends[:, 0] - 0.5), 0, rows).astype(int)
    count = np.clip(np.ceil(ends[:, 1] - 0.5), 0, rows).astype(int) - first
    side = np.repeat(np.arange(len(faces)), count)
    row = np.arange(len(side)) - np.repeat(np.cumsum(count) - count, count) + first[side]
    (x0, y0), (x1, y1) = faces[side, 0].T, faces[side, 1].T
    x = x0 + (row + 0.5 - y0) * (x1 - x0) / (y1 - y0)
    crossed = np.zeros((rows, columns + 1), dtype=np.uint8)
    # Slightly to the left, so that a side through a centre counts the same regardless of rounding.
    np.add.at(crossed, (row, np.clip(np.ceil(x - 0.5 - 1e-9), 0, columns).astype(int)), 1)
    return np.asarray(np.bitwise_xor.accumulate(crossed & 1, axis=1)[:, :columns].astype(bool))


def cells_of(shape: "BaseGeometry", grid: Grid) -> NDArray[np.bool_]:
    """Return the cells of a grid whose centres lie in a shape of the world, shape (rows, columns)."""
    rows, columns = grid.occupied.shape
    if shape.is_empty:
        return np.zeros((rows, columns), dtype=bool)
    faces = _faces(shape)
    return cells_within(grid.cells(faces), rows=rows, columns=columns)


def _closed_walls(world: World) -> World:
    """Return the walls of a world that have openings, without the openings."""
    walls = tuple(wall.model_copy(update={"openings": ()}) for wall in world.walls if wall.openings)
    return world.model_copy(update={"walls": walls, "obstacles": ()})


def thickened(shape: "BaseGeometry", resolution: float) -> "BaseGeometry":
    """Return the parts of a shape that are thinner than a cell, widened by one cell."""
    import shapely

    half, parts = resolution / 2, shapely.get_parts(shape)
    opened = shapely.buffer(shapely.buffer(parts, -half * 0.99, join_style="mitre"), half, join_style="mitre")
    thin = shapely.get_parts(shapely.difference(parts, opened))
    return shapely.union_all(shapely.buffer(thin[shapely.area(thin) > resolution**2 / 2], half))


def _faces(shape: "BaseGeometry") -> Array:
    """Return the sides of a shape's outlines, including holes, shape (n, 2, 2)."""
    import shapely

    polygons = [part for part in shapely.get_parts(shape) if part.geom_type == "Polygon"]
    rings = [shapely.get_coordinates(ring) for part in polygons for ring in (part.exterior, *part.interiors)]
    return np.concatenate([np.stack([ring[:-1], ring[1:]], axis=1) for ring in rings])


def _inside(occupied: NDArray[np.bool_], reach: int, starts: Array) -> NDArray[np.bool_]:
    """Return the cells that no passage wider than a doorway connects to the edge; all cells if robots are outside."""
    import cv2

    away = cv2.distanceTransform((~occupied).astype(np.uint8), cv2.DIST_L2, 5)
    _, parts = cv2.connectedComponents((away > reach).astype(np.uint8), connectivity=4)
    edge = np.unique(np.concatenate([parts[0], parts[-1], parts[:, 0], parts[:, -1]]))
    outside = np.isin(parts, edge[edge > 0])
    inside = cv2.distanceTransform((~outside).astype(np.uint8), cv2.DIST_L2, 5) > reach
    rows, columns = occupied.shape
    for x, y in starts:
        column, row = math.floor(x), math.floor(y)
        if not (0 <= column < columns and 0 <= row < rows and inside[row, column]):
            return np.ones_like(occupied)
    return np.asarray(inside if (inside & ~occupied).any() else np.ones_like(occupied), dtype=bool)
