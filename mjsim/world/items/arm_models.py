"""Arms read from files, as `mjsim.mechanics` represents them."""

from typing import TYPE_CHECKING

import numpy as np

from mjsim.geometry import Array

if TYPE_CHECKING:  # Imported again where it is used, so that worlds that do not need it load faster.
    from mjsim.mechanics import Arm, Link
    from mjsim.models import FileArm

POSTURES = 4
"""Number of postures at which each joint is checked for mass that it moves."""
MIN_INERTIA = 1e-12
"""Smallest inertia or mass that a joint must move [kg m^2, kg]."""
THIN, THINNEST = 0.04, 0.01
"""Radius of a link that is drawn as a line or has no mass: as a fraction of the arm's length, and the minimum [m]."""


def arm_of(file: "FileArm", name: str) -> "Arm":
    """Return the arm of a file, with its base at the origin of the file and without a tool."""
    from mjsim.mechanics import Arm

    length = sum(float(np.linalg.norm(link.before[:3, 3])) for link in file.links)
    radius = max(THIN * length, THINNEST)
    links = tuple(_link(file, number, radius) for number in range(len(file.links)))
    return Arm(links=links, name=name, flange=file.flange, end=file.end)


def faulty_joint(arm: "Arm") -> int | None:
    """Return the index of a joint that moves no mass, from 0; None if there is none."""
    q = np.random.default_rng(0).uniform(-1.0, 1.0, (POSTURES, arm.n))
    moved = np.diagonal(arm.inertia(q), axis1=-2, axis2=-1).max(axis=0)
    return next((number for number, inertia in enumerate(moved.tolist()) if inertia < MIN_INERTIA), None)


def _link(file: "FileArm", number: int, radius: float) -> "Link":
    from mjsim.mechanics import Link, Solid, capsule, inverted

    link = file.links[number]
    start, end = inverted(link.after)[:3, 3], _far_end(file, number)
    x, y, z = link.center.tolist()
    xx, yy, zz, xy, yz, xz = link.inertia[[0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]].tolist()
    solid = Solid(link.mass, (x, y, z), (xx, yy, zz, xy, yz, xz)) if link.mass is not None else None
    solid = solid or capsule(start, end, radius)
    return Link(
        before=link.before,
        after=link.after,
        slide=link.slide,
        lower=link.bounds[0],
        upper=link.bounds[1],
        mass=solid.mass,
        center=solid.center,
        inertia=solid.inertia,
        rotor_inertia=link.armature,
        viscous=link.damping,
        coulomb=(link.friction, -link.friction),
        max_torque=link.max_torque,
        max_velocity=link.max_velocity,
        bone=(_point(start), _point(end)),
        radius=radius,
        label=link.name,
        parent=link.parent,
    )


def _far_end(file: "FileArm", number: int) -> Array:
    """Return the end of a link's line, link frame, shape (3,) [m]: the next joint, the flange or the centre of mass."""
    ahead = [link.before[:3, 3] for link in file.links if link.parent == number]
    if number == file.end:
        return np.asarray(file.flange[:3, 3], dtype=float)
    return ahead[0] if ahead else file.links[number].center


def _point(values: Array) -> tuple[float, float, float]:
    x, y, z = values.tolist()
    return x, y, z
