"""Scan matching: a distance field around walls, and the alignment of a scan to them."""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array, wrap_angle

from .scan_walls import EFFECTIVE, SPACING, Surface, rotation

SIGMA, FINEST = 0.03, 0.01
"""Standard deviation of an element's distance from its wall, from noise and walls that are not exactly straight, and
its minimum [m]."""
ALONG = 0.01
"""Mean square of the component of walls' normals along a direction that is attributed to noise."""
WEIGHED = 0.1
"""As `EFFECTIVE`, when comparing hypotheses: changes, such as doors and people, hide or add whole pieces."""
ALIKE = 0.9
"""Elements in one cell belong to one wall if the cosine of the angle between their normals is above this."""
CUT = 3.0
"""Number of standard deviations beyond which an element is not on the wall."""


class WallField:
    """The nearest element of a surface for each cell of a grid, and its distance.

    References:
        Felzenszwalb, Huttenlocher, Distance Transforms of Sampled Functions, Theory of Computing 8, 2012.
    """

    def __init__(self, surface: Surface, *, cell: float = 0.1, margin: float = 1.0) -> None:
        """Compute the distances.

        Args:
            surface: At least one element.
            cell: Side of a cell [m].
            margin: How far the grid reaches beyond the walls [m].
        """
        self.surface, self.cell = surface, cell
        self.lower: Array = surface.points.min(axis=0) - margin
        columns, rows = np.ceil((surface.points.max(axis=0) + margin - self.lower) / cell).astype(int)
        self._most = np.array([columns - 1, rows - 1])
        free = np.ones((rows, columns), dtype=np.uint8)
        at = self.cells(surface.points)
        count = np.bincount(at, minlength=rows * columns).reshape(rows, columns).astype(np.float32)
        # Each scan has one element every `SPACING`, three in a row of three cells.
        blurred = cv2.blur(count, (3, 3), borderType=cv2.BORDER_CONSTANT)
        self.scans: NDArray[np.float32] = np.asarray(blurred, dtype=np.float32) * np.float32(3.0 * SPACING / cell)
        """Approximate number of scans that show the wall in each cell; shape (rows, columns)."""
        free.ravel()[at] = 0
        distance, labels = cv2.distanceTransformWithLabels(
            free, cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
        )
        self.distance: NDArray[np.float32] = np.asarray(distance, dtype=np.float32) * np.float32(cell)
        """Shape (rows, columns) [m]; the first row is at the smallest y."""
        self._labels = labels.ravel()
        self._element: NDArray[np.intp] = np.zeros(int(labels.max()) + 1, dtype=np.intp)
        self._element[self._labels[at]] = np.arange(len(at))
        self.surface = _averaged(surface, self._element[self._labels[at]])

    def cells(self, points: Array) -> NDArray[np.intp]:
        """Return the indices in the flattened grid of the cells of points (..., 2) [m], limited to the grid."""
        column = np.minimum(np.maximum((points[..., 0] - self.lower[0]) / self.cell, 0.0), self._most[0])
        row = np.minimum(np.maximum((points[..., 1] - self.lower[1]) / self.cell, 0.0), self._most[1])
        return np.asarray(row.astype(np.intp) * (self._most[0] + 1) + column.astype(np.intp))

    def nearest(self, points: Array) -> tuple[NDArray[np.float32], NDArray[np.intp]]:
        """Return the distance [m] from each point (n, 2) to the nearest element, by its cell, and its index, (n,)."""
        at = self.cells(points)
        return self.distance.ravel()[at], self._element[self._labels[at]]


def _averaged(surface: Surface, chosen: NDArray[np.intp]) -> Surface:
    """Return a surface whose chosen elements are the averages of their cells.

    Each scan shows the wall in a cell once. A match on one of them alone would repeat its error; on their average,
    errors even out.

    Args:
        surface: Elements of several scans, shape (n, ...).
        chosen: The element chosen in the cell of each, shape (n,).
    """
    alike = np.einsum("ni,ni->n", surface.normals, surface.normals[chosen]) > ALIKE
    weight, number = alike.astype(float), len(chosen)
    count = np.maximum(np.bincount(chosen, weight, number), 1.0)
    x, y, nx, ny = (np.bincount(chosen, weight * column, number) for column in (*surface.points.T, *surface.normals.T))
    size = np.maximum(np.hypot(nx, ny), 1e-9)
    points = np.stack([x / count, y / count], axis=1)
    return Surface(points, np.stack([nx / size, ny / size], axis=1), surface.noise)


@dataclass(frozen=True, slots=True, eq=False)
class Match:
    """Alignment of a scan with a surface."""

    pose: Array
    """Of the scan's frame in the surface's, shape (3,) [m, m, rad]."""
    information: Array
    """Inverse of the pose's covariance from points and guess, shape (3, 3)."""
    share: float
    """Ratio of the scan's elements on the surface to all."""
    seen: Array
    """Part of the information that is from the points alone, shape (3, 3)."""
    older: Array
    """The same, with each point weighted by (n - 1) / 2 if n scans show its wall, shape (3, 3)."""
    cost: float
    """Minus twice the log-likelihood of scan and guess, up to a constant."""
    conflict: float
    """Ratio of elements near the surface, but not on it, to all."""


