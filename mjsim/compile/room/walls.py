"""Walls: boxes for collisions, and few merged meshes for rendering.

Both come from the same boxes, so that visual and collision shapes agree.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.compile.room.prisms import Face, Faces, Prisms, visible_faces
from mjsim.compile.room.unrolling import metric_places, unrolled
from mjsim.compile.textures import MAX_TILE_SIDE, add_material, color_of, tint_of
from mjsim.geometry import Array
from mjsim.models import bounded
from mjsim.style import SURFACES
from mjsim.world import Wall, World, item_names, rooms_at, solid_pieces

COLLISION, VISUAL = 3, 1
"""Geom groups."""
PLANE_SPACING = 1000.0
"""Spacing of MuJoCo's subdivision of planes for drawing [m]: flat faces in distant light need none."""
CHUNK_SIDE = 12.0
"""Side of the squares into which the meshes of a large floor are divided, so that invisible ones cost nothing [m]."""
MIN_CORNERS = 4
"""Minimum number of vertices of a mesh in MuJoCo."""
LINES = "walls"
"""Name of the custom numbers in the scene with the positions of walls that reach the floor."""
ON_FLOOR = 1e-6
"""Largest height at which the lower edge of a wall counts as on the floor [m]."""

PROBE_DISTANCE = 0.01
"""Distance in front of a face at which a point shows to which room the face belongs [m]."""
MAX_LONE_BOXES = 2000
"""Number of boxes added one by one to a scene."""
END_OVERLAP = 1e-5
"""Overlap of boxes that meet at their ends, so that no ray passes between them by rounding [m]."""

