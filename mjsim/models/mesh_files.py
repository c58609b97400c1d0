"""Meshes of Collada, glTF, OBJ and STL, read by trimesh, as parts of one colour or texture that MuJoCo reads.

Lengths become metres and z points up, as stated in each file. Untrusted files must be read in the guarded reader.
"""

import io
import posixpath
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mjsim.geometry import Array
from mjsim.models.xml_text import RefusedXmlError, checked_xml
from mjsim.sentences import Sentence

SUFFIXES = (".dae", ".gltf", ".glb", ".obj", ".stl")
"""Endings of files that are read."""
Y_UP = (".gltf", ".glb")
"""Formats whose y axis points up."""
MAX_TRIANGLES = 60_000
"""Maximum number of triangles of a part; it is simplified until it has no more."""
MAX_PARTS = 32
"""Maximum number of parts of a mesh; those beyond have the colour of the last."""
MAX_CELLS = 400
"""Number of cells along the longest side of a mesh in the first simplification."""
COARSENING_RATIO = 0.75
"""Factor of the number of cells from one simplification to the next."""
FLAT, SPECK, MIN_SPECK = 1e-9, 2e-3, 3e-5
"""Maximum volume of a flat mesh, as a share of the cube of its size; side of the speck added to it, as a share of its
size; and minimum side of the speck [m]."""
SPECK_FACES = ((0, 2, 1), (0, 3, 2), (0, 1, 3), (1, 2, 3))
MAX_SIDE = 1024
"""Maximum side of a texture [px]."""
NO_PICTURE = 2
"""The library's own picture for a mesh without one has this side [px]."""
_HEAD, _RECORD = 80, np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])
_UNIT = re.compile(r"<unit\b[^>]*\bmeter\s*=\s*[\"']\s*([0-9.eE+-]{1,20})\s*[\"']")
_UP = re.compile(r"<up_axis>\s*([XYZ])_UP\s*</up_axis>")
_KEY, _NUMBER = re.compile(r"""\b(id|name)\s*=\s*["']([^"']*)["']"""), re.compile(r"[._]\d+$")
"""Names of a geometry, and the suffix that the library adds for its parts."""
_UPRIGHT: Mapping[str, Array] = {
    "X": np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]]),
    "Y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
    "Z": np.eye(3),
}
"""Axis that points up in a file -> rotation to one with z up."""


@dataclass(frozen=True, slots=True, eq=False)
class MeshPart:
    """A part of a mesh with one colour or texture."""

    data: bytes
    """A binary STL; with a texture, an OBJ."""
    rgba: tuple[float, float, float, float] | None = None
    """Its colour, 0 to 1; None if the file has none."""
    texture: bytes | None = None
    """A PNG."""
    coarser: bool = False
    """Whether it was simplified."""
    bare: bool = False
    """Whether pictures, or material files that it names, were not read."""

    @property
    def ending(self) -> str:
        """Ending of the name of its file."""
        return ".stl" if self.texture is None else ".obj"


def mesh_parts(
    path: str,
    data: bytes,
    read: Callable[[str], bytes],
    *,
    up_axis: bool = True,
    named: str = "",
    pictures: bool = True,
) -> list[MeshPart]:
    """Return the parts of a mesh.

    Args:
        path: Its file; the ending tells the format.
        data: Contents of the file.
        read: Returns a file that it names, by its path relative to the folder of the mesh; raises ValueError.
        up_axis: Whether Collada is turned as its `<up_axis>` says; Gazebo does not turn it.
        named: Name of the mesh in the file that is meant; '' for all.
        pictures: Whether parts keep their pictures; otherwise they get the mean colour of these.

    Raises:
        ValueError: It cannot be read as a mesh, or has none of this name; the message names the file.
    """
    groups: dict[object, list[Any]] = {}
    for mesh in _meshes(path, data, read, up_axis=up_axis, named=named):
        rgba, picture = _look(mesh)
        key: object = rgba if picture is None else id(picture)
        groups.setdefault(key if len(groups) < MAX_PARTS or key in groups else next(reversed(groups)), []).append(mesh)
    return [_part(meshes, pictures=pictures) for meshes in groups.values()]


