"""Walls in scans: evenly spaced elements with normals and noise."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array

from .level_scan import LevelScan
from .scan_noise import range_noise, smoothed

SPACING = 0.1
"""Distance between neighbouring elements of a wall [m]."""
MAX_RANGE = 25.0
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

    def thinned(self, count: int) -> "Surface":
        """Return at most this many of its elements, evenly chosen."""
        if len(self.points) <= count:
            return self
        chosen = np.arange(count) * (len(self.points) - 1) // (count - 1)
        return Surface(self.points[chosen], self.normals[chosen], self.noise[chosen])


def walls_of(view: LevelScan) -> Surface:
    """Return the walls in a scan, in the robot's frame."""
    scan, sensor = view.scan, view.robot_from_lidar
    error = range_noise(scan)
    points = sensor.transform(smoothed(scan, error).points())
    return surface_of(points, origin=(sensor.x, sensor.y), noise=error, increment=scan.angle_increment)


def surface_of(
    points: Array, *, origin: tuple[float, float] = (0.0, 0.0), noise: float = 0.0, increment: float = 0.0
) -> Surface:
    """Return the straight walls in a scan.

    Args:
        points: Points in the order of the beams, shape (n, 2) [m].
        origin: Position of the sensor, in the frame of the points [m].
        noise: Standard deviation of a range [m].
        increment: Angle between two beams [rad].
    """
    ranges = np.hypot(points[:, 0] - origin[0], points[:, 1] - origin[1])
    inside = ranges < MAX_RANGE
    points, ranges = points[inside], ranges[inside]
    if len(points) < 3:
        return Surface(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0))
    x, y, run = _evenly(points, ranges)
    if len(x) < 3:
        return Surface(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0))
    centres, normals, rms, flat = _lines(x, y, run, half=2 + int(noise / BLURRED))
    towards = (origin[0] - centres[0]) * normals[0] + (origin[1] - centres[1]) * normals[1]
    normals *= np.where(towards < 0.0, -1.0, 1.0)
    # Across the wall, the error is the range noise times the cosine of the angle of incidence, towards / r, and beams
    # hit it every r * increment / cosine: this gives the noise of an element of `SPACING`.
    squared = EFFECTIVE * noise**2 * increment / SPACING * np.abs(towards)
    return Surface(centres.T[flat], normals.T[flat], np.maximum(np.sqrt(squared), rms)[flat])


def _evenly(points: Array, ranges: Array) -> tuple[Array, Array, NDArray[np.intp]]:
    """Return x and y of points every `SPACING` along connected points, and the number of each one's wall, (m,) each."""
    x, y = points.T
    dx, dy = x[1:] - x[:-1], y[1:] - y[:-1]
    gap, direction = np.hypot(dx, dy), np.arctan2(dy, dx)
    turn = np.abs(direction[1:] - direction[:-1])
    straight = np.minimum(turn, 2.0 * np.pi - turn) < STRAIGHT
    goes_on = np.zeros(len(gap), dtype=bool)
    goes_on[1:] = straight
    goes_on[:-1] |= straight
    connected = (gap < NEIGHBOUR) | (goes_on & (gap < 0.1 * ranges[1:]))
    # Consecutive walls are laid on one line, with a step of no length between them.
    along, wall = np.zeros(len(x)), np.zeros(len(x), dtype=np.intp)
    np.cumsum(gap * connected, out=along[1:])
    np.cumsum(~connected, out=wall[1:])
    at = np.arange(0.5 * SPACING, along[-1], SPACING)
    before = np.minimum(np.maximum(along.searchsorted(at, side="right"), 1), len(x) - 1) - 1
    share = (at - along[before]) / np.maximum(along[before + 1] - along[before], 1e-9)
    return x[before] + share * dx[before], y[before] + share * dy[before], wall[before]


def _lines(x: Array, y: Array, run: NDArray[np.intp], *, half: int) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
    """Return the line through each point (n,) and its neighbours on the same wall.

    Returns:
        A point of the line, shape (2, n); its normal, shape (2, n); standard deviation of neighbours from it, shape
        (n,) [m]; whether they are on it, shape (n,).
    """
    number = np.arange(len(x))
    first = np.maximum(number - half, run.searchsorted(run, side="left"))
    last = np.minimum(number + half + 1, run.searchsorted(run, side="right"))
    sums = np.zeros((5, len(x) + 1))
    np.cumsum([x, y, x * x, x * y, y * y], axis=1, out=sums[:, 1:])
    count = (last - first).astype(float)
    mx, my, xx, xy, yy = (sums.take(last, axis=1) - sums.take(first, axis=1)) / count
    xx, xy, yy = xx - mx * mx, xy - mx * my, yy - my * my
    angle = 0.5 * np.arctan2(2.0 * xy, xx - yy)
    normals = np.array([-np.sin(angle), np.cos(angle)])
    across = np.maximum(0.5 * (xx + yy) - np.hypot(0.5 * (xx - yy), xy), 0.0)
    centres = np.array([x, y])
    centres -= ((x - mx) * normals[0] + (y - my) * normals[1]) * normals
    # The line takes two of the points' degrees of freedom.
    rms = np.sqrt(across * count / np.maximum(count - 2.0, 1.0))
    return centres, normals, rms, (count >= 3) & (across < FLAT**2)


def joined(surfaces: Sequence[Surface]) -> Surface:
    """Return one surface from several in the same frame."""
    return Surface(
        np.concatenate([surface.points for surface in surfaces]),
        np.concatenate([surface.normals for surface in surfaces]),
        np.concatenate([surface.noise for surface in surfaces]),
    )


def placed(surfaces: Sequence[Surface], poses: Array) -> Surface:
    """Return one surface from several, given the pose of each one's frame, shape (k, 3)."""
    whole, counts = joined(surfaces), [len(surface.points) for surface in surfaces]
    turns = np.array([np.cos(poses[:, 2]), np.sin(poses[:, 2]), poses[:, 0], poses[:, 1]])
    c, s, dx, dy = turns.repeat(counts, axis=1)
    (x, y), (nx, ny) = whole.points.T, whole.normals.T
    points, normals = np.empty_like(whole.points), np.empty_like(whole.normals)
    points[:, 0], points[:, 1] = c * x - s * y + dx, s * x + c * y + dy
    normals[:, 0], normals[:, 1] = c * nx - s * ny, s * nx + c * ny
    return Surface(points, normals, whole.noise)


def rotation(angle: float) -> Array:
    """Return the matrix that turns by an angle [rad, left positive], shape (2, 2)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])
