"""A file of MJCF or URDF, and all that it names, as one tree of XML and its files in memory.

Only what makes a thing is kept: bodies, joints, geoms, inertias, meshes, textures and materials. Actuators, sensors,
options and the like are left out, so that a thing from anywhere can do nothing to the world around it; what it could
not be without, such as plugins, is refused. Nothing is read but through the function that is given.
"""

import posixpath
from collections.abc import Callable, Mapping, Set
from dataclasses import dataclass
from xml.etree import ElementTree

from mjsim.models.meshes import check_mesh
from mjsim.models.pictures import picture_size
from mjsim.models.prefixes import is_unbound, with_prefixes

Read = Callable[[str], bytes]
"""Returns a file by its path from the folder of the world, or raises ValueError."""
Element = ElementTree.Element

Sections = Mapping[str, Set[str]]
"""Sections of MJCF, and which elements are kept in each."""

MOST_ELEMENTS, DEEPEST = 20_000, 64
MOST_INCLUDES = 16
"""Files within files, one below the other."""
MOST_GEOMS = 2000
MOST_BYTES = 100_000_000
"""Of all files of a model together."""
MOST_XML = 8_000_000
"""Bytes of XML of a model together."""
MOST_PIXELS = 100_000_000
"""Of all textures of a model together."""
CUBE_SIDES = 6
FOREIGN = "foreign."
"""Before the tags of elements that are for other programs; nothing looks for such."""
MESH_ENDINGS = (".obj", ".stl", ".msh")

_COMPILER = {
    *("angle", "autolimits", "balanceinertia", "boundinertia", "boundmass", "eulerseq", "inertiafromgeom"),
    "inertiagrouprange",
}
"""Settings of MuJoCo's compiler that change what a file means."""
THING: Sections = {
    "default": {"default", "geom", "joint", "mesh", "material"},
    "asset": {"mesh", "texture", "material"},
    "worldbody": {"body", "geom", "joint", "inertial", "frame", "replicate"},
    "contact": {"exclude"},
}
"""Parts of MJCF that make a thing, and what is kept in them."""
_SERVOS = {"general", "motor", "position", "velocity", "intvelocity", "damper"}
ROBOT: Sections = {
    **THING,
    "default": {*THING["default"], *_SERVOS, "site", "camera", "equality", "tendon"},
    "worldbody": {*THING["worldbody"], "site", "camera"},
    "actuator": _SERVOS,
    "equality": {"connect", "weld", "joint"},
    "tendon": {"fixed", "spatial", "joint", "geom", "site", "pulley"},
}
"""Parts of MJCF that make a robot which moves by its own servos, and what is kept in them."""
_REFUSED = {
    "extension": "plugins",
    "plugin": "plugins",
    "attach": "another model",
    "composite": "a composite",
    "flexcomp": "soft parts",
    "flex": "soft parts",
    "hfield": "a height field",
}
"""What no thing may have, as errors call it."""
_INSTEAD = {"attach": "write both as one file, mujoco.MjSpec.from_file(FILE).to_xml()"}
"""What would be right in place of it."""
_URDF = {"link", "joint", "material"}
_URDF_COMPILER = {"boundinertia", "boundmass"}
"""Settings of a URDF's own element for MuJoCo that are kept: the least mass and inertia of what moves."""
_URDF_PARTS = {
    "link": {"inertial", "visual", "collision"},
    "joint": {"parent", "child", "origin", "axis", "limit", "dynamics"},
    "material": {"color"},
}


@dataclass(frozen=True, slots=True)
class ModelFiles:
    """A model as MuJoCo reads it, without a file system."""

    root: Element
    """The tree of <mujoco> or <robot>, to be read only."""
    assets: dict[str, bytes]
    """Meshes and textures by the names that the tree uses."""
    paths: tuple[str, ...]
    """All files, the model's own first, as paths from the folder of the world."""

    @property
    def urdf(self) -> bool:
        """Whether it is URDF, not MJCF."""
        return self.root.tag == "robot"


