"""Static parts of a compiled model: visible surfaces as triangles in the world, with colour and emitted light."""

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.compile import merged_into, rgba_of, texture_of, triangles_of
from mjsim.geometry import Array
from mjsim.light.baked import GAMMA

VISIBLE_GROUPS = (0, 1, 5)
"""Groups of geoms that cameras see, or that are currently removed."""
MIN_OPAQUE_ALPHA = 0.5
"""Minimum alpha of a surface that casts a shadow."""
PIXEL_STRIDE = 17
"""Step in pixels for the mean colour of a picture: coprime with usual widths."""
PICTURE_PREFIX, CEILING, BACK_SUFFIX = "beacon/", "ceiling", ":back"
"""Names of geoms: pictures and markers, the ceiling, and backs of pictures."""


@dataclass(frozen=True, slots=True, eq=False)
class StillGeom:
    """A visible geom, in the frame of the world at the start."""

    geom: int
    """Geom in the model."""
    points: Array
    """Shape (n, 3) [m]."""
    normals: Array
    """Outward, shape (n, 3)."""
    texcoords: Array | None
    """Shape (n, 2); None without a picture."""
    triangles: NDArray[np.int32]
    """Shape (m, 3)."""
    albedo: Array
    """Mean linear reflectance, red, green, blue, shape (3,)."""
    glow: float
    """Emitted light relative to full light."""
    shades: bool
    """Whether it casts shadows and reflects light; flat pictures on walls do neither."""
    is_ceiling: bool
    """Whether it is the ceiling, which has the ambient light."""
    moves: bool
    """Whether it can move, or is a person: then it casts a shadow at its initial place, but has no light map."""


def static_geoms(model: mujoco.MjModel) -> NDArray[np.intp]:
    """Return the visible geoms that cannot move."""
    still = model.body_weldid[model.geom_bodyid] == 0
    still &= model.body_mocapid[model.body_rootid[model.geom_bodyid]] < 0
    # Of merged shapes, the mesh counts as visible, whichever is drawn now.
    return np.flatnonzero(still & np.isin(model.geom_group, VISIBLE_GROUPS) & (merged_into(model) <= 0))


def solid_of(model: mujoco.MjModel, data: mujoco.MjData, geom: int) -> StillGeom | None:
    """Return a geom as triangles in the world; None if it has no surface of triangles."""
    shape = triangles_of(model, geom)
    if shape is None or not len(shape.corners):
        return None
    turned, material = data.geom_xmat[geom].reshape(3, 3), int(model.geom_matid[geom])
    name = model.geom(geom).name
    textured = texture_of(model, geom) >= 0
    return StillGeom(
        geom,
        shape.points @ turned.T + data.geom_xpos[geom],
        shape.normals @ turned.T,
        shape.places if textured else None,
        shape.corners.astype(np.int32),
        albedo_of(model, geom),
        # The emission of pictures cancels the ambient light on them; it is not light of their own.
        0.0 if material < 0 or name.startswith(PICTURE_PREFIX) else float(model.mat_emission[material]),
        not name.startswith(PICTURE_PREFIX) and BACK_SUFFIX not in name and rgba_of(model, geom)[3] >= MIN_OPAQUE_ALPHA,
        name == CEILING,
        bool(model.body_weldid[model.geom_bodyid[geom]] != 0),
    )


def albedo_of(model: mujoco.MjModel, geom: int) -> Array:
    """Return the mean linear reflectance of a geom, red, green, blue, shape (3,)."""
    own = np.ones(3) if model.geom(geom).name.startswith(PICTURE_PREFIX) else rgba_of(model, geom)[:3]
    texture = texture_of(model, geom)
    mean = np.ones(3) if texture < 0 else np.power(texture_sample(model, texture) / 255.0, GAMMA).mean(axis=0)
    return np.power(own, GAMMA) * mean


def texture_sample(model: mujoco.MjModel, texture: int) -> NDArray[np.uint8]:
    """Return some pixels of a texture, evenly chosen, shape (n, 3)."""
    first, channels = int(model.tex_adr[texture]), int(model.tex_nchannel[texture])
    count = int(model.tex_height[texture]) * int(model.tex_width[texture])
    pixels = model.tex_data[first : first + count * channels].reshape(count, channels)[::PIXEL_STRIDE]
    chosen: NDArray[np.uint8] = pixels[:, :3] if channels >= 3 else np.repeat(pixels[:, :1], 3, axis=1)
    return chosen
