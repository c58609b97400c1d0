"""Reads an MJCF or URDF file and all files that it names into one XML tree and a set of files in memory.

Only what makes up an object is kept: bodies, joints, geoms, inertias, meshes, textures and materials. Actuators,
sensors, options and the like are dropped, so that an object from any source cannot affect the world around it;
indispensable features that are not supported, such as plugins, are rejected. Files are read only through the given
function.
"""

import posixpath
from collections.abc import Callable, Mapping, Set
from dataclasses import dataclass
from xml.etree import ElementTree

from mjsim.models.mesh_sizes import check_mesh
from mjsim.models.picture_sizes import picture_size
from mjsim.models.proven import digest
from mjsim.models.sdf import mjcf_of_sdf
from mjsim.models.urdf_objects import keep_urdf
from mjsim.models.xml_text import RefusedXmlError
from mjsim.models.xml_tree import FOREIGN, tree_of
from mjsim.sentences import Sentence

Read = Callable[[str], bytes]
"""Returns a file by its path relative to the folder of the world; raises ValueError."""
Element = ElementTree.Element

Sections = Mapping[str, Set[str]]
"""Sections of MJCF, and the elements kept in each."""

MAX_INCLUDES = 16
"""Maximum nesting of included files."""
MAX_GEOMS = 2000
MAX_BYTES = 100_000_000
"""Maximum size of all files of a model together [bytes]."""
MAX_XML = 8_000_000
"""Maximum size of all XML of a model together [bytes]."""
MAX_PIXELS = 100_000_000
"""Maximum number of pixels of all textures of a model together."""
CUBE_SIDES = 6
MESH_ENDINGS = (".obj", ".stl", ".msh")

_COMPILER = {
    *("angle", "autolimits", "balanceinertia", "boundinertia", "boundmass", "eulerseq", "inertiafromgeom"),
    "inertiagrouprange",
}
"""Settings of MuJoCo's compiler that affect the meaning of a file."""
THING: Sections = {
    "default": {"default", "geom", "joint", "mesh", "material"},
    "asset": {"mesh", "texture", "material"},
    "worldbody": {"body", "geom", "joint", "inertial", "frame", "replicate"},
    "contact": {"exclude"},
}
"""Parts of MJCF that make up an object, and the elements kept in them."""
_SERVOS = {"general", "motor", "position", "velocity", "intvelocity", "damper"}
ROBOT: Sections = {
    **THING,
    "default": {*THING["default"], *_SERVOS, "site", "camera", "equality", "tendon"},
    "worldbody": {*THING["worldbody"], "site", "camera"},
    "actuator": _SERVOS,
    "equality": {"connect", "weld", "joint"},
    "tendon": {"fixed", "spatial", "joint", "geom", "site", "pulley"},
}
"""Parts of MJCF that make up a robot with its own servos, and the elements kept in them."""
_REFUSED = {
    "extension": "plugins",
    "plugin": "plugins",
    "attach": "another model",
    "composite": "a composite",
    "flexcomp": "soft parts",
    "flex": "soft parts",
    "hfield": "a height field",
}
"""Features that no object may have, with their names in messages."""
_INSTEAD = {"attach": "write both as one file, mujoco.MjSpec.from_file(FILE).to_xml()"}
"""Advice on what to use instead."""


@dataclass(frozen=True, slots=True)
class ModelFiles:
    """A model in memory, as MuJoCo reads it."""

    root: Element
    """Tree of <mujoco> or <robot>; read-only."""
    assets: dict[str, bytes]
    """Meshes and textures by their names in the tree."""
    paths: tuple[str, ...]
    """All files, the model's own first, as paths relative to the folder of the world."""
    sums: frozenset[str] = frozenset()
    """SHA-256 of each file."""

    @property
    def urdf(self) -> bool:
        """Whether it is URDF; otherwise it is MJCF."""
        return self.root.tag == "robot"


@dataclass(frozen=True, slots=True, eq=False)
class PlainFile:
    """A mesh or a texture that MuJoCo reads."""

    path: str
    data: bytes


def gather_model(path: str, read: Read, *, sections: Sections = THING) -> ModelFiles:
    """Return a model with all files that it names.

    Args:
        path: The MJCF or URDF file.
        read: Returns files.
        sections: Sections of MJCF that are kept.

    Raises:
        ValueError: A file does not exist, is invalid, or is too large; the message names it.
    """
    gatherer = Gatherer(path, read)
    root = gatherer.parse(path)
    gatherer.keep(root, sections)
    return ModelFiles(root, gatherer.assets, tuple(gatherer.paths), frozenset(gatherer.sums))


