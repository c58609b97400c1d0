"""Walls and obstacles as upright prisms, to ask what stands somewhere; and how doubts about a world are told."""

from collections.abc import Collection, Iterator
from typing import TYPE_CHECKING

from mjsim.world.items import Obstacle, Wall, World
from mjsim.world.plan import prisms, wall_pieces

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

Doubt = tuple[str, tuple[str | int, ...]]
"""A sentence, and the path of the value that it is about."""

SPARE = 1e-3
"""A beacon or a robot may reach this far into something [m]: coordinates are written to the millimetre."""


_Prism = tuple[str, "BaseGeometry", float, float]
"""Name, outline, lower and upper height [m]."""


class Solids:
    """Walls and obstacles as upright prisms, found fast by where they stand; walls are cut when one asks about them."""

    def __init__(self, world: World) -> None:
        from shapely import STRtree, box, polygons

        self._walls = world.walls
        self._pieces: dict[int, list[_Prism]] = {}
        # The tip of a corner stands out by less than the thickness.
        bounds = [_bounds(wall) for wall in world.walls]
        self._walls_tree = STRtree([box(*bound) for bound in bounds])
        self._things: list[_Prism] = []
        for number, obstacle in enumerate(world.obstacles):
            for outline, low, high in prisms(obstacle):
                self._things.append((called(obstacle, number), polygons(outline), low, high))
        self._things_tree = STRtree([outline for _, outline, _, _ in self._things])

    def reached(
        self, shape: "BaseGeometry", *, depth: float, low: float, high: float, but: Collection[str] = ()
    ) -> str | None:
        """Return the name of what a shape reaches into by more than a depth, between two heights [m].

        Args:
            shape: From above, world frame.
            depth: [m]
            low: [m]
            high: [m]
            but: Names of what does not count.
        """
        for name, outline, bottom, top in self._near(shape):
            if bottom < high and top > low and name not in but:
                inner = outline.buffer(-depth) if depth > 0 else outline
                if inner.intersects(shape):
                    return name
        return None

    def _near(self, shape: "BaseGeometry") -> Iterator["_Prism"]:
        from shapely import polygons

        for number in sorted(self._walls_tree.query(shape).tolist()):
            if number not in self._pieces:
                wall = self._walls[number]
                name = f"wall '{wall.name}'" if wall.name else f"walls[{number}]"
                self._pieces[number] = [(name, polygons(p.outline), p.low, p.high) for p in wall_pieces(wall)]
            yield from self._pieces[number]
        for number in sorted(self._things_tree.query(shape).tolist()):
            yield self._things[number]


def _bounds(wall: Wall) -> tuple[float, float, float, float]:
    (x, y), spare = zip(*wall.points, strict=True), wall.thickness
    return min(x) - spare, min(y) - spare, max(x) + spare, max(y) + spare


def called(obstacle: Obstacle, number: int) -> str:
    """Return how a sentence calls an obstacle, the number of which counts from 0."""
    return f"obstacle '{obstacle.name}'" if obstacle.name else f"obstacles[{number}]"


def pair(at: tuple[float, ...]) -> str:
    """Return a place as it is written in a world file."""
    return f"[{', '.join(f'{value:g}' for value in at)}]"