def align(field: WallField, scan: Surface, guess: Array, information: Array, *, start: Array | None = None) -> Match:
    """Return the pose at which a scan fits a surface best, near a start.

    Point-to-line ICP: each element moves to the line through the nearest element of the surface that faces the same
    side. The guess counts as a measurement, so that it decides along a bare corridor, where walls give no information.

    Args:
        field: Of the walls seen before.
        scan: In its own frame.
        guess: Of the pose, shape (3,).
        information: Inverse of the guess's covariance, shape (3, 3).
        start: Initial pose; by default the guess.

    References:
        Censi, An ICP Variant Using a Point-to-Line Metric, ICRA 2008.
    """
    pose = np.array(guess if start is None else start, dtype=float)
    seen, reach, sigma = np.zeros((3, 3)), 0.5, SIGMA
    for _ in range(12):
        distance, miss, J, noise = _compared(field, scan, pose)
        # Huber: beyond two standard deviations a miss counts less than its square.
        size, near = np.abs(miss), distance < reach
        spread = np.maximum(sigma, noise)
        weight = np.minimum(1.0, 2.0 * spread / np.maximum(size, 1e-9)) * near
        J[:, :2] = J[:, :2] @ _trusted(J, weight)
        weighted = (EFFECTIVE / spread**2 * weight)[:, None] * J
        seen = weighted.T @ J
        off = pose - guess
        off[2] = wrap_angle(off[2])
        step = np.linalg.solve(seen + information, weighted.T @ miss + information @ off)
        pose = pose - step
        reach = max(0.2, 0.7 * reach)
        # The median of the sizes of normal deviates is 0.674 of their standard deviation.
        sigma = min(max(_median(size[near]) / 0.674, FINEST), SIGMA) if near.any() else SIGMA
        if np.abs(step).max() < 1e-3:
            break
    at = field.cells(scan.points @ rotation(float(pose[2])).T + pose[:2])
    others = 0.5 * np.maximum(field.scans.ravel()[at] - 1.0, 0.0)
    return _judged(field, scan, pose, guess, information, seen, (others[:, None] * weighted).T @ J)


def _trusted(J: Array, weight: Array) -> Array:
    """Return the matrix that removes from a shift the directions constrained only by noise of normals, shape (2, 2).

    Along a bare corridor the normals are not exactly perpendicular to it; without this, their errors would count as
    information.

    References:
        Zhang, Kaess, Singh, On Degeneracy of Optimization-based State Estimation Problems, ICRA 2016.
    """
    weighted = weight[:, None] * J[:, :2]
    (a, b), (_, d) = (weighted.T @ J[:, :2]).tolist()
    # Eigenvalues and the angle of the first eigenvector of a symmetric matrix of two rows.
    middle, radius, angle = 0.5 * (a + d), math.hypot(0.5 * (a - d), b), 0.5 * math.atan2(2.0 * b, a - d)
    noise = ALONG * float(weight.sum())
    first, second = (
        math.sqrt(max(0.0, 1.0 - noise / max(value, 1e-9))) for value in (middle + radius, middle - radius)
    )
    c, s = math.cos(angle), math.sin(angle)
    along = c * s * (first - second)
    return np.array([[c * c * first + s * s * second, along], [along, s * s * first + c * c * second]])


def _median(values: Array) -> float:
    """Return the upper median of values (n,), at least one."""
    middle = len(values) // 2
    return float(np.partition(values, middle)[middle])


def _judged(
    field: WallField, scan: Surface, pose: Array, guess: Array, information: Array, seen: Array, older: Array
) -> Match:
    """Return the match of a scan with a surface at a pose."""
    pose = np.array([pose[0], pose[1], wrap_angle(float(pose[2]))])
    distance, miss, _, _ = _compared(field, scan, pose)
    on = (distance < 0.2) & (np.abs(miss) < CUT * SIGMA)
    squares = np.where(on, (miss / SIGMA) ** 2, CUT**2)
    off = pose - guess
    off[2] = wrap_angle(off[2])
    cost = WEIGHED * float(squares.sum()) + float(off @ information @ off)
    conflict = float(np.mean(~on & (distance < 0.5)))
    return Match(pose, seen + information, float(np.mean(on)), seen, older, cost, conflict)


def misses(pose: Array, points: Array, places: Array, normals: Array) -> tuple[Array, Array]:
    """Return the signed distances of points from lines, and their derivatives by the pose of the points' frame.

    Args:
        pose: Of the points' frame in that of the lines, shape (3,).
        points: In their own frame, shape (n, 2) [m].
        places: A point of each one's line, shape (n, 2) [m].
        normals: Unit vectors across the lines, shape (n, 2).

    Returns:
        Distances, shape (n,) [m], and their derivative by (x, y, heading), shape (n, 3).
    """
    arm = points @ rotation(float(pose[2])).T
    J = np.empty((len(arm), 3))
    J[:, :2] = normals
    J[:, 2] = normals[:, 1] * arm[:, 0] - normals[:, 0] * arm[:, 1]
    return np.einsum("ni,ni->n", normals, arm + pose[:2] - places), J


def _compared(field: WallField, scan: Surface, pose: Array) -> tuple[Array, Array, Array, Array]:
    """Return the distances of elements of a scan from those of a surface, and their derivatives by the pose.

    Returns:
        Distance to the nearest element, infinite if that faces another side, (n,) [m]; signed distance from its line,
        (n,) [m]; derivative of the latter by (x, y, heading), (n, 3); the larger one of both elements' noise, (n,) [m].
    """
    R = rotation(float(pose[2])).T
    distance, number = field.nearest(scan.points @ R + pose[:2])
    normals = field.surface.normals[number]
    faces = np.einsum("ni,ni->n", scan.normals @ R, normals) > 0.7
    miss, J = misses(pose, scan.points, field.surface.points[number], normals)
    noise = np.maximum(scan.noise, field.surface.noise[number])
    return np.where(faces, distance, np.inf), miss, J, noise
