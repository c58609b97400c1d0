"""Links of SDF as a tree, as URDF requires: SDF allows joints in any direction, to the world, and in loops."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element

from mjsim.geometry import Array
from mjsim.inventory import Fate, FileItem

WORLD = "world"


@dataclass(frozen=True, slots=True, eq=False)
class SdfJoint:
    """A joint of SDF in the frame of the robot."""

    name: str
    kind: str
    parent: str
    child: str
    pose: Array
    """Shape (4, 4) [m]."""
    elements: Sequence[Element]
    """Its `<axis>` and `<axis2>`, in the form that URDF has."""
    axes: Sequence[Array]
    """Their directions, shape (3,)."""


@dataclass(frozen=True, slots=True, eq=False)
class Branch:
    """A link, and the joint that carries it."""

    link: str
    parent: str = ""
    """Empty for the root."""
    joint: SdfJoint | None = None
    backward: bool = False
    """Whether the link is the parent of the joint in SDF."""


def branches(links: Mapping[str, object], joints: Sequence[SdfJoint]) -> tuple[list[Branch], list[FileItem]]:
    """Return the links of the largest connected part, each after its parent, and what was left out."""
    used = [joint for joint in joints if WORLD not in (joint.parent, joint.child) and joint.kind != "gearbox"]
    trees: list[list[Branch]] = []
    for link in links:
        if not any(branch.link == link for tree in trees for branch in tree):
            trees.append(_tree(link, used))
    tree = max(trees, key=len, default=[])
    if tree:
        tree = _tree(_root([branch.link for branch in tree], used), used)
    found, carrying = {branch.link for branch in tree}, {id(branch.joint) for branch in tree}
    looped = {id(joint) for joint in used if joint.child in found and id(joint) not in carrying}
    items = [item for joint in joints for item in _told(joint, closes=id(joint) in looped)]
    lost = [name for name in links if name not in found]
    return tree, [
        *items,
        *(FileItem(Fate.LEFT_OUT, "link", name, "no joint connects it with the others") for name in lost),
    ]


def _root(links: Sequence[str], joints: Sequence[SdfJoint]) -> str:
    """Return the link that no joint carries; if there are several, the link with most joints."""
    carried = {joint.child for joint in joints}
    roots = [link for link in links if link not in carried]
    ends = [end for joint in joints for end in (joint.parent, joint.child)]
    return roots[0] if len(roots) == 1 else max(links, key=ends.count)


def _tree(root: str, joints: Sequence[SdfJoint]) -> list[Branch]:
    """Return the links that joints connect with a root, breadth first."""
    found, seen = [Branch(root)], {root}
    for branch in found:
        for joint in joints:
            for parent, child in ((joint.parent, joint.child), (joint.child, joint.parent)):
                if parent == branch.link and child not in seen:
                    seen.add(child)
                    found.append(Branch(child, parent, joint, backward=parent == joint.child))
    return found


def _told(joint: SdfJoint, *, closes: bool) -> Iterator[FileItem]:
    """Yield what is left out of a joint."""
    if WORLD in (joint.parent, joint.child):
        yield FileItem(Fate.LEFT_OUT, "joint", joint.name, "it holds the robot to the world")
    elif closes:
        yield FileItem(Fate.LEFT_OUT, "joint", joint.name, "it closes a loop of links; mjsim has trees only")
    elif joint.kind == "gearbox":
        yield FileItem(Fate.LEFT_OUT, "gearbox joint", joint.name, "the two joints that it couples move freely")
    elif joint.kind != "fixed" and not joint.axes:
        yield FileItem(Fate.LEFT_OUT, f"{joint.kind or 'nameless'} joint", joint.name, "treated as rigid")
