"""Shapes of a compiled model as triangles, in frames of their own."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from mjsim.geometry import Array

FACETS = 24
"""Facets around a round shape."""
HALF_PLANE_SIDE = 50.0
"""Half the side of an infinite plane [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Triangles:
    """A surface."""

    points: Array
    """Corners, shape (n, 3) [m]."""
    normals: Array
    """Outward surface normal at each corner, shape (n, 3)."""
    places: Array
    """Texture coordinates of each corner, from the upper left to (1, 1) at the lower right, shape (n, 2)."""
    corners: NDArray[np.uint32]
    """Indices of corners, counter-clockwise seen from outside, shape (m, 3)."""


def triangles_of(model: mujoco.MjModel, geom: int) -> Triangles | None:
    """Return the surface of a geom in its own frame; None for kinds defined by a function."""
    kind = mujoco.mjtGeom(model.geom_type[geom])
    if kind == mujoco.mjtGeom.mjGEOM_PLANE:
        return _plane(model, geom)
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        return _mesh(model, int(model.geom_dataid[geom]))
    if kind == mujoco.mjtGeom.mjGEOM_HFIELD:
        return _field(model, int(model.geom_dataid[geom]))
    return shape_triangles(kind, model.geom_size[geom])


def shape_triangles(kind: mujoco.mjtGeom, size: ArrayLike, *, facets: int = FACETS) -> Triangles | None:
    """Return the surface of a shape.

    Args:
        kind: Kind of geom; for those without a surface of their own None is returned.
        size: As MuJoCo defines it, shape (3,) [m].
        facets: Facets around a round shape, a multiple of 4.
    """
    make = _SHAPES.get(kind)
    return None if make is None else make(np.asarray(size, dtype=float), facets)


def _flat(points: Array, corners: NDArray[np.uint32], places: Array | None = None) -> Triangles:
    """Return triangles without shared corners, each with its own normal; degenerate ones are dropped."""
    triangles = points[corners]
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    area = np.linalg.norm(normals, axis=1)
    nonzero = area > 0.0
    triangles, normals = triangles[nonzero].reshape(-1, 3), (normals[nonzero] / area[nonzero, None]).repeat(3, axis=0)
    at = np.zeros((len(triangles), 2)) if places is None else places[corners][nonzero].reshape(-1, 2)
    return Triangles(triangles, normals, at, np.arange(len(triangles), dtype=np.uint32).reshape(-1, 3))


def _plane(model: mujoco.MjModel, geom: int) -> Triangles:
    half = np.where(model.geom_size[geom, :2] > 0.0, model.geom_size[geom, :2], HALF_PLANE_SIDE)
    unit = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    material = int(model.geom_matid[geom])
    repeat = np.ones(2) if material < 0 else model.mat_texrepeat[material]
    if material >= 0 and model.mat_texuniform[material]:
        repeat = repeat * half
    # MuJoCo counts pictures on a finite plane from its corner at -x, +y.
    places = 0.5 * repeat * (1.0 + unit * [1.0, -1.0])
    points = np.column_stack([unit * half, np.zeros(4)])
    corners = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32)
    return Triangles(points, np.tile([0.0, 0.0, 1.0], (4, 1)), places, corners)


def _mesh(model: mujoco.MjModel, mesh: int) -> Triangles:
    """Return a mesh; corners with the same position, normal and texture coordinates are merged."""

    def part(values: NDArray[np.float32], start: NDArray[np.int32], count: NDArray[np.int32]) -> NDArray[np.float32]:
        return values[start[mesh] : start[mesh] + count[mesh]]

    faces = slice(model.mesh_faceadr[mesh], model.mesh_faceadr[mesh] + model.mesh_facenum[mesh])
    points = part(model.mesh_vert, model.mesh_vertadr, model.mesh_vertnum)
    normals = part(model.mesh_normal, model.mesh_normaladr, model.mesh_normalnum)
    which = [model.mesh_face[faces].ravel(), model.mesh_facenormal[faces].ravel()]
    pictured = model.mesh_texcoordadr[mesh] >= 0
    if pictured:
        which.append(model.mesh_facetexcoord[faces].ravel())
    once, corner = np.unique(np.column_stack(which), axis=0, return_inverse=True)
    places = np.zeros((len(once), 2))
    if pictured:
        places = part(model.mesh_texcoord, model.mesh_texcoordadr, model.mesh_texcoordnum)[once[:, 2]]
    return Triangles(points[once[:, 0]], normals[once[:, 1]], places, corner.reshape(-1, 3).astype(np.uint32))


def _field(model: mujoco.MjModel, field: int) -> Triangles:
    """Return the upper side of a height field."""
    rows, columns = int(model.hfield_nrow[field]), int(model.hfield_ncol[field])
    first = int(model.hfield_adr[field])
    half_x, half_y, top, _ = model.hfield_size[field]
    x, y = np.meshgrid(np.linspace(-half_x, half_x, columns), np.linspace(-half_y, half_y, rows))
    heights = model.hfield_data[first : first + rows * columns] * top
    points = np.column_stack([x.ravel(), y.ravel(), heights])
    return _flat(points, _quads(rows, columns))


