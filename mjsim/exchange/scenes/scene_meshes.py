"""Meshes of scenes: divided into their parts, boxes recognised."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np
import shapely

from mjsim.errors import UsageError
from mjsim.exchange.bounded_file import read_bounded
from mjsim.exchange.drawings import Indices
from mjsim.exchange.scenes.scene_solids import Scene, SceneSkin, SceneSolid
from mjsim.geometry import Array
from mjsim.inventory import Fate
from mjsim.models import MeshPart, bounded, encode_png, floats, gazebo_triangles, mesh_parts, read_picture

MAX_BYTES = 60_000_000
"""Maximum size of a mesh file [bytes]."""
MAX_LOOKS, MAX_SIDE = 64 << 20, 512
"""Maximum size of all visible meshes of a scene [bytes], and maximum side of a picture on them [px]."""
MAX_PARTS = 200
"""Above this number of connected parts, a mesh is used unchanged."""
MIN_BOX_SHARE = 0.98
"""A part that fills at least this fraction of its smallest box is that box."""
MAX_FLAT_RATIO = 1e-3
"""A mesh whose thickness is below this fraction of its size is flat."""
MIN_AREA = 1e-6
"""Minimum area in a polyline [m^2]."""
WELD_DISTANCE = 1e-5
"""Corners in the same cell of this size are one vertex [m]."""


@dataclass(frozen=True, slots=True)
class MeshName:
    """A mesh of a file."""

    path: Path
    named: str = ""
    """Its name in the file; '' for all."""
    centred: bool = False
    """Whether the middle of its bounding box is its origin."""


Part = tuple[Array, Indices]
"""Vertices, shape (n, 3) [m], and triangles, shape (m, 3)."""


class MeshFiles:
    """Reads each mesh once, and notes what could not be read."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._parts: dict[MeshName, list[Part]] = {}
        self._looks: dict[MeshName, list[MeshPart]] = {}
        self._bytes = 0

    def solids(self, mesh: MeshName, scale: Array, pose: Array, color: str | None) -> Iterator[SceneSolid]:
        """Yield the parts of a mesh.

        Args:
            mesh: The file, and the mesh in it.
            scale: Factors along x, y and z.
            pose: Pose of the mesh in the world, shape (4, 4) [m].
            color: '#rrggbb'.
        """
        if mesh not in self._parts:
            self._parts[mesh] = self._read(mesh)
        # A mirrored triangle has its corners the other way round.
        order = slice(None, None, -1 if np.prod(scale) < 0.0 else 1)
        for vertices, faces in self._parts[mesh]:
            try:
                part = SceneSolid("mesh", (), pose, color, vertices * scale, faces[:, order])
            except ValueError as error:
                self._scene.tell(Fate.LEFT_OUT, "mesh part", mesh.path.name, str(error))
                continue
            yield boxed(part)

    def skins(self, mesh: MeshName, scale: Array, pose: Array, read: Callable[[str], bytes]) -> list[SceneSkin]:
        """Return the visible parts of a mesh, in their colours and textures; none if it has neither.

        Args:
            mesh: The file, and the mesh in it.
            scale: Factors along x, y and z.
            pose: Pose of the mesh in the world, shape (4, 4) [m].
            read: Returns a file that the mesh names.
        """
        if mesh not in self._looks:
            self._looks[mesh] = self._seen(mesh, read)
        return [SceneSkin(look, scale, pose) for look in self._looks[mesh]]

    def _seen(self, mesh: MeshName, read: Callable[[str], bytes]) -> list[MeshPart]:
        try:
            data = read_bounded(mesh.path, limit=MAX_BYTES, kind="a mesh")
            looks = mesh_parts(mesh.path.name, data, read, up_axis=False, named=mesh.named)
        except (UsageError, ValueError) as error:
            self._scene.tell(Fate.LEFT_OUT, "look", mesh.path.name, str(error))
            return []
        if mesh.centred or all(look.rgba is None and look.texture is None for look in looks):
            return []
        looks = [smaller(look) for look in looks]
        self._bytes += sum(len(look.data) + len(look.texture or b"") for look in looks)
        if self._bytes > MAX_LOOKS:
            self._scene.tell(Fate.LEFT_OUT, "look", mesh.path.name, f"looks of more than {MAX_LOOKS >> 20} MB")
            return []
        return looks

    def prisms(self, shape: Element, pose: Array, color: str | None, name: str, where: str) -> Iterator[SceneSolid]:
        """Yield the prism on a `<polyline>`."""
        height = floats(shape.findtext("height", "1"), 1, f"{where}: height")[0]
        ring = [floats(point.text, 2, f"{where}: point") for point in shape.findall("point")]
        if len(ring) < 3 or not height > 0.0 or not shapely.Polygon(ring).area > MIN_AREA:
            self._scene.tell(Fate.LEFT_OUT, "polyline", name, "it has no area, or no height")
            return
        count = len(ring)
        vertices = np.array([[*point, z] for z in (0.0, height) for point in ring])
        here, ahead = np.arange(count), (np.arange(count) + 1) % count
        sides = [np.stack([here, ahead, ahead + count], axis=1), np.stack([here, ahead + count, here + count], axis=1)]
        yield boxed(SceneSolid("mesh", (), pose, color, vertices, np.concatenate(sides)))

    def _read(self, mesh: MeshName) -> list[Part]:
        """Return vertices, shape (n, 3) [m], and triangles, shape (m, 3), of each connected part of a mesh."""
        try:
            data = read_bounded(mesh.path, limit=MAX_BYTES, kind="a mesh")
            triangles, coarser = gazebo_triangles(mesh.path.name, data, named=mesh.named)
        except (UsageError, ValueError) as error:
            self._scene.tell(Fate.LEFT_OUT, "mesh", mesh.path.name, str(error))
            return []
        if coarser:
            self._scene.tell(Fate.GUESSED, "mesh", mesh.path.name, "simplified, as it has very many triangles")
        corners = triangles.reshape(-1, 3)
        middle = (corners.min(axis=0) + corners.max(axis=0)) / 2.0
        return parts_of(triangles - middle if mesh.centred else triangles)


