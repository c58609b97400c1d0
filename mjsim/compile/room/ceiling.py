"""The ceiling: a face visible only from below, so that views from above see into the rooms."""

import mujoco
import numpy as np

from mjsim.compile.room.prisms import Face
from mjsim.compile.room.walls import WallBox, add_mesh_geom
from mjsim.compile.textures import MAX_TILE_SIDE, add_material, color_of, tint_of
from mjsim.geometry import Array
from mjsim.models import bounded
from mjsim.style import SURFACES
from mjsim.world import Ceiling, World


def add_ceiling(spec: mujoco.MjSpec, world: World, walls: list[WallBox], lower: Array, upper: Array) -> None:
    """Add the ceiling over the world; it is visible from below and collides with nothing."""
    ceiling = _styled(world)
    if ceiling is None:
        return
    height = ceiling_height(ceiling, walls, float(upper[2]))
    (x0, y0), (x1, y1) = lower[:2], upper[:2]
    corners = np.array([(x0, y0, height), (x0, y1, height), (x1, y1, height), (x1, y0, height)])
    triangles = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32)
    textured = ceiling.texture is not None
    geom = add_mesh_geom(
        spec,
        "ceiling",
        [Face(corners, triangles, np.array([0.0, 0.0, -1.0]), 0)],
        tile=ceiling.tile if textured else 1.0,
    )
    geom.material, geom.rgba = "matte", color_of(ceiling.color)
    if ceiling.texture is not None:
        add_material(spec, "ceiling", bounded(world.read_picture(ceiling.texture), MAX_TILE_SIDE))
        geom.material, geom.rgba = "ceiling", color_of(tint_of(ceiling))


def _styled(world: World) -> Ceiling | None:
    """Return the ceiling of a world; one without a texture has that of the world's style."""
    if world.ceiling is None or world.ceiling.texture is not None or world.style == "plain":
        return world.ceiling
    texture, tile = SURFACES[world.style].ceiling
    return world.ceiling.model_copy(update={"texture": texture, "tile": tile})


def ceiling_height(ceiling: Ceiling, walls: list[WallBox], top: float) -> float:
    """Return the height of a ceiling: its own, that of the highest wall, or without walls of the highest object [m]."""
    if ceiling.height is not None:
        return ceiling.height
    return max((float(wall.center[2] + wall.half[2]) for wall in walls), default=top)
