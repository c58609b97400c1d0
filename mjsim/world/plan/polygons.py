"""The world from above: outlines of everything solid, for drawings, checks and maps."""

from typing import TYPE_CHECKING

import numpy as np

from mjsim.geometry import Array
from mjsim.world.items import World
from mjsim.world.plan.outlines import cut, footprint, stays, top
from mjsim.world.plan.pieces import Piece, wall_pieces
from mjsim.world.plan.wall_corners import solid_pieces

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

__all__ = ["Piece", "footprint", "obstacle_polygons", "segments", "solid", "top", "wall_pieces", "wall_polygons"]

GRID = 1e-6
"""Points closer than this coincide [m]."""
SLICE = 0.2
"""Height of the section [m]: above doorsteps, below window sills, where robots collide."""


def wall_polygons(world: World, *, height: float = SLICE) -> list[Array]:
    """Return the solid parts of the walls in a horizontal section.

    Args:
        world: The world.
        height: Height of the section above the floor [m].

    Returns:
        Convex outlines in the world frame, counter-clockwise, shape (4, 2) each [m]; neighbours share an edge.
    """
    pieces = (piece for wall in solid_pieces(world.walls) for piece in wall)
    return [piece.outline for piece in pieces if piece.low <= height < piece.high]


def obstacle_polygons(world: World, *, height: float = SLICE) -> list[Array]:
    """Return the sections of the static obstacles, shape (n, 2) each [m]."""
    return [outline for obstacle in world.obstacles if stays(obstacle) for outline in cut(obstacle, height)]


def solid(world: World, *, height: float = SLICE) -> "BaseGeometry":
    """Return the section of all walls and static obstacles as one shapely geometry [m]."""
    import shapely

    walls = np.array(wall_polygons(world, height=height)).reshape(-1, 4, 2)
    things = [shapely.Polygon(outline) for outline in obstacle_polygons(world, height=height)]
    # Rounded, so that edges computed twice coincide.
    outlines = np.concatenate([shapely.polygons(np.round(walls / GRID) * GRID), np.array(things, dtype=object)])
    parts = shapely.get_parts(shapely.disjoint_subset_union_all(outlines))
    # Snapped to a grid, so that joints leave no gaps: each part separately unless another is this close.
    one, other = shapely.STRtree(parts).query(parts, predicate="dwithin", distance=2 * GRID)
    touching = np.isin(np.arange(len(parts)), one[one != other])
    joined = shapely.set_precision(shapely.multipolygons(parts[touching]), GRID)
    return shapely.multipolygons(shapely.get_parts([*shapely.set_precision(parts[~touching], GRID), joined]))


def segments(world: World, *, height: float = SLICE) -> Array:
    """Return the faces of walls and obstacles in the section, solid to the left, shape (n, 2, 2) [m]."""
    import shapely

    parts = shapely.orient_polygons(shapely.get_parts(solid(world, height=height)))
    rings = [shapely.get_coordinates(ring) for part in parts for ring in (part.exterior, *part.interiors)]
    faces = [np.stack([ring[:-1], ring[1:]], axis=1) for ring in rings]
    return np.concatenate([np.zeros((0, 2, 2)), *faces])
