"""One link of an arm, the joint that moves it, and the motor of that joint."""

import math
from dataclasses import dataclass

import numpy as np

from mjsim.geometry import Array
from mjsim.mechanics.link_inertias import Six, Solid, Vector3, check_inertia
from mjsim.mechanics.transforms import is_rigid
from mjsim.sentences import Sentence


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Link:
    """A rigid body and the joint before it, revolute [rad, N m] or prismatic [m, N].

    Values of the motor are on its side of the gear: it turns `gear` times as fast as the joint.
    """

    before: Array
    """Frame of the joint in that of the link before, at value 0: previous_from_joint, shape (4, 4) [m]. The joint
    turns about, or slides along, its z axis."""
    after: Array
    """Frame of the link in that of the joint, which moves: joint_from_link, shape (4, 4) [m]."""
    slide: bool = False
    """Whether the joint slides."""
    lower: float = -math.inf
    """[rad, m]"""
    upper: float = math.inf
    """[rad, m]"""
    mass: float = 0.0
    """[kg]"""
    center: Vector3 = (0.0, 0.0, 0.0)
    """Centre of mass in the frame of the link [m]."""
    inertia: Six = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    """Ixx, Iyy, Izz, Ixy, Iyz, Ixz about the centre, along the axes of the link [kg m^2]."""
    gear: float = 1.0
    """Gear ratio, motor to joint [-, rad/m]; negative for opposite directions."""
    rotor_inertia: float = 0.0
    """[kg m^2]"""
    viscous: float = 0.0
    """Friction at the motor [N m s/rad]."""
    coulomb: tuple[float, float] = (0.0, 0.0)
    """Dry friction at the motor for positive motion of the joint (at least 0), and negative motion (at most 0) [N
    m]."""
    max_torque: float = math.inf
    """Maximum torque at the joint [N m, N]."""
    max_velocity: float = math.inf
    """Maximum velocity of the joint [rad/s, m/s]."""
    bone: tuple[Vector3, Vector3] = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    """Ends of the capsule that represents it, in its frame [m]."""
    radius: float = 0.05
    """Radius of that capsule [m]."""
    dh: tuple[float, float, float, float] | None = None
    """theta [rad], d [m], a [m], alpha [rad] of the table that it comes from."""
    label: str = ""
    """Name of its joint in the file that it comes from."""
    parent: int | None = None
    """Number of the link that carries it, counted from 0, -1 for the base; by default the one before it."""

    def __post_init__(self) -> None:
        """Check everything that does not depend on other links."""
        for name in ("before", "after"):
            matrix = np.array(getattr(self, name), dtype=float)
            if matrix.shape != (4, 4) or not np.isfinite(matrix).all() or not is_rigid(matrix):
                raise ValueError(Sentence("{name} is not a homogeneous transform of shape (4, 4)", name))
            matrix.flags.writeable = False
            object.__setattr__(self, name, matrix)
        _check_numbers(self)
        check_inertia(self.inertia)

    @property
    def solid(self) -> Solid:
        """Mass, centre and inertia."""
        return Solid(self.mass, self.center, self.inertia)

    @property
    def armature(self) -> float:
        """Inertia of the rotor reflected to the joint [kg m^2, kg]."""
        return self.gear**2 * self.rotor_inertia


def _check_numbers(link: Link) -> None:
    for name in ("mass", "center", "inertia", "gear", "rotor_inertia", "viscous", "coulomb", "radius", "bone"):
        if not np.isfinite(getattr(link, name)).all():
            raise ValueError(Sentence("{name} is {value}; it must be finite", name, getattr(link, name)))
    for name in ("mass", "rotor_inertia", "viscous"):
        if getattr(link, name) < 0.0:
            raise ValueError(Sentence("{name} is {value:g}; it must not be below 0", name, getattr(link, name)))
    for name in ("max_torque", "max_velocity", "radius"):
        if not getattr(link, name) > 0.0:
            raise ValueError(Sentence("{name} is {value:g}; it must be above 0", name, getattr(link, name)))
    if link.gear == 0.0:
        raise ValueError("gear is 0; it must not be 0")
    if link.coulomb[0] < 0.0 or link.coulomb[1] > 0.0:
        plus, minus = link.coulomb
        raise ValueError(
            Sentence("coulomb is [{plus:g}, {minus:g}]; the first must be 0 or more, the second 0 or less", plus, minus)
        )
    if not link.lower < link.upper:
        raise ValueError(
            Sentence("range is [{lower:g}, {upper:g}]; the first must be below the second", link.lower, link.upper)
        )
