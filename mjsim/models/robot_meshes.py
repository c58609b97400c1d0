"""Meshes of a URDF in formats that MuJoCo does not read, and shapes whose mesh is left out."""

import copy
import posixpath
from collections.abc import Callable, Collection
from xml.etree.ElementTree import Element, SubElement

from mjsim.models.mesh_files import MeshPart, alone, mesh_parts, whole_mesh, with_volume
from mjsim.models.model_sources import PlainFile
from mjsim.models.proven import guarded_parts

FOREIGN_MESHES = (".dae", ".gltf", ".glb")
"""Formats that MuJoCo does not read."""
MADE = "made://"
"""Prefix of the names of generated files."""


class PlainMeshes:
    """Converts the other meshes of a URDF for MuJoCo: a shape for each colour or texture of a visual one."""

    def __init__(
        self,
        read: Callable[[str], bytes],
        failed: Callable[[str, ValueError], str],
        *,
        guarded: bool = False,
        up_axis: bool = True,
    ) -> None:
        """Store functions.

        Args:
            read: Returns a file by its name in the description.
            failed: Takes the name of a mesh that cannot be read, and returns its replacement.
            up_axis: Whether Collada is turned as its `<up_axis>` says.
            guarded: Whether to call the guarded reader, which reads no textures; otherwise this runs in it.
        """
        self._read, self._failed, self._guarded, self._up_axis = read, failed, guarded, up_axis
        self._known: dict[tuple[str, bool], list[MeshPart]] = {}
        self._names: dict[bytes, str] = {}
        self.made: dict[str, PlainFile] = {}
        """Name in the text -> the file."""
        self.coarser: set[str] = set()
        """Meshes that were simplified."""
        self.bare: set[str] = set()
        """Meshes whose pictures and material files are not read."""
        self.absent: set[str] = set()
        """Files that meshes name and that do not exist."""

    def put_into(self, root: Element) -> None:
        """Replace the shapes of a URDF that have such meshes."""
        folder = next((own.get("meshdir", "") for own in root.findall("mujoco/compiler")), "")
        coloured = {item.get("name") for item in root.findall("material") if item.find("color") is not None}
        for link in root.iter("link"):
            for shape in [*link.findall("visual"), *link.findall("collision")]:
                mesh = shape.find("geometry/mesh")
                name = "" if mesh is None else mesh.get("filename", "")
                if mesh is None or not self._is_foreign(name, seen=shape.tag == "visual"):
                    continue
                try:
                    parts = self._parts(posixpath.join(folder, name) if "://" not in name else name, shape, coloured)
                except ValueError as error:
                    mesh.set("filename", self._failed(name, error))
                    continue
                place = list(link).index(shape)
                link[place : place + 1] = [self._shape(shape, part, name) for part in parts]

    def _is_foreign(self, name: str, *, seen: bool) -> bool:
        """Return whether a mesh is to be replaced: for its format, or as an OBJ with colours."""
        if name.lower().endswith(FOREIGN_MESHES):
            return True
        if not (seen and name.lower().endswith(".obj")):
            return False
        try:
            return b"mtllib" in self._read(name)[:20_000]
        except ValueError:
            return False

    def _parts(self, name: str, shape: Element, coloured: Collection[str | None]) -> list[MeshPart]:
        """Return the parts of a mesh: a single one for a collision shape, or a shape that has a colour in the URDF."""
        material = shape.find("material")
        own = material is not None and (material.find("color") is not None or material.get("name") in coloured)
        whole = shape.tag == "collision" or own
        if (name, whole) not in self._known:
            folder = posixpath.dirname(name)

            absent: set[str] = set()

            def beside(other: str) -> bytes:
                try:
                    return self._read(posixpath.join(folder, other))
                except ValueError:
                    absent.add(other)
                    raise

            data = self._read(name)
            if self._guarded:
                parts = guarded_parts(name, data, whole=whole)
            else:
                up = self._up_axis
                parts = (
                    [whole_mesh(name, data, beside, up_axis=up)]
                    if whole
                    else mesh_parts(name, data, beside, up_axis=up)
                )
            self._known[name, whole] = parts
            self.absent |= absent
            if any(part.coarser for part in parts):
                self.coarser.add(name)
            if any(part.bare for part in parts) and self._guarded:
                self.bare.add(name)
        return self._known[name, whole]

    def plain(self, path: str, data: bytes) -> bytes:
        """Return an STL in the form and size that MuJoCo takes; raises ValueError if it cannot be read."""
        part = guarded_parts(path, data, whole=True)[0] if self._guarded else whole_mesh(path, data, alone)
        if part.coarser:
            self.coarser.add(path)
        return part.data

    def _shape(self, shape: Element, part: MeshPart, name: str) -> Element:
        """Return a shape with a part of its mesh."""
        made = copy.deepcopy(shape)
        mesh = made.find("geometry/mesh")
        assert mesh is not None
        stem = posixpath.splitext(posixpath.basename(name))[0]
        data = part.data if part.texture is not None else with_volume(part.data)
        mesh.set("filename", self._named(stem, part.ending, data))
        if part.rgba is not None or part.texture is not None:
            for old in made.findall("material"):
                made.remove(old)
            material = SubElement(made, "material", {"name": f"{stem}-{len(self.made)}"})
            SubElement(material, "color", {"rgba": " ".join(f"{value:g}" for value in part.rgba or (1, 1, 1, 1))})
            if part.texture is not None:
                SubElement(material, "texture", {"filename": self._named(stem, ".png", part.texture)})
        return made

    def _named(self, stem: str, ending: str, data: bytes) -> str:
        if data not in self._names:
            name = self._names[data] = f"{MADE}{stem}-{len(self.made)}{ending}"
            self.made[name] = PlainFile(name.removeprefix(MADE), data)
        return self._names[data]


def without_shapes(root: Element, missing: Collection[str]) -> None:
    """Remove URDF shapes whose mesh is left out; a link without visual shapes shows its collision shapes."""
    for material in root.iter("material"):
        for texture in material.findall("texture"):
            if texture.get("filename") in missing:
                material.remove(texture)
    for link in root.iter("link"):
        visuals = link.findall("visual")
        for shape in [*visuals, *link.findall("collision")]:
            mesh = shape.find("geometry/mesh")
            geometry = shape.find("geometry")
            if (mesh is not None and mesh.get("filename") in missing) or geometry is None or not len(geometry):
                link.remove(shape)
        if visuals and link.find("visual") is None:
            link.extend(_visual_of(shape, visuals[0].find("material")) for shape in link.findall("collision"))


def _visual_of(shape: Element, material: Element | None) -> Element:
    """Return the visual shape for a collision shape."""
    seen = copy.deepcopy(shape)
    seen.tag = "visual"
    if name := shape.get("name"):
        seen.set("name", f"{name}-seen")
    if material is not None and seen.find("material") is None:
        seen.append(copy.deepcopy(material))
    return seen