def whole_mesh(path: str, data: bytes, read: Callable[[str], bytes], *, up_axis: bool = True) -> MeshPart:
    """Return a mesh as one part without a colour; arguments and errors are those of `mesh_parts`."""
    return _plain([mesh.triangles for mesh in _meshes(path, data, read, up_axis=up_axis)], None)


def gazebo_triangles(path: str, data: bytes, *, named: str = "") -> tuple[Array, bool]:
    """Return the triangles of a mesh as Gazebo reads it, without `<up_axis>`, and whether there are fewer than in it.

    Args:
        path: Its file.
        data: Contents of the file.
        named: Name of the mesh in the file that is meant; '' for all.

    Returns:
        triangles: Shape (n, 3, 3) [m].
        coarser: Whether the mesh was simplified.

    Raises:
        ValueError: It cannot be read as a mesh, or has none of this name; the message names the file.
    """
    whole = np.concatenate([mesh.triangles for mesh in _meshes(path, data, alone, up_axis=False, named=named)])
    fewer = coarser(whole)
    return fewer, len(fewer) < len(whole)


def alone(name: str) -> bytes:
    """Refuse every file: for meshes whose further files are left out."""
    raise ValueError(Sentence("files that a mesh names are not read, such as '{name}'", name))


def _meshes(
    path: str, data: bytes, read: Callable[[str], bytes], *, up_axis: bool = True, named: str = ""
) -> list[Any]:
    """Return the meshes of a file, placed, in metres, z up; without `up_axis`, those of Collada are not rotated."""
    import trimesh

    ending = posixpath.splitext(path)[1].lower()
    turn = np.eye(4)
    turn[:3, :3] = _upright(path, data, ending, up_axis=up_axis)
    beside: Any = _Beside(read)
    # Otherwise objects of one material are one mesh, with the name of the first.
    apart: dict[str, Any] = {"split_objects": True} if named and ending == ".obj" else {}
    try:
        scene = trimesh.load_scene(
            io.BytesIO(data), file_type=ending[1:], resolver=beside, process=False, skip_materials=False, **apart
        )
        found: list[Any] = [mesh for mesh in scene.dump() if len(getattr(mesh, "faces", ()))]
        for mesh in found:
            mesh.apply_transform(turn)
    # Libraries fail on damaged files in any way; what they return is checked below.
    except Exception as error:
        reason = " ".join(str(error).split())[:100] or type(error).__name__
        raise ValueError(
            Sentence("'{path}' cannot be read as a mesh ({reason}); export it again", path, reason)
        ) from None
    corners = np.concatenate([mesh.vertices for mesh in found] or [np.zeros((1, 3))])
    if not (np.isfinite(corners).all() and np.ptp(corners, axis=0).max() > 0.0):
        raise ValueError(Sentence("'{path}' cannot be read as a mesh: it has no triangles; export it again", path))
    return _named(found, named, path, data) if named else found


def _named(meshes: Sequence[Any], name: str, path: str, data: bytes) -> list[Any]:
    """Return the meshes that have a name in their file, by itself or by that of their node or geometry.

    Raises:
        ValueError: There are none.
    """
    heads = [dict(_KEY.findall(head.decode(errors="replace"))) for head in re.findall(rb"<geometry\b[^>]*>", data)]
    ids = {name, *(head.get("id", "") for head in heads if head.get("name") == name)}
    called = [{_NUMBER.sub("", str(mesh.metadata.get(key, ""))) for key in ("name", "node")} for mesh in meshes]
    called = [each | {str(mesh.metadata.get("name", ""))} for each, mesh in zip(called, meshes, strict=True)]
    found = [mesh for mesh, names in zip(meshes, called, strict=True) if names & ids]
    if not found:
        own = {head["name"] for head in heads if head.get("name")}
        known = sorted(own or {each for names in called for each in names if each})
        raise ValueError(
            Sentence(
                "'{path}' has no mesh '{name}'; its meshes are {known}", path, name[:60], ", ".join(known[:8])[:200]
            )
        )
    return found


