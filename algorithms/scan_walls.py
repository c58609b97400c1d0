"""Walls in scans: evenly spaced elements with normals and noise."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array

from .level_scan import LevelScan
from .scan_noise import range_noise, smoothed

SPACING = 0.1
"""Distance between neighbouring elements of a wall [m]."""
FARTHEST = 25.0
"""Walls farther from the sensor are not used [m]."""
NEIGHBOUR = 0.3
"""Two consecutive points of a scan closer than this are on one wall [m]."""
STRAIGHT = 0.25
"""More distant ones are on one wall if its direction changes by at most this [rad]."""
FLAT = 0.03
"""Maximum standard deviation of points from the line fitted to them [m]."""
BLURRED = 0.025
"""Lines are fitted to one more neighbour on either side for each multiple of this range noise [m]."""
EFFECTIVE = 0.3
"""Number of independent elements relative to all elements of a scan; errors of neighbours are correlated."""


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """Elements of walls, evenly spaced, in one frame."""

    points: Array
    """Shape (n, 2) [m]."""
    normals: Array
    """Unit vectors across the walls, towards the side from which they were seen, shape (n, 2)."""
    noise: Array
    """Standard deviation of each from its wall, by the noise of ranges (with `EFFECTIVE` independence) or by the
    deviation of its neighbours from their line, as at an edge, shape (n,) [m]."""

    def moved(self, pose: Array) -> "Surface":
        """Return the surface transformed by `pose` (x, y, heading), the pose of its frame."""
        R = rotation(float(pose[2]))
        return Surface(self.points @ R.T + pose[:2], self.normals @ R.T, self.noise)

    def thinned(self, most: int) -> "Surface":
        """Return at most this many of its elements, evenly chosen."""
        if len(self.points) <= most:
            return self
        chosen = np.linspace(0, len(self.points) - 1, most).astype(np.intp)
        return Surface(self.points[chosen], self.normals[chosen], self.noise[chosen])


def walls_of(looked: LevelScan) -> Surface:
    """Return the walls in a scan, in the robot's frame."""
    scan, sensor = looked.scan, looked.robot_from_lidar
    error = range_noise(scan)
    points = sensor.transform(smoothed(scan, error).points())
    return surface_of(points, origin=(sensor.x, sensor.y), noise=error, increment=scan.angle_increment)


def surface_of(
    points: Array, *, origin: tuple[float, float] = (0.0, 0.0), noise: float = 0.0, increment: float = 0.0
) -> Surface:
    """Return the straight walls in a scan.

    Args:
        points: In the order of the beams, shape (n, 2) [m].
        origin: Position of the sensor, in the frame of the points [m].
        noise: Standard deviation of a range [m].
        increment: Angle between two beams [rad].
    """
    points = points[np.hypot(*(points - origin).T) < FARTHEST]
    if len(points) < 3:
        return Surface(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0))
    even, run = _evenly(points, np.hypot(*(points - origin).T))
    if len(even) < 3:
        return Surface(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0))
    centres, normals, off, flat = _lines(even, run, half=2 + int(noise / BLURRED))
    towards = np.sum((np.asarray(origin) - centres) * normals, axis=1)
    normals = np.where(towards[:, None] < 0.0, -normals, normals)
    # Ranges err by their noise times the cosine of the angle at which the beam meets the wall, towards / r, across it,
    # and beams meet it every r * increment / cosine. So much tells an element of `SPACING`.
    squared = EFFECTIVE * noise**2 * increment / SPACING * np.abs(towards)
    return Surface(centres[flat], normals[flat], np.maximum(np.sqrt(squared), off)[flat])


def _evenly(points: Array, ranges: Array) -> tuple[Array, NDArray[np.intp]]:
    """Return points every `SPACING` along connected points, shape (m, 2), and the number of each one's wall, (m,)."""
    step = np.diff(points, axis=0)
    gap = np.hypot(*step.T)
    turn = np.abs(np.diff(np.arctan2(step[:, 1], step[:, 0])))
    straight = np.minimum(turn, 2.0 * np.pi - turn) < STRAIGHT
    goes_on = np.concatenate([[False], straight]) | np.concatenate([straight, [False]])
    near = (gap < NEIGHBOUR) | (goes_on & (gap < 0.1 * ranges[1:]))
    # Consecutive walls are laid on one line, with a step of no length between them.
    along = np.concatenate([[0.0], np.cumsum(np.where(near, gap, 0.0))])
    wall = np.concatenate([[0], np.cumsum(~near)])
    at = np.arange(0.5 * SPACING, along[-1], SPACING)
    after = np.clip(np.searchsorted(along, at, side="right"), 1, len(points) - 1)
    share = (at - along[after - 1]) / np.maximum(along[after] - along[after - 1], 1e-9)
    return points[after - 1] + share[:, None] * step[after - 1], wall[after - 1]


def _lines(points: Array, run: NDArray[np.intp], *, half: int) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
    """Return the line through each point and its neighbours on the same wall.

    Returns:
        A point of the line, shape (n, 2); its normal, shape (n, 2); standard deviation of neighbours from it, shape
        (n,) [m]; whether they are on it, shape (n,).
    """
    number = np.arange(len(points))
    first = np.maximum(number - half, np.searchsorted(run, run, side="left"))
    last = np.minimum(number + half + 1, np.searchsorted(run, run, side="right"))
    x, y = points.T
    sums = np.zeros((len(points) + 1, 5))
    np.cumsum(np.column_stack([x, y, x * x, x * y, y * y]), axis=0, out=sums[1:])
    count = (last - first).astype(float)
    mx, my, xx, xy, yy = ((sums[last] - sums[first]) / count[:, None]).T
    xx, xy, yy = xx - mx * mx, xy - mx * my, yy - my * my
    angle = 0.5 * np.arctan2(2.0 * xy, xx - yy)
    normals = np.stack([-np.sin(angle), np.cos(angle)], axis=-1)
    across = np.maximum(0.5 * (xx + yy) - np.hypot(0.5 * (xx - yy), xy), 0.0)
    means = np.stack([mx, my], axis=-1)
    centres = points - np.sum((points - means) * normals, axis=1)[:, None] * normals
    # Two of the points' degrees of freedom are the line's.
    off = np.sqrt(across * count / np.maximum(count - 2.0, 1.0))
    return centres, normals, off, (count >= 3) & (across < FLAT**2)


def joined(surfaces: list[Surface]) -> Surface:
    """Return one surface from several in the same frame."""
    return Surface(
        np.concatenate([surface.points for surface in surfaces]),
        np.concatenate([surface.normals for surface in surfaces]),
        np.concatenate([surface.noise for surface in surfaces]),
    )


def rotation(angle: float) -> Array:
    """Return the matrix that turns by an angle [rad, left positive], shape (2, 2)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])
