"""How must a scan be moved to lie on another? From nearby exactly, from afar by trying."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from mjsim.geometry import Array, wrap_angle

from .distance_grid import DistanceGrid

NEIGHBOUR = 0.3
"""Two points next to each other in a scan that are nearer than this lie on one wall [m]."""
SIGMA = 0.03
"""Standard deviation of a point's distance from its wall: noise, and walls that are not quite lines [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """Points of walls and the directions that the walls face, in one frame."""

    points: Array
    """Shape (n, 2) [m]."""
    normals: Array
    """Unit vectors across the walls, shape (n, 2)."""

    def moved(self, pose: Array) -> "Surface":
        """Return it in the frame in which `pose` (x, y, heading) is its frame's pose."""
        R = _rotation(float(pose[2]))
        return Surface(self.points @ R.T + pose[:2], self.normals @ R.T)


def surface_of(points: Array) -> Surface:
    """Return those points of a scan that lie on walls, and the walls' normals.

    Args:
        points: In the order of the beams, shape (n, 2) [m].
    """
    if len(points) < 3:
        return Surface(np.zeros((0, 2)), np.zeros((0, 2)))
    before, after = points[1:-1] - points[:-2], points[2:] - points[1:-1]
    along = points[2:] - points[:-2]
    lengths = np.hypot(*along.T)
    near = (np.hypot(*before.T) < NEIGHBOUR) & (np.hypot(*after.T) < NEIGHBOUR) & (lengths > 1e-6)
    # Not across a corner: there the middle point lies off the line between its neighbours.
    bend = np.abs(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0])
    straight = near & (bend < 0.35 * np.hypot(*before.T) * np.hypot(*after.T))
    along = along[straight] / lengths[straight, None]
    return Surface(points[1:-1][straight], np.stack([-along[:, 1], along[:, 0]], axis=-1))


def joined(surfaces: list[Surface]) -> Surface:
    """Return one surface of many that lie in one frame."""
    return Surface(
        np.concatenate([surface.points for surface in surfaces]),
        np.concatenate([surface.normals for surface in surfaces]),
    )


@dataclass(frozen=True, slots=True, eq=False)
class Match:
    """Where a scan lies on a surface."""

    pose: Array
    """Of the scan's frame in the surface's, shape (3,) [m, m, rad]."""
    information: Array
    """Inverse of the pose's covariance as the points and the guess give it, shape (3, 3)."""
    share: float
    """Of the scan's points that lie on the surface."""


def align(surface: Surface, points: Array, guess: Array, information: Array, *, rounds: int = 15) -> Match:
    """Return the pose at which points lie best on a surface, near a guess.

    Each point is led to the line through the nearest point of the surface; the guess counts as a measurement, so
    that along a bare corridor, where walls tell nothing, the guess decides.

    Args:
        surface: Walls seen before.
        points: Of the new scan, in its own frame, shape (n, 2) [m].
        guess: Of the pose, shape (3,).
        information: Inverse of the guess's covariance, shape (3, 3).
        rounds: The most steps of Gauss-Newton.

    References:
        Censi, An ICP Variant Using a Point-to-Line Metric, ICRA 2008.
    """
    pose, tree = np.array(guess, dtype=float), cKDTree(surface.points)
    H, share, reach = np.asarray(information, dtype=float), 0.0, 0.5
    for _ in range(rounds):
        distance, nearest = tree.query(points @ _rotation(pose[2]).T + pose[:2])
        miss, J = misses(pose, points, surface.points[nearest], surface.normals[nearest])
        used = distance < reach
        # Huber: beyond two standard deviations a miss counts less than its square.
        weight = np.where(used, np.minimum(1.0, 2.0 * SIGMA / np.maximum(np.abs(miss), 1e-9)), 0.0) / SIGMA**2
        off = pose - guess
        off[2] = wrap_angle(off[2])
        # Neighbouring beams err alike, for walls are not quite lines: a scan counts for a tenth of its points.
        H = 0.1 * (J.T * weight) @ J + information
        step = np.linalg.solve(H, 0.1 * J.T @ (weight * miss) + information @ off)
        pose -= step
        reach = max(0.15, 0.7 * reach)
        share = float(np.mean(used & (np.abs(miss) < 3.0 * SIGMA)))
        if np.abs(step).max() < 1e-5:
            break
    pose[2] = wrap_angle(pose[2])
    return Match(pose, np.asarray(H, dtype=float), share)


def misses(pose: Array, points: Array, places: Array, normals: Array) -> tuple[Array, Array]:
    """Return how far points are in front of lines, and how that changes with the pose of the points' frame.

    Args:
        pose: Of the points' frame in that of the lines, shape (3,).
        points: In their own frame, shape (n, 2) [m].
        places: A point of each one's line, shape (n, 2) [m].
        normals: Unit vectors across the lines, shape (n, 2).

    Returns:
        Distances, shape (n,) [m], and their derivative by (x, y, heading), shape (n, 3).
    """
    arm = points @ _rotation(float(pose[2])).T
    miss = np.sum(normals * (arm + pose[:2] - places), axis=1)
    return miss, np.column_stack([normals, normals[:, 1] * arm[:, 0] - normals[:, 0] * arm[:, 1]])


def search(surface: Surface, points: Array, guess: Array, *, reach: float = 1.0, turn: float = 0.5) -> Array:
    """Return the pose among many around a guess at which points lie best on a surface, shape (3,).

    Args:
        surface: Walls seen before.
        points: Of the new scan, in its own frame, shape (n, 2) [m].
        guess: Of the pose, shape (3,).
        reach: How far from the guess to try [m].
        turn: How far to turn from it [rad].

    References:
        Olson, Real-Time Correlative Scan Matching, ICRA 2009.
    """
    cell = 0.1
    tiny = np.stack([surface.points, surface.points + 1e-6], axis=1)
    grid = DistanceGrid.from_segments(tiny, cell=cell, margin=reach + 0.5)
    likely = np.exp(-0.5 * (grid.distance / cell) ** 2)
    steps = np.arange(-reach, reach + 1e-9, cell)
    some = points[:: max(1, len(points) // 60)]
    best, chosen = -1.0, np.array(guess, dtype=float)
    shifts = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    for extra in np.arange(-turn, turn + 1e-9, 0.035):
        placed = some @ _rotation(guess[2] + extra).T + guess[:2]
        cells = grid.cells(placed + shifts[:, None])
        score = likely[cells[..., 0], cells[..., 1]].mean(axis=1)
        # Of alike places the one nearest to the guess.
        score -= 0.02 * np.hypot(*shifts.T) / reach
        top = int(np.argmax(score))
        if score[top] > best:
            best = float(score[top])
            chosen = np.array([*(guess[:2] + shifts[top]), guess[2] + extra])
    return chosen


def _rotation(angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])
