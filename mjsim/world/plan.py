"""The world seen from above: outlines of what is solid, for drawing, for checks and for the map."""

import math
from typing import TYPE_CHECKING

import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.world.model import World
from mjsim.world.pieces import Piece, wall_pieces
from mjsim.world.things import (
    BoxObstacle,
    CylinderObstacle,
    ModelObstacle,
    Obstacle,
    RampObstacle,
    SphereObstacle,
    StepsObstacle,
)

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

__all__ = ["Piece", "footprint", "obstacle_polygons", "segments", "solid", "top", "wall_pieces", "wall_polygons"]

SLICE = 0.2
"""Height at which the plan is cut [m]: above doorsteps, below window sills, where robots bump."""
CYLINDER_SIDES = 32


def wall_polygons(world: World, *, height: float = SLICE) -> list[Array]:
    """Return the solid parts of the walls where a level plane cuts them.

    Args:
        world: Its walls with their openings.
        height: Of the plane above the floor [m].

    Returns:
        Convex outlines in the world frame, counter-clockwise, shape (4, 2) each [m]; neighbours share an edge.
    """
    pieces = (piece for wall in world.walls for piece in wall_pieces(wall))
    return [piece.outline for piece in pieces if piece.low <= height < piece.high]


def obstacle_polygons(world: World, *, height: float = 0.0) -> list[Array]:
    """Return the outlines of the obstacles that reach above a height, world frame, shape (n, 2) each [m]."""
    return [footprint(obstacle) for obstacle in world.obstacles if top(obstacle) > height]


def footprint(obstacle: Obstacle) -> Array:
    """Return the outline of an obstacle from above, world frame, counter-clockwise, shape (n, 2) [m]."""
    world_from_obstacle = Pose(obstacle.at[0], obstacle.at[1], math.radians(obstacle.heading_deg))
    return world_from_obstacle.transform(_outline(obstacle))


def _outline(obstacle: Obstacle) -> Array:
    """Return the outline of an obstacle from above in its own frame, shape (n, 2) [m]."""
    match obstacle:
        case BoxObstacle(box=(length, width, _)) | RampObstacle(ramp=(length, width, _)):
            return _rectangle(length, width)
        case StepsObstacle(steps=(length, width, _)):
            return _rectangle(length, width)
        case CylinderObstacle(cylinder=(radius, _)) | SphereObstacle(sphere=radius):
            angles = np.arange(CYLINDER_SIDES) * (2 * np.pi / CYLINDER_SIDES)
            return radius * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        case ModelObstacle(scale=scale):
            return _rectangle(scale, scale)


def _rectangle(length: float, width: float) -> Array:
    return np.array([length, width]) / 2 * [[-1, -1], [1, -1], [1, 1], [-1, 1]]


def solid(world: World, *, height: float = SLICE) -> "BaseGeometry":
    """Return everything that a robot can bump into where a level plane cuts it, as one shapely geometry [m]."""
    import shapely

    outlines = wall_polygons(world, height=height) + obstacle_polygons(world, height=height)
    # On a grid of a micrometre, so that edges computed twice are one and a joint leaves no hair crack.
    return shapely.union_all([shapely.Polygon(outline) for outline in outlines], grid_size=1e-6)


def segments(world: World, *, height: float = SLICE) -> Array:
    """Return the faces of walls and obstacles in the plane, solid to the left, shape (n, 2, 2) [m]."""
    import shapely

    parts = shapely.orient_polygons(shapely.get_parts(solid(world, height=height)))
    rings = [shapely.get_coordinates(ring) for part in parts for ring in (part.exterior, *part.interiors)]
    faces = [np.stack([ring[:-1], ring[1:]], axis=1) for ring in rings]
    return np.concatenate([np.zeros((0, 2, 2)), *faces])


def top(obstacle: Obstacle) -> float:
    """Return the height of an obstacle's highest point above the floor [m]."""
    match obstacle:
        case BoxObstacle(box=(_, _, height)) | RampObstacle(ramp=(_, _, height)) | StepsObstacle(steps=(_, _, height)):
            return obstacle.elevation + height
        case CylinderObstacle(cylinder=(_, height)):
            return obstacle.elevation + height
        case SphereObstacle(sphere=radius):
            return obstacle.elevation + 2 * radius
        case ModelObstacle(scale=scale):
            return obstacle.elevation + scale
