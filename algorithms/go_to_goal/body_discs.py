"""The body of a robot as a few discs, for fast tests of clearance on a distance grid."""

import math

import numpy as np

from mjsim.geometry import Array
from mjsim.interface import RobotInfo

from .obstacle_map import ObstacleMap

EXCESS = 0.015
"""Excess of the discs beyond the sides of the body [m]."""
MAX_DISCS = 9
"""Maximum number of discs."""


class BodyDiscs:
    """Discs that cover the outline of a body, in a row along its longer side."""

    def __init__(self, robot: RobotInfo) -> None:
        """Cover the outline; a body without one is a single disc."""
        self.centres: Array = np.zeros((1, 2))
        """Shape (k, 2), robot frame [m]."""
        self.radii: Array = np.array([robot.radius])
        """Shape (k,) [m]."""
        outline = robot.outline
        if outline is not None and not _is_round(outline):
            self.centres, self.radii = _covered(outline)
        self.half_width = float(self.radii.min()) - EXCESS * (len(self.radii) > 1)
        """Half of the shorter side: the body needs at least this clearance from its centreline [m]."""
        self.reach = robot.radius
        """Radius of the circle about the origin that contains the body [m]."""

    def clearance(self, x: Array, y: Array, heading: Array, map: ObstacleMap) -> Array:
        """Return the distance between the rim and obstacles at poses, shape (...) each [m]."""
        return np.asarray(self.clearances(x, y, heading, map).min(axis=0))

    def clearances(self, x: Array, y: Array, heading: Array, map: ObstacleMap) -> Array:
        """Return the distance between each disc and obstacles at poses, shape (...) each; shape (discs, ...) [m]."""
        c, s = np.cos(heading), np.sin(heading)
        discs = zip(self.centres.tolist(), self.radii.tolist(), strict=True)
        return np.stack([map.at(x + c * a - s * b, y + s * a + c * b) - radius for (a, b), radius in discs])


def _covered(outline: Array) -> tuple[Array, Array]:
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


def _is_round(outline: Array) -> bool:
    """Return whether an outline is nearly a circle about the origin."""
    away = np.hypot(*outline.T)
    return len(outline) > 8 and bool(away.max() < 1.1 * away.min())