def _quads(rows: int, columns: int) -> NDArray[np.uint32]:
    """Return the triangles of a grid of points, shape (m, 3); each row lies to the right of the next."""
    start = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    one = np.column_stack([start, start + 1, start + columns + 1])
    other = np.column_stack([start, start + columns + 1, start + columns])
    return np.concatenate([one, other]).astype(np.uint32)


def _box(size: Array, _: int) -> Triangles:
    """Return a box of half sides (3,) [m]."""
    signs = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    corners = [corner for a, b, c, d in sides for corner in ((a, b, c), (a, c, d))]
    return _flat(signs * size, np.array(corners, dtype=np.uint32))


def _cylinder(size: Array, facets: int) -> Triangles:
    """Return a cylinder of radius and half length [m] along z."""
    turn = np.linspace(0.0, 2.0 * np.pi, facets + 1)
    ring = np.column_stack([np.cos(turn), np.sin(turn)])
    around = np.column_stack([ring, np.zeros(len(ring))])
    side = np.concatenate([np.column_stack([size[0] * ring, np.full(len(ring), z)]) for z in (-size[1], size[1])])
    parts = [Triangles(side, np.tile(around, (2, 1)), np.zeros((len(side), 2)), _quads(2, len(ring)))]
    for up in (-1.0, 1.0):
        rim = np.column_stack([size[0] * ring[:-1], np.full(facets, up * size[1])])
        fan = np.column_stack([np.zeros(facets - 2), np.arange(1, facets - 1), np.arange(2, facets)])
        corners = np.asarray(fan if up > 0.0 else fan[:, ::-1], dtype=np.uint32)
        parts.append(Triangles(rim, np.tile([0.0, 0.0, up], (facets, 1)), np.zeros((facets, 2)), corners))
    return joined(parts)


def _ball(size: Array, facets: int, *, length: float = 0.0) -> Triangles:
    """Return an ellipsoid of half axes (3,) [m], its halves moved apart from the middle along z."""
    turn = np.linspace(0.0, 2.0 * np.pi, facets + 1)
    half = np.linspace(-0.5 * np.pi, 0.0, facets // 4 + 1)
    rise = np.concatenate([half, -half[::-1]] if length else [half, -half[-2::-1]])
    shift = np.repeat([-length, length], len(half)) if length else np.zeros(len(rise))
    level, angle = (grid.ravel() for grid in np.meshgrid(rise, turn, indexing="ij"))
    unit = np.column_stack([np.cos(level) * np.cos(angle), np.cos(level) * np.sin(angle), np.sin(level)])
    points = unit * size + np.column_stack([np.zeros((len(unit), 2)), shift.repeat(len(turn))])
    normals = unit / size
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Triangles(points, normals, np.zeros((len(unit), 2)), _quads(len(rise), len(turn)))


def _sphere(size: Array, facets: int) -> Triangles:
    return _ball(np.full(3, size[0]), facets)


def _capsule(size: Array, facets: int) -> Triangles:
    return _ball(np.full(3, size[0]), facets, length=float(size[1]))


_SHAPES: Mapping[mujoco.mjtGeom, Callable[[Array, int], Triangles]] = {
    mujoco.mjtGeom.mjGEOM_BOX: _box,
    mujoco.mjtGeom.mjGEOM_CYLINDER: _cylinder,
    mujoco.mjtGeom.mjGEOM_ELLIPSOID: _ball,
    mujoco.mjtGeom.mjGEOM_SPHERE: _sphere,
    mujoco.mjtGeom.mjGEOM_CAPSULE: _capsule,
}


def joined(parts: list[Triangles]) -> Triangles:
    """Return several surfaces as one."""
    first = np.cumsum([0, *(len(part.points) for part in parts)])
    return Triangles(
        np.concatenate([part.points for part in parts]),
        np.concatenate([part.normals for part in parts]),
        np.concatenate([part.places for part in parts]),
        np.concatenate([part.corners + np.uint32(at) for part, at in zip(parts, first, strict=False)]),
    )


def coarser(shape: Triangles, cell: float) -> Triangles:
    """Return a surface with fewer triangles: corners in one cell of a grid are merged at their mean.

    Args:
        shape: A smooth surface without a texture.
        cell: Side of a cell [m].

    References:
        Rossignac, Borrel: Multi-resolution 3D approximations for rendering complex scenes (1993): vertex clustering.
    """
    _, into, counts = np.unique(np.round(shape.points / cell), axis=0, return_inverse=True, return_counts=True)
    into = into.reshape(-1)
    points, normals = np.zeros((len(counts), 3)), np.zeros((len(counts), 3))
    np.add.at(points, into, shape.points)
    np.add.at(normals, into, shape.normals)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    corners = into[shape.corners]
    first, second, third = corners.T
    corners = corners[(first != second) & (second != third) & (third != first)]
    # Of triangles that coincide, one is enough.
    _, unique = np.unique(np.sort(corners, axis=1), axis=0, return_index=True)
    return Triangles(
        points / counts[:, None],
        normals / np.maximum(lengths, 1e-12),
        np.zeros((len(counts), 2)),
        corners[np.sort(unique)].astype(np.uint32),
    )
