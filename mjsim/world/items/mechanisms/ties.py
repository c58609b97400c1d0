"""Couplings between values that the constraints of a mechanism impose."""

import math

import numpy as np

from mjsim.geometry import Array
from mjsim.mechanics import Apart, BodyPoint, Linear, Rows
from mjsim.sentences import Sentence
from mjsim.world.ground import fault
from mjsim.world.items.mechanisms.assembly import Assembly, Coupling, Rod, Spring
from mjsim.world.items.mechanisms.constraints import (
    DistanceConstraint,
    GearConstraint,
    ScrewConstraint,
    SpringConstraint,
)
from mjsim.world.items.mechanisms.many_joints import ScrewJoint
from mjsim.world.items.mechanisms.mechanism_items import MechanismParts
from mjsim.world.items.mechanisms.motions import spots_of
from mjsim.world.items.mechanisms.tree import Points


def couplings_of(mechanism: MechanismParts, found: Assembly) -> tuple[Coupling, ...]:
    """Return the coupled values: those of screw joints, and of gears and screws between joints."""
    made = list[Coupling]()
    for joint in mechanism.all_joints:
        if isinstance(joint, ScrewJoint):
            turn = found.columns[joint.name].start
            ratio = joint.pitch / (2.0 * math.pi)
            made.append(Coupling(name=f"{joint.name}.thread", first=turn + 1, second=turn, ratio=ratio))
    for number, item in enumerate(mechanism.constraints):
        name = item.called(number)
        if isinstance(item, GearConstraint):
            first, second = _columns(found, item.gear, (False, False), ("constraints", number, "gear"))
            made.append(Coupling(name=name, first=first, second=second, ratio=item.ratio))
        elif isinstance(item, ScrewConstraint):
            turn, slide = _columns(found, item.screw, (False, True), ("constraints", number, "screw"))
            made.append(Coupling(name=name, first=slide, second=turn, ratio=item.pitch / (2.0 * math.pi)))
    return tuple(made)


def _columns(
    found: Assembly, names: tuple[str, ...], slides: tuple[bool, bool], path: tuple[str | int, ...]
) -> tuple[int, int]:
    columns = []
    for place, (name, slide) in enumerate(zip(names, slides, strict=True)):
        try:
            column = found.moved_column(name)
        except ValueError as error:
            raise fault(str(error), *path, place) from None
        if found.slides[column] != slide:
            does, should = ("slides", "turns") if found.slides[column] else ("turns", "slides")
            raise fault(Sentence("joint '{name}' {does}; name one that {should}", name, does, should), *path, place)
        columns.append(column)
    if columns[0] == columns[1]:
        raise fault(Sentence("joint '{name}' is tied to itself; name two joints", names[0]), *path)
    return columns[0], columns[1]


def rods_of(mechanism: MechanismParts, found: Assembly, points: Points) -> tuple[Rod, ...]:
    """Return the constant distances."""
    made = list[Rod]()
    for number, item in enumerate(mechanism.constraints):
        if isinstance(item, DistanceConstraint):
            ends = spots_of(item.distance, found, points, ("constraints", number, "distance"))
            made.append(Rod(name=item.called(number), ends=ends, length=item.length))
    return tuple(made)


def springs_of(mechanism: MechanismParts, found: Assembly, points: Points) -> tuple[Spring, ...]:
    """Return the springs between points."""
    return tuple(
        Spring(
            name=item.called(number),
            ends=spots_of(item.spring, found, points, ("constraints", number, "spring")),
            stiffness=item.stiffness,
            damping=item.damping,
            rest=item.rest,
        )
        for number, item in enumerate(mechanism.constraints)
        if isinstance(item, SpringConstraint)
    )


def tied_rows(found: Assembly, start: Array | None) -> list[Rows]:
    """Return the equations of the couplings.

    Args:
        found: The mechanism.
        start: Values at the start, shape (values,), which gears and distances are relative to; None while they are
            unknown, for the equations that hold in any case.
    """
    rows = list[Rows]()
    for each in found.couplings:
        factors = {each.first: 1.0, each.second: -each.ratio}
        if start is not None:
            rows.append(Linear(factors, float(start[each.first] - each.ratio * start[each.second])))
        elif each.name.endswith(".thread"):
            rows.append(Linear(factors))
    for rod in found.rods:
        if rod.length is not None:
            rows.append(Apart(rod.ends, rod.length))
        elif start is not None:
            rows.append(Apart(rod.ends, end_distance(found, rod.ends, start)))
    return rows


def end_distance(found: Assembly, ends: tuple[BodyPoint, BodyPoint], values: Array) -> float:
    """Return the distance of two points [m]."""
    placement = found.linkage.place(values)
    return float(np.linalg.norm(ends[1].place(placement) - ends[0].place(placement)))
