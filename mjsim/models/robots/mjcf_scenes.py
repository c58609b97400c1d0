"""MJCF scenes: removes the surroundings of a robot, and locks joints on which a simulator moves the whole robot."""

from collections.abc import Iterator, Sequence

from mjsim.models.model_sources import Element

MIN_HINGES = 2
"""Minimum number of hinges of a robot: those of its wheels."""
_FREE = "freejoint"
_JOINTS = ("joint", _FREE)
_KINDS = {
    **dict.fromkeys(("joint", "joint1", "joint2", "jointinparent"), "joint"),
    **dict.fromkeys(("body", "body1", "body2"), "body"),
    **dict.fromkeys(("site", "site1", "site2", "refsite", "cranksite", "slidersite", "sidesite"), "site"),
    "geom": "geom",
    "tendon": "tendon",
}
"""Attributes that refer to an element, and the kind of that element."""
_LINKED = ("contact", "equality", "tendon", "actuator")
"""Sections whose items refer to elements."""


def without_scenery(root: Element, path: str) -> Iterator[str]:
    """Remove everything in MJCF except its robot, and yield notes on what was done.

    The robot is the only body in the world with hinges. With several such bodies, or none because the wheels are
    attached to the world, nothing is removed.
    """
    worlds = root.findall("worldbody")
    robots = [body for world in worlds for body in world.findall("body") if _hinges(body) >= MIN_HINGES]
    if len(robots) != 1:
        return
    scenery = [
        (world, item)
        for world in worlds
        for item in world
        if item.tag in ("body", "geom") and item is not robots[0] and not _hinges(item)
    ]
    for world, item in scenery:
        world.remove(item)
    _forget(root, [item for _, item in scenery])
    bodies = [item.get("name", "?") for _, item in scenery if item.tag == "body"]
    if bodies:
        shown = ", ".join(f"'{name}'" for name in bodies[:4]) + (" and more" if len(bodies) > 4 else "")
        noun = "body" if len(bodies) == 1 else "bodies"
        yield f"left out: {len(bodies)} {noun} beside the robot in {path}: {shown}"


def without_mjcf_rails(root: Element, path: str) -> Iterator[str]:
    """Remove MJCF joints on which a simulator moves the whole robot, and yield notes on what was done."""
    for body in [body for world in root.findall("worldbody") for body in world.findall("body")]:
        rails = list(_rails(body))
        joints = [joint for _, joint in rails]
        turning = _hinges(body) - sum(joint.get("type", "hinge") == "hinge" for joint in joints)
        if turning < MIN_HINGES or not any(joint.get("type") == "slide" for joint in joints):
            continue
        for carrier, joint in rails:
            carrier.remove(joint)
            yield f"{path}: joint '{joint.get('name', '?')}' moves the whole robot; locked, because wheels move it"
        _forget(root, joints)


def _rails(body: Element) -> Iterator[tuple[Element, Element]]:
    """Yield the joints between the world and the first body with a shape or several children, each with its body."""
    yield from ((body, joint) for joint in body.findall("joint"))
    inner = body.findall("body")
    if len(inner) == 1 and body.find("geom") is None:
        yield from _rails(inner[0])


def _hinges(item: Element) -> int:
    """Return the number of hinges that the text of a body and its descendants contains."""
    return sum(joint.get("type", "hinge") == "hinge" for joint in item.iter("joint"))


def _forget(root: Element, removed: Sequence[Element]) -> None:
    """Remove elements that refer to removed ones, and those that refer to them."""
    names = {
        ("joint" if part.tag in _JOINTS else part.tag, part.get("name")) for item in removed for part in item.iter()
    }
    while True:
        lost = [
            (section, item)
            for tag in _LINKED
            for section in root.findall(tag)
            for item in section
            if any((_KINDS.get(key), value) in names for part in item.iter() for key, value in part.attrib.items())
        ]
        if not lost:
            return
        for section, item in lost:
            section.remove(item)
            names |= {("tendon", item.get("name"))} if section.tag == "tendon" else set()
