"""Walls: boxes that things bump into, and few merged meshes that cameras see.

Both come from the same boxes, so that what is seen is what is bumped into.
"""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from mjsim.compile.names import item_names
from mjsim.compile.pictures import LONGEST_TILE_SIDE, add_material, bounded, color_of, read_picture
from mjsim.compile.solids import Face, Prism, visible_faces
from mjsim.geometry import Array
from mjsim.world.model import World
from mjsim.world.pieces import SLIVER, Piece, wall_pieces
from mjsim.world.structure import Wall

COLLISION, VISUAL = 3, 1
"""Geom groups."""
UNDIVIDED = 1000.0
"""Spacing of the lines by which MuJoCo divides a plane to draw it [m]: flat faces lit from afar need none."""
CHUNK = 24.0
"""Side of the squares by which the meshes of a large floor are divided, so that unseen ones cost nothing [m]."""

Look = tuple[str | None, str, float]
"""Texture, colour and size of a tile [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class WallBox:
    """The solid of one piece of a wall."""

    name: str
    center: Array
    """World frame, shape (3,) [m]."""
    half: Array
    """Half sizes along the wall, across it and upwards, shape (3,) [m]."""
    heading: float
    """Of the wall [rad]."""
    look: Look

    def outline(self) -> Array:
        """Return its corners from above, counter-clockwise, shape (4, 2) [m]."""
        c, s = np.cos(self.heading), np.sin(self.heading)
        corners = self.half[:2] * [[-1, -1], [1, -1], [1, 1], [-1, 1]]
        return np.asarray(corners @ [[c, s], [-s, c]] + self.center[:2])


def wall_boxes(walls: Sequence[Wall]) -> list[WallBox]:
    """Return the boxes of all walls, wall by wall."""
    return [box for wall, name in zip(walls, item_names(walls), strict=True) for box in _boxes(wall, name)]


def _boxes(wall: Wall, name: str) -> Iterator[WallBox]:
    texture = wall.texture
    look = texture, "#ffffff" if texture else wall.color, wall.tile if texture else 1.0
    half = wall.thickness / 2
    solids = (solid for piece in wall_pieces(wall) for solid in _solids(piece, half))
    for index, (first, last, half_width, piece) in enumerate(solids):
        along = last - first
        yield WallBox(
            name=f"wall/{name}/{index}",
            center=np.array([*(first + last) / 2, (piece.low + piece.high) / 2]),
            half=np.array([np.hypot(*along) / 2, half_width, (piece.high - piece.low) / 2]),
            heading=float(np.arctan2(along[1], along[0])),
            look=look,
        )


def _solids(piece: Piece, half: float) -> Iterator[tuple[Array, Array, float, Piece]]:
    """Yield the boxes that stand for a piece: both ends of their middle line [m], half their width [m], the piece.

    At a mitre the box reaches as far as the mitre does. That would stand out of the next segment's side where
    the wall turns by more than a right angle: there the box reaches as far as it may, half^2 / mitre, and a bevel
    across the corner fills the notch between both ends.
    """
    along = piece.end - piece.start
    length = float(np.hypot(*along))
    along /= length
    right = np.array([along[1], -along[0]])
    reach = ((piece.outline - piece.start) @ along).tolist()
    before, after = (-reach[0], -reach[3]), (reach[1] - length, reach[2] - length)
    first, last = _square_end(*before, half), _square_end(*after, half)
    yield piece.start - along * first, piece.end + along * last, half, piece
    mitre = max(after)
    if mitre - last > SLIVER:
        tip = along * mitre + right * half * np.sign(after[0] - after[1])
        size = float(np.hypot(*tip))
        yield piece.end, piece.end + tip * (2 * half**2 / size**2), half * (mitre - last) / size, piece


def _square_end(right: float, left: float, half: float) -> float:
    """Return how far a box may reach beyond its piece's centreline, from how far the right and left side do [m]."""
    reach = max(right, left)
    return min(reach, half**2 / reach) if reach > 0.0 and abs(right - left) > SLIVER else reach


def add_walls(spec: mujoco.MjSpec, world: World, boxes: Sequence[WallBox]) -> None:
    """Add the walls of a world: a box for each piece, and the meshes that are seen."""
    for box in boxes:
        geom = spec.worldbody.add_geom(
            name=box.name,
            type=mujoco.mjtGeom.mjGEOM_BOX,
            group=COLLISION,
            pos=box.center,
            size=box.half,
            rgba=color_of(box.look[1]),  # for sensors that tell how bright it is
        )
        geom.quat = [np.cos(box.heading / 2), 0.0, 0.0, np.sin(box.heading / 2)]
    looks = list(dict.fromkeys(box.look for box in boxes))
    materials = [_material(spec, world, look, index) for index, look in enumerate(looks)]
    prisms = [_prism(box, looks.index(box.look)) for box in boxes]
    for index, faces in enumerate(_chunks(visible_faces(prisms)), start=1):
        look = looks[faces[0].look]
        # A colon cannot be part of an item's name, so this never meets the name of a box.
        geom = add_mesh_geom(spec, f"wall/seen:{index}", faces, tile=look[2])
        geom.material, geom.rgba = materials[faces[0].look], color_of(look[1])


def _prism(box: WallBox, look: int) -> Prism:
    low, high = box.center[2] - box.half[2], box.center[2] + box.half[2]
    return Prism(box.outline(), float(low), float(high), look)


def _material(spec: mujoco.MjSpec, world: World, look: Look, index: int) -> str:
    texture = look[0]
    if texture is None:
        return "matte"
    name = f"wall/texture{index + 1}"
    add_material(spec, name, bounded(read_picture(world.read_asset(texture)), LONGEST_TILE_SIDE))
    return name


def _chunks(faces: Sequence[Face]) -> list[list[Face]]:
    """Return the faces by look and by square of the plane."""
    chunks: dict[tuple[int, ...], list[Face]] = defaultdict(list)
    corner = np.min([face.points[0, :2] for face in faces], axis=0, initial=np.inf)
    for face in faces:
        square = np.floor((face.points[:, :2].mean(axis=0) - corner) / CHUNK).astype(int).tolist()
        chunks[face.look, *square].append(face)
    return list(chunks.values())


def add_mesh_geom(spec: mujoco.MjSpec, name: str, faces: Sequence[Face], *, tile: float) -> mujoco.MjsGeom:
    """Add faces to the world as one mesh that is seen and never touched, textured by metric tiles."""
    mesh = spec.add_mesh(name=name, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
    counts = np.cumsum([0] + [len(face.points) for face in faces])
    mesh.uservert = np.concatenate([face.points for face in faces]).ravel()
    mesh.usernormal = np.concatenate([np.tile(face.normal, (len(face.points), 1)) for face in faces]).ravel()
    mesh.usertexcoord = np.concatenate([_texture_points(face) / tile for face in faces]).ravel()
    triangles = [face.triangles + first for face, first in zip(faces, counts[:-1], strict=True)]
    mesh.userface = np.concatenate(triangles).astype(np.int32).ravel()
    return spec.worldbody.add_geom(
        name=name, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, group=VISUAL, contype=0, conaffinity=0
    )


def _texture_points(face: Face) -> Array:
    """Return where each corner lies on the texture, to the right and downwards, shape (n, 2) [m]."""
    if face.normal[2]:
        return face.points[:, :2] * [1.0, -1.0]
    right = np.array([-face.normal[1], face.normal[0]])
    return np.column_stack([face.points[:, :2] @ right, -face.points[:, 2]])