class Gatherer:
    """Reads the files of one model and enforces the limits."""

    def __init__(self, path: str, read: Read) -> None:
        self._path, self._folder, self._read = path, posixpath.dirname(path), read
        self._elements, self._bytes, self._xml, self._pixels = 0, 0, 0, 0
        self._flat: dict[str, str] = {}
        self.assets: dict[str, bytes] = {}
        self.paths: list[str] = []
        self.sums: set[str] = set()

    def parse(self, path: str) -> Element:
        """Return the root of an XML file."""
        data = self.file(path)
        self._xml += len(data)
        if self._xml > MAX_XML:
            raise _fault("'{path}' has more than {max_xml} MB of XML; make it simpler", self._path, MAX_XML // 10**6)
        try:
            root, self._elements = tree_of(path, data, self._elements)
        except ElementTree.ParseError as error:
            raise _fault("'{path}' is not XML: {error}; correct it", path, error) from None
        except RefusedXmlError as error:
            raise _fault("'{path}' {error}", path, error) from None
        root.tag = root.tag.removeprefix(FOREIGN)
        return root

    def file(self, path: str) -> bytes:
        """Return a file of the model, and count its size."""
        data = self._read(path)
        if path not in self.paths:
            self._bytes += len(data)
            self.paths.append(path)
            self.sums.add(digest(data))
        if self._bytes > MAX_BYTES:
            raise _fault(
                "the files of '{path}' have more than {max_bytes} MB; make them smaller", self._path, MAX_BYTES // 10**6
            )
        return data

    def keep(self, root: Element, sections: Sections) -> None:
        """Keep only given sections of a model, and read the files that it names."""
        if root.tag == "mujoco":
            self.keep_mjcf(root, sections)
        elif root.tag == "robot":
            self.keep_urdf(root)
        elif root.tag == "sdf" and sections is THING:
            made = mjcf_of_sdf(root, self._path)
            root.clear()
            root.tag = made.tag
            root.extend(made)
            self.keep_mjcf(root, sections)
        else:
            path, tag = self._path, root.tag
            raise _fault(
                "'{path}' begins with <{tag}>; a model begins with <mujoco> (MJCF) or <robot> (URDF)", path, tag
            )

    def keep_mjcf(self, root: Element, sections: Sections) -> None:
        """Keep the given sections of MJCF."""
        self.put_includes_in(root, 0)
        for element in root.iter():
            if element.tag in _REFUSED:
                instead = _INSTEAD.get(element.tag, "make it of geoms")
                raise _fault(
                    "'{path}' has {refused} (<{tag}>); {instead}",
                    self._path,
                    _REFUSED[element.tag],
                    element.tag,
                    instead,
                )
        compilers = [dict(section.attrib) for section in root.findall("compiler")]
        settings = {key: value for compiler in compilers for key, value in compiler.items()}
        reduced = ElementTree.Element("mujoco")
        ElementTree.SubElement(reduced, "compiler", {key: settings[key] for key in settings if key in _COMPILER})
        for section in root:
            if section.tag in sections:
                _keep(section, sections[section.tag])
                reduced.append(section)
        worlds = reduced.findall("worldbody")
        for world in worlds:
            reduced.remove(world)
        # A geom directly in the file's world has mass only as part of a body.
        body = ElementTree.SubElement(ElementTree.SubElement(reduced, "worldbody"), "body")
        for world in worlds:
            world.tag, world.attrib = (
                "frame",
                {key: world.attrib[key] for key in ("childclass",) if key in world.attrib},
            )
            body.append(world)
        _check_count(self._path, _geoms_in(body))
        self._take_assets(reduced, settings)
        root.clear()
        root.extend(reduced)

    def put_includes_in(self, element: Element, depth: int) -> None:
        """Replace each <include file=.../> by the contents of the file."""
        if depth > MAX_INCLUDES:
            raise _fault(
                "'{path}' includes files more than {max_includes} deep; is it a loop?", self._path, MAX_INCLUDES
            )
        for index, child in reversed(list(enumerate(element))):
            if child.tag != "include":
                self.put_includes_in(child, depth)
                continue
            name = child.get("file", "")
            try:
                included = self.parse(self._resolved(name))
            except ValueError as error:
                raise _fault("'{path}' includes '{name}': {error}", self._path, name, error) from None
            self.put_includes_in(included, depth + 1)
            element[index : index + 1] = list(included)

    def _take_assets(self, root: Element, settings: dict[str, str]) -> None:
        both, strip = settings.get("assetdir", ""), settings.get("strippath") == "true"
        folders = {"mesh": settings.get("meshdir", both), "texture": settings.get("texturedir", both)}
        for item in root.iter():
            if item.tag not in folders:
                continue
            self._check_builtin(item)
            item.attrib.pop("content_type", None)
            named = [key for key in item.attrib if key.startswith("file")]
            if named and item.tag == "texture":
                # MuJoCo goes by the ending of the name, and reads no JPEG; it gets all pictures as PNG.
                item.set("content_type", "image/png")
            for key in named:
                name = item.attrib[key]
                if "name" not in item.attrib and key == "file":
                    item.set("name", posixpath.splitext(posixpath.basename(name))[0])
                name = posixpath.basename(name) if strip else name
                item.set(key, self.asset(posixpath.join(folders[item.tag], name), item.tag))

    def asset(self, name: str, kind: str, *, variant: str = "") -> str:
        """Read a mesh or a texture; return its name in the text."""
        path = self._resolved(name)
        if path + variant in self._flat:
            return self._flat[path + variant]
        if kind == "mesh" and not path.lower().endswith(MESH_ENDINGS):
            raise _fault("'{path}' names the mesh '{name}'; convert it to OBJ or STL", self._path, name)
        return self.store(PlainFile(path, self.file(path)), kind, variant)

    def store(self, file: "PlainFile", kind: str, variant: str) -> str:
        """Keep a mesh or a texture; return its name in the text."""
        path, data = file.path, file.data
        if path + variant in self._flat:
            return self._flat[path + variant]
        if kind == "mesh":
            check_mesh(path, data)
        if kind == "texture":
            try:
                width, height = picture_size(data)
            except ValueError as error:
                raise _fault("'{path}' {error}", path, error) from None
            self._count_pixels(width * height)
        flat = self._flat[path + variant] = f"{len(self._flat)}-{posixpath.basename(path)}"
        self.assets[flat] = data
        return flat

    def _check_builtin(self, item: Element) -> None:
        """Check the size of a texture generated by MuJoCo."""
        if "builtin" not in item.attrib:
            return
        if item.tag == "mesh":
            raise _fault("'{path}' has a mesh generated by MuJoCo (builtin); name an OBJ or STL file", self._path)
        width, height = (item.get(key, "0") for key in ("width", "height"))
        if not all(size.isdecimal() and len(size) < 10 for size in (width, height)):
            raise _fault(
                "'{path}' has a texture of {width} x {height} pixels; give whole numbers", self._path, width, height
            )
        # All faces of a cube have the size given by its width.
        self._count_pixels(int(width) * max(int(height), int(width) * CUBE_SIDES))

    def _count_pixels(self, count: int) -> None:
        self._pixels += count
        if self._pixels > MAX_PIXELS:
            limit = MAX_PIXELS // 10**6
            raise _fault(
                "the textures of '{path}' have more than {limit} megapixels; make them smaller", self._path, limit
            )

    def _resolved(self, name: str) -> str:
        """Return the path of a file that the model names; it must not leave the folder of the world."""
        if name.startswith("package://"):
            return self._packaged(name)
        path = posixpath.normpath(posixpath.join(self._folder, name.removeprefix("file://")))
        if not name or path.startswith(("/", "..")) or "\\" in name:
            raise _fault(
                "'{path}' names the file '{name}'; keep it beside the model and name it from there", self._path, name
            )
        return path

    def _packaged(self, name: str) -> str:
        """Return the path of 'package://NAME/REST': below a folder NAME around the model, or any folder around it."""
        package, _, rest = name.removeprefix("package://").partition("/")
        around = [self._folder]
        while around[-1]:
            around.append(posixpath.dirname(around[-1]))
        likely = [base for base in around if posixpath.basename(base) == package]
        for base in [*likely, *(posixpath.join(base, package) for base in around), *around]:
            path = posixpath.normpath(posixpath.join(base, rest))
            if not path.startswith(("/", "..")) and self._exists(path):
                return path
        raise _fault(
            "'{path}' names '{name}', which is not found from any folder that contains the model; put it in one",
            self._path,
            name,
        )

    def _exists(self, path: str) -> bool:
        try:
            self._read(path)
        except ValueError:
            return False
        return True

    def keep_urdf(self, root: Element) -> None:
        """Keep the parts of a URDF that make up an object."""
        keep_urdf(root, self.asset)
        _check_count(self._path, sum(item.tag in ("link", "visual", "collision") for item in root.iter()))


def _keep(element: Element, tags: Set[str]) -> None:
    """Remove elements except of some kinds, recursively."""
    for child in list(element):
        # The world file states whether it can be pushed.
        if child.tag in tags and not (child.tag == "joint" and child.get("type") == "free"):
            _keep(child, tags)
            for key in ("mocap", "gravcomp", "sleep", "user", "plugin"):
                child.attrib.pop(key, None)
        else:
            element.remove(child)


def _geoms_in(element: Element) -> int:
    """Return the number of geoms in an element, counting those in <replicate> as often as it repeats them."""
    count = sum(map(_geoms_in, element)) + (element.tag == "geom")
    if element.tag == "replicate":
        text = element.get("count", "0")
        return max(count, 1) * (int(text) if text.isdecimal() and len(text) < 10 else 10**9)
    return count


def _check_count(path: str, count: int) -> None:
    if count > MAX_GEOMS:
        raise _fault("'{path}' has {count} parts; it must have at most {max_geoms}", path, count, MAX_GEOMS)


def _fault(template: str, *values: object) -> ValueError:
    """Return the error of a `Sentence`."""
    return ValueError(Sentence(template, *values))
