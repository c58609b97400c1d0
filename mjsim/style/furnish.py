"""Furnishes a world in its style: frames of doorways and windows, the view through them, and things along walls."""

import math
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from mjsim.geometry import Pose
from mjsim.style.atlas import PartAtlas
from mjsim.style.atlas_faces import Axes, Quad, Range
from mjsim.style.recipes import STYLES, RoomStyle, StyleName, WallItem
from mjsim.style.sides import BEACON_MARGIN, Rectangle, Side, WallOpening, free_stretches, sides_of
from mjsim.style.small_things import Things
from mjsim.world import Hung, Leaf, World, hung, room_polygons

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry


MAX_TRIES = 6
"""Places that are tried for a thing."""
MIN_GAP = 0.12
"""Minimum distance between things, and from corners and frames [m]."""
FRAME_WIDTH = 0.07
"""Width of the frames of doors and windows [m]."""


class Hanging:
    """Fills a side with things, at random; the random numbers depend only on the position of the side."""

    def __init__(self, side: Side, atlas: PartAtlas, counts: Counter[str]) -> None:
        """Start with what occupies the side: openings, beacons and things that stand in front of it.

        Args:
            side: The side.
            atlas: The parts.
            counts: How many things of each kind the room has; changed.
        """
        self._side, self._atlas, self._counts = side, atlas, counts
        self.rng = np.random.default_rng(side.seed)
        frame = FRAME_WIDTH + MIN_GAP
        self._taken: list[Rectangle] = [*side.beacons, *side.things]
        for hole in side.holes:
            low, high = hole.opening.sill, hole.opening.head
            self._taken.append((hole.left - frame, hole.right + frame, low - frame, high + frame))

    def fill(self, hung: Sequence[WallItem]) -> Iterator[Quad]:
        """Yield things of all kinds, as many as fit and belong on a side of this length."""
        for thing in hung:
            count = int(self.rng.poisson(self._side.length / thing.every))
            for _ in range(min(count, thing.most) if self._side.length >= thing.least else 0):
                yield from self._hang(thing)

    def put(self, left: float, thing: WallItem) -> Iterator[Quad]:
        """Yield a thing at a place, unless something is there."""
        place = (left, left + thing.width, thing.low, thing.low + thing.height)
        if self._counts[thing.kind] < thing.most and self._free(place):
            self._taken.append(place)
            self._counts[thing.kind] += 1
            part = self.one_of(thing.kind)
            yield from self._side.frame.block(place[:2], (0.0, thing.depth), place[2:], part, thing.side)

    def run(self, across: Range, up: Range, depth: float, part: str) -> Iterator[Quad]:
        """Yield a band along the wall, unless something is there."""
        if self._free((*across, *up)):
            self._taken.append((*across, *up))
            yield from self._side.frame.band(across, up, depth, part, length=1.0)

    def one_of(self, kind: str) -> str:
        """Return a random variant of a kind."""
        variants = [name for name in self._atlas.parts if name.partition("/")[0] == kind]
        return variants[self.rng.integers(len(variants))]

    def _hang(self, thing: WallItem) -> Iterator[Quad]:
        room = self._side.length - thing.width - 2 * MIN_GAP
        if room < 0.0 or thing.low + thing.height > self._side.height:
            return
        for left in self.rng.uniform(MIN_GAP, MIN_GAP + room, MAX_TRIES).tolist():
            faces = list(self.put(left, thing))
            if faces:
                yield from faces
                return

    def _free(self, place: Rectangle) -> bool:
        left, right, low, high = place
        inside = left >= 0.0 and right <= self._side.length and high <= self._side.height
        return inside and not any(
            overlap((left - MIN_GAP / 2, right + MIN_GAP / 2, low, high), other) for other in self._taken
        )


def overlap(one: Rectangle, other: Rectangle) -> bool:
    """Return whether two rectangles of a side overlap."""
    return one[0] < other[1] and other[0] < one[1] and one[2] < other[3] and other[2] < one[3]


SKIRTING_HEIGHT, SKIRTING_DEPTH = 0.08, 0.012
"""Height and thickness of skirting boards [m]."""
HAZARD_HEIGHTS = (0.1, 0.22)
"""Heights of the striped band in warehouses [m]."""
DUCT_HEIGHTS = (0.86, 0.96)
"""Heights of cable ducts [m]."""
DUCT_SHARE, MIN_DUCT = 0.5, 1.2
"""Share of walls with a duct, and its least length [m]."""
PROBE_DISTANCE, BEYOND_ALL = 0.2, 1e6
"""Distance from a wall at which the space is probed, and a distance beyond everything [m]."""
LEAF_GAP = 0.0015
"""Distance of the picture of a leaf from the leaf [m]."""


def wall_faces(world: World, name: StyleName, atlas: PartAtlas) -> Mapping[int, list[Quad]]:
    """Return the faces on the walls of each room, by its number."""
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
    """Yield the faces on each obstacle, in its frame."""
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
    """Return where windows show no view: in rooms, or everywhere if a beacon hangs outside of all rooms."""
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
    """Return whether the other side of a hole is outside of all rooms."""
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
    """Return the stretches of a side in which nothing interrupts a band between two heights; none above the wall."""
    if up[1] > side.height:
        return []
    holes = [(hole.left, hole.right) for hole in side.holes if hole.opening.sill < up[1] and hole.opening.head > up[0]]
    band = (0.0, side.length, *up)
    beacons = [beacon[:2] for beacon in side.beacons if overlap(band, beacon)]
    return free_stretches(side.length, [*holes, *beacons])


