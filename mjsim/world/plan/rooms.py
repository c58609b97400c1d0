"""Rooms: the parts of the plane that walls enclose once all their openings are closed."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.world.items import Wall
from mjsim.world.plan.wall_corners import solid_pieces

if TYPE_CHECKING:
    from shapely import Polygon

GRID = 1e-6
"""Points closer than this coincide [m]."""
MIN_AREA = 0.5
"""Smaller gaps between walls are not rooms [m^2]."""


def room_polygons(walls: Sequence[Wall]) -> "list[Polygon]":
    """Return the rooms up to the faces of their walls, world frame [m], from west to east and south to north."""
    import shapely

    closed = [wall.model_copy(update={"openings": ()}) for wall in walls]
    outlines = [piece.outline for wall in solid_pieces(closed) for piece in wall]
    if not outlines:
        return []
    solid = shapely.union_all(shapely.polygons(np.array(outlines)), grid_size=GRID)
    holes = [ring for part in shapely.get_parts(solid) for ring in shapely.get_rings(part)[1:]]
    inside = shapely.difference(shapely.union_all(shapely.polygons(np.array(holes, dtype=object))), solid)
    rooms = [part for part in shapely.get_parts(inside) if part.area >= MIN_AREA]
    return sorted(rooms, key=lambda room: room.bounds)


def rooms_at(walls: Sequence[Wall], points: Array) -> NDArray[np.intp]:
    """Return the number of the room of each point, -1 for none; points have shape (n, 2) [m]."""
    import shapely

    found = np.full(len(points), -1, dtype=np.intp)
    point, room = shapely.STRtree(room_polygons(walls)).query(shapely.points(points), predicate="within")
    found[point] = room
    return found
