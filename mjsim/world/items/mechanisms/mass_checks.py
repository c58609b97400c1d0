"""Checks that everything that moves has mass or inertia, without which forces determine no motion."""

import numpy as np

from mjsim.geometry import Array
from mjsim.mechanics import TreeJoint, tensor
from mjsim.sentences import Sentence
from mjsim.world.ground import fault
from mjsim.world.items.mechanisms.assembly import Assembly
from mjsim.world.items.mechanisms.mechanism_items import MechanismParts

MIN_INERTIA = 1e-14
"""Smallest mass or inertia that a joint must move: MuJoCo's own limit is a tenth of it [kg, kg m^2]."""
SINGULAR = 1e-12
"""A combination of values that moves no mass has an eigenvalue of the scaled mass matrix below this."""


def check_inertias(mechanism: MechanismParts, found: Assembly, values: Array) -> None:
    """Raise a fault for a joint that moves no mass and no inertia.

    Args:
        mechanism: Mechanism as written.
        found: Its assembly.
        values: Values at the start, shape (values,).
    """
    matrix = mass_matrix(mechanism, found, values)
    own = [column for name in {tree.name for tree in _carrying(found)} for column in found.columns[name]]
    matrix = matrix[np.ix_(own, own)]
    scale = np.diag(matrix)
    if len(own) and scale.min() >= MIN_INERTIA:
        sizes, vectors = np.linalg.eigh(matrix / np.sqrt(np.outer(scale, scale)))
        if sizes[0] >= SINGULAR:
            return
        scale = -np.abs(vectors[:, 0])
    if len(own):
        _refuse(mechanism, found, own[int(np.argmin(scale))])


def _carrying(found: Assembly) -> list[TreeJoint]:
    """Return the joints that place a body, not a ghost."""
    count = len(found.linkage.joints) - len(found.cuts) - len(found.tracks)
    return list(found.linkage.joints[:count])


def mass_matrix(mechanism: MechanismParts, found: Assembly, values: Array) -> Array:
    """Return the mass matrix of the tree, shape (values, values) [kg, kg m, kg m^2]."""
    linkage = found.linkage
    placement, total = linkage.place(values), np.zeros((linkage.size, linkage.size))
    for body in mechanism.bodies:
        solid, number = body.solid(), found.number(body.name)
        pose = placement.poses[number]
        slope = linkage.point_jacobian(placement, number, pose[:3, :3] @ solid.center + pose[:3, 3])
        turn = pose[:3, :3].T @ linkage.turn_jacobian(placement, number)
        total += solid.mass * slope.T @ slope + turn.T @ tensor(solid.inertia) @ turn
    return total


def _refuse(mechanism: MechanismParts, found: Assembly, column: int) -> None:
    name = next(name for name, own in found.columns.items() if column in own)
    number = next(place for place, joint in enumerate(mechanism.all_joints) if joint.name == name)
    tree = next(k for k, tree in enumerate(found.linkage.joints, start=1) if tree.name == name)
    raise fault(
        Sentence(
            "joint '{name}' moves no mass and no inertia, so its motion is undetermined; give body '{body}' an inertia",
            name,
            found.bodies[tree],
        ),
        *(("joints", number) if number < len(mechanism.joints) else mechanism.written(number)),
    )
