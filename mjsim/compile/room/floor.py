"""The floor, and its patches with other friction."""

import math

import mujoco
import numpy as np

from mjsim.compile.room.walls import COLLISION, PLANE_SPACING, VISUAL
from mjsim.compile.textures import MAX_TILE_SIDE, add_material, color_of, tint_of
from mjsim.geometry import Array
from mjsim.models import bounded
from mjsim.style import SURFACES
from mjsim.world import Floor, FloorPatch, World, item_names

AROUND_WALLS, AROUND_NOTHING = 2.0, 20.0
"""Margins of the visible floor around the objects on it [m]; robots can drive beyond it."""
PATCH_HEIGHT = 0.0006
"""Height of a patch above the surface below it [m]: twice the sag of a wheel, so that the patch alone carries the
wheel, and too small to disturb it."""
PATCH_DEPTH = 0.1
"""Depth of a patch in the floor, so that contacts push upwards out of it [m]."""


def add_floor(spec: mujoco.MjSpec, world: World, lower: Array, upper: Array) -> None:
    """Add the floor: infinite for collisions, as large as the world for the eye, tiled from the world's origin."""
    floor = _styled(world)
    around = AROUND_WALLS if world.walls else AROUND_NOTHING
    low, high = lower[:2] - around, upper[:2] + around
    if floor.texture is not None:
        # MuJoCo counts the tiles of a finite plane from its corner at -x, +y.
        low, high = np.floor(low / floor.tile) * floor.tile, np.ceil(high / floor.tile) * floor.tile
        _add_tiles(spec, world, "floor", floor.texture, floor.tile)
    center, half = (low + high) / 2, (high - low) / 2
    keys = {"type": mujoco.mjtGeom.mjGEOM_PLANE, "pos": [*center, 0.0], "size": [*half, PLANE_SPACING]}
    look = {
        "material": "matte" if floor.texture is None else "floor",
        "rgba": color_of(floor.color if floor.texture is None else tint_of(floor)),
    }
    friction = [floor.friction, 0.005, 0.0001]
    if floor is world.floor:
        spec.worldbody.add_geom(name="floor", friction=friction, **keys, **look)
        return
    # Lidars see the floor as it is without a style.
    rgba = color_of(floor.color)
    spec.worldbody.add_geom(name="floor", group=COLLISION, friction=friction, material="matte", rgba=rgba, **keys)
    spec.worldbody.add_geom(name="floor/:style", group=VISUAL, contype=0, conaffinity=0, **keys, **look)


def _styled(world: World) -> Floor:
    """Return the floor of a world; one without a texture has that of the world's style."""
    if world.floor.texture is not None or world.style == "plain":
        return world.floor
    texture, tile = SURFACES[world.style].floor
    return world.floor.model_copy(update={"texture": texture, "tile": tile})


def add_patches(spec: mujoco.MjSpec, world: World) -> None:
    """Add the patches `floor/NAME`: the collision shape is a slab in the floor, the visual one lies on it."""
    patches = world.floor.patches
    for patch, name, layer in zip(patches, item_names(patches), layers(patches), strict=True):
        top, half = layer * PATCH_HEIGHT, [size / 2 for size in patch.size]
        turn = math.radians(patch.heading_deg) / 2
        quat = [math.cos(turn), 0.0, 0.0, math.sin(turn)]
        spec.worldbody.add_geom(
            name=f"floor/{name}",
            type=mujoco.mjtGeom.mjGEOM_BOX,
            group=COLLISION,
            pos=[*patch.at, (top - PATCH_DEPTH) / 2],
            size=[*half, (top + PATCH_DEPTH) / 2],
            quat=quat,
            friction=[patch.friction, 0.005, 0.0001],
        )
        seen = f"floor/seen:{name}"
        if patch.texture is not None:
            _add_tiles(spec, world, seen, patch.texture, patch.tile)
        spec.worldbody.add_geom(
            name=seen,
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            group=VISUAL,
            contype=0,
            conaffinity=0,
            pos=[*patch.at, top],
            size=[*half, PLANE_SPACING],
            quat=quat,
            material="matte" if patch.texture is None else seen,
            rgba=color_of(patch.color if patch.texture is None else tint_of(patch)),
        )


def layers(patches: tuple[FloorPatch, ...]) -> list[int]:
    """Return the layer of each patch, counted from 1: above earlier patches that it overlaps."""
    import shapely

    outlines = [shapely.Polygon(patch.outline()) for patch in patches]
    found: list[int] = []
    for place, outline in enumerate(outlines):
        below = [found[other] for other in range(place) if outline.intersects(outlines[other])]
        found.append(max(below, default=0) + 1)
    return found


def _add_tiles(spec: mujoco.MjSpec, world: World, name: str, texture: str, tile: float) -> None:
    """Add the material of a plane that is tiled with a picture."""
    add_material(spec, name, bounded(world.read_picture(texture), MAX_TILE_SIDE))
    material = spec.material(name)
    material.texuniform, material.texrepeat = True, [2.0 / tile] * 2
