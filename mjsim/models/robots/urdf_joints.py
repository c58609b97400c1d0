"""URDF joints: their speed limits, placeholders of limits, and joints that simulators use instead of wheels."""

from collections.abc import Iterator
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

from mjsim.geometry import Array
from mjsim.models.inertia_repair import finite_number
from mjsim.models.model_sources import Element

MIN_WHEELS = 2
"""Minimum number of wheels of a robot."""
MAX_ALONG = 0.3
"""A joint steers a wheel if its axis is across the wheel's: maximum cosine between them."""


def without_rails(root: Element, path: str) -> Iterator[str]:
    """Make URDF joints rigid on which a simulator moves the whole robot, and yield notes on what was done."""
    joints = root.findall("joint")
    below = {name: [j for j in joints if _end(j, "parent") == name] for name in {_end(j, "parent") for j in joints}}
    carried = {_end(joint, "child") for joint in joints}
    bare = {link.get("name", "") for link in root.findall("link") if not link.findall("visual/geometry")}
    bare -= {link.get("name", "") for link in root.findall("link") if link.findall("collision/geometry")}
    at = next((name for name in below if name not in carried), "")
    while at in bare and len(below.get(at, ())) == 1:
        joint = below[at][0]
        if joint.get("type") != "fixed":
            joint.set("type", "fixed")
            yield f"{path}: joint '{joint.get('name', '?')}' moves the whole robot; locked, because wheels move it"
        at = _end(joint, "child")


def _end(joint: Element, which: str) -> str:
    """Return the link at one end of a joint."""
    found = joint.find(which)
    return "" if found is None else found.get("link", "")


def _is_wheel(joint: Element) -> bool:
    """Return whether names say that a joint carries a wheel, other than a caster."""
    names = f"{joint.get('name', '')} {_end(joint, 'child')}".lower()
    return "wheel" in names and not any(word in names for word in ("caster", "castor"))


def rolling_wheels(root: Element, path: str) -> Iterator[str]:
    """Let the wheels of a URDF roll that a joint only steers, as of cars made to be looked at, and yield notes."""
    joints = root.findall("joint")
    if not any(joint.get("type") == "continuous" and _is_wheel(joint) for joint in joints):
        return
    # Wheels that only show how a car with two wheels would stand touch nothing.
    kind = "collision" if root.find("link/collision/geometry") is not None else "visual"
    links = {link.get("name", ""): link for link in root.findall("link")}
    carrying = {_end(joint, "parent") for joint in joints}
    for joint in joints:
        wheel, name = _end(joint, "child"), joint.get("name", "?")
        if joint.get("type") != "revolute" or not _is_wheel(joint) or wheel in carrying or wheel not in links:
            continue
        axle, steers = _axle(links[wheel], kind), _three(joint.find("axis"), "xyz", "1 0 0")
        if axle is not None and abs(float(axle @ steers)) < MAX_ALONG * float(np.linalg.norm(steers)):
            _put_between(root, joint, f"{name}_rolling", axle)
            yield f"{path}: joint '{name}' only steers its wheel; joint '{name}_rolling' added, on which it turns"


def _put_between(root: Element, joint: Element, name: str, axle: Array) -> None:
    """Put a link and a joint between a joint and the wheel that it carries."""
    for parent, wheel in [(f"{name}_from", end.get("link", "")) for end in joint.findall("child")]:
        rolling = ElementTree.SubElement(root, "joint", name=name, type="continuous")
        for tag, link in (("parent", parent), ("child", wheel)):
            ElementTree.SubElement(rolling, tag, link=link)
        ElementTree.SubElement(rolling, "axis", xyz=" ".join(f"{value:.6g}" for value in axle))
        ElementTree.SubElement(root, "link", name=parent)
    for end in joint.findall("child"):
        end.set("link", f"{name}_from")


def _axle(link: Element, kind: str) -> Array | None:
    """Return the axis of the only cylinder of a link, in its frame, shape (3,); None if it has not one."""
    found = [shape for shape in link.findall(kind) if shape.find("geometry/cylinder") is not None]
    if len(found) != 1:
        return None
    angles = _three(found[0].find("origin"), "rpy", "0 0 0")
    return np.asarray(Rotation.from_euler("xyz", angles).as_matrix()[:, 2])


def _three(element: Element | None, key: str, default: str) -> Array:
    """Return three numbers of an element, those that are missing or not finite as 0, shape (3,)."""
    words = (element.get(key, default) if element is not None else default).split()
    return np.array([finite_number(word) or 0.0 for word in [*words, "0", "0", "0"][:3]])


def freed_wheels(root: Element, path: str) -> Iterator[str]:
    """If all wheels of a URDF are on fixed joints, let them turn, and yield notes on what was done."""
    wheels = [joint for joint in root.findall("joint") if _is_wheel(joint)]
    if len(wheels) < MIN_WHEELS or any(joint.get("type") != "fixed" for joint in wheels):
        return
    for joint in wheels:
        joint.set("type", "continuous")
        if joint.find("axis") is None:
            joint.append(joint.makeelement("axis", {"xyz": "0 1 0"}))
        yield f"{path}: joint '{joint.get('name', '?')}' of a wheel is fixed; made to turn"


def joint_speeds(root: Element) -> Iterator[tuple[str, float]]:
    """Yield the maximum speeds of joints of a URDF."""
    for joint in root.findall("joint"):
        limit = joint.find("limit")
        speed = finite_number(limit.get("velocity")) if limit is not None else None
        if speed is not None and speed > 0.0:
            yield joint.get("name", ""), speed


def without_limits(root: Element) -> frozenset[str]:
    """Return the hinges of a URDF whose limits are both 0: exporters of CAD write that where they know none."""
    found = set()
    for joint in root.findall("joint"):
        limit = joint.find("limit")
        if joint.get("type") == "revolute" and limit is not None:
            ends = [finite_number(limit.get(key, "0")) or 0.0 for key in ("lower", "upper")]
            if ends == [0.0, 0.0]:
                found.add(joint.get("name", ""))
    return frozenset(found)
