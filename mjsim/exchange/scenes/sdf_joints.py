"""The joints of a model of SDF: which links move as one, and what hinges and slides move on them."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np

from mjsim.exchange.scenes.scene_solids import Scene, ScenePart, SceneSkin, SceneSolid
from mjsim.geometry import Array
from mjsim.inventory import Fate
from mjsim.models import MAX_HINGE_LIMIT, SceneJoint, SdfFrames, axis_of, finite_number, link_named

KINDS: Mapping[str, str] = {"revolute": "hinge", "continuous": "hinge", "prismatic": "slide"}
"""Types of joints of SDF with one axis."""
WORLD = "world"


@dataclass(frozen=True, slots=True, eq=False)
class SdfLink:
    """A link as solids."""

    name: str
    solids: Sequence[SceneSolid]
    """Poses in the world."""
    mass: float
    """[kg]"""
    skins: Sequence[SceneSkin] = ()


@dataclass(frozen=True, slots=True, eq=False)
class SdfTree:
    """Links that move as one, and what joints move on them."""

    links: Sequence[SdfLink]
    parts: Sequence[ScenePart]
    held: bool
    """Whether it is fixed to the world."""


def trees_of(
    model: Element,
    links: Sequence[SdfLink],
    frames: SdfFrames,
    world_from_model: Array,
    scene: Scene,
    *,
    in_joint: bool,
) -> list[SdfTree]:
    """Return the links of a model as trees of joints; those that are fixed to each other are one body.

    Args:
        model: The `<model>`.
        links: Its links.
        frames: Its frames.
        world_from_model: Shape (4, 4) [m].
        scene: Notes what is lost.
        in_joint: Whether axes are in the frames of their joints unless they say otherwise.
    """
    name, where = model.get("name", ""), f"{frames.where}: {model.get('name', '')}"
    joints = [joint for joint in model.findall("joint") if joint.get("type") is not None]
    known = {link.name for link in links}
    ends = {
        id(joint): tuple(link_named(model, joint.findtext(end) or "") for end in ("parent", "child"))
        for joint in joints
    }
    owner = {each: each for each in (WORLD, *known)}
    moving = []
    for joint in joints:
        parent, child = ends[id(joint)]
        if parent not in owner or child not in owner:
            scene.tell(Fate.GUESSED, "joint", f"{name}::{joint.get('name', '')}", "held: it joins nested models")
        elif joint.get("type") in KINDS and not _is_locked(joint):
            moving.append(joint)
        else:
            if joint.get("type") not in ("fixed", *KINDS):
                why = f"held: mjsim brings in {', '.join(KINDS)} joints"
                scene.tell(Fate.GUESSED, f"{joint.get('type')} joint", f"{name}::{joint.get('name', '')}", why)
            _merge(owner, parent, child)
    carried: dict[str, list[Element]] = {}
    children: set[str] = set()
    for joint in moving:
        parent, child = (_root(owner, end) for end in ends[id(joint)])
        if child == _root(owner, WORLD):
            # A joint has the world as its child in some files; it works the other way round.
            parent, child = child, parent
        if parent == child or child in children:
            scene.tell(Fate.LEFT_OUT, "joint", f"{name}::{joint.get('name', '')}", "it closes a loop of links")
            continue
        children.add(child)
        carried.setdefault(parent, []).append(joint)

    def members(root: str) -> list[SdfLink]:
        return [link for link in links if _root(owner, link.name) == root]

    def parts(root: str) -> Iterator[ScenePart]:
        for joint in carried.get(root, []):
            child = next(each for end in reversed(ends[id(joint)]) if (each := _root(owner, end)) != root)
            own = members(child)
            solids = [solid for link in own for solid in link.solids]
            inner = list(parts(child))
            if solids or inner:
                made = _joint(joint, model, frames, world_from_model, where, in_joint=in_joint)
                if (limits := _limits(joint)) is not None and limits[0] > limits[1]:
                    why = "the lower one is above the upper one; it has none"
                    scene.tell(Fate.GUESSED, "limits of joint", f"{name}::{joint.get('name', '')}", why)
                label = own[0].name if own else joint.get("name", "part")
                skins = [skin for link in own for skin in link.skins]
                yield ScenePart(label, [made], solids, sum(link.mass for link in own), inner, skins)

    world = _root(owner, WORLD)
    # Links without any joint between them are meant as one thing, though Gazebo lets them fall apart.
    loose = [
        root for root in dict.fromkeys(_root(owner, link.name) for link in links) if root not in {world, *children}
    ]
    found = [
        SdfTree(
            [link for root in roots for link in members(root)], [part for root in roots for part in parts(root)], held
        )
        for roots, held in (([world], True), (loose, False))
    ]
    return [tree for tree in found if tree.parts or any(link.solids for link in tree.links)]


def _joint(
    joint: Element, model: Element, frames: SdfFrames, world_from_model: Array, where: str, *, in_joint: bool
) -> SceneJoint:
    """Return a joint with one axis."""
    pose = frames.pose_of(joint)
    axis = joint.find("axis")
    said = f"{where}: joint '{joint.get('name', '')}'"
    turned = np.array([0.0, 0.0, 1.0]) if axis is None else axis_of(axis, frames, pose, said, in_joint=in_joint)
    numbers = {
        key: finite_number(None if axis is None else axis.findtext(f"dynamics/{key}"))
        for key in ("damping", "friction", "spring_stiffness", "spring_reference")
    }
    limits = _limits(joint)
    bounded = limits is not None and limits[0] < limits[1] and max(-limits[0], limits[1]) < MAX_HINGE_LIMIT
    length = float(np.linalg.norm(turned))
    return SceneJoint(
        kind=KINDS[joint.get("type", "")],
        anchor=(world_from_model @ pose)[:3, 3],
        axis=world_from_model[:3, :3] @ (turned / length if length > 0.0 else np.array([0.0, 0.0, 1.0])),
        range=limits if bounded else None,
        damping=max(numbers["damping"] or 0.0, 0.0),
        friction=max(numbers["friction"] or 0.0, 0.0),
        stiffness=max(numbers["spring_stiffness"] or 0.0, 0.0),
        rest=numbers["spring_reference"] or 0.0,
    )


def _limits(joint: Element) -> tuple[float, float] | None:
    """Return the limits of a joint [rad or m]; None if it has not both, as of a continuous one."""
    low, high = (finite_number(joint.findtext(f"axis/limit/{end}")) for end in ("lower", "upper"))
    return None if low is None or high is None or joint.get("type") == "continuous" else (low, high)


def _is_locked(joint: Element) -> bool:
    limits = _limits(joint)
    return limits is not None and limits[0] == limits[1]


def _root(owner: Mapping[str, str], name: str) -> str:
    while owner[name] != name:
        name = owner[name]
    return name


def _merge(owner: dict[str, str], first: str, second: str) -> None:
    first, second = _root(owner, first), _root(owner, second)
    if second == WORLD:
        first, second = second, first
    owner[second] = first