WallFinish = tuple[str | None, str, float]
"""Texture, colour and size of a tile [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class WallBox:
    """The box of one segment of a wall."""

    name: str
    center: Array
    """World frame, shape (3,) [m]."""
    half: Array
    """Half sizes along the wall, across it and upwards, shape (3,) [m]."""
    heading: float
    """Heading of the wall [rad]."""
    finish: WallFinish

    outline: Array
    """Outline of the segment from above, mitred at corners, counter-clockwise, shape (4, 2) [m]."""
    line: Array
    """Its centreline, solid from end to end, shape (2, 2) [m]."""


def wall_boxes(walls: Sequence[Wall]) -> list[WallBox]:
    """Return the boxes of all walls, wall by wall.

    At a mitre a box extends to the end of its longer side: the excess lies inside the box of the next segment.
    """
    solids = solid_pieces(walls)
    pieces = [piece for wall in solids for piece in wall]
    if not pieces:
        return []
    names = [f"wall/{n}/{k}" for n, wall in zip(item_names(walls), solids, strict=True) for k in range(len(wall))]
    finishes = [finish for finish, wall in zip(map(_finish, walls), solids, strict=True) for _ in wall]
    outlines = np.array([piece.outline for piece in pieces])
    starts, ends = np.array([piece.start for piece in pieces]), np.array([piece.end for piece in pieces])
    along = (ends - starts) / np.linalg.norm(ends - starts, axis=1, keepdims=True)
    left = np.column_stack([-along[:, 1], along[:, 0]])
    p_piece = np.einsum("nki,nji->nkj", outlines - starts[:, None], np.stack([along, left], axis=1))
    first, last = p_piece.min(axis=1), p_piece.max(axis=1)
    half, middle = (last - first) / 2, (first + last) / 2
    levels = np.array([(piece.low, piece.high) for piece in pieces])
    centers = starts + along * middle[:, :1] + left * middle[:, 1:]
    centers = np.column_stack([centers, levels.mean(axis=1)])
    halves = np.column_stack([half, (levels[:, 1] - levels[:, 0]) / 2])
    headings = np.arctan2(along[:, 1], along[:, 0]).tolist()
    lines = np.stack([starts, ends], axis=1)
    return [WallBox(*row) for row in zip(names, centers, halves, headings, finishes, outlines, lines, strict=True)]


def _finish(wall: Wall) -> WallFinish:
    return (wall.texture, tint_of(wall), wall.tile) if wall.texture else (None, wall.color, 1.0)


def add_walls(spec: mujoco.MjSpec, world: World, boxes: Sequence[WallBox]) -> None:
    """Add the walls of a world: a collision box for each segment, and the visual meshes."""
    _add_boxes(spec, boxes)
    _add_lines(spec, boxes)
    look_of = {box.finish: _styled(box.finish, world) for box in boxes}
    boxes = [replace(box, finish=look_of[box.finish]) for box in boxes] if world.style != "plain" else boxes
    finishes = list(dict.fromkeys(box.finish for box in boxes))
    materials = _materials(spec, world, finishes)
    faces = visible_faces(_prisms(boxes, finishes))
    places = _places(faces, np.array([finish[0] is not None for finish in finishes], dtype=bool))
    for index, (part, part_places) in enumerate(_chunks(faces, places, world), start=1):
        kind = int(part.material[0])
        # An item's name cannot contain a colon, so this never equals the name of a box.
        geom = _add_mesh(spec, f"wall/seen:{index}", part, part_places / finishes[kind][2])
        geom.material, geom.rgba = materials[kind], color_of(finishes[kind][1])


def _styled(finish: WallFinish, world: World) -> WallFinish:
    """Return how a finish looks in the style of a world: one without a texture has that of the style."""
    texture, color, _ = finish
    if world.style == "plain" or texture is not None:
        return finish
    texture, tile = SURFACES[world.style].wall
    return texture, "#ffffff" if color == Wall.model_fields["color"].default else color, tile


def wall_lines(model: mujoco.MjModel) -> Array:
    """Return the centrelines of the walls in a compiled scene that stand on the floor and occlude objects behind them.

    Returns:
        x and y of one end, of the other, and the height, shape (n, 5) [m]; empty for a scene not from mjsim.
    """
    index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_NUMERIC, LINES)
    if index < 0:
        return np.empty((0, 5))
    first = model.numeric_adr[index]
    return np.array(model.numeric_data[first : first + model.numeric_size[index]], dtype=float).reshape(-1, 5)


def _add_lines(spec: mujoco.MjSpec, boxes: Sequence[WallBox]) -> None:
    """Store the centrelines of the walls that stand on the floor: cameras need not draw objects hidden by these."""
    standing = [box for box in boxes if box.center[2] - box.half[2] < ON_FLOOR]
    if standing:
        rows = [[*box.line.ravel().tolist(), float(box.center[2] + box.half[2])] for box in standing]
        spec.add_numeric(name=LINES, data=np.array(rows).ravel(), size=5 * len(rows))


def _add_boxes(spec: mujoco.MjSpec, boxes: Sequence[WallBox]) -> None:
    """Add the collision boxes, many of them in separate specs: MuJoCo recounts the entire scene at each new geom."""
    centers = np.array([box.center for box in boxes]).tolist()
    sizes = [[along + END_OVERLAP, across, up] for along, across, up in (box.half.tolist() for box in boxes)]
    colors = {finish: color_of(finish[1]) for finish in {box.finish for box in boxes}}
    for first in range(0, len(boxes), MAX_LONE_BOXES):
        part, batch = mujoco.MjSpec() if first else spec, range(first, min(first + MAX_LONE_BOXES, len(boxes)))
        geoms = [part.worldbody.add_geom() for _ in batch]
        if part is not spec:
            spec.attach(part, prefix=f"wall:{first}/", frame=spec.worldbody.add_frame())
        for geom, index in zip(geoms, batch, strict=True):
            heading = boxes[index].heading
            # One by one and as lists, which takes half the time of arrays and keywords.
            geom.name, geom.type, geom.group = boxes[index].name, mujoco.mjtGeom.mjGEOM_BOX, COLLISION
            # Boxes are invisible, but a lidar reports their brightness (tests/sim/test_lidar.py).
            geom.pos, geom.size, geom.rgba = centers[index], sizes[index], colors[boxes[index].finish]
            geom.quat = [math.cos(heading / 2), 0.0, 0.0, math.sin(heading / 2)]


def _prisms(boxes: Sequence[WallBox], finishes: Sequence[WallFinish]) -> Prisms:
    order = {finish: index for index, finish in enumerate(finishes)}
    middle, half = np.array([(box.center[2], box.half[2]) for box in boxes]).reshape(-1, 2).T
    finish = np.array([order[box.finish] for box in boxes], dtype=np.int64)
    return Prisms(np.array([box.outline for box in boxes]), middle - half, middle + half, finish)


def _materials(spec: mujoco.MjSpec, world: World, finishes: Sequence[WallFinish]) -> list[str]:
    """Return the material of each finish; those with one texture share it."""
    names: dict[str | None, str] = {None: "matte"}
    for texture, _, _ in finishes:
        if texture is not None and texture not in names:
            names[texture] = f"wall/texture{len(names)}"
            add_material(spec, names[texture], bounded(world.read_picture(texture), MAX_TILE_SIDE))
    return [names[texture] for texture, _, _ in finishes]


def _places(faces: Faces, textured: NDArray[np.bool_]) -> Array:
    """Return the position of each corner on its texture, which continues round edges, shape (n, 2) [m]."""
    places = metric_places(faces.points, faces.normals)
    triangles = faces.triangles[textured[faces.material]]
    if len(triangles):
        corners, inverse = np.unique(triangles, return_inverse=True)
        renumbered = inverse.reshape(-1, 3).astype(np.int32)
        places[corners] = unrolled(faces.points[corners], faces.normals[corners], renumbered)
    return places


def _chunks(faces: Faces, places: Array, world: World) -> list[tuple[Faces, Array]]:
    """Return the faces by look and by square of the plane, with the positions of their corners on a texture.

    Textured pixels are slow: in a style the faces are divided by room too, so that rooms behind walls cost nothing.
    """
    if not len(faces.material):
        return []
    middles = faces.points[faces.triangles, :2].mean(axis=1)
    squares = np.floor((middles - middles.min(axis=0)) / CHUNK_SIDE).astype(np.int64)
    rooms = np.zeros(len(middles), dtype=np.int64)
    if world.style != "plain":
        rooms = rooms_at(world.walls, middles + faces.normals[faces.triangles[:, 0], :2] * PROBE_DISTANCE)
    keys = np.column_stack([faces.material, rooms, squares])
    order = np.lexsort(keys.T[::-1])
    ends = np.flatnonzero((keys[order][1:] != keys[order][:-1]).any(axis=1)) + 1
    return [
        _with_enough_corners(faces.some(triangles), places[np.unique(faces.triangles[triangles])])
        for triangles in np.split(order, ends)
    ]


def _with_enough_corners(faces: Faces, places: Array) -> tuple[Faces, Array]:
    """Return the same faces; a triangle alone in its square has one corner twice, as MuJoCo requires four."""
    if len(faces.points) >= MIN_CORNERS:
        return faces, places
    points, normals, places = (np.vstack([each, each[-1:]]) for each in (faces.points, faces.normals, places))
    return Faces(points, normals, faces.triangles, faces.material), places


def add_mesh_geom(spec: mujoco.MjSpec, name: str, faces: Sequence[Face], *, tile: float) -> mujoco.MjsGeom:
    """Add faces to the world as one purely visual mesh, textured by metric tiles."""
    joined = Faces.of(faces)
    return _add_mesh(spec, name, joined, metric_places(joined.points, joined.normals) / tile)


def _add_mesh(spec: mujoco.MjSpec, name: str, faces: Faces, places: Array) -> mujoco.MjsGeom:
    mesh = spec.add_mesh(name=name, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
    mesh.uservert = faces.points.ravel()
    mesh.usernormal = faces.normals.ravel()
    mesh.usertexcoord = places.ravel()
    mesh.userface = faces.triangles.ravel()
    return spec.worldbody.add_geom(
        name=name, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, group=VISUAL, contype=0, conaffinity=0
    )
