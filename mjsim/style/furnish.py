"""Furnishes a world in its style."""

import math
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING

from mjsim.geometry import Pose
from mjsim.style.atlas import PartAtlas
from mjsim.style.atlas_faces import Axes, Quad
from mjsim.style.hanging import Hanging, overlap
from mjsim.style.recipes import STYLES, RoomStyle, StyleName
from mjsim.style.sides import Side, WallOpening, free_stretches, sides_of
from mjsim.style.small_things import Things
from mjsim.style.window_frames import opening_faces
from mjsim.world import Hung, Leaf, World, hung, room_polygons

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

SKIRTING_HEIGHT, SKIRTING_DEPTH = 0.08, 0.012
"""Height and thickness of skirting boards [m]."""
HAZARD_HEIGHTS = (0.1, 0.22)
"""Heights of the striped band in warehouses [m]."""
DUCT_HEIGHTS = (0.86, 0.96)
"""Heights of cable ducts [m]."""
DUCT_SHARE, MIN_DUCT = 0.5, 1.2
"""Share of walls with a duct, and its least length [m]."""
PROBE_DISTANCE, BEYOND_ALL = 0.2, 1e6
"""Distance at which it is asked what is there, and beyond everything [m]."""
LEAF_GAP = 0.0015
"""Distance of the picture of a leaf from the leaf [m]."""


def wall_faces(world: World, name: StyleName, atlas: PartAtlas) -> Mapping[int, list[Quad]]:
    """Return what is on the walls of each room, by its number."""
    style, beyond = STYLES[name], _beyond(world)
    found: dict[int, list[Quad]] = {}
    counts: dict[int, Counter[str]] = defaultdict(Counter)
    for side in sides_of(world):
        hanging = Hanging(side, atlas, counts[side.room])
        faces = found.setdefault(side.room, [])
        faces += opening_faces(side, hanging, style, view=partial(_is_outside, side, beyond))
        faces += _bands(side, style, hanging)
        faces += hanging.fill(style.hung)
    return found


def thing_faces(world: World, name: StyleName, atlas: PartAtlas) -> Iterator[list[Quad]]:
    """Yield what is on each obstacle, in its frame."""
    things = Things(world, STYLES[name], list(atlas.parts))
    return (things.of(obstacle) for obstacle in world.obstacles)


def leaf_faces(leaf: Leaf, thickness: float, name: StyleName) -> list[Quad]:
    """Return the two sides of a door's leaf, in its frame."""
    out = thickness / 2 + LEAF_GAP
    one, other = Axes.facing(0.0, 0.0, 0.0, math.pi / 2), Axes.facing(0.0, 0.0, 0.0, -math.pi / 2)
    gap, part = 0.012, f"{STYLES[name].leaf}/1"
    up = (leaf.low + gap, leaf.high - gap)
    return [
        one.sheet((-leaf.width + gap, -gap), up, out, part),
        other.sheet((gap, leaf.width - gap), up, out, part),
    ]


def _beyond(world: World) -> "BaseGeometry":
    """Return where a window has no view: in other rooms, and everywhere if a beacon hangs outside of all rooms."""
    import shapely

    rooms = shapely.union_all(room_polygons(world.walls))
    outside = [
        item for item in hung(world) if item.fixed and not rooms.contains(shapely.Point(item.place.x, item.place.y))
    ]
    return (
        shapely.box(-BEYOND_ALL, -BEYOND_ALL, BEYOND_ALL, BEYOND_ALL)
        if any(not _at_wall(rooms, item) for item in outside)
        else rooms
    )


def _at_wall(rooms: "BaseGeometry", item: Hung) -> bool:
    """Return whether a beacon hangs on the inside of a wall, or in it."""
    import shapely

    front = item.place @ Pose(PROBE_DISTANCE, 0.0, 0.0)
    return bool(rooms.contains(shapely.Point(front.x, front.y)))


def _is_outside(side: Side, beyond: "BaseGeometry", hole: WallOpening) -> bool:
    """Return whether what is on the other side of a hole is no room."""
    import shapely

    point = side.frame.points(((hole.left + hole.right) / 2, -hole.thickness - PROBE_DISTANCE, 0.0))[0]
    return not beyond.contains(shapely.Point(point[:2]))


def _bands(side: Side, style: RoomStyle, hanging: Hanging) -> Iterator[Quad]:
    """Yield skirting boards, cable ducts and striped bands, which openings and beacons interrupt."""
    yield from _band(side, (0.0, SKIRTING_HEIGHT), SKIRTING_DEPTH, f"{style.skirting}/1", length=1.0)
    if style.hazard:
        yield from _band(side, HAZARD_HEIGHTS, 0.004, "hazard/1", length=0.96)
    if style.duct and hanging.rng.random() < DUCT_SHARE:
        for left, right in _free(side, DUCT_HEIGHTS):
            if right - left > MIN_DUCT:
                yield from hanging.run((left + 0.1, right - 0.1), DUCT_HEIGHTS, 0.04, "duct/1")


def _band(side: Side, up: tuple[float, float], out: float, part: str, *, length: float) -> Iterator[Quad]:
    for stretch in _free(side, up):
        yield from side.frame.band(stretch, up, out, part, length=length)


def _free(side: Side, up: tuple[float, float]) -> list[tuple[float, float]]:
    """Return the stretches of a side in which nothing interrupts a band at some heights; none above the wall."""
    if up[1] > side.height:
        return []
    holes = [(hole.left, hole.right) for hole in side.holes if hole.opening.sill < up[1] and hole.opening.head > up[0]]
    band = (0.0, side.length, *up)
    beacons = [beacon[:2] for beacon in side.beacons if overlap(band, beacon)]
    return free_stretches(side.length, [*holes, *beacons])
