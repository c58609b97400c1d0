"""Free distance of a moving footprint."""

import math
from dataclasses import dataclass

import numpy as np

from mjsim.geometry import Array
from mjsim.interface import RobotInfo
from mjsim.safety.body_outline import is_round

MIN_CLEARANCE = 0.05
"""Minimum clearance of a free path [m]."""
HEADING_ALLOWANCE = 0.07
"""Heading error relative to the path that is allowed for; it swings the ends of a long body out [rad]."""
MAX_TOUCHING_DISTANCE = 0.03
"""Points closer than this count as touching [m]."""
ROOMY_DISTANCE = 0.12
"""Distance from the path beyond which obstacles do not slow the robot; larger for a long one [m]."""
CREEP_RATIO = 0.35
"""Fraction of the speed at minimum clearance."""
PATH_SAMPLES = 12
"""Number of poses checked along a path."""


@dataclass(frozen=True, slots=True, eq=False)
class FreePaths:
    """Free time and clearance of the examined paths."""

    times: Array
    """Time for which each path is free [s], shape (k,); 0 if blocked at once."""
    ease: Array
    """Allowed fraction of the speed on each path, considering lateral clearance, shape (k,)."""


class Footprint:
    """The shape of a robot, swept along arcs: a circle, or a bounding box if it is not round."""

    def __init__(self, robot: RobotInfo, *, clearance: float = MIN_CLEARANCE, swing: bool = False) -> None:
        """Store the shape given by the data sheet.

        Args:
            robot: Robot with this body.
            clearance: Minimum distance between its rim and obstacles on a free path [m]; a long body keeps more.
            swing: Use the circle in which it turns on the spot, whatever its shape.
        """
        self.radius = robot.radius
        self._shares = np.arange(1, PATH_SAMPLES + 1) / PATH_SAMPLES
        self._box: tuple[Array, Array] | None = None
        outline = robot.outline
        if outline is not None and not swing and not is_round(outline):
            low, high = outline.min(axis=0), outline.max(axis=0)
            self._box = (low + high) / 2, (high - low) / 2
        self._nearest = max(clearance, HEADING_ALLOWANCE * self.radius)
        self.roomy = ROOMY_DISTANCE + (self._nearest - MIN_CLEARANCE)

    @property
    def width(self) -> float:
        """Width over its sides [m]."""
        return 2.0 * (self.radius if self._box is None else float(np.min(self._box[1])))

    @property
    def slender(self) -> float:
        """Distance from its origin to its farthest point, in half widths; 1 for a circle."""
        return 2.0 * self.radius / self.width

    @property
    def round(self) -> bool:
        """Whether it is a circle."""
        return self._box is None

    def arcs(self, points: Array, *, speed: float, turns: Array, seconds: float) -> FreePaths:
        """Examine arcs that start straight ahead.

        Args:
            points: Obstacles, robot's frame, shape (n, 2) [m].
            speed: Negative backwards [m/s].
            turns: Turn rates, shape (k,) [rad/s].
            seconds: Time horizon [s].
        """
        times = self._shares * seconds
        rates = np.where(turns == 0.0, 1e-9, turns)[:, None]
        angles = rates * times
        # A circle of radius v / w about a point at the side.
        radii = speed / rates
        return self._free_paths(points, radii * np.sin(angles), radii * (1.0 - np.cos(angles)), angles, times)

    def lines(self, points: Array, *, speed: float, bearings: Array, seconds: float, turned: bool) -> FreePaths:
        """Examine straight lines in all directions.

        Args:
            points: Obstacles, robot's frame, shape (n, 2) [m].
            speed: [m/s]
            bearings: Bearings of the lines, shape (k,) [rad].
            seconds: Time horizon [s].
            turned: Whether the robot turns to the direction of the line first; otherwise it keeps its heading.
        """
        times = self._shares * seconds
        x, y = (speed * times * side[:, None] for side in (np.cos(bearings), np.sin(bearings)))
        headings = np.broadcast_to(bearings[:, None] if turned else 0.0, x.shape)
        return self._free_paths(points, x, y, headings, times)

    def can_spin(self, points: Array, turn: float) -> bool:
        """Return whether it can turn on the spot by 20 degrees."""
        if self._box is None or not len(points):
            return True
        angles, still = (
            math.copysign(1.0, turn) * np.linspace(0.06, 0.36, PATH_SAMPLES)[None],
            np.zeros((1, PATH_SAMPLES)),
        )
        return bool(
            self._free_paths(points, still, still, angles, np.arange(1.0, PATH_SAMPLES + 1)).times[0]
            >= PATH_SAMPLES - 1
        )

    def _free_paths(self, points: Array, x: Array, y: Array, headings: Array, times: Array) -> FreePaths:
        """Return free times and clearances of paths through places x, y, shape (k, 12)."""
        dx, dy = points[:, 0] - x[..., None], points[:, 1] - y[..., None]
        if self._box is None:
            # Distances are compared by their squares.
            room = dx * dx + dy * dy
            now = np.einsum("ij,ij->i", points, points)
            # A point that is already too close counts only while the robot approaches it.
            limit = np.minimum((self.radius + self._nearest) ** 2, now * 0.998)
            gap = np.sqrt(room[:, : PATH_SAMPLES // 2].min(axis=(1, 2))) - self.radius
        else:
            (middle_x, middle_y), (half_x, half_y) = self._box
            c, s = np.cos(headings)[..., None], np.sin(headings)[..., None]
            room = np.maximum(np.abs(c * dx + s * dy - middle_x) - half_x, np.abs(c * dy - s * dx - middle_y) - half_y)
            now = np.maximum(np.abs(points[:, 0] - middle_x) - half_x, np.abs(points[:, 1] - middle_y) - half_y)
            # The distance of points that are already closer, beside a long body, may halve while the body swings clear.
            relaxed = np.where(now > MAX_TOUCHING_DISTANCE, np.maximum(0.5 * now, MAX_TOUCHING_DISTANCE), now - 0.002)
            limit = np.where(now > 0.0, np.minimum(self._nearest, relaxed), -np.inf)
            gap = room[:, : PATH_SAMPLES // 2].min(axis=(1, 2))
        blocked = (room < limit).any(axis=-1)
        first = np.where(blocked.any(axis=1), blocked.argmax(axis=1), PATH_SAMPLES)
        free = np.where(first == 0, 0.0, times[np.maximum(first, 1) - 1])
        return FreePaths(
            free,
            np.clip(
                CREEP_RATIO + (1.0 - CREEP_RATIO) * (gap - self._nearest) / (self.roomy - self._nearest),
                CREEP_RATIO,
                1.0,
            ),
        )
