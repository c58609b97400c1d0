"""Scan matching: a distance field around walls, and the alignment of a scan to them."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array, wrap_angles

from ..estimation.pose_matrices import solution
from .scan_walls import EFFECTIVE, SPACING, Surface

SIGMA, FINEST = 0.03, 0.01
"""Standard deviation of an element's distance from its wall, from noise and walls that are not exactly straight, and
its minimum [m]."""
ALONG = 0.01
"""Mean square of the component of walls' normals along a direction that is attributed to noise."""
WEIGHED = 0.1
"""As `EFFECTIVE`, when comparing hypotheses: changes, such as doors and people, hide or add whole pieces."""
PARALLEL = 0.9
"""Elements in one cell belong to one wall if the cosine of the angle between their normals is above this."""
AT_REST = 1e-3
"""An alignment ends with a step smaller than this [m, rad]."""
FACING = 0.7
"""Elements face the same side if the cosine of the angle between their normals is above this."""
ON_WALL, BESIDE = 0.2, 0.5
"""An element on a wall is at most this far from the nearest one, and one beside it at most this far [m]."""
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
        self.cell = cell
        x, y = surface.points.T
        self.lower: Array = np.array([x.min(), y.min()]) - margin
        size = np.ceil((np.array([x.max(), y.max()]) + margin - self.lower) / cell).astype(int)
        self.columns, self.rows = size.tolist()
        self._last = (size - 1.0)[:, None, None]
        free = np.ones((self.rows, self.columns), dtype=np.uint8)
        points = (surface.points - self.lower).T
        at = self.cells(points[:, None])[0]
        free.ravel()[at] = 0
        distance, labels = cv2.distanceTransformWithLabels(
            free, cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
        )
        self.distance: NDArray[np.float32] = np.asarray(distance, dtype=np.float32).ravel() * np.float32(cell)
        """Distance to the nearest wall, shape (rows * columns,) [m]; the first row of cells is at the smallest y."""
        # OpenCV numbers the occupied cells from 1.
        self._labels: NDArray[np.int32] = np.asarray(labels, dtype=np.int32).ravel()
        label = self._labels[at]
        self._lines = _averaged(points, surface, label)
        count = np.zeros((self.rows, self.columns), dtype=np.float32)
        count.ravel()[at] = np.bincount(label)[label]
        # Each scan has one element every `SPACING`, three in a row of three cells.
        count *= 3.0 * SPACING / cell
        blurred = cv2.blur(count, (3, 3), borderType=cv2.BORDER_CONSTANT)
        self.scans: NDArray[np.float32] = np.asarray(blurred, dtype=np.float32).ravel()
        """Approximate number of scans that show the wall in each cell, shape (rows * columns,)."""

    def cells(self, points: Array) -> NDArray[np.intp]:
        """Return the indices in the flattened grid of the cells of points, limited to the grid, shape (k, n).

        Args:
            points: Relative to the corner `lower`, shape (2, k, n) [m].
        """
        scaled = points * (1.0 / self.cell)
        np.maximum(scaled, 0.0, out=scaled)
        np.minimum(scaled, self._last, out=scaled)
        column, row = scaled.astype(np.intp)
        row *= self.columns
        row += column
        return np.asarray(row)

    def beside(self, points: Array) -> float:
        """Return the proportion of points (n, 2), at least one, that are near a wall."""
        at = self.cells((points - self.lower).T[:, None])[0]
        return float(np.mean(self.distance.take(at) < ON_WALL))

    def nearest(self, at: NDArray[np.intp]) -> Array:
        """Return the nearest element of each cell (k, n).

        Returns:
            Normals, noise [m], and distances of the lines from `lower` along the normals [m], shape (4, k, n).
        """
        return self._lines.take(self._labels.take(at), axis=1)


def _averaged(points: Array, surface: Surface, label: NDArray[np.int32]) -> Array:
    """Return the averages of the elements in each occupied cell.

    Each scan shows the wall in a cell once. A match on one of them alone would repeat its error; on their average,
    errors even out.

    Args:
        points: Points of the elements of several scans, relative to some origin, shape (2, n) [m].
        surface: The elements.
        label: Number of the occupied cell of each, from 1, shape (n,).

    Returns:
        Of each occupied cell the normal, the noise of one of its elements [m], and the distance of the line from the
        origin along the normal [m], shape (4, cells + 1).
    """
    chosen = np.zeros(int(label.max()) + 1, dtype=np.intp)
    chosen[label] = np.arange(len(label))
    across, along = surface.normals.T
    one = chosen[label]
    parallel = (across * across[one] + along * along[one] > PARALLEL).astype(float)
    columns = [parallel, *(parallel * points), parallel * across, parallel * along]
    count, x, y, nx, ny = np.array([np.bincount(label, column, len(chosen)) for column in columns])
    size = np.maximum(np.hypot(nx, ny), 1e-9)
    nx, ny = nx / size, ny / size
    return np.array([nx, ny, surface.noise[chosen], (nx * x + ny * y) / np.maximum(count, 1.0)])