def gather_model(path: str, read: Read, *, sections: Sections = THING) -> ModelFiles:
    """Return a model with all files that it names.

    Args:
        path: Of the file of MJCF or URDF.
        read: Where files come from.
        sections: Of MJCF, what is kept.

    Raises:
        ValueError: A file does not exist, is not what it should be, or is too large; in a sentence that names it.
    """
    gatherer = Gatherer(path, read)
    root = gatherer.parse(path)
    gatherer.keep(root, sections)
    return ModelFiles(root, gatherer.assets, tuple(gatherer.paths))


class Builder(ElementTree.TreeBuilder):
    """Builds the tree of a file, and stops where it grows beyond all models."""

    def __init__(self, path: str, count: int) -> None:
        super().__init__()
        self._path, self._depth, self.count = path, 0, count

    def doctype(self, name: str, pubid: str | None, system: str | None) -> None:
        """Refuse: entities could stand for any amount of text."""
        raise ValueError(f"'{self._path}' declares a document type; leave <!DOCTYPE ...> out")

    def start(self, tag: str, attrs: dict[str, str]) -> Element:
        """Count, then begin an element."""
        self._depth += 1
        self.count += 1
        if self._depth > DEEPEST:
            raise ValueError(f"'{self._path}' is nested more than {DEEPEST} deep; make it flatter")
        if self.count > MOST_ELEMENTS:
            raise ValueError(f"'{self._path}' has more than {MOST_ELEMENTS} elements; make it simpler")
        if tag.startswith("{"):
            tag = self._foreign(*tag[1:].rsplit("}", 1))
        return super().start(tag, {name: value for name, value in attrs.items() if not name.startswith("{")})

    def _foreign(self, space: str, word: str) -> str:
        """Return a tag that nothing looks for; elements of xacro would change what the file means."""
        if space.endswith("xacro"):
            raise ValueError(f"'{self._path}' holds <{word}> of {space}; expand it")
        return f"{FOREIGN}{word}"

    def end(self, tag: str) -> Element:
        """End an element."""
        self._depth -= 1
        return super().end(tag)


def _tree(path: str, data: bytes, count: int) -> tuple[Element, int]:
    """Return the root of a file, and the number of elements with those that were counted before it."""
    builder = Builder(path, count)
    parser = ElementTree.XMLParser(target=builder)
    try:
        parser.feed(data)
        root: Element = parser.close()
    except ElementTree.ParseError as error:
        if is_unbound(error) and (bound := with_prefixes(data)) != data:
            return _tree(path, bound, count)
        raise
    return root, builder.count


