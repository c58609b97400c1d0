"""Walls and obstacles as upright prisms, to ask what stands somewhere; and how doubts about a world are told."""

from collections.abc import Collection
from typing import TYPE_CHECKING

from mjsim.world.model import World
from mjsim.world.outlines import prisms
from mjsim.world.pieces import wall_pieces
from mjsim.world.things import Obstacle

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

Doubt = tuple[str, tuple[str | int, ...]]
"""A sentence, and the path of the value that it is about."""

SPARE = 1e-3
"""A beacon or a robot may reach this far into something [m]: coordinates are written to the millimetre."""


class Solids:
    """Walls and obstacles as upright prisms, found fast by where they stand."""

    def __init__(self, world: World) -> None:
        from shapely import STRtree, polygons

        pieces = [(number, piece) for number, wall in enumerate(world.walls) for piece in wall_pieces(wall)]
        words = [f"wall '{wall.name}'" if wall.name else f"walls[{number}]" for number, wall in enumerate(world.walls)]
        names = [words[number] for number, _ in pieces]
        outlines = list(polygons([piece.outline for _, piece in pieces])) if pieces else []
        self.low, self.high = [piece.low for _, piece in pieces], [piece.high for _, piece in pieces]
        for number, obstacle in enumerate(world.obstacles):
            for outline, low, high in prisms(obstacle):
                names.append(called(obstacle, number))
                outlines.append(polygons(outline))
                self.low.append(low)
                self.high.append(high)
        self.names, self.outlines, self.tree = names, outlines, STRtree(outlines)

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
        for index in sorted(self.tree.query(shape)):
            if self.low[index] < high and self.high[index] > low and self.names[int(index)] not in but:
                inner = self.outlines[index].buffer(-depth) if depth > 0 else self.outlines[index]
                if inner.intersects(shape):
                    return self.names[int(index)]
        return None


def called(obstacle: Obstacle, number: int) -> str:
    """Return how a sentence calls an obstacle, the number of which counts from 0."""
    return f"obstacle '{obstacle.name}'" if obstacle.name else f"obstacles[{number}]"


def pair(at: tuple[float, ...]) -> str:
    """Return a place as it is written in a world file."""
    return f"[{', '.join(f'{value:g}' for value in at)}]"