@dataclass(frozen=True, slots=True, eq=False)
class Match:
    """Alignment of a scan with a surface."""

    pose: Array
    """Pose of the scan's frame in the surface's, shape (3,) [m, m, rad]."""
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


def align(field: WallField, scan: Surface, guess: Array, information: Array, starts: Array) -> list[Match]:
    """Return the poses at which a scan fits a surface best, near each of some starts.

    Point-to-line ICP: each element moves to the line through the nearest element of the surface that faces the same
    side. The guess counts as a measurement, so that it decides along a bare corridor, where walls give no information.

    Args:
        field: Field of the walls seen before.
        scan: Scan in its own frame.
        guess: Guess of the pose, shape (3,).
        information: Inverse of the guess's covariance, shape (3, 3).
        starts: Initial poses, shape (k, 3).

    References:
        Censi, An ICP Variant Using a Point-to-Line Metric, ICRA 2008.
    """
    poses = np.array(starts, dtype=float)
    poses[:, 2] = guess[2] + wrap_angles(poses[:, 2] - guess[2])
    both = np.concatenate([scan.points, scan.normals]).T.copy()
    moving, now = np.arange(len(poses)), poses
    reach, sigma = BESIDE, np.full((len(poses), 1), SIGMA)
    for _ in range(12):
        compared = _compared(field, both, scan.noise, now)
        on_wall, robust, weight = _weights(compared, sigma[moving], reach)
        system, trusted = _system(compared.K, robust, weight)
        H, b = system[:, :, :3] @ trusted + information, system[:, :, 3] + (now - guess) @ information
        steps = [solution(each, right) for each, right in zip(H.tolist(), b.tolist(), strict=True)]
        poses[moving] = now - steps
        sigma[moving, 0] = [_scatter(size[beside]) for size, beside in zip(compared.size, on_wall, strict=True)]
        reach = max(ON_WALL, 0.7 * reach)
        moving = moving[[max(map(abs, step)) >= AT_REST for step in steps]]
        if not len(moving):
            break
        now = poses[moving]
    return _judged(field, _compared(field, both, scan.noise, poses), poses, sigma, guess, information)


def _scatter(sizes: Array) -> float:
    """Return the standard deviation of distances from walls, given their sizes (n,) [m]."""
    if not len(sizes):
        return SIGMA
    middle = len(sizes) // 2
    # The median of the sizes of normal deviates is 0.674 of their standard deviation.
    return min(max(float(np.partition(sizes, middle)[middle]) / 0.674, FINEST), SIGMA)


class _Compared(NamedTuple):
    """Elements of a scan beside the nearest ones of a surface, at k poses of the scan."""

    at: NDArray[np.intp]
    """Cell of each, shape (k, n)."""
    distance: NDArray[np.float32]
    """Distance of the nearest element, shape (k, n) [m]."""
    same: NDArray[np.bool_]
    """Whether that faces the same side, shape (k, n)."""
    K: Array
    """Derivative of the signed distance from its line by (x, y, heading), and that distance, shape (4, k, n)."""
    size: Array
    """Distance from its line, shape (k, n) [m]."""
    noise: Array
    """The larger one of both elements' noise, shape (k, n) [m]."""


def _compared(field: WallField, both: Array, noise: Array, poses: Array) -> _Compared:
    """Return how a scan lies on a surface.

    Args:
        field: Field of the surface.
        both: Points of the elements of the scan, and their normals, in its frame, shape (2, 2 n).
        noise: Noise of the elements, shape (n,) [m].
        poses: Poses of the scan, shape (k, 3).
    """
    turns = [(math.cos(heading), math.sin(heading)) for heading in poses[:, 2].tolist()]
    R = np.array([[c, -s] for c, s in turns] + [[s, c] for c, s in turns])
    turned, count = (R @ both).reshape(2, len(poses), -1), len(noise)
    arm, (fx, fy) = turned[:, :, :count], turned[:, :, count:]
    placed = arm + (poses[:, :2] - field.lower).T[:, :, None]
    at = field.cells(placed)
    lines = field.nearest(at)
    same = fx * lines[0] + fy * lines[1] > FACING
    larger = np.maximum(noise, lines[2])
    K = misses(arm, placed, lines)
    return _Compared(at, field.distance.take(at), same, K, np.abs(K[3]), larger)


