"""The body of a robot as a few discs, for fast tests of clearance on a distance grid."""

import math

import numpy as np

from mjsim.geometry import Array
from mjsim.interface import RobotInfo

from .obstacle_map import ObstacleMap

EXCESS, CLOSE_EXCESS = 0.015, 0.02
"""Excess of the discs beyond the sides of the body; beyond all its rim, if the body is long [m]."""
MAX_DISCS = 9
"""Maximum number of discs in a row."""
LONG = 2.0
"""A body is long if it reaches so many times as far as half its width."""
SAMPLED, CENTRED = 0.01, 0.02
"""Distances between points of the rim of a long body that are covered, and between possible centres [m]."""


class BodyDiscs:
    """Discs that cover the outline of a body: in a row along its longer side, or of many sizes if it is long."""

    def __init__(self, robot: RobotInfo) -> None:
        """Cover the outline; a body without one is a single disc."""
        self.centres: Array = np.zeros((1, 2))
        """Shape (k, 2), robot frame [m]."""
        self.radii: Array = np.array([robot.radius])
        """Shape (k,) [m]."""
        self.reach = robot.radius
        """Radius of the circle about the origin that contains the body [m]."""
        self.half_width = robot.radius
        """Clearance with which the body passes: half of its smaller side, or of its width if it drives no other way
        [m]."""
        self.is_long = False
        """Whether it passes gaps that are much narrower than those in which it can turn."""
        outline = robot.outline
        if outline is None or _is_round(outline):
            return
        self.centres, self.radii = _row(outline)
        self.half_width = float(self.radii.min()) - EXCESS * (len(self.radii) > 1)
        if robot.max_left == 0.0 and np.ptp(self.centres[:, 1]) > 0.0:
            self.half_width = float(np.abs(outline[:, 1]).max())
        self.is_long = self.reach > LONG * self.half_width
        if self.is_long:
            self.centres, self.radii = _cover(outline)

    def clearance(self, x: Array, y: Array, heading: Array, map: ObstacleMap) -> Array:
        """Return the distance between the rim and obstacles at poses, shape (...) each [m]."""
        return np.asarray(self.clearances(x, y, heading, map).min(axis=0))

    def clearances(self, x: Array, y: Array, heading: Array, map: ObstacleMap) -> Array:
        """Return the distance between each disc and obstacles at poses, shape (...) each; shape (discs, ...) [m]."""
        c, s = np.cos(heading), np.sin(heading)
        discs = zip(self.centres.tolist(), self.radii.tolist(), strict=True)
        return np.stack([map.at(x + c * a - s * b, y + s * a + c * b) - radius for (a, b), radius in discs])


def _row(outline: Array) -> tuple[Array, Array]:
    """Return the centres and radii of discs in strips across the longer side of an outline, shape (n, 2)."""
    low, high = outline.min(axis=0), outline.max(axis=0)
    along = int(np.argmax(high - low))
    length, width = float((high - low)[along]), float((high - low)[1 - along])
    # sqrt((w / 2)^2 + (l / 2 n)^2) <= w / 2 + excess
    count = math.ceil(length / (2.0 * math.sqrt(EXCESS * (width + EXCESS))))
    count = min(max(count, 1), MAX_DISCS)
    edges = np.linspace(low[along], high[along], count + 1)
    middle = np.empty((count, 2))
    middle[:, along] = 0.5 * (edges[1:] + edges[:-1])
    middle[:, 1 - along] = 0.5 * (low[1 - along] + high[1 - along])
    return middle, np.full(count, math.hypot(0.5 * width, 0.5 * length / count))


def _cover(outline: Array) -> tuple[Array, Array]:
    """Return the centres and radii of few discs that cover an outline, shape (n, 2), and exceed it nowhere much.

    The one that covers most of what is left, over and over: Johnson, Approximation Algorithms for Combinatorial
    Problems, Journal of Computer and System Sciences 9(3), 1974.
    """
    rim = _rim(outline)
    steps = [
        np.linspace(low, high, 2 * round((high - low) / (2.0 * CENTRED)) + 1)
        for low, high in zip(*_box(outline), strict=True)
    ]
    centres = np.stack(np.meshgrid(*steps), axis=-1).reshape(-1, 2)
    centres = centres[_contains(outline, centres)]
    radii = np.hypot(*np.moveaxis(centres[:, None] - rim, -1, 0)).min(axis=1) + CLOSE_EXCESS
    points = np.concatenate([rim, centres[::4]])
    covers = np.hypot(*np.moveaxis(centres[:, None] - points, -1, 0)) <= radii[:, None]
    left, chosen = covers.any(axis=0), list[int]()
    while left.any():
        chosen.append(int(np.argmax(covers @ left.astype(np.float32))))
        left &= ~covers[chosen[-1]]
    return centres[chosen], radii[chosen]


def _box(outline: Array) -> tuple[Array, Array]:
    """Return the corners of the box around an outline, shape (2,) each [m]."""
    return outline.min(axis=0), outline.max(axis=0)


def _rim(outline: Array) -> Array:
    """Return points on an outline, shape (k, 2) [m]."""
    edges = np.roll(outline, -1, axis=0) - outline
    counts = 1 + np.ceil(np.hypot(*edges.T) / SAMPLED).astype(int)
    parts = [
        start + np.linspace(0.0, 1.0, count)[:, None] * edge
        for start, edge, count in zip(outline, edges, counts.tolist(), strict=True)
    ]
    return np.concatenate(parts)


def _contains(outline: Array, points: Array) -> Array:
    """Return which points (n, 2) are inside an outline: its edges cross a ray from them an odd number of times."""
    start, end = outline, np.roll(outline, -1, axis=0)
    x, y = points[:, 0, None], points[:, 1, None]
    spans = (start[:, 1] > y) != (end[:, 1] > y)
    rise = np.where(end[:, 1] == start[:, 1], 1.0, end[:, 1] - start[:, 1])
    crossing = start[:, 0] + (y - start[:, 1]) / rise * (end[:, 0] - start[:, 0])
    return np.asarray(np.count_nonzero(spans & (x < crossing), axis=1) % 2 == 1)


def _is_round(outline: Array) -> bool:
    """Return whether an outline is nearly a circle about the origin."""
    away = np.hypot(*outline.T)
    return len(outline) > 8 and bool(away.max() < 1.1 * away.min())
