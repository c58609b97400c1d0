"""Flat four-sided faces with a part of the atlas, and blocks and bands of them."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mjsim.geometry import Array

Range = tuple[float, float]


@dataclass(frozen=True, slots=True, eq=False)
class Quad:
    """A face that shows a part of the atlas."""

    corners: Array
    """Lower left, lower right, upper right, upper left as its viewer sees them, shape (4, 3) [m]."""
    part: str
    """Name of the part."""
    share: float = 1.0
    """Share of the part's width that is shown, from its left."""


@dataclass(frozen=True, slots=True, eq=False)
class Axes:
    """Axes for someone facing a wall or the front of a thing: right, out towards the viewer, and up."""

    origin: Array
    """Shape (3,) [m]."""
    right: Array
    """Horizontal unit vector, shape (3,)."""
    out: Array
    """Horizontal unit vector, shape (3,)."""

    @classmethod
    def facing(cls, x: float, y: float, z: float, heading: float) -> "Axes":
        """Return the frame at a point of something that faces a heading [rad]."""
        c, s = math.cos(heading), math.sin(heading)
        return cls(np.array([x, y, z]), np.array([-s, c, 0.0]), np.array([c, s, 0.0]))

    def points(self, *places: tuple[float, float, float]) -> Array:
        """Return points at (right, out, up) from the origin, shape (n, 3) [m]."""
        right, out, up = np.array(places).T[:, :, None]
        return np.asarray(self.origin + right * self.right + out * self.out + up * [0.0, 0.0, 1.0])

    def sheet(self, across: Range, up: Range, out: float, part: str, *, share: float = 1.0) -> Quad:
        """Return an upright face towards the viewer."""
        (a, b), (low, high) = across, up
        return Quad(self.points((a, out, low), (b, out, low), (b, out, high), (a, out, high)), part, share)

    def lying(self, across: Range, out: Range, up: float, part: str, *, below: bool = False) -> Quad:
        """Return a level face, seen from above, or from below; `out` is from its rear to its front edge."""
        (a, b), (rear, front) = across, out
        if below:
            return Quad(self.points((a, rear, up), (b, rear, up), (b, front, up), (a, front, up)), part)
        return Quad(self.points((a, front, up), (b, front, up), (b, rear, up), (a, rear, up)), part)

    def block(self, across: Range, out: Range, up: Range, front: str, side: str) -> Iterator[Quad]:
        """Yield the faces of a block except its back."""
        (a, b), (rear, near), (low, high) = across, out, up
        yield self.sheet(across, up, near, front)
        yield Quad(self.points((a, rear, low), (a, near, low), (a, near, high), (a, rear, high)), side)
        yield Quad(self.points((b, near, low), (b, rear, low), (b, rear, high), (b, near, high)), side)
        yield self.lying(across, out, high, side)
        yield self.lying(across, out, low, side, below=True)

    def band(self, across: Range, up: Range, out: float, part: str, *, length: float) -> Iterator[Quad]:
        """Yield a band along a wall with a top, whose picture repeats after a length [m]."""
        first, end = across
        count = max(math.ceil((end - first) / length - 1e-6), 1)
        for k in range(count):
            a, b = first + k * length, min(first + (k + 1) * length, end)
            yield self.sheet((a, b), up, out, part, share=(b - a) / length)
        yield Quad(self.lying(across, (0.0, out), up[1], part).corners, part, 0.02)
