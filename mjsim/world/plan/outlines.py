"""Obstacles from above: footprint, height, and horizontal sections."""

import math

import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.world.items import (
    BoxObstacle,
    CylinderObstacle,
    ModelObstacle,
    Obstacle,
    RampObstacle,
    SphereObstacle,
    StepsObstacle,
)

CIRCLE_SIDES = 32
THINNEST = 1e-6
"""Thinner parts are ignored [m]."""


def world_from_obstacle(obstacle: Obstacle) -> Pose:
    """Return the initial pose of an obstacle; the x axis of its frame is along its length."""
    return Pose(obstacle.at[0], obstacle.at[1], math.radians(obstacle.heading_deg))


def stays(obstacle: Obstacle) -> bool:
    """Return whether an obstacle is static."""
    return not obstacle.movable and obstacle.path is None


def footprint(obstacle: Obstacle) -> Array:
    """Return the outline of an obstacle from above, world frame, counter-clockwise, shape (n, 2) [m].

    It is convex except for models.
    """
    match obstacle:
        case BoxObstacle(box=(length, width, _)) | RampObstacle(ramp=(length, width, _)):
            outline = _rectangle(-length / 2, length / 2, width)
        case StepsObstacle(steps=(length, width, _)):
            outline = _rectangle(-length / 2, length / 2, width)
        case CylinderObstacle(cylinder=(radius, _)) | SphereObstacle(sphere=radius):
            outline = _circle(radius)
        case ModelObstacle(shape=shape, scale=scale):
            outline = shape.outline * scale
        case _:
            raise AssertionError(obstacle)
    return world_from_obstacle(obstacle).transform(outline)


def bottom(obstacle: Obstacle) -> float:
    """Return the height of an obstacle's lowest point above the floor [m]."""
    return obstacle.elevation


def top(obstacle: Obstacle) -> float:
    """Return the height of an obstacle's highest point above the floor [m]."""
    match obstacle:
        case BoxObstacle(box=(_, _, height)) | RampObstacle(ramp=(_, _, height)) | StepsObstacle(steps=(_, _, height)):
            return obstacle.elevation + height
        case CylinderObstacle(cylinder=(_, height)):
            return obstacle.elevation + height
        case SphereObstacle(sphere=radius):
            return obstacle.elevation + 2 * radius
        case ModelObstacle(shape=shape, scale=scale):
            return obstacle.elevation + (shape.high - shape.low) * scale
        case _:
            raise AssertionError(obstacle)


def prisms(obstacle: Obstacle) -> list[tuple[Array, float, float]]:
    """Return vertical prisms that contain an obstacle: one per part of a model, otherwise one.

    Returns:
        Each has a convex outline, world frame, counter-clockwise, shape (n, 2) [m], and the heights of its lower and
        upper face above the floor [m].
    """
    if not isinstance(obstacle, ModelObstacle):
        return [(footprint(obstacle), bottom(obstacle), top(obstacle))]
    place, scale = world_from_obstacle(obstacle), obstacle.scale
    lift = obstacle.origin_height
    return [
        (place.transform(hull * scale), low * scale + lift, high * scale + lift)
        for hull, low, high in obstacle.shape.columns
    ]


def cut(obstacle: Obstacle, height: float) -> list[Array]:
    """Return the horizontal section of an obstacle.

    Args:
        obstacle: The obstacle, at its initial position.
        height: Height of the section above the floor [m].

    Returns:
        Convex outlines, world frame, counter-clockwise, shape (n, 2) each [m]; for a model, the hull from above of each
        part that the plane cuts.
    """
    if not bottom(obstacle) <= height < top(obstacle):
        return []
    above, place = height - obstacle.elevation, world_from_obstacle(obstacle)
    match obstacle:
        case SphereObstacle(sphere=radius):
            across = math.sqrt(max(radius**2 - (above - radius) ** 2, 0.0))
            return [place.transform(_circle(across))] if across > THINNEST else []
        case RampObstacle(ramp=(length, width, rise)):
            return [place.transform(_rectangle(length * (above / rise - 0.5), length / 2, width))]
        case StepsObstacle(steps=(length, width, rise), count=count):
            lower = math.floor(above / rise * count)
            return [place.transform(_rectangle(length * (lower / count - 0.5), length / 2, width))]
        case ModelObstacle():
            return [outline for outline, low, high in prisms(obstacle) if low <= height < high]
    return [footprint(obstacle)]


def _rectangle(back: float, front: float, width: float) -> Array:
    half = width / 2
    return np.array([[back, -half], [front, -half], [front, half], [back, half]])


def _circle(radius: float) -> Array:
    angles = np.arange(CIRCLE_SIDES) * (2 * np.pi / CIRCLE_SIDES)
    return radius * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
