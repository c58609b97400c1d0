"""Mass and inertia of a capsule, and checks of inertias.

An inertia is six numbers: Ixx, Iyy, Izz, Ixy, Iyz, Ixz [kg m^2], about the centre of mass.
"""

import math
from dataclasses import dataclass

import numpy as np

from mjsim.geometry import Array, nearest_moments
from mjsim.sentences import Sentence

DENSITY = 1000.0
"""Density of a link without given mass [kg/m^3]."""
ROUNDING = 1e-9
"""Tolerance for negative principal moments by rounding, relative to the largest."""
MIN_MASS, MIN_MOMENT = 1e-6, 1e-9
"""Minimum mass and moment of a body for plain MuJoCo [kg, kg m^2]."""

Vector3 = tuple[float, float, float]
Six = tuple[float, float, float, float, float, float]


@dataclass(frozen=True, slots=True)
class Solid:
    """Mass, centre and inertia of a rigid body."""

    mass: float
    """[kg]"""
    center: Vector3
    """Centre of mass in the frame of the body [m]."""
    inertia: Six
    """Inertia about the centre, along the axes of that frame [kg m^2]."""


def tensor(inertia: Six) -> Array:
    """Return an inertia as a symmetric matrix, shape (3, 3) [kg m^2]."""
    xx, yy, zz, xy, yz, xz = inertia
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], dtype=float)


def six_of(matrix: Array) -> Six:
    """Return a symmetric matrix, shape (3, 3), as six numbers."""
    xx, yy, zz, xy, yz, xz = matrix[[0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]].tolist()
    return xx, yy, zz, xy, yz, xz


def capsule(start: Array, end: Array, radius: float) -> Solid:
    """Return mass, centre and inertia of a capsule of 1000 kg/m^3; a sphere where both ends are one point.

    Args:
        start: Centre of one end, shape (3,) [m].
        end: Centre of the other end, shape (3,) [m].
        radius: [m]

    References:
        A cylinder and two half spheres, whose centres lie 3/8 radius beyond its ends: Eberly, Polyhedral Mass
        Properties (2002), or any table of moments of inertia.
    """
    along = np.asarray(end, dtype=float) - start
    length = float(np.linalg.norm(along))
    tube, ball = DENSITY * math.pi * radius**2 * length, DENSITY * 4.0 / 3.0 * math.pi * radius**3
    across = tube * (radius**2 / 4.0 + length**2 / 12.0)
    across += ball * (0.4 * radius**2 + length**2 / 4.0 + 0.375 * radius * length)
    axial = 0.5 * tube * radius**2 + 0.4 * ball * radius**2
    axis = along / length if length > 0.0 else np.array([0.0, 0.0, 1.0])
    inertia = across * np.eye(3) + (axial - across) * np.outer(axis, axis)
    x, y, z = (0.5 * (np.asarray(start) + end)).tolist()
    return Solid(tube + ball, (x, y, z), six_of(inertia))


def check_inertia(inertia: Six) -> None:
    """Check that an inertia is possible for a rigid body, or one with rotors; raises ValueError otherwise.

    An inertia that violates the triangle inequality is accepted: published tables have links with one moment only.
    """
    moments = np.linalg.eigvalsh(tensor(inertia))
    if moments[0] < -ROUNDING * np.abs(moments).max():
        raise ValueError(
            Sentence(
                "the smallest principal moment of the inertia is {moments:.4g} kg m^2; it must not be below 0",
                moments[0],
            )
        )


def nearest_valid(solid: Solid) -> Solid:
    """Return the nearest mass and inertia valid in plain MuJoCo: positive, and no moment above the sum of the others.

    Principal axes are kept. The change of the moments is minimal in the least-squares sense.
    """
    moments, axes = np.linalg.eigh(tensor(solid.inertia))
    moments = np.maximum(nearest_moments(moments), MIN_MOMENT)
    if moments[2] > moments[0] + moments[1]:  # where the others were raised from below 0
        moments[2] = moments[0] + moments[1]
    return Solid(max(solid.mass, MIN_MASS), solid.center, six_of(axes @ np.diag(moments) @ axes.T))


def is_valid(solid: Solid) -> bool:
    """Return whether mass and inertia are valid in plain MuJoCo."""
    moments = np.linalg.eigvalsh(tensor(solid.inertia))
    return solid.mass >= MIN_MASS and moments[0] >= MIN_MOMENT and moments[2] <= moments[0] + moments[1]
