"""Light sources of a world: lamps as small areas, windows as areas of the sky, the ceiling or the sky itself."""

import math
from collections.abc import Callable, Sequence

import numpy as np

from mjsim.geometry import Array
from mjsim.light.baked import linear
from mjsim.light.light_rays import Points, Rectangle, Room, hemisphere, starts_of
from mjsim.world import Lamp, World, room_polygons

LAMP_SIDE = 0.2
"""Side of a lamp, a level square that shines downwards [m]."""
FULL_AT = 2.0
"""Distance below a lamp of brightness 1 at which its light is full light [m]."""
SKY_RADIANCE = 1.0 / math.pi
"""Radiance of the sky: a level surface that sees all of it is in full light."""
DAYLIGHT_RATIO = 2.0
"""Radiance of windows relative to that of the sky without a ceiling: days are brighter than rooms."""
SKY_SHARE_LIMIT = 0.1
"""Minimum share of rays that reach the sky from the outer side of a window, and maximum from the inner."""
VIEW_DEPTH = 0.5
"""Maximum distance behind a window of the surfaces that it shows [m]."""
RAYS_PER_SIDE, PROBE_DISTANCE = 16, 0.5
"""Rays per side of a hemisphere that tell outside from inside, and distance from the wall at which they begin [m]."""


def lamp_rectangle(lamp: Lamp) -> Rectangle:
    """Return a lamp whose light at 2 m below it is full light."""
    half, middle = LAMP_SIDE / 2, np.array([*lamp.at, lamp.height])
    # Arvo's formula in closed form, for a point on the axis of a square.
    edge = math.hypot(half, FULL_AT)
    light = 4.0 * half / edge * math.atan(half / edge)
    return Rectangle(middle, np.array([half, 0.0, 0.0]), np.array([0.0, -half, 0.0]), 1.0 / light)


def lamp_color(color: str) -> Array:
    """Return the linear light of a lamp's colour '#rrggbb', shape (3,)."""
    return linear(np.array([int(color[i : i + 2], 16) / 255 for i in (1, 3, 5)]))


def window_rectangles(world: World, room: Room) -> list[Rectangle]:
    """Return the openings between inside and outside, which shine inwards, of a world with a ceiling."""
    if world.ceiling is None:
        return []
    return _lit_inwards(_openings(world), room)


def _openings(world: World) -> list[Rectangle]:
    """Return the openings of all walls, in the middle of the wall, facing to its right."""
    found = []
    for wall in world.walls:
        for opening in wall.openings:
            first, last = (np.array([*end, 0.0]) for end in wall.segments()[opening.segment])
            length = float(np.linalg.norm(last - first))
            begin, end = min(opening.at, length), min(opening.at + opening.width, length)
            high = min(opening.head, wall.height)
            if end - begin > 1e-3 and high - opening.sill > 1e-3:
                along = (last - first) / length
                middle = first + along * (begin + end) / 2 + [0.0, 0.0, (high + opening.sill) / 2]
                up = np.array([0.0, 0.0, (high - opening.sill) / 2])
                found.append(Rectangle(middle, along * (end - begin) / 2, up, DAYLIGHT_RATIO * SKY_RADIANCE))
    return found


def _lit_inwards(openings: Sequence[Rectangle], room: Room) -> list[Rectangle]:
    """Return the openings with the sky on one side only, facing away from it."""
    if not openings:
        return []
    outward = np.array([each.outward for each in openings])
    middle = np.array([each.middle for each in openings])
    right, left = (sky_share(room, middle + PROBE_DISTANCE * side, side) for side in (outward, -outward))
    found = []
    for opening, to_right, to_left in zip(openings, right.tolist(), left.tolist(), strict=True):
        if max(to_right, to_left) > SKY_SHARE_LIMIT > min(to_right, to_left):
            across = opening.across if to_right < to_left else -opening.across
            found.append(Rectangle(opening.middle, across, opening.along, opening.radiance))
    return found


def behind(window: Rectangle, at: Points) -> Array:
    """Return whether points lie in the opening of a window, beyond its plane, and face inwards, shape (n,)."""
    to = at.points - window.middle
    depth = -(to @ window.outward)
    inside = (depth > 0.0) & (depth < VIEW_DEPTH) & (at.normals @ window.outward > 0.9)
    for side in (window.across, window.along):
        inside &= np.abs(to @ side) <= side @ side + 1e-6
    return np.asarray(inside)


def sky_share(room: Room, points: Array, normals: Array) -> Array:
    """Return the share of light on points that comes from the sky, upwards, shape (n,)."""
    at = Points(np.arange(len(points)), points, normals)
    starts = starts_of(at)
    free = [(room.first(starts, each)[0] < 0) & (each[:, 2] > 0.0) for each in hemisphere(at, RAYS_PER_SIDE)]
    return np.asarray(np.mean(free, axis=0), dtype=float)


def inside_of(world: World) -> Callable[[Array], Array]:
    """Return a function that tells whether points, shape (n, 2) [m], are inside a room; without rooms, all are."""
    import shapely

    rooms = shapely.union_all(room_polygons(world.walls))
    if rooms.is_empty:
        return lambda points: np.ones(len(points), dtype=bool)
    shapely.prepare(rooms)
    return lambda points: np.asarray(shapely.contains_xy(rooms, points[:, 0], points[:, 1]))
