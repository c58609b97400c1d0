"""Torques of a chain of links: Newton and Euler's equations, all vectors in the world frame.

In one frame velocities are sums from the base outwards, and forces sums from the tool inwards, so no loop is needed.

References:
    Featherstone, Rigid Body Dynamics Algorithms (2008), sections 5.3 and 6.2; Corke, Robotics, Vision and Control
    (2017), section 9.1 for motors, gears and friction; Slotine and Li, Int. J. of Robotics Research 6(3), 1987, for
    the product of inertial parameters.
"""

from dataclasses import dataclass

import numpy as np

from mjsim.geometry import Array
from mjsim.mechanics.arm_links import Link
from mjsim.mechanics.chain import Chain, Posture
from mjsim.mechanics.link_inertias import tensor
from mjsim.mechanics.transforms import cross, skew


@dataclass(frozen=True, slots=True, eq=False)
class Masses:
    """Masses, inertias and motors of the links as arrays."""

    mass: Array
    """Shape (n,) [kg]."""
    center: Array
    """Centre of mass in the frame of each link, with a 1 below, shape (n, 4) [m]."""
    inertia: Array
    """Inertia about the centre in the frame of each link, shape (n, 3, 3) [kg m^2]."""
    armature: Array
    """Inertia of the rotors at the joints, shape (n,) [kg m^2, kg]."""
    viscous: Array
    """Friction at the joints, shape (n,) [N m s/rad, N s/m]."""
    coulomb: Array
    """Dry friction at the joints to plus and to minus, shape (2, n) [N m, N]."""


@dataclass(frozen=True, slots=True, eq=False)
class LinkMotion:
    """Accelerations and spins of links, world frame, each of shape (..., n, 3)."""

    spin: Array
    """[rad/s]"""
    spin_rate: Array
    """[rad/s^2]"""
    swing: Array
    """Accelerations of a link's points as a linear function of their relative positions, shape (..., n, 3, 3)
    [1/s^2]."""
    origin: Array
    """Acceleration of the link's point at its joint, minus gravity [m/s^2]."""


def masses_of(links: tuple[Link, ...]) -> Masses:
    """Return masses, inertias and motors of links as arrays."""
    gears = np.array([abs(link.gear) for link in links])
    return Masses(
        mass=np.array([link.mass for link in links]),
        center=np.array([[*link.center, 1.0] for link in links]),
        inertia=np.array([tensor(link.inertia) for link in links]),
        armature=np.array([link.armature for link in links]),
        viscous=np.array([link.viscous for link in links]) * gears**2,
        coulomb=np.array([link.coulomb for link in links]).T * gears,
    )


def motion_of(chain: Chain, posture: Posture, qd: Array, qdd: Array, gravity: Array) -> LinkMotion:
    """Return the motion of all links; rates have shape (..., n), gravity (3,) [m/s^2].

    The acceleration of a joint's point is the sum over the rigid parts of the arm before it, and over the prismatic
    joints before it with their Coriolis terms.
    """
    axes, points = posture.axes, posture.points
    turn = axes * (chain.turns * qd)[..., None]
    spin = chain.outwards(turn)
    before = spin - turn
    spin_rate = chain.outwards(axes * (chain.turns * qdd)[..., None] + cross(before, turn))
    steps = np.zeros_like(spin_rate)
    if chain.slides.any():
        slide = axes * (chain.slides * qd)[..., None]
        steps += axes * (chain.slides * qdd)[..., None] + 2.0 * cross(before, slide)
    # The base neither rotates nor accelerates, so the offsets from it contribute nothing.
    joints, carriers = chain.jointed, chain.carriers
    stretch, swing = points.take(joints, -2) - points.take(carriers, -2), _swing(spin, spin_rate)
    steps[..., joints, :] += (swing.take(carriers, -3) @ stretch[..., None])[..., 0]
    return LinkMotion(spin, spin_rate, swing, chain.outwards(steps) - gravity)


def _swing(spin: Array, spin_rate: Array) -> Array:
    """Return the matrices that give accelerations of points of turning bodies, shape (..., n, 3, 3) [1/s^2]."""
    turn = skew(spin)
    return np.asarray(turn @ turn + skew(spin_rate))


def rigid_torques(chain: Chain, masses: Masses, posture: Posture, qd: Array, *, qdd: Array, gravity: Array) -> Array:
    """Return the torques for the links, without rotors and friction, shape (..., n) [N m, N]."""
    motion = motion_of(chain, posture, qd, qdd, gravity)
    rotation = posture.links[..., :3, :3]
    centers = (posture.links @ masses.center[:, :, None])[..., :3, 0]
    arm = centers - posture.points
    spin, spin_rate = motion.spin, motion.spin_rate
    acceleration = motion.origin + (motion.swing @ arm[..., None])[..., 0]
    inertia = rotation @ masses.inertia @ np.swapaxes(rotation, -1, -2)
    force = masses.mass[:, None] * acceleration
    moment = (inertia @ spin_rate[..., None])[..., 0] + cross(spin, (inertia @ spin[..., None])[..., 0])
    return _at_joints(chain, posture, force, moment + cross(arm, force))


def gravity_torques(chain: Chain, masses: Masses, posture: Posture, gravity: Array) -> Array:
    """Return the torques that hold the links up, shape (..., n) [N m, N], in gravity (3,) [m/s^2]."""
    centers = (posture.links @ masses.center[:, :, None])[..., :3, 0]
    force = np.broadcast_to(-masses.mass[:, None] * gravity, centers.shape)
    return _at_joints(chain, posture, force, cross(centers - posture.points, force))


