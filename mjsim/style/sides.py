"""Sides of rooms: stretches of wall seen from inside, with the things that take up space on them."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from mjsim.geometry import Array
from mjsim.style.atlas_faces import Axes
from mjsim.world import Opening, World, footprint, hung, room_polygons, solid_pieces, stays, top

if TYPE_CHECKING:
    from shapely import Polygon

WALL_TOLERANCE = 0.01
"""Distance within which a face is that of a wall [m]."""
MAX_ANGLE_SINE = 0.02
"""Sine of the largest angle between a side and the wall of its openings."""
STANDING_DISTANCE = 0.45
"""Distance from a wall within which things stand before it [m]."""
BEACON_MARGIN = 0.3
"""Distance of small things from a beacon, so that its surroundings stay the same for detectors [m]."""
MIN_STRETCH = 0.15
"""Shorter stretches of wall stay bare [m]."""
HANGING_DISTANCE = 0.3
"""Distance from a wall within which a beacon hangs on it [m]."""
MAX_BEACON_RATIO = 1.0
"""Largest half height of a beacon, as a multiple of its width."""

Rectangle = tuple[float, float, float, float]
"""Left, right, low, high on a side [m]."""


@dataclass(frozen=True, slots=True)
class WallOpening:
    """An opening of a wall, on one side of it."""

    opening: Opening
    left: float
    """[m]"""
    right: float
    """[m]"""
    thickness: float
    """Thickness of the wall [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Side:
    """A straight stretch of wall, seen from a room."""

    frame: Axes
    """Its origin is at the left end of the stretch, on the floor."""
    length: float
    """[m]"""
    height: float
    """[m]"""
    room: int
    holes: tuple[WallOpening, ...]
    beacons: tuple[Rectangle, ...]
    """Beacons with a margin, which stays free."""
    things: tuple[Rectangle, ...]
    """Things in front of the wall."""
    seed: list[int] = field(default_factory=list)
    """Seed of random choices on it; depends only on its position."""


def sides_of(world: World) -> list[Side]:
    """Return the sides of all rooms of a world, room by room."""
    walls = _Walls(world)
    return [
        walls.side(start, end, number)
        for number, room in enumerate(room_polygons(world.walls))
        for start, end in _edges(room)
        if np.hypot(*(end - start)) >= MIN_STRETCH
    ]


def _edges(room: "Polygon") -> list[tuple[Array, Array]]:
    """Return the straight edges of a room, its inside to their left, in an order that depends only on position."""
    import shapely

    found: list[tuple[Array, Array]] = []
    for ring in shapely.get_rings(shapely.orient_polygons(room.simplify(1e-4))):
        found += itertools.pairwise(shapely.get_coordinates(ring))
    return sorted(found, key=lambda edge: np.round(np.concatenate(edge), 3).tolist())


class _Walls:
    """Things on the walls of a world, and in front of them."""

    def __init__(self, world: World) -> None:
        import shapely

        self._holes = [
            (wall.thickness, opening, np.array(wall.segments()[opening.segment]))
            for wall in world.walls
            for opening in wall.openings
        ]
        closed = [wall.model_copy(update={"openings": ()}) for wall in world.walls]
        pieces = [piece for wall in solid_pieces(closed) for piece in wall]
        self._tree = shapely.STRtree([shapely.Polygon(piece.outline) for piece in pieces])
        self._heights = np.array([piece.high for piece in pieces])
        self._beacons = [item for item in hung(world) if item.fixed]
        things = [item for item in world.obstacles if stays(item)]
        outlines = [footprint(item) for item in things]
        self._outlines = np.concatenate([np.zeros((0, 2)), *outlines])
        self._first = np.cumsum([0, *(len(outline) for outline in outlines)])[:-1]
        self._levels = np.array([(item.elevation, top(item)) for item in things]).reshape(-1, 2)

    def side(self, start: Array, end: Array, room: int) -> Side:
        """Return the side along an edge of a room, whose inside is to the left of the way from start to end."""
        import shapely

        length = float(np.hypot(*(end - start)))
        along = (end - start) / length
        right, out = np.array([*-along, 0.0]), np.array([-along[1], along[0], 0.0])
        frame = Axes(np.array([*end, 0.0]), right, out)
        behind = shapely.Point((start + end) / 2 - out[:2] * WALL_TOLERANCE)
        walls = self._tree.query(behind, predicate="within")
        height = float(self._heights[walls].max()) if len(walls) else 0.0
        holes = tuple(hole for each in self._holes if (hole := _hole(frame, length, *each)) is not None)
        beacons, things = tuple(self._hung(frame)), tuple(self._standing(frame, length))
        seed = np.round(np.concatenate([start, end]) * 100).astype(int).tolist()
        return Side(
            frame, length, height, room, holes, beacons, things, [abs(value) * 2 + (value < 0) for value in seed]
        )

    def _hung(self, frame: Axes) -> list[Rectangle]:
        """Return the rectangles of beacons at the wall, with their margin."""
        found = []
        for item in self._beacons:
            across, away = _seen(frame, np.array([item.place.x, item.place.y]))
            if -HANGING_DISTANCE < away < HANGING_DISTANCE + item.beacon.width:
                half, tall = item.beacon.width / 2 + BEACON_MARGIN, item.beacon.width * MAX_BEACON_RATIO + BEACON_MARGIN
                found.append((across - half, across + half, item.center - tall, item.center + tall))
        return found

    def _standing(self, frame: Axes, length: float) -> list[Rectangle]:
        """Return the rectangles of things that stand before the wall."""
        if not len(self._first):
            return []
        offsets = self._outlines - frame.origin[:2]
        across, away = offsets @ frame.right[:2], offsets @ frame.out[:2]
        left, right = (ufunc.reduceat(across, self._first) for ufunc in (np.minimum, np.maximum))
        near = (np.minimum.reduceat(away, self._first) < STANDING_DISTANCE) & (
            np.maximum.reduceat(away, self._first) > 0.0
        )
        chosen = near & (right > 0.0) & (left < length)
        return [tuple(row) for row in np.column_stack([left, right, self._levels])[chosen].tolist()]


def _seen(frame: Axes, point: Array) -> tuple[float, float]:
    """Return a point of the plan as coordinates of a frame: right, and out [m]."""
    offset = point - frame.origin[:2]
    return float(offset @ frame.right[:2]), float(offset @ frame.out[:2])


def _hole(frame: Axes, length: float, thickness: float, opening: Opening, segment: Array) -> WallOpening | None:
    """Return an opening as a hole of a side; None where it is in another wall."""
    first, last = segment
    span = float(np.hypot(*(last - first)))
    along = (last - first) / span
    if abs(float(along @ frame.out[:2])) > MAX_ANGLE_SINE:
        return None
    ends = [_seen(frame, first + along * min(at, span)) for at in (opening.at, opening.at + opening.width)]
    left, right = sorted(end[0] for end in ends)
    if abs(ends[0][1] + thickness / 2) > WALL_TOLERANCE or right < WALL_TOLERANCE or left > length - WALL_TOLERANCE:
        return None
    return WallOpening(opening, max(left, 0.0), min(right, length), thickness)


def free_stretches(length: float, blocked: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return the parts of [0, length] outside of intervals [m]."""
    found, free = [], 0.0
    for left, right in sorted(blocked):
        if left > free:
            found.append((free, min(left, length)))
        free = max(free, right)
    if free < length:
        found.append((free, length))
    return [(left, right) for left, right in found if right - left > WALL_TOLERANCE]
