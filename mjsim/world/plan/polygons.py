"""The world seen from above: outlines of what is solid, for drawing, for checks and for the map."""

from typing import TYPE_CHECKING

import numpy as np

from mjsim.geometry import Array
from mjsim.world.items import World
from mjsim.world.plan.corners import solid_pieces
from mjsim.world.plan.outlines import cut, footprint, stays, top
from mjsim.world.plan.pieces import Piece, wall_pieces

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

__all__ = ["Piece", "footprint", "obstacle_polygons", "segments", "solid", "top", "wall_pieces", "wall_polygons"]

GRID = 1e-6
"""Points nearer than this are one [m]."""
SLICE = 0.2
"""Height at which the plan is cut [m]: above doorsteps, below window sills, where robots bump."""


def wall_polygons(world: World, *, height: float = SLICE) -> list[Array]:
    """Return the solid parts of the walls where a level plane cuts them.

    Args:
        world: Its walls with their openings.
        height: Of the plane above the floor [m].

    Returns:
        Convex outlines in the world frame, counter-clockwise, shape (4, 2) each [m]; neighbours share an edge.
    """
    pieces = (piece for wall in solid_pieces(world.walls) for piece in wall)
    return [piece.outline for piece in pieces if piece.low <= height < piece.high]


def obstacle_polygons(world: World, *, height: float = SLICE) -> list[Array]:
    """Return what a level plane cuts of the obstacles that stay where they are, shape (n, 2) each [m]."""
    return [outline for obstacle in world.obstacles if stays(obstacle) for outline in cut(obstacle, height)]


def solid(world: World, *, height: float = SLICE) -> "BaseGeometry":
    """Return all walls and obstacles that stay, where a level plane cuts them, as one shapely geometry [m]."""
    import shapely

    walls = np.array(wall_polygons(world, height=height)).reshape(-1, 4, 2)
    things = [shapely.Polygon(outline) for outline in obstacle_polygons(world, height=height)]
    # Rounded, so that edges computed twice are one.
    outlines = np.concatenate([shapely.polygons(np.round(walls / GRID) * GRID), np.array(things, dtype=object)])
    parts = shapely.get_parts(shapely.disjoint_subset_union_all(outlines))
    # On a grid, so that a joint leaves no hair crack: each part on its own unless another is so near.
    one, other = shapely.STRtree(parts).query(parts, predicate="dwithin", distance=2 * GRID)
    near = np.isin(np.arange(len(parts)), one[one != other])
    joined = shapely.set_precision(shapely.multipolygons(parts[near]), GRID)
    return shapely.multipolygons(shapely.get_parts([*shapely.set_precision(parts[~near], GRID), joined]))


def segments(world: World, *, height: float = SLICE) -> Array:
    """Return the faces of walls and obstacles in the plane, solid to the left, shape (n, 2, 2) [m]."""
    import shapely

    parts = shapely.orient_polygons(shapely.get_parts(solid(world, height=height)))
    rings = [shapely.get_coordinates(ring) for part in parts for ring in (part.exterior, *part.interiors)]
    faces = [np.stack([ring[:-1], ring[1:]], axis=1) for ring in rings]
    return np.concatenate([np.zeros((0, 2, 2)), *faces])
