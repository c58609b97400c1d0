"""URDF joints: their speed limits, placeholders of limits, and joints that simulators use instead of wheels."""

from collections.abc import Iterator

from mjsim.models.inertia_repair import finite_number
from mjsim.models.model_sources import Element

MIN_WHEELS = 2
"""Minimum number of wheels of a robot."""


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


def freed_wheels(root: Element, path: str) -> Iterator[str]:
    """If all wheels of a URDF are on fixed joints, let them turn, and yield notes on what was done."""
    joints = root.findall("joint")

    def is_wheel(joint: Element) -> bool:
        names = f"{joint.get('name', '')} {_end(joint, 'child')}".lower()
        return "wheel" in names and not any(word in names for word in ("caster", "castor"))

    wheels = [joint for joint in joints if is_wheel(joint)]
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
