"""Closed smooth surfaces through oval rings."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array

RING_POINTS = 24
"""Number of points of a ring."""
INTERPOLATED_RINGS = 4
"""Number of rings interpolated between two given ones."""
DOME_RINGS = 4
"""Number of rings of a rounded end."""


@dataclass(frozen=True, slots=True)
class Ring:
    """An oval cross-section of a limb or trunk, perpendicular to the axis of the surface."""

    along: float
    """Position of its plane along the axis [m]."""
    front: float
    """Extent to the front of the axis [m]."""
    back: float
    """Extent to the back [m]."""
    left: float
    """Extent to the left, and to the right unless given [m]."""
    right: float | None = None
    """Extent to the right [m]."""
    square: float = 2.0
    """Exponent of the superellipse: 2 is an ellipse, larger values approach a rectangle."""


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """A closed triangle mesh."""

    vertices: Array
    """Shape (n, 3) [m]."""
    faces: NDArray[np.int32]
    """Vertex indices, counter-clockwise seen from outside, shape (m, 3)."""

    def volume(self) -> float:
        """Return the enclosed volume [m^3]."""
        a, b, c = (self.vertices[self.faces[:, k]] for k in range(3))
        return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def loft(rings: Sequence[Ring], *, start: float, end: float) -> Mesh:
    """Return a smooth surface through rings along z, closed by domes; x is forward, y left.

    Args:
        rings: Rings from one end to the other, with increasing or decreasing `along`.
        start: Height of the dome before the first ring [m].
        end: Height of the dome after the last ring [m].
    """
    from scipy.interpolate import PchipInterpolator

    given = sorted(rings, key=lambda ring: ring.along)
    if given[0] is not rings[0]:
        start, end = end, start
    table = np.array(
        [[r.along, r.front, r.back, r.left, r.left if r.right is None else r.right, r.square] for r in given]
    )
    places = np.interp(
        np.arange((len(given) - 1) * INTERPOLATED_RINGS + 1) / INTERPOLATED_RINGS, np.arange(len(given)), table[:, 0]
    )
    smooth = np.column_stack([places, PchipInterpolator(table[:, 0], table[:, 1:], axis=0)(places)])
    return _skin(np.concatenate([_dome(smooth[0], -start)[::-1], smooth, _dome(smooth[-1], end)]))


def _dome(ring: Array, reach: float) -> Array:
    """Return rings that round off an end, shape (DOME_RINGS, 6)."""
    angles = np.linspace(0.0, np.pi / 2, DOME_RINGS + 1)[1:]
    found = np.tile(ring, (DOME_RINGS, 1))
    found[:, 0] += reach * np.sin(angles)
    middle = (ring[1] - ring[2]) / 2, (ring[3] - ring[4]) / 2
    # A ring at the tip has almost no size, and is centred in its oval.
    shrunk = np.maximum(np.cos(angles), 0.02)[:, None]
    for (one, other), center in zip(((1, 2), (3, 4)), middle, strict=True):
        half = (ring[one] + ring[other]) / 2
        found[:, [one]], found[:, [other]] = center + half * shrunk, -center + half * shrunk
    return found


def _skin(rings: Array) -> Mesh:
    angles = np.arange(RING_POINTS) * (2 * np.pi / RING_POINTS)
    c, s = np.cos(angles), np.sin(angles)
    along, front, back, left, right, square = (rings[:, [k]] for k in range(6))
    power = 2.0 / square
    x = np.where(c >= 0, front, back) * np.sign(c) * np.abs(c) ** power
    y = np.where(s >= 0, left, right) * np.sign(s) * np.abs(s) ** power
    body = np.stack([x, y, np.broadcast_to(along, x.shape)], axis=-1)
    tips = body[[0, -1]].mean(axis=1)
    count = len(rings) * RING_POINTS
    return Mesh(np.concatenate([body.reshape(-1, 3), tips]), _faces(len(rings), count))


@cache
def _faces(rows: int, count: int) -> NDArray[np.int32]:
    index = np.arange(RING_POINTS)
    after = (index + 1) % RING_POINTS
    found = [np.stack([index * 0 + count, after, index], axis=-1)]
    for row in range(rows - 1):
        low, high = row * RING_POINTS, (row + 1) * RING_POINTS
        found.append(np.stack([low + index, low + after, high + after], axis=-1))
        found.append(np.stack([low + index, high + after, high + index], axis=-1))
    last = (rows - 1) * RING_POINTS
    found.append(np.stack([index * 0 + count + 1, last + index, last + after], axis=-1))
    return np.concatenate(found).astype(np.int32)