def _at_joints(chain: Chain, posture: Posture, force: Array, moment: Array) -> Array:
    """Return the joint torques, shape (..., n), for a force on each link and a moment about its joint's point."""
    points, force_beyond = posture.points, chain.inwards(force)
    about_origin, beyond_origin = cross(points, np.stack([force, force_beyond]))
    moment_beyond = chain.inwards(moment + about_origin) - beyond_origin
    given = chain.slides[:, None] * force_beyond + chain.turns[:, None] * moment_beyond
    result: Array = (posture.axes * given).sum(axis=-1)
    return result


def friction(masses: Masses, qd: Array) -> Array:
    """Return the torques of friction in the motors, shape (..., n) [N m, N]."""
    plus, minus = masses.coulomb
    result: Array = masses.viscous * qd + np.where(qd > 0.0, plus, np.where(qd < 0.0, minus, 0.0))
    return result


def mass_matrix(chain: Chain, masses: Masses, posture: Posture) -> Array:
    """Return the mass matrix, including rotors, shape (..., n, n) [kg m^2, kg m, kg].

    M = sum over links of m Jv^T Jv + Jw^T I Jw (Spong, Hutchinson, Vidyasagar (2006), equation 7.50).
    """
    carried = chain.carried[:, :, None]
    axes, rotation = posture.axes[..., None, :, :], posture.links[..., :3, :3]
    centers = (posture.links @ masses.center[:, :, None])[..., :3, 0]
    arms = centers[..., :, None, :] - posture.points[..., None, :, :]
    slides, turns = chain.slides[:, None], chain.turns[:, None]
    linear = carried * (slides * axes + turns * cross(axes, arms))
    angular = (carried * turns * axes) @ rotation  # along the axes of the links
    both = (linear * masses.mass[:, None, None]) @ np.swapaxes(linear, -1, -2)
    both += angular @ masses.inertia @ np.swapaxes(angular, -1, -2)
    return np.asarray(both.sum(axis=-3) + np.diag(masses.armature))


def regressor(chain: Chain, posture: Posture, qd: Array, *, qdd: Array, gravity: Array) -> Array:
    """Return the matrix Y of `rigid_torques` = Y @ parameters, shape (..., n, 10 n).

    The ten parameters of each link are its mass, its mass times its centre in the link's frame (3), and its inertia
    Ixx, Iyy, Izz, Ixy, Iyz, Ixz about the link's origin (6).
    """
    motion = motion_of(chain, posture, qd, qdd, gravity)
    rotation = posture.links[..., :3, :3]
    arm = posture.links[..., :3, 3] - posture.points
    spin, spin_rate = motion.spin, motion.spin_rate
    origin = motion.origin + cross(spin_rate, arm) + cross(spin, cross(spin, arm))
    forces, moments = _by_parameter(rotation, origin, spin, spin_rate)
    # Contribution of each link's parameters, shape (..., 10, n, 3), to the torque of each joint.
    axes = posture.axes[..., :, None, None, :]
    lever = (posture.links[..., None, None, :, :3, 3]) - posture.points[..., :, None, None, :]
    forces, moments = forces[..., None, :, :, :], moments[..., None, :, :, :]
    slides, turns = chain.slides[:, None, None, None], chain.turns[:, None, None, None]
    shares = (axes * (slides * forces + turns * (moments + cross(lever, forces)))).sum(axis=-1)
    carried = chain.carried.T[:, None, :]  # joint, parameter, link
    columns = np.swapaxes(shares * carried, -1, -2)
    return np.asarray(columns.reshape(*columns.shape[:-2], -1))


def _by_parameter(rotation: Array, origin: Array, spin: Array, spin_rate: Array) -> tuple[Array, Array]:
    """Return force and moment about the link's origin of each parameter alone, shape (..., 10, n, 3) each."""
    columns = np.moveaxis(rotation, -1, -3)  # the link's axes in the world frame, shape (..., 3, n, 3)
    spin, spin_rate, origin = spin[..., None, :, :], spin_rate[..., None, :, :], origin[..., None, :, :]
    by_center = cross(spin_rate, columns) + cross(spin, cross(spin, columns))
    first, second = columns.take(_FIRST, -3), columns.take(_SECOND, -3)
    by_inertia = _unit_moment(first, second, spin_rate) + cross(spin, _unit_moment(first, second, spin))
    none = np.zeros_like(by_inertia)
    forces = np.concatenate([origin, by_center, none], axis=-3)
    return forces, np.concatenate([none[..., :1, :, :], cross(columns, origin), by_inertia], axis=-3)


_FIRST, _SECOND = np.array([0, 1, 2, 0, 1, 0]), np.array([0, 1, 2, 1, 2, 2])
"""Axes of Ixx, Iyy, Izz, Ixy, Iyz, Ixz."""
_ONCE = np.array([0.5, 0.5, 0.5, 1.0, 1.0, 1.0])[:, None, None]
"""A moment of inertia occurs once in the matrix, a product twice."""


def _unit_moment(first: Array, second: Array, vector: Array) -> Array:
    """Return I @ vector for inertias of one entry each, shape (..., 6, n, 3)."""
    along = second * (first * vector).sum(axis=-1, keepdims=True)
    return np.asarray(_ONCE * (along + first * (second * vector).sum(axis=-1, keepdims=True)))


def parameters(links: tuple[Link, ...]) -> Array:
    """Return the numbers that `regressor` multiplies, shape (10 n,)."""
    rows = []
    for link in links:
        center = np.array(link.center)
        about_origin = tensor(link.inertia) + link.mass * (center @ center * np.eye(3) - np.outer(center, center))
        rows.append([link.mass, *(link.mass * center), *about_origin[[0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]]])
    return np.array(rows).reshape(-1)
