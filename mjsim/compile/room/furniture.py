"""Furniture: many small visible shapes are merged into few meshes, like walls.

A picture costs about 20 microseconds for each geom in view, and a table has nine. The geoms of static objects are
merged by room and look, those of a moving body by look. (One texture with a block of texels for each colour would make
one mesh of all colours, but textured pixels cost more than it saves.) The merged geoms remain in the scene for lidars,
contacts, instances and names, in groups that cameras do not draw; their user number is that of their mesh, which has
the negative number. In a world with a style, furniture of one colour is of wood, fabric or metal in that colour.
"""

import colorsys
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.compile.room.covers import mesh_surface
from mjsim.compile.room.triangles import Triangles, joined, shape_triangles
from mjsim.compile.room.walls import CHUNK_SIDE, COLLISION, VISUAL
from mjsim.compile.textures import MAX_TILE_SIDE, add_material
from mjsim.geometry import Array
from mjsim.models import bounded, matrix_of
from mjsim.world import World, rooms_at

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
    """Multiplies the texture so that its mean is as close to the colour as possible."""


class Finishes:
    """Adds the materials of furniture to a scene as they are needed."""

    def __init__(self, spec: mujoco.MjSpec, world: World) -> None:
        """Keep the scene."""
        self._spec, self._world = spec, world
        self._means: dict[str, Array] = {}

    def of(self, rgba: Sequence[float]) -> Finish | None:
        """Return the finish of a colour; None for one that stays plain."""
        kind = _kind(*rgba[:3])
        return None if kind is None else self.made_of(kind, rgba)

    def made_of(self, kind: str, rgba: Sequence[float]) -> Finish:
        """Return the finish of a texture in a colour."""
        if kind not in self._means:
            picture = bounded(self._world.read_picture(f"materials/{kind}.jpg"), MAX_TILE_SIDE)
            if self._spec.material(f"style/{kind}") is None:
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


DRAWN_MERGED = 4
"""Group of purely visual geoms that are drawn as part of a merged mesh."""
MIN_STATIC, MIN_MOVING = 16, 3
"""With fewer geoms in a world, or on a moving body, drawing them one by one costs as little."""
MAX_TRIANGLES = 2000
"""A geom with more triangles is drawn by itself: then triangles count, not geoms."""
MAX_COORDINATE = 1e6
"""A geom with a corner farther away is drawn by itself, if MuJoCo accepts its numbers at all [m]."""
FACETS = ((8, 0.035), (16, 0.12), (28, np.inf))
"""Facets around a round shape up to a radius [m]."""

Look = tuple[str, tuple[float, ...]]
"""Material and colour of a merged mesh."""


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """A geom that can be merged."""

    geom: mujoco.MjsGeom
    carrier: mujoco.MjsBody
    """The body that moves it; the world for a static one."""
    surface: Triangles
    """Surface in the frame of the carrier."""
    look: Look


def merge_furniture(spec: mujoco.MjSpec, world: World) -> None:
    """Merge the visible shapes of the objects in a scene that has no other bodies yet."""
    finishes = None if world.style == "plain" else Finishes(spec, world)
    # A copy, as finishes add materials.
    parts = [part for geom in list(spec.geoms) if (part := _part(spec, geom, finishes)) is not None]
    chosen = [*_static_groups(world, parts), *_moving_groups(parts)]
    if not chosen:
        return
    spec.nuser_geom = 1
    for number, group in enumerate(chosen, start=1):
        _merge(spec, number, group)


def merged_into(model: mujoco.MjModel) -> NDArray[np.intp]:
    """Return for each geom the number of the mesh that shows it, that of the mesh itself negative, 0 for all others."""
    return model.geom_user[:, 0].astype(np.intp) if model.nuser_geom else np.zeros(model.ngeom, dtype=np.intp)


def _static_groups(world: World, parts: Sequence[_Part]) -> list[list[_Part]]:
    """Return the static parts by region and look."""
    static = [part for part in parts if part.carrier.name == "world"]
    styled = world.style != "plain"
    if len(static) < MIN_STATIC and not styled:
        return []
    groups: dict[tuple[object, Look], list[_Part]] = defaultdict(list)
    for part, region in zip(static, _regions(world, static), strict=True):
        groups[region, part.look].append(part)
    return [group for group in groups.values() if len(group) > 1 or styled]


def _moving_groups(parts: Sequence[_Part]) -> list[list[_Part]]:
    """Return the parts of moving bodies by body and look."""
    groups: dict[tuple[str, Look], list[_Part]] = defaultdict(list)
    for part in parts:
        if part.carrier.name != "world":
            groups[part.carrier.name, part.look].append(part)
    return [group for group in groups.values() if len(group) >= MIN_MOVING or group[0].look[0] != "matte"]