def misses(arm: Array, placed: Array, lines: Array) -> Array:
    """Return the signed distances of points from lines, and their derivatives by the pose of the points' frame.

    Args:
        arm: Points relative to the origin of their frame, along the axes of the lines' frame, shape (2, k, n) [m].
        placed: Points in the frame of the lines, shape (2, k, n) [m].
        lines: Unit normals of the lines, anything, and distances of the lines from the origin along the normals [m],
            shape (4, k, n); overwritten.

    Returns:
        Derivatives by (x, y, heading), and the distances [m], shape (4, k, n).
    """
    nx, ny, by_heading, miss = lines
    np.subtract(nx * placed[0] + ny * placed[1], miss, out=miss)
    np.subtract(ny * arm[0], nx * arm[1], out=by_heading)
    return lines


def _weights(compared: _Compared, sigma: Array, reach: float) -> tuple[NDArray[np.bool_], Array, Array]:
    """Return the weights of elements of a scan.

    Args:
        compared: The elements beside a surface.
        sigma: Standard deviation of their distances, shape (k, 1) [m].
        reach: Farther elements do not count [m].

    Returns:
        Whether each counts, its robust weight, and that divided by the variance of its distance [1/m^2], shape (k, n).
    """
    on_wall = compared.same & (compared.distance < reach)
    std = np.maximum(compared.noise, sigma)
    # Huber: beyond two standard deviations a miss counts less than its square.
    robust = on_wall / np.maximum(compared.size / (2.0 * std), 1.0)
    return on_wall, robust, EFFECTIVE * robust / (std * std)


def _system(K: Array, robust: Array, weight: Array) -> tuple[Array, Array]:
    """Return the normal equations of a step.

    Args:
        K: K as in `_Compared`.
        robust: Weight of each element among the normals, shape (k, n).
        weight: Weight of each element's distance, shape (k, n).

    Returns:
        Sums of products of `K` for the trusted part of a step, (k, 3, 4); the matrix that leaves this part, (k, 3, 3).
    """
    weighted = np.concatenate([robust * K[:2], weight * K[:3]])
    products = weighted.transpose(1, 0, 2) @ K.transpose(1, 2, 0)
    trusted = np.array([_trusted(each) for each in products[:, :2, :2].tolist()])
    return trusted @ products[:, 2:], trusted


def _trusted(squares: list[list[float]]) -> list[list[float]]:
    """Return the matrix that removes from a step the shifts constrained only by noise of normals, shape (3, 3).

    Along a bare corridor the normals are not exactly perpendicular to it; without this, their errors would count as
    information.

    Args:
        squares: Weighted sum of the squares of unit normals, shape (2, 2).

    References:
        Zhang, Kaess, Singh, On Degeneracy of Optimization-based State Estimation Problems, ICRA 2016.
    """
    (a, b), (_, d) = squares
    # Eigenvalues and the angle of the first eigenvector of a symmetric matrix of two rows.
    middle, radius, angle = 0.5 * (a + d), math.hypot(0.5 * (a - d), b), 0.5 * math.atan2(2.0 * b, a - d)
    first, second = (
        math.sqrt(max(0.0, 1.0 - ALONG * (a + d) / max(value, 1e-9))) for value in (middle + radius, middle - radius)
    )
    c, s = math.cos(angle), math.sin(angle)
    along = c * s * (first - second)
    return [
        [c * c * first + s * s * second, along, 0.0],
        [along, s * s * first + c * c * second, 0.0],
        [0.0, 0.0, 1.0],
    ]


def _judged(
    field: WallField, compared: _Compared, poses: Array, sigma: Array, guess: Array, information: Array
) -> list[Match]:
    """Return the matches of a scan at poses (k, 3) at which it fits a surface."""
    _, robust, weight = _weights(compared, sigma, ON_WALL)
    others = 0.5 * np.maximum(field.scans.take(compared.at) - 1.0, 0.0)
    seen, older = (
        system[:, :, :3] @ trusted
        for system, trusted in (_system(compared.K, robust, each) for each in (weight, others * weight))
    )
    on = compared.same & (compared.distance < ON_WALL) & (compared.size < CUT * SIGMA)
    squares = np.where(on, (compared.size / SIGMA) ** 2, CUT**2).sum(axis=1)
    difference = poses - guess
    costs = WEIGHED * squares + ((difference @ information) * difference).sum(axis=1)
    poses[:, 2] = wrap_angles(poses[:, 2])
    elements = on.shape[1]
    shares = on.sum(axis=1) / elements
    conflicts = (compared.same & ~on & (compared.distance < BESIDE)).sum(axis=1) / elements
    figures = zip(costs.tolist(), shares.tolist(), conflicts.tolist(), strict=True)
    return [
        Match(poses[k], seen[k] + information, share, seen[k], older[k], cost, conflict)
        for k, (cost, share, conflict) in enumerate(figures)
    ]
