"""The parts of a URDF that make up an object in a world."""

import posixpath
from typing import Protocol
from xml.etree import ElementTree

_URDF = {"link", "joint", "material"}
_URDF_COMPILER = {"boundinertia", "boundmass"}
"""Settings of a URDF's MuJoCo element that are kept: minimum mass and inertia of moving bodies."""
_URDF_PARTS = {
    "link": {"inertial", "visual", "collision"},
    "joint": {"parent", "child", "origin", "axis", "limit", "dynamics"},
    "material": {"color", "texture"},
}
"""Elements that are kept, and their parts."""


class Asset(Protocol):
    """Stores a file that a model names."""

    def __call__(self, name: str, kind: str, *, variant: str = "") -> str:
        """Return the name of the stored file."""


def keep_urdf(root: ElementTree.Element, asset: Asset) -> None:
    """Keep the parts of a URDF that make up an object.

    Args:
        root: Changed in place.
        asset: Stores a named file of a kind in a variant; returns its new name.
    """
    own = root.find("mujoco/compiler")
    folder = "" if own is None else own.get("meshdir", "")
    for child in list(root):
        if child.tag not in _URDF:
            root.remove(child)
    _name_apart(root)
    for item in root.iter():
        if item.tag in _URDF_PARTS and item is not root:
            for part in list(item):
                if part.tag not in _URDF_PARTS[item.tag]:
                    item.remove(part)
        if item.tag == "joint" and item.get("type") in ("floating", "planar"):
            item.set("type", "fixed")
        if item.tag == "joint" and item.get("type") == "continuous":
            for limit in item.findall("limit"):  # URDF defines no limits for such a joint; MuJoCo would apply them.
                limit.attrib.pop("lower", None)
                limit.attrib.pop("upper", None)
        if item.tag == "texture" and item.get("filename"):
            item.set("filename", asset(item.attrib["filename"], "texture"))
        if item.tag == "mesh" and item.get("filename"):
            name = item.attrib["filename"]
            name = name if "://" in name else posixpath.join(folder, name)
            # MuJoCo reads a mesh per file; a mesh used in two sizes must become two files.
            item.set("filename", asset(name, "mesh", variant=item.get("scale", "")))
    settings = {"discardvisual": "false", "strippath": "false", "fusestatic": "false", "balanceinertia": "true"}
    if own is not None:
        settings |= {key: own.attrib[key] for key in sorted(_URDF_COMPILER & own.attrib.keys())}
    ElementTree.SubElement(ElementTree.SubElement(root, "mujoco"), "compiler", settings)


def _name_apart(root: ElementTree.Element) -> None:
    """Give URDF shapes unique names if some have names; MuJoCo gives a shape without one the name of the last."""
    shapes = [shape for link in root.findall("link") for shape in link if shape.tag in ("visual", "collision")]
    taken: set[str] = set()
    for shape in shapes if any(shape.get("name") for shape in shapes) else ():
        own = name = shape.get("name") or shape.tag
        while name in taken:
            name = f"{own}-{len(taken)}"
        shape.set("name", name)
        taken.add(name)