def _upright(path: str, data: bytes, ending: str, *, up_axis: bool) -> Array:
    """Return the rotation and scale that a file's own units and axes need, shape (3, 3)."""
    if ending in Y_UP:
        return _UPRIGHT["Y"]
    if ending != ".dae":
        return np.eye(3)
    try:
        text = checked_xml(data)
    except RefusedXmlError as error:
        raise ValueError(Sentence("'{path}' {error}", path, error)) from None
    unit, up = _UNIT.search(text), _UP.search(text)
    scale = float(unit[1]) if unit else 1.0
    if not 1e-6 < scale < 1e6:
        raise ValueError(
            Sentence("'{path}' cannot be read as a mesh: its unit is {scale:g} m; correct it", path, scale)
        )
    return np.asarray(scale * _UPRIGHT[up[1] if up and up_axis else "Z"])


@dataclass(frozen=True, slots=True)
class _Beside:
    """Gives trimesh the files that a mesh names; it leaves out those that are missing."""

    read: Callable[[str], bytes]

    def get(self, name: str) -> bytes:
        """Return a file by its name in the mesh."""
        return self.read(name.removeprefix("file://").replace("\\", "/"))

    __getitem__ = get


def _look(mesh: Any) -> tuple[tuple[float, float, float, float] | None, Any]:
    """Return the colour of a mesh, and its picture."""
    material = getattr(mesh.visual, "material", None)
    picture = getattr(material, "image", None) or getattr(material, "baseColorTexture", None)
    if picture is not None and (getattr(mesh.visual, "uv", None) is None or max(picture.size) <= NO_PICTURE):
        picture = None
    colour = getattr(mesh.visual if material is None else material, "main_color", None)
    if colour is None or (material is None and not mesh.visual.defined):
        return None, picture
    red, green, blue, alpha = (round(float(value) / 255.0, 4) for value in colour)
    return (red, green, blue, alpha or 1.0), picture


def _part(meshes: Sequence[Any], *, pictures: bool) -> MeshPart:
    """Return meshes of one look as a part."""
    rgba, picture = _look(meshes[0])
    if picture is None:
        return _plain([mesh.triangles for mesh in meshes], rgba)
    from mjsim.models.picture_pixels import encode_png

    image = picture.convert("RGB")
    image.thumbnail((MAX_SIDE, MAX_SIDE))
    pixels = np.asarray(image)
    if not pictures or sum(len(mesh.faces) for mesh in meshes) > MAX_TRIANGLES:
        red, green, blue = (round(float(value) / 255.0, 4) for value in pixels.reshape(-1, 3).mean(axis=0))
        return replace(_plain([mesh.triangles for mesh in meshes], (red, green, blue, 1.0)), bare=True)
    return MeshPart(_obj(meshes), rgba, encode_png(pixels))


def _plain(triangles: Sequence[Array], rgba: tuple[float, float, float, float] | None) -> MeshPart:
    """Return triangles as a part without a texture."""
    whole = np.concatenate(triangles)
    fewer = coarser(whole)
    return MeshPart(stl(fewer), rgba, coarser=len(fewer) < len(whole))


def _speck(triangles: Array) -> Array:
    """Return four triangles that give a flat mesh volume: a speck in its middle, shape (4 or 0, 3, 3)."""
    corners = triangles.reshape(-1, 3)
    volume = np.linalg.det(triangles - corners.mean(axis=0)).sum() / 6.0
    if abs(volume) > FLAT * np.ptp(corners, axis=0).max() ** 3:
        return np.zeros((0, 3, 3))
    return np.asarray(speck_tips(corners)[list(SPECK_FACES)])


