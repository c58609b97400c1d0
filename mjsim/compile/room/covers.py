"""Surfaces of things with a texture: meshes beside their shapes, with the texture in metres and round edges.

MuJoCo stretches a texture along two axes of a box and smears it over the other sides; a mesh has texture coordinates of
its own. The shape remains for contacts and lidars, the mesh is what cameras see. Equal shapes share their mesh, equal
textures their material.
"""

from collections.abc import Sequence

import mujoco
import numpy as np

from mjsim.compile.room.triangles import Triangles, joined, shape_triangles
from mjsim.compile.room.unrolling import unrolled
from mjsim.compile.textures import MAX_TILE_SIDE, add_material
from mjsim.geometry import Array
from mjsim.interface import Picture
from mjsim.models import bounded


class Covers:
    """Textured surfaces of some things in a scene."""

    def __init__(self, spec: mujoco.MjSpec, prefix: str) -> None:
        """Keep the scene to which materials and meshes are added, and the prefix of their names."""
        self._spec, self._prefix = spec, prefix
        self._materials: dict[str, str] = {}
        self._meshes: dict[tuple[bytes, float], str] = {}

    def material(self, texture: str, picture: Picture) -> str:
        """Return the name of the material of a texture, which is added if missing."""
        if texture not in self._materials:
            name = self._materials[texture] = f"{self._prefix}/texture{len(self._materials) + 1}"
            add_material(self._spec, name, bounded(picture, MAX_TILE_SIDE))
        return self._materials[texture]

    def mesh(self, shape: Triangles, tile: float) -> str:
        """Return the name of the mesh of a surface with a texture in tiles [m], which is added if missing."""
        corners = shape.corners.ravel()
        points, normals = shape.points[corners], shape.normals[corners]
        key = np.round(points, 9).tobytes(), tile
        if key not in self._meshes:
            self._meshes[key] = f"{self._prefix}:cover{len(self._meshes) + 1}"
            mesh = self._spec.add_mesh(name=self._meshes[key], inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
            mesh.uservert, mesh.usernormal = points.ravel(), normals.ravel()
            mesh.usertexcoord = (_places(points) / tile).ravel()
            mesh.userface = np.arange(len(points), dtype=np.int32)
        return self._meshes[key]


def _places(points: Array) -> Array:
    """Return the position on a texture of the corners of triangles, three each, shape (n, 2) [m]."""
    first, second, third = points.reshape(-1, 3, 3).transpose(1, 0, 2)
    flat = np.cross(second - first, third - first)
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    return unrolled(points, flat.repeat(3, axis=0), np.arange(len(points), dtype=np.int32).reshape(-1, 3))


def surface_of(spec: mujoco.MjSpec, geoms: Sequence[mujoco.MjsGeom]) -> Triangles:
    """Return the surface of geoms that are not turned, in the frame in which they are placed."""
    parts = []
    for geom in geoms:
        shape = shape_triangles(geom.type, geom.size) or mesh_surface(spec.mesh(geom.meshname))
        parts.append(Triangles(shape.points + geom.pos, shape.normals, shape.places, shape.corners))
    return joined(parts)


def mesh_surface(mesh: mujoco.MjsMesh) -> Triangles:
    """Return the surface of a mesh that is given by its corners, in its own frame."""
    points, normals = np.reshape(mesh.uservert, (-1, 3)), np.reshape(mesh.usernormal, (-1, 3))
    places = np.reshape(mesh.usertexcoord, (-1, 2)) if len(mesh.usertexcoord) else np.zeros((len(points), 2))
    return Triangles(points, normals, places, np.reshape(mesh.userface, (-1, 3)).astype(np.uint32))
