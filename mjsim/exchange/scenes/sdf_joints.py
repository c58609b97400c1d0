"""The joints of a model of SDF: which links move as one, and what hinges and slides move on them."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
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
    """Links that move as one, and the parts that joints move on them."""

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
        scene: Takes notes on what is lost.
        in_joint: Whether axes are in the frames of their joints unless they say otherwise.
    """
    forest = _Forest(model, links, frames, world_from_model, scene, in_joint)
    forest.grow()
    world = forest.root(WORLD)
    # Links without any joint between them are meant as one thing, though Gazebo lets them fall apart.
    roots = dict.fromkeys(forest.root(link.name) for link in links)
    loose = [root for root in roots if root not in {world, *forest.moved}]
    found = [forest.tree([world], held=True), forest.tree(loose, held=False)]
    return [tree for tree in found if tree.parts or any(link.solids for link in tree.links)]


@dataclass(slots=True, eq=False)
class _Forest:
    """Groups of links that are fixed to each other, and the joints between the groups."""

    model: Element
    links: Sequence[SdfLink]
    frames: SdfFrames
    world_from_model: Array
    scene: Scene
    in_joint: bool
    owner: dict[str, str] = field(default_factory=dict)
    """Link -> a link that it is fixed to; itself for the root of a fixed group."""
    carried: dict[str, list[tuple[Element, str]]] = field(default_factory=dict)
    """Root -> the joints on its group, and the roots that these move."""
    moved: set[str] = field(default_factory=set)
    """Roots that a joint moves."""

    def grow(self) -> None:
        """Merge links that are fixed to each other, then attach the groups to their parents."""
        self.owner = {each: each for each in (WORLD, *(link.name for link in self.links))}
        joints = [joint for joint in self.model.findall("joint") if joint.get("type") is not None]
        moving = [joint for joint in joints if self._moves(joint)]
        for joint in moving:
            parent, child = map(self.root, self._ends(joint))
            if child == self.root(WORLD):
                # In some files the child of a joint is the world; the joint is then reversed.
                parent, child = child, parent
            if parent == child or child in self.moved:
                self._tell(Fate.LEFT_OUT, "joint", joint, "it closes a loop of links")
                continue
            self.moved.add(child)
            self.carried.setdefault(parent, []).append((joint, child))

    def root(self, name: str) -> str:
        """Return the root of the fixed group of a link."""
        while self.owner[name] != name:
            name = self.owner[name]
        return name

    def tree(self, roots: Sequence[str], *, held: bool) -> SdfTree:
        """Return the groups of some roots, and the parts that move on them."""
        links = [link for root in roots for link in self._members(root)]
        return SdfTree(links, [part for root in roots for part in self._parts(root)], held)

    def _moves(self, joint: Element) -> bool:
        """Return whether a joint moves; else its links are merged."""
        parent, child = self._ends(joint)
        kind = joint.get("type", "")
        if parent not in self.owner or child not in self.owner:
            self._tell(Fate.GUESSED, "joint", joint, "held: it joins nested models")
            return False
        if kind in KINDS and not _is_locked(joint):
            return True
        if kind not in ("fixed", *KINDS):
            self._tell(Fate.GUESSED, f"{kind} joint", joint, f"held: mjsim imports only {', '.join(KINDS)} joints")
        self.owner[self.root(child)] = self.root(parent)
        return False

    def _ends(self, joint: Element) -> tuple[str, str]:
        parent, child = (link_named(self.model, joint.findtext(end) or "") for end in ("parent", "child"))
        return parent, child

    def _members(self, root: str) -> list[SdfLink]:
        return [link for link in self.links if self.root(link.name) == root]

    def _parts(self, root: str) -> Iterator[ScenePart]:
        where = f"{self.frames.where}: {self.model.get('name', '')}"
        for joint, child in self.carried.get(root, []):
            own, inner = self._members(child), list(self._parts(child))
            solids = [solid for link in own for solid in link.solids]
            if not solids and not inner:
                continue
            made = _joint(joint, self.model, self.frames, self.world_from_model, where, in_joint=self.in_joint)
            if (limits := _limits(joint)) is not None and limits[0] > limits[1]:
                why = "the lower one is above the upper one; it gets no limits"
                self._tell(Fate.GUESSED, "limits of joint", joint, why)
            label = own[0].name if own else joint.get("name", "part")
            skins = [skin for link in own for skin in link.skins]
            yield ScenePart(label, [made], solids, sum(link.mass for link in own), inner, skins)

    def _tell(self, fate: Fate, kind: str, joint: Element, why: str) -> None:
        self.scene.tell(fate, kind, f"{self.model.get('name', '')}::{joint.get('name', '')}", why)


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
    """Return the limits of a joint [rad or m]; None unless it has both; a continuous one has none."""
    low, high = (finite_number(joint.findtext(f"axis/limit/{end}")) for end in ("lower", "upper"))
    return None if low is None or high is None or joint.get("type") == "continuous" else (low, high)


def _is_locked(joint: Element) -> bool:
    limits = _limits(joint)
    return limits is not None and limits[0] == limits[1]
