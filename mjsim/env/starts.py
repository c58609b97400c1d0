"""Random starts: places where a robot touches nothing and that it could reach from its start in the world."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from numpy.random import Generator

from mjsim.errors import UsageError
from mjsim.geometry import Pose
from mjsim.world import SLICE, Robot, Solids, World, disc, leaves, solid

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

MIN_CLEARANCE = 0.05
"""Minimum distance around the body [m]."""
MAX_TRIES = 10_000
"""Number of places tried before giving up."""
MAX_START_DISTANCE = 5.0
"""Maximum distance from the start along each axis, if there are no walls [m]."""

Taken = tuple[float, float, float]
"""Position [m, m] and radius [m] of a robot already placed."""


class Starts:
    """Draws poses for one robot."""

    def __init__(self, world: World, robot: Robot) -> None:
        """Compute the reachable area."""
        from shapely import Polygon, prepare, unary_union

        self._robot, self._solids = robot, Solids(world)
        self._radius = robot.body.radius + MIN_CLEARANCE
        doors = [Polygon(leaf.pose(0.0).transform(leaf.outline())) for leaf in leaves(world)]
        self._doors = unary_union(doors).buffer(self._radius)
        self._free = _reachable(world, robot, self._radius)
        prepare(self._free)
        prepare(self._doors)

    def draw(self, rng: Generator, taken: Sequence[Taken]) -> Pose:
        """Return a pose, uniformly distributed over free places and headings.

        Args:
            rng: Random generator.
            taken: Positions of other robots.

        Raises:
            UsageError: No place was found.
        """
        west, south, east, north = self._free.bounds
        for _ in range(MAX_TRIES):
            x, y, heading = rng.uniform((west, south, -math.pi), (east, north, math.pi)).tolist()
            if self._fits(x, y) and all(
                math.hypot(x - other_x, y - other_y) > self._radius + radius for other_x, other_y, radius in taken
            ):
                return Pose(x, y, heading)
        raise UsageError(f"no free place for robot '{self._robot.name}' in {MAX_TRIES} tries; leave out random_starts")

    def _fits(self, x: float, y: float) -> bool:
        from shapely import Point

        spot = Point(x, y)
        if not self._free.intersects(spot) or self._doors.intersects(spot):
            return False
        around = disc((x, y), self._radius, sides=64)
        return self._solids.reached(around, depth=0.0, low=0.0, high=self._robot.body.height) is None


def _reachable(world: World, robot: Robot, radius: float) -> "BaseGeometry":
    """Return the part of the free plane that contains a robot's start, or is closest to it, with doors open."""
    from shapely import Point, box, get_parts

    start, walls = Point(robot.at), solid(world, height=min(SLICE, robot.body.height / 2))
    bounds = box(*walls.bounds) if world.walls else start.buffer(MAX_START_DISTANCE, cap_style="square")
    free = bounds.difference(walls.buffer(radius))
    if free.is_empty:
        raise UsageError(f"no free place for robot '{robot.name}'; it is too wide for this world")
    nearest: BaseGeometry = min(get_parts(free), key=start.distance)
    return nearest