class Gatherer:
    """Reads the files of one model and keeps count of them."""

    def __init__(self, path: str, read: Read) -> None:
        self._path, self._folder, self._read = path, posixpath.dirname(path), read
        self._elements, self._bytes, self._xml, self._pixels = 0, 0, 0, 0
        self._flat: dict[str, str] = {}
        self.assets: dict[str, bytes] = {}
        self.paths: list[str] = []

    def parse(self, path: str) -> Element:
        """Return the root of an XML file."""
        data = self.file(path)
        self._xml += len(data)
        if self._xml > MOST_XML:
            raise ValueError(f"'{self._path}' has more than {MOST_XML // 10**6} MB of XML; make it simpler")
        try:
            root, self._elements = _tree(path, data, self._elements)
        except ElementTree.ParseError as error:
            raise ValueError(f"'{path}' is not XML: {error}; correct it") from None
        root.tag = root.tag.removeprefix(FOREIGN)
        return root

    def file(self, path: str) -> bytes:
        """Return a file of the model, and count it."""
        data = self._read(path)
        if path not in self.paths:
            self._bytes += len(data)
            self.paths.append(path)
        if self._bytes > MOST_BYTES:
            raise ValueError(f"the files of '{self._path}' have more than {MOST_BYTES // 10**6} MB; make them smaller")
        return data

    def keep(self, root: Element, sections: Sections) -> None:
        """Keep of a model what is asked for, and take the files that it names."""
        if root.tag == "mujoco":
            self.keep_mjcf(root, sections)
        elif root.tag == "robot":
            self.keep_urdf(root)
        else:
            path, tag = self._path, root.tag
            raise ValueError(f"'{path}' begins with <{tag}>; a model begins with <mujoco> (MJCF) or <robot> (URDF)")

    def keep_mjcf(self, root: Element, sections: Sections) -> None:
        """Keep of MJCF what makes a thing, or whatever else is asked for."""
        self.put_includes_in(root, 0)
        for element in root.iter():
            if element.tag in _REFUSED:
                instead = _INSTEAD.get(element.tag, "make it of geoms")
                raise ValueError(f"'{self._path}' has {_REFUSED[element.tag]} (<{element.tag}>); {instead}")
        compilers = [dict(section.attrib) for section in root.findall("compiler")]
        settings = {key: value for compiler in compilers for key, value in compiler.items()}
        kept = ElementTree.Element("mujoco")
        ElementTree.SubElement(kept, "compiler", {key: settings[key] for key in settings if key in _COMPILER})
        for section in root:
            if section.tag in sections:
                _keep(section, sections[section.tag])
                kept.append(section)
        worlds = kept.findall("worldbody")
        for world in worlds:
            kept.remove(world)
        # What stands in the file's world weighs something only as part of a body.
        body = ElementTree.SubElement(ElementTree.SubElement(kept, "worldbody"), "body")
        for world in worlds:
            world.tag, world.attrib = (
                "frame",
                {key: world.attrib[key] for key in ("childclass",) if key in world.attrib},
            )
            body.append(world)
        _check_count(self._path, _geoms_in(body))
        self._take_assets(kept, settings)
        root.clear()
        root.extend(kept)

    def put_includes_in(self, element: Element, depth: int) -> None:
        """Replace each <include file=.../> by what the file holds."""
        if depth > MOST_INCLUDES:
            raise ValueError(f"'{self._path}' includes files more than {MOST_INCLUDES} deep; is it a loop?")
        for index, child in reversed(list(enumerate(element))):
            if child.tag != "include":
                self.put_includes_in(child, depth)
                continue
            name = child.get("file", "")
            try:
                included = self.parse(self._resolved(name))
            except ValueError as error:
                raise ValueError(f"'{self._path}' includes '{name}': {error}") from None
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
            for key in [key for key in item.attrib if key.startswith("file")]:
                name = item.attrib[key]
                if "name" not in item.attrib and key == "file":
                    item.set("name", posixpath.splitext(posixpath.basename(name))[0])
                name = posixpath.basename(name) if strip else name
                item.set(key, self.asset(posixpath.join(folders[item.tag], name), item.tag))

    def asset(self, name: str, kind: str, *, variant: str = "") -> str:
        """Take a mesh or a texture; return the name that the text must use for it."""
        path = self._resolved(name)
        if path + variant in self._flat:
            return self._flat[path + variant]
        if kind == "mesh" and not path.lower().endswith(MESH_ENDINGS):
            raise ValueError(f"'{self._path}' names the mesh '{name}'; convert it to OBJ or STL")
        data = self.file(path)
        if kind == "mesh":
            check_mesh(path, data)
        if kind == "texture":
            try:
                width, height = picture_size(data)
            except ValueError as error:
                raise ValueError(f"'{path}' {error}") from None
            self._count_pixels(width * height)
        flat = self._flat[path + variant] = f"{len(self._flat)}-{posixpath.basename(path)}"
        self.assets[flat] = data
        return flat

    def _check_builtin(self, item: Element) -> None:
        """Check what MuJoCo would make by itself."""
        if "builtin" not in item.attrib:
            return
        if item.tag == "mesh":
            raise ValueError(f"'{self._path}' has a mesh that is made by MuJoCo (builtin); name a file of OBJ or STL")
        width, height = (item.get(key, "0") for key in ("width", "height"))
        if not all(size.isdecimal() and len(size) < 10 for size in (width, height)):
            raise ValueError(f"'{self._path}' has a texture of {width} x {height} pixels; give whole numbers")
        # All sides of a cube are as large as its width says.
        self._count_pixels(int(width) * max(int(height), int(width) * CUBE_SIDES))

    def _count_pixels(self, count: int) -> None:
        self._pixels += count
        if self._pixels > MOST_PIXELS:
            most = MOST_PIXELS // 10**6
            raise ValueError(f"the textures of '{self._path}' have more than {most} megapixels; make them smaller")

    def _resolved(self, name: str) -> str:
        """Return the path of a file that the model names; it may not leave the folder of the world."""
        if name.startswith("package://"):
            return self._packaged(name)
        path = posixpath.normpath(posixpath.join(self._folder, name.removeprefix("file://")))
        if not name or path.startswith(("/", "..")) or "\\" in name:
            raise ValueError(f"'{self._path}' names the file '{name}'; keep it beside the model and name it from there")
        return path

    def _packaged(self, name: str) -> str:
        """Return the path of 'package://NAME/REST': below a folder NAME around the model, or below any around it."""
        package, _, rest = name.removeprefix("package://").partition("/")
        around = [self._folder]
        while around[-1]:
            around.append(posixpath.dirname(around[-1]))
        likely = [base for base in around if posixpath.basename(base) == package]
        for base in [*likely, *(posixpath.join(base, package) for base in around), *around]:
            path = posixpath.normpath(posixpath.join(base, rest))
            if not path.startswith(("/", "..")) and self._is_there(path):
                return path
        raise ValueError(f"'{self._path}' names '{name}', which is not below any folder around it; put it there")

    def _is_there(self, path: str) -> bool:
        try:
            self._read(path)
        except ValueError:
            return False
        return True

    def keep_urdf(self, root: Element) -> None:
        """Keep of URDF what makes a thing."""
        own = root.find("mujoco/compiler")
        folder = "" if own is None else own.get("meshdir", "")
        for child in list(root):
            if child.tag not in _URDF:
                root.remove(child)
        for item in root.iter():
            if item.tag in _URDF_PARTS and item is not root:
                for part in list(item):
                    if part.tag not in _URDF_PARTS[item.tag]:
                        item.remove(part)
            if item.tag == "joint" and item.get("type") in ("floating", "planar"):
                item.set("type", "fixed")
            if item.tag == "joint" and item.get("type") == "continuous":
                for limit in item.findall("limit"):  # URDF has no ends for such a joint; MuJoCo would take them.
                    limit.attrib.pop("lower", None)
                    limit.attrib.pop("upper", None)
            if item.tag == "mesh" and item.get("filename"):
                name = item.attrib["filename"]
                name = name if "://" in name else posixpath.join(folder, name)
                # MuJoCo takes one mesh a file; one that is used in two sizes must be two.
                item.set("filename", self.asset(name, "mesh", variant=item.get("scale", "")))
        _check_count(self._path, sum(item.tag in ("link", "visual", "collision") for item in root.iter()))
        settings = {"discardvisual": "false", "strippath": "false", "fusestatic": "false", "balanceinertia": "true"}
        if own is not None:
            settings |= {key: own.attrib[key] for key in sorted(_URDF_COMPILER & own.attrib.keys())}
        ElementTree.SubElement(ElementTree.SubElement(root, "mujoco"), "compiler", settings)


def _keep(element: Element, tags: Set[str]) -> None:
    """Take away what is not of some kinds, all the way down."""
    for child in list(element):
        # Whether it can be pushed, the world file says.
        if child.tag in tags and not (child.tag == "joint" and child.get("type") == "free"):
            _keep(child, tags)
            for key in ("mocap", "gravcomp", "sleep", "user", "plugin"):
                child.attrib.pop(key, None)
        else:
            element.remove(child)


def _geoms_in(element: Element) -> int:
    """Return how many geoms an element stands for, those of <replicate> counted as often as it says."""
    count = sum(map(_geoms_in, element)) + (element.tag == "geom")
    if element.tag == "replicate":
        text = element.get("count", "0")
        return max(count, 1) * (int(text) if text.isdecimal() and len(text) < 10 else 10**9)
    return count


def _check_count(path: str, count: int) -> None:
    if count > MOST_GEOMS:
        raise ValueError(f"'{path}' has {count} parts; it must have at most {MOST_GEOMS}")
