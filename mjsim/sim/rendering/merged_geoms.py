"""The visible geoms of a compiled model, as a few merged surfaces per moving body."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.compile import Triangles, coarser, has_texcoords, is_flat, joined, rgba_of, texture_of, triangles_of
from mjsim.geometry import Array
from mjsim.models import UNSAID
from mjsim.sim.person_segments import is_segment, is_upper
from mjsim.sim.rendering.lit_corners import LitCorners, shown_color
from mjsim.sim.rendering.merged import visible_parts

MAX_CROWD_TRIANGLES = 60_000
"""Total triangles of people above which they are simplified."""
CELLS_PER_SIDE, MIN_CELL = 10, 0.004
"""Cells along the longest side of a simplified part of a body, and their least size [m]."""

Material = tuple[int | None, bool, bool]
"""The number of the texture on a surface, whether the surface is transparent, and whether its colours include light."""


@dataclass(frozen=True, slots=True, eq=False)
class MergedSurface:
    """A surface drawn at once: of one body, with one texture or none."""

    triangles: Triangles
    """Triangles in the frame of the body."""
    colors: Array
    """RGBA of each corner as it is displayed, in [0, 1], shape (n, 4)."""
    texture: int | None
    """As in `Material`."""
    clear: bool
    """As in `Material`."""
    lit: bool
    """As in `Material`."""
    things: tuple[tuple[str, int], ...]
    """Names of geoms and their numbers of triangles, in order."""


@dataclass(frozen=True, slots=True, eq=False)
class SolidBody:
    """The surfaces of a body that moves as one."""

    body: int
    """Body in the model; 0 for all static geoms."""
    surfaces: tuple[MergedSurface, ...]


def moving_bodies(model: mujoco.MjModel) -> NDArray[np.intp]:
    """Return, for each body, the nearest movable body at or above it, 0 for none, shape (nbody,)."""
    found = np.zeros(model.nbody, dtype=np.intp)
    for body in range(1, model.nbody):
        moves = model.body_jntnum[body] > 0 or model.body_mocapid[body] >= 0 or is_upper(model, body)
        found[body] = body if moves else found[model.body_parentid[body]]
    return found


def solid_bodies(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    *,
    groups: Sequence[int],
    sparing: bool = False,
    light: LitCorners | None = None,
) -> list[SolidBody]:
    """Return the visible surfaces of a model, static ones first.

    Args:
        model: The model.
        data: Its state, with the poses of geoms and bodies computed; each surface is in the frame of its body.
        groups: Visible geom groups.
        sparing: Whether to use fewer triangles for many people.
        light: Light on static surfaces, which colours then include.
    """
    carriers = moving_bodies(model)
    crowd = crowded(model) if sparing else frozenset()
    parts: dict[int, dict[Material, list[int]]] = defaultdict(lambda: defaultdict(list))
    for geom in visible_parts(model, groups).tolist():
        alpha = _color(model, geom)[3]
        if alpha > 0.0:
            body = int(carriers[model.geom_bodyid[geom]])
            lit = light is not None and body == 0
            parts[body][_texture(model, geom), bool(alpha < 1.0), lit].append(geom)
    return [
        SolidBody(
            body,
            tuple(
                surface
                for material, geoms in parts[body].items()
                for surface in _merged(model, data, body, material, geoms, crowd, light)
            ),
        )
        for body in sorted({0, *carriers.tolist()})
    ]


def crowded(model: mujoco.MjModel) -> frozenset[int]:
    """Return the geoms of people where they have more than `MAX_CROWD_TRIANGLES` triangles together; none otherwise."""
    meshes = np.flatnonzero(model.geom_type == mujoco.mjtGeom.mjGEOM_MESH).tolist()
    own = [geom for geom in meshes if is_segment(model, int(model.geom_bodyid[geom]))]
    count = int(model.mesh_facenum[model.geom_dataid[own]].sum()) if own else 0
    return frozenset(own) if count > MAX_CROWD_TRIANGLES else frozenset()


def _merged(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    body: int,
    material: Material,
    geoms: Sequence[int],
    crowd: frozenset[int],
    light: LitCorners | None,
) -> list[MergedSurface]:
    """Return geoms of one material as a surface in the frame of a body; none if no geom has a surface."""
    names, shapes, colors = [], [], []
    for geom in geoms:
        shape = triangles_of(model, geom)
        if shape is not None and geom in crowd:
            shape = coarser(shape, max(float(np.ptp(shape.points, axis=0).max()) / CELLS_PER_SIDE, MIN_CELL))
        if shape is not None and len(shape.corners):
            shape, color = _placed(shape, model, data, geom=geom, body=body), _color(model, geom)
            values = np.ones((len(shape.points), 3))
            if light is not None and body == 0:
                (shape, values), color = light.lit(shape), shown_color(model, geom, color)
            shapes.append(shape)
            names.append((_name(model, geom), len(shape.corners)))
            colors.append(np.column_stack([values * color[:3], np.full(len(values), color[3])]))
    if not shapes:
        return []
    return [MergedSurface(joined(shapes), np.concatenate(colors), *material, tuple(names))]


def _placed(shape: Triangles, model: mujoco.MjModel, data: mujoco.MjData, *, geom: int, body: int) -> Triangles:
    """Return a geom's surface in the frame of a body."""
    world_from_geom, world_from_body = data.geom_xmat[geom].reshape(3, 3), data.xmat[body].reshape(3, 3)
    body_from_geom = world_from_body.T @ world_from_geom
    origin = world_from_body.T @ (data.geom_xpos[geom] - data.xpos[body])
    points = shape.points @ body_from_geom.T + origin
    return Triangles(points, shape.normals @ body_from_geom.T, shape.places, shape.corners)


def _name(model: mujoco.MjModel, geom: int) -> str:
    """Return the name of a geom; of one without a name that of its body."""
    return str(model.geom(geom).name or model.body(model.geom_bodyid[geom]).name)


def _texture(model: mujoco.MjModel, geom: int) -> int | None:
    """Return the flat texture of a geom with texture coordinates, as meshes and planes have."""
    texture = texture_of(model, geom)
    return texture if texture >= 0 and is_flat(model, texture) and has_texcoords(model, geom) else None


def _color(model: mujoco.MjModel, geom: int) -> Array:
    """Return the colour of a geom as it is displayed, RGBA in [0, 1], shape (4,)."""
    material, color = int(model.geom_matid[geom]), rgba_of(model, geom)
    if material >= 0 and np.allclose(model.geom_rgba[geom], UNSAID):
        # Glowing surfaces are dimmed so that they are not too bright together with the light on them.
        color[:3] = np.clip(color[:3] * (1.0 + model.mat_emission[material]), 0.0, 1.0)
    return color


def used_textures(bodies: Sequence[SolidBody]) -> Mapping[int, int]:
    """Return the index of each texture among those in use."""
    seen = {surface.texture for body in bodies for surface in body.surfaces if surface.texture is not None}
    return {texture: place for place, texture in enumerate(sorted(seen))}
