"""Ground below people: the floor, ramps, steps, and low, level objects."""

import math
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from mjsim.geometry import Array
from mjsim.world.items.things import (
    BoxObstacle,
    CylinderObstacle,
    ModelObstacle,
    Obstacle,
    RampObstacle,
    SphereObstacle,
    StepsObstacle,
)

PLATFORM = 0.5
"""People stand on level things up to this height; higher ones are obstacles [m]; assumed."""
EDGE = 1e-9
"""Tolerance within which points on an edge count as on the thing [m]."""


def floors(things: Iterable[Obstacle]) -> tuple[Obstacle, ...]:
    """Return the objects on which people can stand: ramps, steps, and fixed, level, low ones."""
    return tuple(thing for thing in things if not thing.movable and thing.path is None and _is_floor(thing))


def height_under(things: Sequence[Obstacle], spot: Array, *, limit: float = math.inf) -> float:
    """Return the height of the floor, or of the highest of the things on it, at a place [m].

    Args:
        things: Things on the floor.
        spot: World frame, shape (2,) [m].
        limit: Things that are higher there are ignored [m].
    """
    return max((top for thing in things for top in _tops(thing, spot) if top <= limit), default=0.0)


def _is_floor(thing: Obstacle) -> bool:
    match thing:
        case RampObstacle() | StepsObstacle():
            return True
        case BoxObstacle(box=(_, _, height)) | CylinderObstacle(cylinder=(_, height)):
            return thing.elevation + height <= PLATFORM
        case ModelObstacle():
            return thing.elevation + (thing.shape.high - thing.shape.low) * thing.scale <= PLATFORM
        case _:
            return False


def _tops(thing: Obstacle, spot: Array) -> Iterator[float]:
    """Yield the height of a thing above the floor at a place, nothing if it is not below the place [m]."""
    angle = math.radians(thing.heading_deg)
    away, c, s = spot - thing.at, math.cos(angle), math.sin(angle)
    x, y = float(c * away[0] + s * away[1]), float(c * away[1] - s * away[0])
    match thing:
        case BoxObstacle(box=(length, width, height)):
            if _within(x, length) and _within(y, width):
                yield thing.elevation + height
        case RampObstacle(ramp=(length, width, rise)):
            if _within(x, length) and _within(y, width):
                yield thing.elevation + rise * (x / length + 0.5)
        case StepsObstacle(steps=(length, width, rise), count=count):
            if _within(x, length) and _within(y, width):
                step = min(max(math.floor(count * (x / length + 0.5)), 0), count - 1)
                yield thing.elevation + rise * (step + 1) / count
        case CylinderObstacle(cylinder=(radius, height)):
            if math.hypot(x, y) <= radius + EDGE:
                yield thing.elevation + height
        case SphereObstacle(sphere=radius):
            if math.hypot(x, y) <= radius:
                yield thing.elevation + 2 * radius
        case ModelObstacle(shape=shape, scale=scale):
            for hull, _, high in shape.columns:
                if _holds(hull * scale, x, y):
                    yield thing.origin_height + high * scale


def _within(along: float, length: float) -> bool:
    return abs(along) <= length / 2 + EDGE


def _holds(outline: Array, x: float, y: float) -> bool:
    """Return whether a convex outline, counter-clockwise, shape (n, 2), contains a point [m]."""
    sides, ahead = np.roll(outline, -1, axis=0) - outline, np.array([x, y]) - outline
    return bool(np.all(sides[:, 0] * ahead[:, 1] - sides[:, 1] * ahead[:, 0] >= 0.0))