def speck_tips(corners: Array) -> Array:
    """Return the corners of a speck in the middle of others, shape (4, 3)."""
    side = max(SPECK * np.ptp(corners, axis=0).max(), MIN_SPECK)
    return np.asarray(corners.mean(axis=0) + side * np.vstack([np.zeros(3), np.eye(3)]))


def _obj(meshes: Sequence[Any]) -> bytes:
    """Return meshes as an OBJ with texture coordinates."""
    lines, first = [], 1
    for mesh in meshes:
        lines += [f"v {x:.7g} {y:.7g} {z:.7g}" for x, y, z in mesh.vertices]
        # The last part also holds meshes beyond the limit, some without texture coordinates.
        places = getattr(mesh.visual, "uv", None)
        lines += [
            f"vt {u:.6g} {v:.6g}" for u, v in (np.zeros((len(mesh.vertices), 2)) if places is None else places[:, :2])
        ]
        lines += [f"f {a}/{a} {b}/{b} {c}/{c}" for a, b, c in (mesh.faces + first).tolist()]
        first += len(mesh.vertices)
    for triangle in _speck(np.concatenate([mesh.triangles for mesh in meshes])):
        lines += [f"v {x:.7g} {y:.7g} {z:.7g}" for x, y, z in triangle]
        lines.append(f"f {first}/1 {first + 1}/1 {first + 2}/1")
        first += 3
    return "\n".join(lines).encode()


def stl(triangles: Array) -> bytes:
    """Return triangles, shape (n, 3, 3) [m], as a binary STL."""
    records = np.zeros(len(triangles), dtype=_RECORD)
    records["corners"] = triangles
    return b"".ljust(_HEAD) + len(triangles).to_bytes(4, "little") + records.tobytes()


def is_small_stl(data: bytes) -> bool:
    """Return whether a file is a binary STL that needs no simplification."""
    count = int.from_bytes(data[_HEAD : _HEAD + 4], "little")
    return count <= MAX_TRIANGLES and len(data) == _HEAD + 4 + count * _RECORD.itemsize


def with_volume(data: bytes) -> bytes:
    """Return a binary STL, with a speck in its middle if it is flat: MuJoCo requires a volume."""
    count = int.from_bytes(data[_HEAD : _HEAD + 4], "little")
    if not count or not is_small_stl(data):
        return data
    corners = np.frombuffer(data, _RECORD, count, _HEAD + 4)["corners"].astype(float)
    speck = _speck(corners) if np.isfinite(corners).all() else corners[:0]
    return stl(np.concatenate([corners, speck])) if len(speck) else data


def coarser(triangles: Array) -> Array:
    """Return at most `MAX_TRIANGLES` triangles, with corners merged per cell if there are more, shape (m, 3, 3)."""
    cells = float(MAX_CELLS)
    while len(triangles) > MAX_TRIANGLES:
        triangles = _merged(triangles, cells)
        cells *= COARSENING_RATIO
    return triangles


def _merged(triangles: Array, cells: float) -> Array:
    """Return triangles with corners merged per cell, without those of zero area, shape (m, 3, 3)."""
    corners = triangles.reshape(-1, 3)
    size = max(float(np.ptp(corners, axis=0).max()) / cells, 1e-12)
    keys = np.floor((corners - corners.min(axis=0)) / size).astype(np.int64)
    _, owners = np.unique(keys, axis=0, return_inverse=True)
    owners = owners.ravel()
    counts = np.bincount(owners)
    middles = np.column_stack([np.bincount(owners, weights=corners[:, axis]) / counts for axis in range(3)])
    faces = owners.reshape(-1, 3)
    whole = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return np.asarray(middles[np.unique(faces[whole], axis=0)])
