"""What stands in a world as upright prisms, to ask what is somewhere; and how doubts about a world are told."""

from collections.abc import Collection, Iterator

import numpy as np

from mjsim.geometry import Array
from mjsim.world.items import Obstacle, Wall, World
from mjsim.world.plan import prisms, wall_pieces

Doubt = tuple[str, tuple[str | int, ...]]
"""A sentence, and the path of the value that it is about."""

SPARE = 1e-3
"""A beacon or a robot may reach this far into something [m]: coordinates are written to the millimetre."""


ROUNDING = 1e-9
"""Computed outlines may be off by so much [m]."""
_Prism = tuple[str, Array, float, float]
"""Name, convex outline, counter-clockwise, shape (n, 2) [m], lower and upper height [m]."""


class Solids:
    """Walls, obstacles and people as upright prisms, found fast by where they stand.

    Walls are cut when one asks about them.
    """

    def __init__(self, world: World) -> None:
        self._walls = world.walls
        self._pieces: dict[int, list[_Prism]] = {}
        self._things: list[_Prism] = [
            (called(obstacle, number), outline, low, high)
            for number, obstacle in enumerate(world.obstacles)
            for outline, low, high in prisms(obstacle)
        ]
        self._things += [
            (f"person '{person.name}'", *prism) for person in world.people for prism in person.prisms.values()
        ]
        self._wall_boxes = np.array([_bounds(wall) for wall in world.walls]).reshape(-1, 4)
        self._thing_boxes = np.array([_box(outline) for _, outline, _, _ in self._things]).reshape(-1, 4)

    def reached(self, shape: Array, *, depth: float, low: float, high: float, but: Collection[str] = ()) -> str | None:
        """Return the name of what a shape reaches into by more than a depth, between two heights [m].

        Args:
            shape: Points whose convex hull is the shape from above, world frame, shape (n, 2) [m].
            depth: [m]
            low: [m]
            high: [m]
            but: Names of what does not count.
        """
        for name, outline, bottom, top in self._near(shape):
            if bottom < high and top > low and name not in but and _meet(outline, shape, depth):
                return name
        return None

    def _near(self, shape: Array) -> Iterator["_Prism"]:
        box = _box(shape)
        for number in _overlapping(self._wall_boxes, box):
            if number not in self._pieces:
                wall = self._walls[number]
                name = f"wall '{wall.name}'" if wall.name else f"walls[{number}]"
                self._pieces[number] = [(name, p.outline, p.low, p.high) for p in wall_pieces(wall)]
            yield from self._pieces[number]
        for number in _overlapping(self._thing_boxes, box):
            yield self._things[number]


def disc(at: tuple[float, ...], radius: float, *, sides: int = 128) -> Array:
    """Return points around a disc, shape (sides, 2) [m]."""
    angles = np.linspace(0.0, 2 * np.pi, sides, endpoint=False)
    return np.asarray(at + radius * np.stack([np.cos(angles), np.sin(angles)], axis=-1))


def _meet(outline: Array, shape: Array, depth: float) -> bool:
    """Return whether the hull of a shape comes deeper than so much [m] into a convex outline."""
    # Nearly always a side of the outline parts them, which is seen at once and without loading shapely.
    sides = np.roll(outline, -1, axis=0) - outline
    ahead = shape[:, None, :] - outline
    inside = sides[:, 0] * ahead[..., 1] - sides[:, 1] * ahead[..., 0]
    if (inside.max(axis=0) < (depth - ROUNDING) * np.hypot(*sides.T)).any():
        return False
    from shapely import MultiPoint, polygons

    inner = polygons(outline).buffer(-depth) if depth > 0 else polygons(outline)
    return bool(inner.intersects(MultiPoint(shape).convex_hull))


def _overlapping(boxes: Array, box: Array) -> list[int]:
    """Return the numbers of the boxes, (west, south, east, north), that another one meets."""
    meets = (boxes[:, :2] <= box[2:]).all(axis=1) & (boxes[:, 2:] >= box[:2]).all(axis=1)
    numbers: list[int] = np.flatnonzero(meets).tolist()
    return numbers


def _box(points: Array) -> Array:
    return np.concatenate([points.min(axis=0), points.max(axis=0)])


def _bounds(wall: Wall) -> tuple[float, float, float, float]:
    # The tip of a corner stands out by less than the thickness.
    (x, y), spare = zip(*wall.points, strict=True), wall.thickness
    return min(x) - spare, min(y) - spare, max(x) + spare, max(y) + spare


def called(obstacle: Obstacle, number: int) -> str:
    """Return how a sentence calls an obstacle, the number of which counts from 0."""
    return f"obstacle '{obstacle.name}'" if obstacle.name else f"obstacles[{number}]"


def pair(at: tuple[float, ...]) -> str:
    """Return a place as it is written in a world file."""
    return f"[{', '.join(f'{value:g}' for value in at)}]"
