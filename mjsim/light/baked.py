"""Baked light: light maps of static surfaces, one per group of lights that change together, and probes.

All light is linear and relative to full light, in which a surface has exactly its colour in the world file. Values of
pictures are linear light to the power of 1 / GAMMA; since colours are coded by the same power, coded light times a
coded colour is the coded product of both, and OpenGL can multiply bytes.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array

GAMMA = 2.2
"""Exponent from the value of a picture in [0, 1] to linear light."""
ALWAYS, GENERAL, LAMP, DOOR = "", "light", "lamp/", "door/"
"""Names of groups: light that never changes, the ambient light, and the prefixes of a lamp and of a door."""


@dataclass(frozen=True, slots=True, eq=False)
class LitSurface:
    """A static visible geom of the compiled model, in the frame of the world."""

    geom: int
    """Geom in the model."""
    points: Array
    """Corners, each once per chart that contains it, shape (n, 3) [m]."""
    normals: Array
    """Outward normal at each corner, shape (n, 3)."""
    texcoords: Array | None
    """Coordinates of each corner on the surface's own picture, as OpenGL gets them, shape (n, 2); None without one."""
    lightcoords: NDArray[np.float32]
    """Coordinates of each corner on the light map, columns and rows in [0, 1], shape (n, 2)."""
    triangles: NDArray[np.int32]
    """Indices of corners, counter-clockwise seen from outside, shape (m, 3)."""


@dataclass(frozen=True, slots=True, eq=False)
class LightGroup:
    """Light that is switched, dimmed or coloured together."""

    name: str
    """`""` for light that never changes, `light` for the ambient light, `lamp/NAME`, or `door/NAME`: the difference
    between the door open as events open it and closed, which may be negative; its weight is how far it is open, in [0,
    1]."""
    texels: NDArray[np.float16]
    """Irradiance of each texel for weight (1, 1, 1), relative to full light, red, green, blue, shape (h, w, 3)."""
    start: Array
    """Weight at the start of the world, red, green, blue, shape (3,)."""
    gain: float = 1.0
    """Factor of its light relative to physics, for the sky and ceilings in full light: on average, rooms are as bright
    as in plain light."""
    angle: float = 0.0
    """Angle of a door for weight 1, as events open it, positive to the left side of its wall [rad]."""


@dataclass(frozen=True, slots=True, eq=False)
class LightProbes:
    """Light at the points of a regular grid, for moving objects."""

    origin: Array
    """First point, world frame, shape (3,) [m]."""
    spacing: Array
    """Distance of neighbours along x, y and z, shape (3,) [m]."""
    light: NDArray[np.float16]
    """Mean irradiance on the six faces of a small upright cube, shape (groups, nx, ny, nz, 3)."""


@dataclass(frozen=True, slots=True, eq=False)
class BakedLight:
    """The light of a compiled world."""

    surfaces: tuple[LitSurface, ...]
    groups: tuple[LightGroup, ...]
    probes: LightProbes
    exposure: float
    """Factor of all light in pictures; below 1 where the light at the start is brighter than full light."""

    def weights(self, changed: Mapping[str, Array] | None = None) -> Array:
        """Return the weight of each group, shape (groups, 3).

        Args:
            changed: Weights, shape (3,) each, of groups that differ from the start, by name.
        """
        changed = changed or {}
        return np.array([changed.get(group.name, group.start) for group in self.groups], dtype=float)

    def total(self, weights: Array) -> NDArray[np.float32]:
        """Return the exposed light of all groups, shape (h, w, 3); may be above 1, and never negative.

        Args:
            weights: As `weights` returns them.
        """
        total = np.zeros(self.groups[0].texels.shape, np.float32)
        for group, weight in zip(self.groups, weights, strict=True):
            if weight.any():
                total += group.texels.astype(np.float32) * weight.astype(np.float32)
        exposed: NDArray[np.float32] = np.maximum(np.float32(self.exposure) * total, np.float32(0.0))
        return exposed


def linear(value: Array | float) -> Array:
    """Return the linear light of values of pictures; 1 is full light."""
    return np.asarray(np.power(value, GAMMA), dtype=float)


def coded(light: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Return the bytes of a light map: light up to 1, coded like the values of pictures."""
    return np.rint(255.0 * np.power(np.clip(light, 0.0, 1.0), 1.0 / GAMMA)).astype(np.uint8)
