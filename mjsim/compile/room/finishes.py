"""What furniture of one colour is made of in a style: wood, fabric or metal, in that colour."""

import colorsys
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from mjsim.compile.room.triangles import Triangles
from mjsim.compile.textures import MAX_TILE_SIDE, add_material
from mjsim.geometry import Array
from mjsim.models import bounded
from mjsim.world import World

Rgba = tuple[float, ...]

TILES = {"oak": 0.8, "wood": 0.8, "fabric": 0.5, "metal": 0.8}
"""Textures in assets/materials, and size of a tile [m]."""
WOOD_HUES = (0.03, 0.14)
"""Hues of wood, between red and yellow."""
LEAF_HUES = (0.17, 0.47)
"""Hues of leaves, which stay plain."""
MAX_GRAY_SATURATION, MAX_FABRIC_BRIGHTNESS = 0.2, 0.4
"""Saturation below which a colour is grey, and brightness below which it is fabric."""


@dataclass(frozen=True, slots=True)
class Finish:
    """A textured material in a colour."""

    name: str
    tint: Rgba
    """Multiplies the texture so that its mean is the colour, as far as possible."""


class Finishes:
    """Adds the materials of furniture to a scene as they are needed."""

    def __init__(self, spec: mujoco.MjSpec, world: World) -> None:
        """Keep the scene."""
        self._spec, self._world = spec, world
        self._means: dict[str, Array] = {}

    def of(self, rgba: Sequence[float]) -> Finish | None:
        """Return the finish of a colour; None for one that stays plain."""
        kind = _kind(*rgba[:3])
        if kind is None:
            return None
        if kind not in self._means:
            picture = bounded(self._world.read_picture(f"materials/{kind}.jpg"), MAX_TILE_SIDE)
            add_material(self._spec, f"style/{kind}", picture)
            self._means[kind] = picture.mean(axis=(0, 1)) / 255
        tint = np.minimum(np.array(rgba[:3]) / self._means[kind], 1.0)
        return Finish(f"style/{kind}", (*tint.round(3).tolist(), 1.0))


def covered(surface: Triangles, name: str) -> Triangles:
    """Return a surface with its corners placed on the texture of a finish, metric, from the six sides of a box."""
    x, y, z = surface.points.T
    nx, ny, nz = np.abs(surface.normals.T)
    level, endwise = (nz >= nx) & (nz >= ny), nx > ny
    right, down = np.where(level | ~endwise, x, y), np.where(level, -y, -z)
    tile = TILES[name.rpartition("/")[2]]
    return Triangles(surface.points, surface.normals, np.column_stack([right, down]) / tile, surface.corners)


def _kind(red: float, green: float, blue: float) -> str | None:
    hue, saturation, brightness = colorsys.rgb_to_hsv(red, green, blue)
    if saturation >= MAX_GRAY_SATURATION and WOOD_HUES[0] <= hue <= WOOD_HUES[1]:
        return "oak" if brightness > 0.65 else "wood"
    if brightness < MAX_FABRIC_BRIGHTNESS:
        return "fabric"
    if saturation >= MAX_GRAY_SATURATION and LEAF_HUES[0] <= hue <= LEAF_HUES[1]:
        return None
    return "metal"
