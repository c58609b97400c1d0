"""Objects of a world as upright prisms, for overlap queries; and the wording of problems."""

from collections.abc import Collection, Iterator

import numpy as np

from mjsim.geometry import Array
from mjsim.sentences import Sentence
from mjsim.world.items import Obstacle, Wall, World
from mjsim.world.plan import prisms, wall_pieces

Finding = tuple[str, tuple[str | int, ...]]
"""A message, and the path of the value to which it refers."""

MAX_OVERLAP = 1e-3
"""Allowed overlap of a beacon or a robot with something [m]: coordinates are written to the millimetre."""


OUTLINE_TOLERANCE = 1e-9
"""Tolerance for computed outlines [m]."""
_Prism = tuple[str, Array, float, float]
"""Name, convex outline, counter-clockwise, shape (n, 2) [m], lower and upper height [m]."""


class Solids:
    """Walls, obstacles and people as upright prisms, with fast lookup by position.

    The prisms of walls are computed at the first query.
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
            (Sentence("person '{name}'", person.name), *prism)
            for person in world.people
            for prism in person.prisms.values()
        ]
        self._wall_boxes = np.array([_bounds(wall) for wall in world.walls]).reshape(-1, 4)
        self._thing_boxes = np.array([_box(outline) for _, outline, _, _ in self._things]).reshape(-1, 4)

    def reached(self, shape: Array, *, depth: float, low: float, high: float, but: Collection[str] = ()) -> str | None:
        """Return the name of an object that a shape overlaps by more than a depth between two heights, or None.

        Args:
            shape: Points whose convex hull is the shape from above, world frame, shape (n, 2) [m].
            depth: Overlap above which an object counts [m].
            low: Lower height of the shape [m].
            high: Upper height of the shape [m].
            but: Names of objects to ignore.
        """
        for name, outline, bottom, top in self._candidates(shape):
            if bottom < high and top > low and name not in but and _meet(outline, shape, depth):
                return name
        return None

    def _candidates(self, shape: Array) -> Iterator["_Prism"]:
        box = _box(shape)
        for number in _overlapping(self._wall_boxes, box):
            if number not in self._pieces:
                wall = self._walls[number]
                name = Sentence("wall '{name}'", wall.name) if wall.name else f"walls[{number}]"
                self._pieces[number] = [(name, p.outline, p.low, p.high) for p in wall_pieces(wall)]
            yield from self._pieces[number]
        for number in _overlapping(self._thing_boxes, box):
            yield self._things[number]


def disc(at: tuple[float, ...], radius: float, *, sides: int = 128) -> Array:
    """Return points around a disc, shape (sides, 2) [m]."""
    angles = np.linspace(0.0, 2 * np.pi, sides, endpoint=False)
    return np.asarray(at + radius * np.stack([np.cos(angles), np.sin(angles)], axis=-1))


def _meet(outline: Array, shape: Array, depth: float) -> bool:
    """Return whether the convex hull of a shape overlaps a convex outline by more than a depth [m]."""
    # Nearly always a side of the outline separates them; this is found fast and without loading shapely.
    sides = np.roll(outline, -1, axis=0) - outline
    ahead = shape[:, None, :] - outline
    inside = sides[:, 0] * ahead[..., 1] - sides[:, 1] * ahead[..., 0]
    if (inside.max(axis=0) < (depth - OUTLINE_TOLERANCE) * np.hypot(*sides.T)).any():
        return False
    from shapely import MultiPoint, polygons

    inner = polygons(outline).buffer(-depth) if depth > 0 else polygons(outline)
    return bool(inner.intersects(MultiPoint(shape).convex_hull))


def _overlapping(boxes: Array, box: Array) -> list[int]:
    """Return the indices of the boxes, (west, south, east, north), that another box overlaps."""
    meets = (boxes[:, :2] <= box[2:]).all(axis=1) & (boxes[:, 2:] >= box[:2]).all(axis=1)
    numbers: list[int] = np.flatnonzero(meets).tolist()
    return numbers


def _box(points: Array) -> Array:
    return np.concatenate([points.min(axis=0), points.max(axis=0)])


def _bounds(wall: Wall) -> tuple[float, float, float, float]:
    # The tip of a corner extends by less than the thickness.
    (x, y), spare = zip(*wall.points, strict=True), wall.thickness
    return min(x) - spare, min(y) - spare, max(x) + spare, max(y) + spare


def called(obstacle: Obstacle, number: int) -> str:
    """Return the name of an obstacle in messages; the number counts from 0."""
    return Sentence("obstacle '{name}'", obstacle.name) if obstacle.name else f"obstacles[{number}]"


def pair(at: tuple[float, ...]) -> str:
    """Return a position as written in a world file."""
    return f"[{', '.join(f'{value:g}' for value in at)}]"
