"""Lamps in the ceilings of rooms."""

import math
from collections.abc import Mapping

from shapely import box

from mjsim.style.atlas_faces import Axes, Quad
from mjsim.style.recipes import STYLES, StyleName
from mjsim.world import World, room_polygons

LAMP_GAP = 0.01
"""Distance of a lamp's lower side from the ceiling [m]."""
MAX_LAMPS = 1000
"""Approximate limit of lamps in a room; in larger rooms they are farther apart."""


def ceiling_lamps(world: World, name: StyleName, height: float) -> Mapping[int, list[Quad]]:
    """Return the lamps of each room, by its number, under a ceiling of a height [m]."""
    side, apart = STYLES[name].lamp
    found: dict[int, list[Quad]] = {}
    for number, room in enumerate(room_polygons(world.walls)):
        west, south, east, north = room.bounds
        pitch = apart * max(math.ceil(math.sqrt((east - west) * (north - south) / MAX_LAMPS) / apart), 1)
        for x in _grid(west, east, side, pitch):
            for y in _grid(south, north, side, pitch):
                if room.contains(box(x, y, x + side, y + side)):
                    found.setdefault(number, []).extend(_lamp(x, y, height, side))
    return found


def _grid(first: float, last: float, side: float, apart: float) -> list[float]:
    """Return the starts of lamps along a room, aligned to panels from the origin and centred in the room [m]."""
    count = max(int((last - first - side) // apart), 0)
    begin = round(((first + last - count * apart - side) / 2) / side) * side
    return [begin + k * apart for k in range(count + 1)]


def _lamp(x: float, y: float, height: float, side: float) -> list[Quad]:
    """Return the lower side and the rim of a lamp."""
    frame = Axes.facing(x, y + side / 2, height, 0.0)
    across, deep = (-side / 2, side / 2), (0.0, side)
    _, *rim = list(frame.block(across, deep, (-LAMP_GAP, 0.0), "gray", "gray"))[:3]
    return [*rim, frame.lying(across, deep, -LAMP_GAP, "lamp/1", below=True)]
