"""Static geometry as triangles for ray casting with Embree: much faster than MuJoCo, and exact where flat."""

from collections.abc import Callable
from importlib.util import find_spec

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.sim.rays.ray_fan import RayHits

HALF_FLOOR_SIDE = 2000.0
"""Half the side of an infinite floor [m]."""
CORNERS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
"""Corners of a box of half sizes 1, shape (8, 3)."""
SIDES = np.reshape(
    [0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1, 2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3],
    (12, 3),
)
"""Triangles of that box by its corners, shape (12, 3)."""
SQUARE = np.array([[0, 2, 6], [0, 6, 4]])
"""Triangles of its lower side."""
FLAT = (mujoco.mjtGeom.mjGEOM_PLANE, mujoco.mjtGeom.mjGEOM_BOX, mujoco.mjtGeom.mjGEOM_MESH)
"""Kinds of geoms that triangles represent exactly."""


class Standing:
    """Static geoms, for ray casting.

    Boxes, planes and meshes are exact. A round shape is replaced by its bounding box: hits on that are left to MuJoCo.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, geoms: NDArray[np.int64]) -> None:
        """Collect the triangles.

        Args:
            model: The compiled world.
            data: A state of it after `mj_kinematics`.
            geoms: Numbers of the geoms.
        """
        shapes = [_triangles(model, data, geom) for geom in geoms.tolist()]
        corners = np.concatenate([np.zeros((0, 3, 3)), *shapes])
        of_triangles = np.repeat(geoms, [len(shape) for shape in shapes])
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
        heights = np.einsum("ij,ij->i", normals, corners[:, 0])
        # One per triangle, and at the end one for no hit, which has the index -1.
        self._geoms = np.append(of_triangles, -1).astype(np.int32)
        self._is_round = np.append(~np.isin(model.geom_type[of_triangles], FLAT), False)
        self._normals, self._heights = np.append(normals, np.zeros((1, 3)), axis=0), np.append(heights, 0.0)
        self._meet = _embree(corners) if len(corners) else None

    def cast(self, starts: Array, directions: Array, *, limit: float) -> RayHits:
        """Return the hits of rays.

        Args:
            starts: Origins, world frame, shape (n, 3) [m].
            directions: Unit vectors, world frame, shape (n, 3).
            limit: Largest distance of a hit [m].
        """
        if self._meet is None:
            return RayHits.nothing(len(starts))
        triangles = self._meet(starts, directions)
        # Embree finds the triangle in single precision; the intersection with its plane is computed again in double.
        normals = self._normals[triangles]
        along = np.einsum("ij,ij->i", normals, directions)
        ahead = self._heights[triangles] - np.einsum("ij,ij->i", normals, starts)
        distances = np.divide(ahead, along, out=np.full(len(starts), np.inf), where=triangles >= 0)
        distances[distances > limit] = np.inf
        return RayHits(distances, self._geoms[triangles], facing=np.abs(along), unsure=self._is_round[triangles])


def is_clear(model: mujoco.MjModel) -> NDArray[np.bool_]:
    """Return which geoms rays ignore as invisible, as in MuJoCo, shape (ngeom,)."""
    of_material = np.append(model.mat_rgba[:, 3], 1.0)[model.geom_matid]
    clear: NDArray[np.bool_] = np.where(model.geom_matid < 0, model.geom_rgba[:, 3], of_material) == 0.0
    return clear


def has_embree() -> bool:
    """Return whether the ray caster is installed."""
    return find_spec("embreex") is not None


def _embree(corners: Array) -> Callable[[Array, Array], NDArray[np.int32]]:
    """Return a function for the first triangle that each ray hits, -1 for none: starts, directions -> shape (n,)."""
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    scene = EmbreeScene()
    TriangleMesh(scene, np.ascontiguousarray(corners, dtype=np.float32))

    def meet(starts: Array, directions: Array) -> NDArray[np.int32]:
        found: NDArray[np.int32] = scene.run(starts.astype(np.float32), directions.astype(np.float32))
        return found

    return meet


def _triangles(model: mujoco.MjModel, data: mujoco.MjData, geom: int) -> Array:
    """Return the corners of the triangles of a geom in the world, shape (n, 3, 3) [m]."""
    kind, size = model.geom_type[geom], model.geom_size[geom]
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = model.geom_dataid[geom]
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        face, faces = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
        corners = model.mesh_vert[first : first + count][model.mesh_face[face : face + faces]].astype(float)
    elif kind == mujoco.mjtGeom.mjGEOM_PLANE:
        wide = [half if half > 0.0 else HALF_FLOOR_SIDE for half in size[:2].tolist()]
        corners = (CORNERS * [*wide, 0.0])[SQUARE]
    else:
        center, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
        corners = (CORNERS * half + center)[SIDES]
    turned: Array = corners @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]
    return turned