@np.errstate(all="ignore")  # numbers of untrusted files may overflow
def _part(spec: mujoco.MjSpec, geom: mujoco.MjsGeom, finishes: Finishes | None) -> _Part | None:
    """Return a geom to be merged; None for one that is invisible, large, transparent, or textured by its size."""
    if geom.group > VISUAL or geom.rgba[3] < 1.0 or not _owner(geom).startswith("obstacle/"):
        return None
    mesh = spec.mesh(geom.meshname) if geom.type == mujoco.mjtGeom.mjGEOM_MESH else None
    surface = shape_triangles(geom.type, geom.size, facets=_facets(geom)) if mesh is None else mesh_surface(mesh)
    if surface is None or len(surface.corners) > MAX_TRIANGLES:
        return None
    material = spec.material(geom.material)
    textured = material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] != ""
    if textured and (mesh is None or not len(mesh.usertexcoord) or material.texuniform):
        return None
    look = str(geom.material), tuple(float(value) for value in geom.rgba)
    finish = None if finishes is None or geom.material != "matte" else finishes.of(geom.rgba)
    if finish is not None:
        look, surface = (finish.name, finish.tint), covered(surface, finish.name)
    carrier, rotation, origin = _carried(geom)
    points, normals = surface.points @ rotation.T + origin, surface.normals @ rotation.T
    if not (np.abs(points) < MAX_COORDINATE).all():
        return None
    return _Part(geom, carrier, Triangles(points, normals, surface.places, surface.corners), look)


def _facets(geom: mujoco.MjsGeom) -> int:
    """Return the number of facets round a shape: with MuJoCo's 28, many small shapes cost more merged than not."""
    radius = sorted(geom.size)[1] if geom.type == mujoco.mjtGeom.mjGEOM_ELLIPSOID else geom.size[0]
    return next(facets for facets, largest in FACETS if radius <= largest)


def _owner(geom: mujoco.MjsGeom) -> str:
    """Return the name of a geom, or of the topmost body that it is part of."""
    body = geom.parent
    while body.name != "world" and body.parent.name != "world":
        body = body.parent
    return str(geom.name if body.name == "world" else body.name)


def _carried(geom: mujoco.MjsGeom) -> tuple[mujoco.MjsBody, Array, Array]:
    """Return the body that moves a geom, and rotation and origin of the geom in its frame, shapes (3, 3), (3,) [m]."""
    rotation, origin = matrix_of(geom.quat / np.linalg.norm(geom.quat)), np.array(geom.pos)
    body = geom.parent
    outer = [] if geom.frame is None else [geom.frame]
    while body.name != "world" and not len(body.joints):
        outer.append(body)
        body = body.parent
    for frame in outer:
        world_from_frame = matrix_of(frame.quat / np.linalg.norm(frame.quat))
        rotation, origin = world_from_frame @ rotation, world_from_frame @ origin + frame.pos
    return body, rotation, origin


def _regions(world: World, parts: Sequence[_Part]) -> list[tuple[int, ...]]:
    """Return for each part its room, -1 outside, and the square of the plane that it is in."""
    boxes = [(part.surface.points.min(axis=0), part.surface.points.max(axis=0)) for part in parts]
    middles = np.array(boxes).reshape(-1, 2, 3).mean(axis=1)[:, :2]
    rooms = rooms_at(world.walls, middles)
    squares = np.floor(middles / CHUNK_SIDE).astype(int)
    return [tuple(row) for row in np.column_stack([rooms, squares]).tolist()]


def _merge(spec: mujoco.MjSpec, number: int, parts: Sequence[_Part]) -> None:
    """Add the mesh of some geoms to the body that carries them, and hide these from cameras."""
    material, rgba = parts[0].look
    surface = joined([part.surface for part in parts])
    # An item's name cannot contain a colon, so this never equals the name of a part.
    name = f"obstacle/seen:{number}"
    mesh = spec.add_mesh(name=name, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
    mesh.uservert, mesh.usernormal = surface.points.ravel(), surface.normals.ravel()
    mesh.userface = surface.corners.astype(np.int32).ravel()
    if spec.material(material).textures[mujoco.mjtTextureRole.mjTEXROLE_RGB]:
        mesh.usertexcoord = surface.places.ravel()
    parts[0].carrier.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_MESH,
        meshname=name,
        material=material,
        rgba=rgba,
        mass=0.0,
        group=VISUAL,
        contype=0,
        conaffinity=0,
        userdata=[-float(number)],
    )
    for part in parts:
        part.geom.group = COLLISION if part.geom.contype or part.geom.conaffinity else DRAWN_MERGED
        part.geom.userdata = [float(number)]
