"""Rays from texels: what they hit, and how much light of rectangles reaches them. Runs in several processes.

Random numbers depend only on the number of a texel, and work is divided in the same way for any number of processes, so
that the light is the same bit for bit.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array

START_OFFSET = 0.002
"""Distance of the start of a ray from its surface [m]."""
END_OFFSET = 0.004
"""Distance before a lamp or a window at which a ray to it ends [m]."""
WINDOW_CELL = -2
"""Cell of a window: it is a light source of its own, so that rays through it add nothing."""
COARSE_RAYS, FINE_RAYS = 2, 8
"""Rays per side of a rectangle, for all texels, and for those that see only a part of it."""
HORIZON_TOLERANCE = 1e-5
"""Points this far below the horizon still count as on it [m]."""
NEGLIGIBLE_LIGHT = 4e-4
"""Maximum light of a rectangle that is neglected, relative to full light."""

NARROW_GAP = 0.08
"""A surface nearer than this counts as very near: the darkness of narrow gaps must not spread beyond them [m]."""

Numbers = NDArray[np.int64]
Light = NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class Rectangle:
    """A lamp or a window, which shines evenly to one side."""

    middle: Array
    """World frame, shape (3,) [m]."""
    across: Array
    """Half of one side, shape (3,) [m]."""
    along: Array
    """Half of the other, shape (3,) [m]."""
    radiance: float
    """Radiance relative to full light: pi times it is the light on a surface that sees nothing else."""

    @property
    def outward(self) -> Array:
        """Unit vector to the side on which it shines, shape (3,)."""
        normal = np.cross(self.across, self.along)
        return np.asarray(normal / np.linalg.norm(normal), dtype=float)

    @property
    def area(self) -> float:
        """Area [m^2]."""
        return 4.0 * float(np.linalg.norm(np.cross(self.across, self.along)))


@dataclass(frozen=True, slots=True, eq=False)
class Points:
    """Points on surfaces."""

    numbers: Numbers
    """Number of each, which determines its random numbers, shape (n,)."""
    points: Array
    """World frame, shape (n, 3) [m]."""
    normals: Array
    """Unit vectors, shape (n, 3)."""

    def some(self, chosen: Any) -> "Points":
        """Return some of them."""
        return Points(self.numbers[chosen], self.points[chosen], self.normals[chosen])


@dataclass(frozen=True, eq=False)
class Room:
    """All that rays can hit."""

    corners: Light
    """Corners of triangles, world frame, shape (n, 3, 3) [m]."""

    @cached_property
    def _scene(self) -> Any:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        scene = EmbreeScene()
        TriangleMesh(scene, np.ascontiguousarray(self.corners, dtype=np.float32))
        return scene

    def first(self, starts: Light, directions: Light) -> tuple[NDArray[np.int32], Light, NDArray[np.bool_]]:
        """Return the triangle that each ray hits first, -1 for none, the distance [m], and whether from behind."""
        hits = self._scene.run(starts, directions, output=1)
        behind = np.einsum("ij,ij->i", hits["Ng"], directions) > 0.0
        return hits["primID"], hits["tfar"], (hits["primID"] >= 0) & behind

    def is_free(self, starts: Light, directions: Light, lengths: Light) -> NDArray[np.bool_]:
        """Return whether rays reach a length [m] unhindered."""
        free: NDArray[np.bool_] = self._scene.run(starts, directions, lengths, query="OCCLUDED") < 0
        return free


def uniform(numbers: Numbers, stream: int) -> Light:
    """Return random numbers in [0, 1) that depend only on given numbers and a stream, shape (n,).

    References:
        Steele, Lea, Flood: Fast splittable pseudorandom number generators (2014): the mixing function of SplitMix64.
    """
    z = (numbers.astype(np.uint64) << np.uint64(16)) + np.uint64(stream + 1)
    z = z * np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return ((z ^ (z >> np.uint64(31))) >> np.uint64(40)).astype(np.float32) * np.float32(2.0**-24)


def hemisphere(at: Points, side: int) -> Any:
    """Yield the directions of side x side rays of each point, proportional to the cosine, shape (n, 3) each."""
    normals = at.normals.astype(np.float32)
    up = np.where(np.abs(normals[:, 2:]) < 0.9, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]).astype(np.float32)
    across = np.cross(normals, up)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    along = np.cross(normals, across)
    for ray in range(side * side):
        i, j = divmod(ray, side)
        squared = (i + uniform(at.numbers, 2 * ray)) / np.float32(side)
        angle = np.float32(2.0 * np.pi / side) * (j + uniform(at.numbers, 2 * ray + 1))
        radius = np.sqrt(squared)
        yield np.ascontiguousarray(
            (radius * np.cos(angle))[:, None] * across
            + (radius * np.sin(angle))[:, None] * along
            + np.sqrt(1.0 - squared)[:, None] * normals
        )


def starts_of(at: Points) -> Light:
    """Return where the rays of points begin, shape (n, 3) [m]."""
    return np.ascontiguousarray(at.points + START_OFFSET * at.normals, dtype=np.float32)


def buried_share(room: Room, at: Points, side: int) -> Light:
    """Return the share of side x side rays of each point that hit a surface from behind or very near, shape (n,)."""
    starts = starts_of(at)
    hits = []
    for directions in hemisphere(at, side):
        triangles, distances, behind = room.first(starts, directions)
        hits.append(behind | ((triangles >= 0) & (distances < NARROW_GAP)))
    return np.asarray(np.mean(hits, axis=0), dtype=np.float32)


def light_of(room: Room, at: Points, rectangle: Rectangle) -> Light:
    """Return the light of a rectangle on points, relative to full light, shape (n,)."""
    light = np.zeros(len(at.points), np.float32)
    chosen = np.flatnonzero(_estimate(at, rectangle) > NEGLIGIBLE_LIGHT)
    if not len(chosen):
        return light
    seen, some = _sampled(room, at.some(chosen), rectangle, COARSE_RAYS)
    form, whole = _form(at.some(chosen), rectangle)
    partly = (seen > 0.0) & (seen < 1.0)
    if partly.any():
        seen[partly], some[partly] = _sampled(room, at.some(chosen[partly]), rectangle, FINE_RAYS)
    light[chosen] = np.where(whole, form * seen, some)
    return light


def _estimate(at: Points, rectangle: Rectangle) -> Array:
    """Return an upper estimate of the light of a rectangle, shape (n,)."""
    to = rectangle.middle - at.points
    reach = float(np.linalg.norm(rectangle.across) + np.linalg.norm(rectangle.along))
    distance = np.maximum(np.linalg.norm(to, axis=1) - reach, 0.05)
    towards = np.einsum("ij,ij->i", at.normals, to) + reach
    away = np.where(-(to @ rectangle.outward) > 1e-3, -(to @ rectangle.outward) + reach, 0.0)
    cosines = np.minimum(np.clip(towards, 0.0, None) / distance, 1.0) * np.minimum(away / distance, 1.0)
    return np.asarray(rectangle.radiance * rectangle.area * cosines / distance**2, dtype=float)


def _form(at: Points, rectangle: Rectangle) -> tuple[Array, NDArray[np.bool_]]:
    """Return the light of a rectangle that nothing hides, and whether all of it is above the horizon, shape (n,) both.

    References:
        Arvo: The irradiance Jacobian for partially occluded polyhedral sources (1994), equation 1, after Lambert.
    """
    a, b = rectangle.across, rectangle.along
    to = rectangle.middle + np.array([-a - b, b - a, a + b, a - b]) - at.points[:, None]
    # A window that ends in the plane of its own reveal counts as above the horizon.
    whole = (np.einsum("nkj,nj->nk", to, at.normals) > -HORIZON_TOLERANCE).all(axis=1)
    to /= np.maximum(np.linalg.norm(to, axis=2, keepdims=True), 1e-12)
    after = np.roll(to, -1, axis=1)
    edges = np.cross(to, after)
    lengths = np.linalg.norm(edges, axis=2)
    angles = np.arctan2(lengths, np.einsum("nkj,nkj->nk", to, after))
    form = np.einsum("nk,nkj,nj->n", angles / np.maximum(lengths, 1e-12), edges, at.normals) / 2.0
    return rectangle.radiance * np.abs(form), whole


def _sampled(room: Room, at: Points, rectangle: Rectangle, side: int) -> tuple[Light, Light]:
    """Return the visible share of a rectangle and its light by side x side rays, shape (n,) both."""
    starts = starts_of(at)
    seen, light = np.zeros(len(starts), np.float32), np.zeros(len(starts), np.float32)
    for ray in range(side * side):
        i, j = divmod(ray, side)
        # All points of the rectangle are shifted by the same amount, so that they stay evenly spaced.
        u = 2.0 * (i + uniform(at.numbers, 1001)) / side - 1.0
        v = 2.0 * (j + uniform(at.numbers, 1002)) / side - 1.0
        to = rectangle.middle + u[:, None] * rectangle.across + v[:, None] * rectangle.along - starts
        distance = np.linalg.norm(to, axis=1)
        to /= distance[:, None]
        cosines = np.clip(np.einsum("ij,ij->i", to, at.normals), 0.0, None) * np.clip(
            -(to @ rectangle.outward), 0, None
        )
        lengths = np.maximum(distance - END_OFFSET, 0.0).astype(np.float32)
        free = (cosines > 0.0) & room.is_free(starts, np.ascontiguousarray(to, dtype=np.float32), lengths)
        seen += free
        light += np.where(free, cosines / np.maximum(distance, 1e-3) ** 2, 0.0)
    share = 1.0 / side**2
    return seen * np.float32(share), light * np.float32(share * rectangle.radiance * rectangle.area)
