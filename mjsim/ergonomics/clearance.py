"""Clearances between a person's body and the surroundings."""

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from mjsim.ergonomics.sight import name_of
from mjsim.world import Person

MAX_CLEARANCE = 0.3
"""Larger clearances are not computed [m]."""
CONTACT_GROUPS = (0, 3)
"""Geom groups with contact."""
MAX_ROWS = 12
"""Number of clearances returned, the smallest first, in addition to all overlaps."""
SOFT_TISSUE_DEPTH = 0.01
"""Soft tissue and soles yield by this much; deeper overlaps count as collisions [m]; assumed, no source."""


@dataclass(frozen=True, slots=True)
class Clearance:
    """The smallest distance between a segment and an object; negative for overlap."""

    segment: str
    thing: str
    distance: float
    """[m]"""


def clearances(model: mujoco.MjModel, data: mujoco.MjData, person: str, *, count: int = MAX_ROWS) -> list[Clearance]:
    """Return the smallest clearances of a person, one per object and segment, the smallest first.

    Shapes are treated as convex: a mesh is replaced by its convex hull, as in MuJoCo's contacts.

    Args:
        model: The compiled world.
        data: Its state after `mj_kinematics`.
        person: Name of the person.
        count: Number of clearances returned, or all overlaps if there are more.
    """
    bodies = np.array([model.body(int(body)).name.partition("/")[0] == person for body in range(model.nbody)])
    solid = np.isin(model.geom_group, CONTACT_GROUPS) & ((model.geom_contype != 0) | (model.geom_conaffinity != 0))
    plane = model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE
    own = np.flatnonzero(bodies[model.geom_bodyid] & solid)
    others = np.flatnonzero(~bodies[model.geom_bodyid] & solid & ~plane)
    found: dict[tuple[str, str], float] = {}
    for geom in own.tolist():
        for other in others.tolist():
            between = float(np.linalg.norm(data.geom_xpos[geom] - data.geom_xpos[other]))
            if between > model.geom_rbound[geom] + model.geom_rbound[other] + MAX_CLEARANCE:
                continue
            distance = mujoco.mj_geomDistance(model, data, geom, other, MAX_CLEARANCE, None)
            key = model.body(int(model.geom_bodyid[geom])).name.partition("/")[2], name_of(model, other)
            if distance < found.get(key, MAX_CLEARANCE):
                found[key] = distance
    overlaps = sum(distance < 0.0 for distance in found.values())
    ranked = sorted(found.items(), key=lambda item: item[1])[: max(count, overlaps)]
    return [Clearance(segment, thing, distance) for (segment, thing), distance in ranked]


def collisions(found: Sequence[Clearance], person: Person) -> list[Clearance]:
    """Return the collisions of a posture, deepest first, one per segment and object of the world.

    Contact of the body with its seat, and overlap of a hand or foot with the object of its target, are intended.

    Args:
        found: Clearances, from `clearances`.
        person: The seated person.
    """
    deepest: dict[tuple[str, str], Clearance] = {}
    for each in sorted(found, key=lambda each: each.distance):
        if each.distance < -SOFT_TISSUE_DEPTH and not _is_meant(each, person):
            deepest.setdefault((each.segment, each.thing.partition("/")[0]), each)
    return list(deepest.values())


def _is_meant(clearance: Clearance, person: Person) -> bool:
    side, _, part = clearance.segment.partition("_")
    held = {"hand": person.hands, "foot": person.feet}.get(part)
    target = None if held is None else getattr(held, side)
    meant = [name for name in (person.seat, target and target.rpartition(".")[0]) if name is not None]
    return any(clearance.thing == name or clearance.thing.startswith(f"{name}/") for name in meant)