def smaller(look: MeshPart) -> MeshPart:
    """Return a part with a picture of at most `MAX_SIDE` pixels."""
    if look.texture is None:
        return look
    return replace(look, texture=encode_png(bounded(read_picture(look.texture), MAX_SIDE)))


def parts_of(triangles: Array) -> list[Part]:
    """Return vertices and faces of each connected part; of the whole if there are very many.

    Args:
        triangles: Shape (n, 3, 3) [m].
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    corners = triangles.reshape(-1, 3)
    _, first, owners = np.unique(np.round(corners / WELD_DISTANCE), axis=0, return_index=True, return_inverse=True)
    vertices, faces = corners[first], owners.reshape(-1, 3)
    edges = np.concatenate([faces[:, :2], faces[:, 1:]])
    graph = coo_matrix((np.ones(len(edges)), edges.T), shape=(len(vertices),) * 2)
    count, label = connected_components(graph, directed=False)
    if count > MAX_PARTS:
        return [(vertices, faces)]
    of_face = label[faces[:, 0]]
    return [_compact(vertices, faces[of_face == part]) for part in range(count)]


def _compact(vertices: Array, faces: Indices) -> Part:
    """Return the vertices that faces use, and the faces with their new numbers."""
    used, numbers = np.unique(faces, return_inverse=True)
    return vertices[used], numbers.reshape(-1, 3)


def boxed(solid: SceneSolid) -> SceneSolid:
    """Return a mesh, or the upright box that it is; a flat one becomes a thin box."""
    from scipy.spatial import ConvexHull, QhullError

    box = _smallest_box(solid)
    extents = np.linalg.svd(solid.vertices - solid.vertices.mean(axis=0), compute_uv=False)
    if extents[-1] < MAX_FLAT_RATIO * extents[0]:
        return box
    try:
        hull = ConvexHull(solid.vertices)
    except (QhullError, ValueError):
        return box
    return box if hull.volume >= MIN_BOX_SHARE * float(np.prod(box.size)) and _is_full(solid, hull.volume) else solid


def _is_full(solid: SceneSolid, volume: float) -> bool:
    """Return whether the triangles of a mesh enclose nearly its convex hull."""
    # Relative to the middle, every missing triangle counts; relative to a corner, those at it would not.
    a, b, c = ((solid.vertices - solid.vertices.mean(axis=0))[solid.faces[:, k]] for k in range(3))
    return abs(float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum())) / 6.0 >= MIN_BOX_SHARE * volume


def _smallest_box(solid: SceneSolid) -> SceneSolid:
    """Return the smallest upright box around a mesh, in the frame of the world."""
    import shapely

    points = solid.corners()
    ring = shapely.minimum_rotated_rectangle(shapely.MultiPoint(points[:, :2]))
    low, high = points[:, 2].min(), points[:, 2].max()
    corners = shapely.get_coordinates(ring)[:4]
    if len(corners) < 4:
        return SceneSolid(
            "box", (1e-3, 1e-3, max(1e-3, float(high - low))), solid.pose, solid.color, texture=solid.texture
        )
    along, across = corners[1] - corners[0], corners[2] - corners[1]
    pose = np.eye(4)
    pose[:2, 0] = along / max(1e-9, float(np.hypot(*along)))
    pose[:2, 1] = -pose[1, 0], pose[0, 0]
    pose[:3, 3] = *corners.mean(axis=0), (low + high) / 2
    sizes = (float(np.hypot(*along)), float(np.hypot(*across)), float(high - low))
    return SceneSolid("box", tuple(max(1e-3, size) for size in sizes), pose, solid.color, texture=solid.texture)
