"""Reads worlds and models of Gazebo: SDF 1.4 to 1.12, with included models.

References:
    SDFormat specification 1.12, http://sdformat.org/spec
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath
from xml.etree.ElementTree import Element

import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.bounded_file import read_bounded
from mjsim.exchange.scenes.scene_meshes import MeshFiles, MeshName
from mjsim.exchange.scenes.scene_solids import ON_ROBOTS, Light, Scene, SceneSkin, SceneSolid, SceneThing
from mjsim.exchange.scenes.sdf_files import Folders
from mjsim.exchange.scenes.sdf_joints import SdfLink, trees_of
from mjsim.exchange.scenes.sdf_looks import MAX_PICTURE, SdfLooks
from mjsim.exchange.scenes.sdf_state import restore
from mjsim.geometry import Array
from mjsim.inventory import Fate
from mjsim.models import SdfFrames, color_of, floats, has_joint_frames, is_robot, mesh_of, sizes_of

MAX_INCLUDES = 12
"""Maximum nesting of included models."""
USUAL_MASS = 1.0
"""Mass of a link without one, as SDF defines [kg]."""
GROUND, SUN = ("ground_plane", "ground plane"), ("sun",)
"""Models of Gazebo that a world of mjsim has anyway."""
_TRUE = ("true", "1")


def read_sdf(path: Path, *, search: list[Path]) -> Scene:
    """Return the scene of an SDF file: of its first world, or of its models.

    Args:
        path: The file.
        search: Further folders with folders of models.

    Raises:
        UsageError: The file cannot be read, or is not valid SDF.
    """
    folders = Folders(path, search)
    root = folders.read(path)
    if root.tag not in ("sdf", "gazebo"):
        raise UsageError(f"'{path}' begins with <{root.tag[:40]}>; a scene of Gazebo begins with <sdf>")
    worlds = root.findall("world")
    reader = _Reader(path, folders)
    for other in worlds[1:]:
        reader.scene.tell(Fate.LEFT_OUT, "world", other.get("name", ""), "a file gives one world, its first")
    reader.world(worlds[0] if worlds else root)
    return reader.scene


@dataclass(frozen=True, slots=True, eq=False)
class _Outer:
    """The parent of a model or an include: the world, or a model."""

    frames: SdfFrames
    world_from_outer: Array
    """Shape (4, 4) [m]."""
    file: Path
    name: str = ""
    """Empty for the world."""
    static: bool = False
    alone: bool = False
    """Whether it contains only one include, which then has its name."""
    depth: int = 0


class _Reader:
    """Collects the scene of one file."""

    def __init__(self, path: Path, folders: Folders) -> None:
        self.scene, self._path, self._folders = Scene(), path, folders
        self._meshes = MeshFiles(self.scene)
        self._looks = SdfLooks(self.scene, folders)
        self._in_joint = has_joint_frames(folders.read(path))

    def world(self, world: Element) -> None:
        """Take the models, lights and includes of a world, or of a file without one."""
        restore(world, self.scene, self._placed)
        frames = self._frames(world, self._path)
        for child in world:
            if child.tag in ("model", "include"):
                self._model(child, _Outer(frames, np.eye(4), self._path))
            elif child.tag == "light":
                self._light(child, frames, np.eye(4))
            elif child.tag in ("actor", "road", "population"):
                self.scene.tell(Fate.LEFT_OUT, child.tag, child.get("name", ""), "mjsim does not support it")

    def _frames(self, element: Element, file: Path) -> SdfFrames:
        def inner(child: Element) -> SdfFrames | None:
            found = self._opened(child, file)
            return None if found is None else self._frames(*found)

        return SdfFrames(element, str(self._path), inner)

    def _placed(self, element: Element) -> tuple[Element, SdfFrames] | None:
        """Return the model in an element of the world, and its frames."""
        found = self._opened(element, self._path)
        return None if found is None else (found[0], self._frames(*found))

    def _opened(self, element: Element, file: Path) -> tuple[Element, Path] | None:
        """Return the model in an element, which may include a file, and its file; None if it cannot be read."""
        if element.tag == "model":
            return element, file
        if element.tag != "include":
            return None
        uri = (element.findtext("uri") or "").strip()
        place = self._folders.find(uri, file.parent)
        if place is None:
            return None
        inner = self._folders.model_file(place)
        root = self._folders.read(inner)
        model = root if root.tag == "model" else root.find("model")
        return None if model is None else (model, inner)

    def _model(self, element: Element, outer: "_Outer") -> None:
        """Take a model or an include."""
        if outer.depth > MAX_INCLUDES:
            raise UsageError(f"'{self._path}' nests models more than {MAX_INCLUDES} deep; is it a loop?")
        if element.tag == "include" and self._is_stock(element):
            return
        found = self._opened(element, outer.file)
        uri = (element.findtext("uri") or "").strip()
        if found is None:
            self.scene.tell(Fate.LEFT_OUT, "model", uri or element.get("name", ""), _why_missing(uri))
            return
        model, inner_file = found
        own = (element.findtext("name") or "").strip() or element.get("name") or model.get("name") or "model"
        name = f"{outer.name}::{own}" if outer.name and not outer.alone else outer.name or own
        bare = element.tag == "include" and element.find("pose") is None
        placed = model if bare else element
        world_from_model = outer.world_from_outer @ outer.frames.pose_of(placed)
        static = outer.static or _is_true(element.find("static")) or _is_true(model.find("static"))
        if not static and is_robot(model):
            self._robot(name, world_from_model)
            return
        for sensor in model.findall("link/sensor"):
            label = f"{name}::{sensor.get('name', '')}"
            self.scene.tell(Fate.LEFT_OUT, f"{sensor.get('type', '')} sensor".strip(), label, ON_ROBOTS)
        frames = self._frames(model, inner_file)
        self._links(model, frames, world_from_model, inner_file, name, static=static)
        alone = len([child for child in model if child.tag in ("include", "model", "link")]) == 1
        inner = _Outer(frames, world_from_model, inner_file, name, static, alone, outer.depth + 1)
        for child in model:
            if child.tag in ("model", "include"):
                self._model(child, inner)
            elif child.tag == "light":
                self._light(child, frames, world_from_model)

    def _is_stock(self, element: Element) -> bool:
        """Return whether an include is the ground or the sun of Gazebo."""
        last = (element.findtext("uri") or "").strip().rstrip("/").rpartition("/")[2].lower()
        return last in GROUND or last in SUN

    def _robot(self, name: str, world_from_robot: Array) -> None:
        x, y, heading = world_from_robot[0, 3], world_from_robot[1, 3], math.atan2(*world_from_robot[[1, 0], 0])
        self.scene.starts.append((float(x), float(y), heading))
        why = "its start is kept; import it with mjsim new --robot-from"
        self.scene.tell(Fate.LEFT_OUT, "robot", name, why)

    def _links(
        self, model: Element, frames: SdfFrames, world_from_model: Array, file: Path, name: str, *, static: bool
    ) -> None:
        """Add the links of a model as one thing, with the parts that joints move."""
        links, bare = [], 0
        for link in model.findall("link"):
            found = list(self._solids(link, frames, world_from_model, file, name))
            skins = self._skins(link, frames, world_from_model, file, name) if found else []
            touched = len(link.findall("collision"))
            shown = sum(visual.find("geometry/mesh") is None or not skins for visual in link.findall("visual"))
            bare += touched == 0 and shown > 0
            if shown > touched > 0:
                why = f"{shown - touched} more than collision shapes; only the latter are used"
                self.scene.tell(Fate.LEFT_OUT, "visible part of a link", f"{name}::{link.get('name', '')}", why)
            links.append(SdfLink(link.get("name", ""), found, _mass_of(link, name), skins))
        if bare:
            self.scene.tell(Fate.LEFT_OUT, "visible model part", name, "it has no collision shape")
        if static:
            solids = [solid for link in links for solid in link.solids]
            if solids:
                skins = [skin for link in links for skin in link.skins]
                self.scene.add(SceneThing(name, solids, world_from_model, skins=skins))
            return
        for tree in trees_of(model, links, frames, world_from_model, self.scene, in_joint=self._in_joint):
            solids = [solid for link in tree.links for solid in link.solids]
            mass = None if tree.held else max(sum(link.mass for link in tree.links), 1e-3)
            skins = [skin for link in tree.links for skin in link.skins]
            self.scene.add(SceneThing(name, solids, world_from_model, mass, tree.parts, skins))

    def _skins(
        self, link: Element, frames: SdfFrames, world_from_model: Array, file: Path, name: str
    ) -> list[SceneSkin]:
        """Return the visible parts of the meshes of a link that have no material in SDF."""
        found = []
        for visual in link.findall("visual"):
            shape = visual.find("geometry/mesh")
            if shape is None or self._looks.of_visual(visual, file, name)[0] is not None:
                continue
            uri, scale = mesh_of(shape, f"'{self._path}': {name}")
            place = self._folders.find(uri, file.parent)
            if place is None or not place.is_file():
                continue
            pose = world_from_model @ frames.pose_in(link, visual, f"'{self._path}': {name}")
            found += self._meshes.skins(_mesh_name(place, shape), np.array(scale), pose, self._beside(place))
        return found

    def _beside(self, mesh: Path) -> Callable[[str], bytes]:
        """Return a function that reads files that a mesh names."""

        def read(uri: str) -> bytes:
            place = self._folders.find(uri, mesh.parent) or self._folders.find(
                PurePosixPath(uri).name, mesh.parent.parent / "materials" / "textures"
            )
            if place is None:
                raise ValueError(f"no file '{uri}'")
            try:
                return read_bounded(place, limit=MAX_PICTURE, kind="a picture")
            except UsageError as error:
                raise ValueError(str(error)) from None

        return read

    def _solids(
        self, link: Element, frames: SdfFrames, world_from_model: Array, file: Path, name: str
    ) -> Iterator[SceneSolid]:
        """Yield the collision shapes of a link, with the looks of its visible shapes."""
        looks = [self._looks.of_visual(visual, file, name) for visual in link.findall("visual")]
        known = [look for look in looks if look != (None, None)]
        for number, part in enumerate(link.findall("collision")):
            geometry = part.find("geometry")
            if geometry is None or not len(geometry):
                self.scene.tell(Fate.LEFT_OUT, "collision", f"{name}::{part.get('name', '')}", "it has no shape")
            pose = world_from_model @ frames.pose_in(link, part, f"'{self._path}': {name}")
            color, texture = known[min(number, len(known) - 1)] if known else (None, None)
            if geometry is not None:
                for solid in self._shapes(geometry, pose, color, file, name):
                    yield replace(solid, texture=texture)

    def _shapes(self, geometry: Element, pose: Array, color: str | None, file: Path, name: str) -> Iterator[SceneSolid]:
        """Yield the solids of a geometry."""
        where = f"'{self._path}': {name}"
        for shape in geometry:
            sizes = sizes_of(shape, where)
            if sizes and not all(sizes):
                self.scene.tell(Fate.LEFT_OUT, shape.tag, name, "its size is 0")
            elif shape.tag in ("box", "sphere"):
                yield SceneSolid("box" if shape.tag == "box" else "sphere", tuple(sizes), pose, color)
            elif shape.tag in ("cylinder", "capsule", "cone"):
                radius, length = sizes
                if shape.tag != "cylinder":
                    self.scene.tell(Fate.GUESSED, shape.tag, name, "a cylinder of its size")
                length += 2.0 * radius if shape.tag == "capsule" else 0.0
                yield SceneSolid("cylinder", (radius, length), pose, color)
            elif shape.tag == "ellipsoid":
                self.scene.tell(Fate.GUESSED, shape.tag, name, "a box around it")
                yield SceneSolid("box", tuple(2.0 * radius for radius in sizes), pose, color)
            elif shape.tag == "mesh":
                yield from self._mesh(shape, pose, color, file, name)
            elif shape.tag == "polyline":
                yield from self._meshes.prisms(shape, pose, color, name, where)
            elif shape.tag == "plane":
                self._plane(shape, pose, name)
            elif shape.tag != "empty":
                self.scene.tell(Fate.LEFT_OUT, shape.tag, name, "no such shape in mjsim")

    def _mesh(self, shape: Element, pose: Array, color: str | None, file: Path, name: str) -> Iterator[SceneSolid]:
        uri, scale = mesh_of(shape, f"'{self._path}': {name}")
        place = self._folders.find(uri, file.parent)
        if place is None or not place.is_file():
            self.scene.tell(Fate.LEFT_OUT, "mesh", uri or name, _why_missing(uri))
            return
        yield from self._meshes.solids(_mesh_name(place, shape), np.array(scale), pose, color)

    def _plane(self, shape: Element, pose: Array, name: str) -> None:
        normal = pose[:3, :3] @ floats(shape.findtext("normal", "0 0 1"), 3, f"'{self._path}': {name}: normal")
        if normal[2] < 0.99 * np.linalg.norm(normal) or abs(pose[2, 3]) > 0.05:
            self.scene.tell(Fate.LEFT_OUT, "plane", name, "a world has one floor, at height 0")

    def _light(self, light: Element, frames: SdfFrames, world_from_outer: Array) -> None:
        name = light.get("name", "")
        if light.get("type") not in ("point", "spot"):
            if light.get("type") != "directional" or name.lower() not in SUN:
                self.scene.tell(Fate.LEFT_OUT, "directional light", name, "a world has ambient light and lamps")
            return
        if light.get("type") == "spot":
            self.scene.tell(Fate.GUESSED, "spot light", name, "a lamp that shines in all directions")
        where = f"'{self._path}': light '{name}'"
        place = (world_from_outer @ frames.pose_of(light))[:3, 3]
        reach = float(floats(light.findtext("attenuation/range", "10"), 1, f"{where}: range")[0])
        self.scene.lights.append(Light(name, place, color_of(light) or "#ffffff", reach))


def _mesh_name(place: Path, shape: Element) -> MeshName:
    """Return the mesh to which a `<mesh>` refers."""
    named = (shape.findtext("submesh/name") or "").strip()
    return MeshName(place, named, _is_true(shape.find("submesh/center")))


def _mass_of(link: Element, name: str) -> float:
    text = link.findtext("inertial/mass")
    return USUAL_MASS if text is None else abs(floats(text, 1, f"mass of {name}")[0])


def _is_true(element: Element | None) -> bool:
    return element is not None and (element.text or "").strip().lower() in _TRUE


def _why_missing(uri: str) -> str:
    """Return why a file that a scene names is missing, and what to do."""
    if not uri:
        return "it names no file; give it a <uri>"
    if uri.startswith(("http://", "https://")):
        return "nothing is fetched from the network; put the model beside the file and name it model://NAME"
    return "not found; put its folder beside the file, in 'models' there, or in a folder of GAZEBO_MODEL_PATH"
