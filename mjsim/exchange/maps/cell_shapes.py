"""Rectangles and discs fitted to cells of a grid by their moments; all lengths in cells."""

import math
from dataclasses import dataclass

import numpy as np

from mjsim.exchange.maps.map_pixels import Cells
from mjsim.geometry import Array
from mjsim.world import cells_within


@dataclass(frozen=True, slots=True)
class Bar:
    """A rectangle: a straight wall, or an obstacle from above."""

    x: float
    """Centre x [cells]."""
    y: float
    heading: float
    """Direction of its length [rad]."""
    length: float
    width: float

    @property
    def along(self) -> Array:
        """Unit vector along its length, shape (2,)."""
        return np.array([math.cos(self.heading), math.sin(self.heading)])

    @property
    def ends(self) -> Array:
        """Both ends of its centreline, shape (2, 2) [cells]."""
        middle = np.array([self.x, self.y])
        return np.asarray(middle + np.outer([-0.5, 0.5], self.along * self.length), dtype=float)

    def outline(self, *, grown: float = 0.0) -> Array:
        """Return its corners, offset outward by `grown`, counter-clockwise, shape (4, 2) [cells]."""
        c, s = self.along
        half = np.array([self.length, self.width]) / 2 + grown
        return np.asarray(half * [[-1, -1], [1, -1], [1, 1], [-1, 1]] @ [[c, s], [-s, c]] + [self.x, self.y])


@dataclass(frozen=True, slots=True)
class Disc:
    """A round obstacle from above."""

    x: float
    y: float
    radius: float


def bar_between(start: Array, end: Array, width: float) -> Bar:
    """Return the bar whose centreline has these ends, shape (2,) each."""
    along = end - start
    x, y = ((start + end) / 2).tolist()
    return Bar(x, y, math.atan2(along[1], along[0]), math.hypot(*along), width)


def fitted_bar(points: Array) -> tuple[Bar, float]:
    """Return the rectangle with the second moments of cells, and how well it covers them.

    Args:
        points: Centres of the cells, shape (n, 2) [cells].

    Returns:
        The rectangle; and the intersection over union of both sets of cells, 0 to 1.
    """
    middle = points.mean(axis=0)
    x, y = middle.tolist()
    offsets = points - middle
    covariance = offsets.T @ offsets / len(points)
    principal = math.atan2(2 * covariance[0, 1], covariance[0, 0] - covariance[1, 1]) / 2
    around = _lattice(points) - middle
    best: tuple[Bar, float] | None = None
    for heading in (0.0, principal, _hull_heading(points)):
        c, s = math.cos(heading), math.sin(heading)
        u, v = np.abs(offsets @ [[c, -s], [s, c]]).T
        # A uniform rectangle has variance length^2 / 12; that of a cell itself is 1 / 12.
        length, width = np.sqrt(12.0 * np.array([np.mean(u**2), np.mean(v**2)]) + 1.0).tolist()
        within = int(np.count_nonzero((u <= length / 2) & (v <= width / 2)))
        u, v = np.abs(around @ [[c, -s], [s, c]]).T
        overlap = _shared(points, within, int(np.count_nonzero((u <= length / 2) & (v <= width / 2))))
        if best is None or overlap > best[1] + 1e-3:
            bar = Bar(x, y, heading, length, width)
            best = bar if length >= width else Bar(x, y, heading + math.pi / 2, width, length), overlap
    assert best is not None
    return best


def fitted_disc(points: Array) -> tuple[Disc, float]:
    """Return the disc with the area of cells, centres of shape (n, 2), and how well it covers them, as `fitted_bar`."""
    middle = points.mean(axis=0)
    radius = math.sqrt(len(points) / math.pi)
    within, lattice = (
        int(np.count_nonzero(np.hypot(*(cells - middle).T) <= radius)) for cells in (points, _lattice(points))
    )
    x, y = middle.tolist()
    return Disc(x, y, radius), _shared(points, within, lattice)


def cells_in(outline: Array, shape: tuple[int, int]) -> tuple[tuple[slice, slice], Cells]:
    """Return the window of a grid around a closed outline, shape (n, 2), and which cells have centres inside it."""
    lower = np.clip(np.floor(outline.min(axis=0)).astype(int), 0, shape[::-1])
    upper = np.clip(np.ceil(outline.max(axis=0)).astype(int), lower, shape[::-1])
    faces = np.stack([outline, np.roll(outline, -1, axis=0)], axis=1) - lower
    columns, rows = (upper - lower).tolist()
    window = slice(lower[1], upper[1]), slice(lower[0], upper[0])
    return window, cells_within(faces, rows=rows, columns=columns)


def _shared(points: Array, covered: int, lattice: int) -> float:
    """Return intersection over union of cells and a shape: `covered` cells are in both, `lattice` in the shape."""
    return covered / (len(points) + lattice - covered)


def _lattice(points: Array) -> Array:
    """Return the centres of all grid cells in the bounding box of cells and a margin of 3 cells, shape (n, 2)."""
    lower, upper = points.min(axis=0) - 3.0, points.max(axis=0) + 4.0
    columns, rows = np.arange(lower[0], upper[0]), np.arange(lower[1], upper[1])
    return np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)


def _hull_heading(points: Array) -> float:
    """Return the direction of the smallest rectangle around points [rad]."""
    import cv2

    (_, _, angle) = cv2.minAreaRect(points.astype(np.float32))
    return math.radians(angle)


def fitted_rectangle(corners: Array) -> Bar | None:
    """Return the rectangle with four corners in order, shape (4, 2); None if they do not form one."""
    if len(corners) != 4:
        return None
    first, second, third, fourth = corners
    size = math.dist(first, third)
    across, along = second - first, fourth - first
    if math.dist(first + across + along, third) > 1e-3 * size or abs(float(across @ along)) > 1e-3 * size**2:
        return None
    long, wide = (along, across) if math.hypot(*along) >= math.hypot(*across) else (across, along)
    x, y = corners.mean(axis=0).tolist()
    return Bar(x, y, math.atan2(long[1], long[0]), math.hypot(*long), math.hypot(*wide))