FRAME_THICKNESS = 0.012
"""Thickness of a frame on the wall [m]."""
BAR_WIDTH = 0.05
"""Width of the bars of a window [m]."""
COVERED_SHARE = 0.3
"""Share of a window that blinds or curtains cover."""
RADIATOR = WallItem("radiator", 1.0, 0.55, 0.14, 1.0, 0.06, "white", 99)
MIN_SILL = 0.75
"""Lowest sill above a radiator [m]."""
SWITCH = WallItem("switch", 0.08, 0.08, 1.05, 1.0, 0.01, "white", 99)
SIGN = WallItem("door_sign", 0.21, 0.15, 1.45, 1.0, 0.008, "gray", 99)
EXIT = WallItem("exit", 0.4, 0.18, 2.2, 1.0, 0.03, "green", 99)


def opening_faces(
    side: Side, hanging: Hanging, style: RoomStyle, *, view: Callable[[WallOpening], bool]
) -> Iterator[Quad]:
    """Yield frames, windows, and what belongs beside doors, on one side.

    Args:
        side: The side.
        hanging: Its things.
        style: The style.
        view: Whether a window shows the view, because no room is behind it.
    """
    for hole in side.holes:
        if hole.opening.sill >= side.height:
            continue
        yield from _casing(side, hole, style.frame)
        if hole.opening.sill > 0.0:
            if view(hole):
                yield from _window(side, hole, hanging, style)
            if hole.opening.sill >= MIN_SILL:
                yield from hanging.put((hole.left + hole.right - RADIATOR.width) / 2, RADIATOR)
        else:
            yield from hanging.put(hole.right + FRAME_WIDTH + 0.1, SWITCH)
            yield from hanging.put(hole.left - FRAME_WIDTH - 0.12 - SIGN.width, SIGN)
            if side.length > 6.0:
                yield from hanging.put((hole.left + hole.right - EXIT.width) / 2, EXIT)


def _casing(side: Side, hole: WallOpening, part: str) -> Iterator[Quad]:
    """Yield the bars around an opening; a bar that would touch a beacon or its margin is left out."""
    low, high = hole.opening.sill, min(hole.opening.head, side.height)
    bars: list[Rectangle] = [
        (hole.left - FRAME_WIDTH, hole.left, low, high + FRAME_WIDTH),
        (hole.right, hole.right + FRAME_WIDTH, low, high + FRAME_WIDTH),
        (hole.left, hole.right, high, high + FRAME_WIDTH),
    ]
    if low > 0.0:
        bars.append((hole.left - FRAME_WIDTH, hole.right + FRAME_WIDTH, low - 0.04, low))
    for bar in bars:
        within = bar[0] >= 0.0 and bar[1] <= side.length and bar[3] <= side.height
        if within and not any(overlap(bar, _bare(beacon)) for beacon in side.beacons):
            proud = FRAME_THICKNESS if bar[2] >= low else 4 * FRAME_THICKNESS
            yield from side.frame.block(bar[:2], (0.0, proud), bar[2:], part, part)


def _bare(beacon: Rectangle) -> Rectangle:
    """Return the rectangle of a beacon with a narrow margin: a door's frame is plain, and cannot be moved."""
    less = BEACON_MARGIN - 2 * FRAME_THICKNESS
    return beacon[0] + less, beacon[1] - less, beacon[2] + less, beacon[3] - less


def _window(side: Side, hole: WallOpening, hanging: Hanging, style: RoomStyle) -> Iterator[Quad]:
    """Yield the bars, the view and the cover of a window, within the thickness of its wall."""
    frame, back = side.frame, -0.7 * hole.thickness
    left, right, low, high = hole.left, hole.right, hole.opening.sill, min(hole.opening.head, side.height)
    middle, width = (left + right) / 2, right - left
    view = hanging.one_of(style.view)
    yield frame.sheet((left, right), (low, high), back - 0.01, view)
    for across in (
        (left, left + BAR_WIDTH),
        (middle - BAR_WIDTH / 2, middle + BAR_WIDTH / 2),
        (right - BAR_WIDTH, right),
    ):
        yield from frame.block(across, (back - 0.01, back + 0.03), (low, high), "white", "gray")
    for up in ((low, low + BAR_WIDTH), (high - BAR_WIDTH, high)):
        yield from frame.block((left, right), (back - 0.01, back + 0.03), up, "white", "gray")
    if style.cover == "blinds":
        share = COVERED_SHARE * hanging.rng.uniform(0.3, 2.0)
        yield frame.sheet((left, right), (high - share * (high - low), high), back + 0.05, "blinds/1")
    else:
        for across in ((left, left + COVERED_SHARE / 2 * width), (right - COVERED_SHARE / 2 * width, right)):
            yield frame.sheet(across, (low, high), -0.01, "curtain/1")
