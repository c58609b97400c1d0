"""How the geoms of a compiled model look."""

import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.models import UNSAID


def texture_of(model: mujoco.MjModel, geom: int) -> int:
    """Return the texture of a geom, -1 without one."""
    material = int(model.geom_matid[geom])
    return -1 if material < 0 else int(model.mat_texid[material, mujoco.mjtTextureRole.mjTEXROLE_RGB])


def is_flat(model: mujoco.MjModel, texture: int) -> bool:
    """Return whether a texture is one picture, not one for each side of a cube."""
    return bool(model.tex_type[texture] == mujoco.mjtTexture.mjTEXTURE_2D)


def has_texcoords(model: mujoco.MjModel, geom: int) -> bool:
    """Return whether a surface has texture coordinates of its own; on others MuJoCo derives them from the points."""
    kind, mesh = mujoco.mjtGeom(model.geom_type[geom]), int(model.geom_dataid[geom])
    unrolled = kind == mujoco.mjtGeom.mjGEOM_MESH and model.mesh_texcoordadr[mesh] >= 0
    return bool(unrolled or kind == mujoco.mjtGeom.mjGEOM_PLANE)


def rgba_of(model: mujoco.MjModel, geom: int) -> Array:
    """Return the colour of a geom, or of its material if it sets none, RGBA in [0, 1], shape (4,)."""
    own, material = model.geom_rgba[geom], int(model.geom_matid[geom])
    of_material = material >= 0 and np.allclose(own, UNSAID)
    return np.asarray(model.mat_rgba[material] if of_material else own, dtype=float)
