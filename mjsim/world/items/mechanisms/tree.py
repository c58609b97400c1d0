"""The tree of a mechanism's joints, and where its loops are cut."""

import math
from collections.abc import Mapping, Sequence

from mjsim.mechanics import Linkage, TreeJoint, inverted, placed
from mjsim.sentences import Sentence
from mjsim.world.ground import fault
from mjsim.world.items.mechanisms.joints import MechanismJoint
from mjsim.world.items.mechanisms.mechanism_items import MechanismParts
from mjsim.world.items.mechanisms.points import GROUND, Place, place_of

SOFT_CUTS = ("revolute", "spherical")
"""Joints preferred for cutting a loop: they only need coincident points."""
Points = Mapping[str, Mapping[str, tuple[float, ...]]]
"""By body, its named points."""


def places_of(mechanism: MechanismParts, points: Points) -> dict[str, tuple[Place, Place]]:
    """Return by joint the points that coincide."""
    found = {}
    for number, joint in enumerate(mechanism.all_joints):
        ends = []
        for which, end in enumerate(joint.of):
            try:
                ends.append(place_of(end, points))
            except ValueError as error:
                raise fault(str(error), *mechanism.written(number), which) from None
        if ends[0].body == ends[1].body:
            raise fault(
                Sentence("joint '{name}' holds '{body}' to itself; name two bodies", joint.name, ends[0].body),
                *mechanism.written(number),
            )
        found[joint.name] = (ends[0], ends[1])
    return found


def tree_of(mechanism: MechanismParts, places: Mapping[str, tuple[Place, Place]]) -> list[tuple[MechanismJoint, bool]]:
    """Return the joints that place a body, parents first, each with whether it is traversed backwards."""
    chosen = _spanning(mechanism, places)
    reached, order, left = {GROUND}, list[tuple[MechanismJoint, bool]](), list(chosen)
    while left:
        for joint in left:
            first, second = (place.body for place in places[joint.name])
            if (first in reached) != (second in reached):
                order.append((joint, second in reached))
                reached |= {first, second}
                left.remove(joint)
                break
        else:
            break
    for number, body in enumerate(mechanism.bodies):
        if body.name not in reached:
            raise fault(
                Sentence(
                    "no chain of joints leads from '{ground}' to body '{name}'; join it to '{ground}' or to"
                    " a body that is joined",
                    GROUND,
                    body.name,
                ),
                *("bodies", number, "name"),
            )
    return order


def _spanning(mechanism: MechanismParts, places: Mapping[str, tuple[Place, Place]]) -> list[MechanismJoint]:
    """Return a spanning tree of joints; joints that are poor choices for a cut come first."""
    driven = needed(mechanism)
    group = {GROUND: GROUND} | {body.name: body.name for body in mechanism.bodies}

    def root(name: str) -> str:
        while group[name] != name:
            name = group[name]
        return name

    chosen = []
    for joint in sorted(mechanism.all_joints, key=lambda each: _may_be_cut(each) and each.name not in driven):
        first, second = (root(place.body) for place in places[joint.name])
        if first != second:
            group[second] = first
            chosen.append(joint)
    return sorted(chosen, key=mechanism.all_joints.index)


def needed(mechanism: MechanismParts) -> set[str]:
    """Return the joints that something acts on, which the physics must therefore contain."""
    names = [actuator.target for actuator in mechanism.actuators]
    for item in mechanism.constraints:
        names += getattr(item, "gear", None) or getattr(item, "screw", None) or ()
    return {name.partition(".")[0] for name in names}


def _may_be_cut(joint: MechanismJoint) -> bool:
    own = ("stiffness", "damping", "friction", "range", "range_deg")
    return joint.kind in SOFT_CUTS and all(getattr(joint, key) is None for key in own)


def linkage_of(
    mechanism: MechanismParts,
    places: Mapping[str, tuple[Place, Place]],
    tree: Sequence[tuple[MechanismJoint, bool]],
    axis: tuple[float, ...],
) -> tuple[Linkage, tuple[str, ...], dict[str, tuple[int, int]]]:
    """Return the linkage, the bodies by number, and the cuts."""
    firsts, column = {}, 0
    for each in mechanism.all_joints:
        firsts[each.name] = column
        column += sum(part.width for part in each.primitives(axis))
    bodies, found, cuts = [GROUND], list[TreeJoint](), {}
    for joint, backwards in tree:
        ends = places[joint.name]
        found.append(_tree_joint(joint, ends, axis, bodies, first=firsts[joint.name], backwards=backwards))
        bodies.append(ends[0 if backwards else 1].body)
    within, acted = {joint.name for joint, _ in tree}, needed(mechanism)
    for item in mechanism.all_joints:
        if item.name not in within:
            ends = places[item.name]
            found.append(_tree_joint(item, ends, axis, bodies, first=firsts[item.name], backwards=False))
            soft = _may_be_cut(item) and item.name not in acted
            bodies.append("" if soft else f"{item.name}.ghost")
            cuts[item.name] = (len(bodies) - 1, bodies.index(ends[1].body))
    return Linkage(found), tuple(bodies), cuts


def _tree_joint(
    joint: MechanismJoint,
    ends: tuple[Place, Place],
    axis: tuple[float, ...],
    bodies: Sequence[str],
    *,
    first: int,
    backwards: bool,
) -> TreeJoint:
    turned = placed((0.0, 0.0, 0.0), [math.radians(angle) for angle in joint.rpy_deg])
    at_first = placed(ends[0].at, (0.0, 0.0, 0.0))
    at_second = turned @ placed([-value for value in ends[1].at], (0.0, 0.0, 0.0))
    parts, parent = joint.primitives(axis), ends[1 if backwards else 0].body
    return TreeJoint(
        name=joint.name,
        parent=bodies.index(parent),
        before=inverted(at_second) if backwards else at_first,
        primitives=parts[::-1] if backwards else parts,
        after=inverted(at_first) if backwards else at_second,
        sign=-1.0 if backwards else 1.0,
        first=first,
    )


def values_of(mechanism: MechanismParts) -> tuple[tuple[str, ...], dict[str, range], tuple[bool, ...]]:
    """Return names of all values, their columns by joint, and whether each is a length."""
    names, columns, slides = list[str](), {}, list[bool]()
    for joint in mechanism.all_joints:
        begin = len(names)
        for part in joint.primitives((0.0, 0.0, 1.0)):
            suffixes = ("rx", "ry", "rz") if part.kind == "ball" else (part.suffix,)
            names += [f"{joint.name}.{suffix}" if suffix else joint.name for suffix in suffixes]
            slides += [part.kind == "slide"] * part.width
        columns[joint.name] = range(begin, len(names))
    return tuple(names), columns, tuple(slides)
