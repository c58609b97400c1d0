"""Scenes of MJCF: what stands around a robot is left out, and joints on which a simulator moves all of it are held."""

from collections.abc import Iterator, Sequence

from mjsim.models.files import Element

FEWEST_HINGES = 2
"""Of a robot: its wheels."""
_FREE = "freejoint"
_JOINTS = ("joint", _FREE)
_KINDS = {
    **dict.fromkeys(("joint", "joint1", "joint2", "jointinparent"), "joint"),
    **dict.fromkeys(("body", "body1", "body2"), "body"),
    **dict.fromkeys(("site", "site1", "site2", "refsite", "cranksite", "slidersite", "sidesite"), "site"),
    "geom": "geom",
    "tendon": "tendon",
}
"""Attributes that name a part, and the kind of that part."""
_LINKED = ("contact", "equality", "tendon", "actuator")
"""Sections whose items name parts."""


def without_scenery(root: Element, path: str) -> Iterator[str]:
    """Take away of MJCF what is beside its robot, and yield what was done.

    A robot is the one body of the world with hinges of its own. What is of several such bodies, or of none, as where
    the wheels themselves hang on the world, stays as it is.
    """
    worlds = root.findall("worldbody")
    robots = [body for world in worlds for body in world.findall("body") if _hinges(body) >= FEWEST_HINGES]
    if len(robots) != 1:
        return
    gone = [
        (world, item)
        for world in worlds
        for item in world
        if item.tag in ("body", "geom") and item is not robots[0] and not _hinges(item)
    ]
    for world, item in gone:
        world.remove(item)
    _forget(root, [item for _, item in gone])
    bodies = [item.get("name", "?") for _, item in gone if item.tag == "body"]
    if bodies:
        shown = ", ".join(f"'{name}'" for name in bodies[:4]) + (" and more" if len(bodies) > 4 else "")
        yield f"left out: what is beside the robot in {path}, {len(bodies)} of them: {shown}"


def without_mjcf_rails(root: Element, path: str) -> Iterator[str]:
    """Take joints of MJCF away on which a simulator slides the whole robot, and yield what was done."""
    for body in [body for world in root.findall("worldbody") for body in world.findall("body")]:
        rails = list(_rails(body))
        joints = [joint for _, joint in rails]
        turning = _hinges(body) - sum(joint.get("type", "hinge") == "hinge" for joint in joints)
        if turning < FEWEST_HINGES or not any(joint.get("type") == "slide" for joint in joints):
            continue
        for carrier, joint in rails:
            carrier.remove(joint)
            yield f"{path}: joint '{joint.get('name', '?')}' moves the whole robot; held, as wheels move it"
        _forget(root, joints)


def _rails(body: Element) -> Iterator[tuple[Element, Element]]:
    """Yield the joints between the world and the first body that has a shape or several parts, each with its body."""
    yield from ((body, joint) for joint in body.findall("joint"))
    inner = body.findall("body")
    if len(inner) == 1 and body.find("geom") is None:
        yield from _rails(inner[0])


def _hinges(item: Element) -> int:
    """Return how many hinges a body has, all the way down, as far as its own text tells."""
    return sum(joint.get("type", "hinge") == "hinge" for joint in item.iter("joint"))


def _forget(root: Element, gone: Sequence[Element]) -> None:
    """Take away what names parts that are gone, and what names that."""
    names = {("joint" if part.tag in _JOINTS else part.tag, part.get("name")) for item in gone for part in item.iter()}
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
