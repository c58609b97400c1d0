"""A graph of poses in the plane: measured steps between them, and the poses that agree with all best."""

from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import coo_array, csc_array
from scipy.sparse.linalg import splu

from mjsim.geometry import Array, wrap_angles

HUBER = 2.0
"""Beyond so many standard deviations a step between far poses counts less than its square."""


@dataclass
class PoseGraph:
    """Poses (x, y, heading) and measured steps from one to another; the first pose stays where it is.

    References:
        Grisetti, Kuemmerle, Stachniss, Burgard, A Tutorial on Graph-Based SLAM, IEEE ITS Magazine 2(4), 2010,
        section IV: Gauss-Newton on a sparse system.
    """

    poses: Array
    """Shape (n, 3) [m, m, rad]."""
    ends: list[tuple[int, int]] = field(default_factory=list)
    """From which pose to which each step leads."""
    steps: list[Array] = field(default_factory=list)
    """Pose of the second in the frame of the first, shape (3,) each."""
    informations: list[Array] = field(default_factory=list)
    """Inverse of each step's covariance, shape (3, 3) each."""

    def add_pose(self, pose: Array) -> int:
        """Add a pose; return its number."""
        self.poses = np.concatenate([self.poses, pose[None]])
        return len(self.poses) - 1

    def add_step(self, one: int, other: int, step: Array, information: Array) -> None:
        """Add a measured step from one pose to another."""
        self.ends.append((one, other))
        self.steps.append(step)
        self.informations.append(information)

    def solve(self, *, rounds: int = 8) -> float:
        """Move the poses to where they agree with all steps best; return the mean squared error left, in units."""
        squared = np.zeros(0)
        for _ in range(rounds):
            H, b, squared = self._system()
            change = splu(H).solve(-b).reshape(-1, 3)
            self.poses = self.poses + change
            self.poses[:, 2] = wrap_angles(self.poses[:, 2])
            if np.abs(change).max() < 1e-6:
                break
        return float(np.mean(squared)) if len(squared) else 0.0

    def covariance(self, number: int) -> Array:
        """Return the covariance of one pose, given the first, shape (3, 3)."""
        H, _, _ = self._system()
        columns = np.zeros((H.shape[0], 3))
        columns[3 * number : 3 * number + 3] = np.eye(3)
        return np.asarray(splu(H).solve(columns)[3 * number : 3 * number + 3], dtype=float)

    def _system(self) -> tuple[csc_array, Array, Array]:
        """Return H (3 n, 3 n) and b (3 n,) of the normal equations, and each step's squared error."""
        number = len(self.poses)
        first, second = np.array(self.ends).reshape(-1, 2).T
        error, A, B = step_errors(self.poses[first], self.poses[second], np.array(self.steps).reshape(-1, 3))
        information = np.array(self.informations).reshape(-1, 3, 3)
        squared = np.einsum("ki,kij,kj->k", error, information, error)
        # Steps along the way are trusted; those that close a loop might be wrong.
        far = np.abs(first - second) > 1
        weight = np.where(far, np.minimum(1.0, HUBER / np.sqrt(np.maximum(squared, 1e-12))), 1.0)
        information = information * weight[:, None, None]
        b = np.zeros((number, 3))
        blocks, rows, columns = [], [], []
        for one, J in ((first, A), (second, B)):
            np.add.at(b, one, np.einsum("kji,kjl,kl->ki", J, information, error))
            for other, K in ((first, A), (second, B)):
                blocks.append(J.transpose(0, 2, 1) @ information @ K)
                rows.append(np.broadcast_to((3 * one)[:, None, None] + np.arange(3)[:, None], (len(one), 3, 3)))
                columns.append(np.broadcast_to((3 * other)[:, None, None] + np.arange(3), (len(one), 3, 3)))
        # The first pose is held by a very stiff spring.
        fixed = np.arange(3)
        values = np.concatenate([np.ravel(blocks), np.full(3, 1e12)])
        place = (np.concatenate([np.ravel(rows), fixed]), np.concatenate([np.ravel(columns), fixed]))
        return coo_array((values, place), shape=(3 * number, 3 * number)).tocsc(), b.ravel(), squared


def step_between(one: Array, other: Array) -> Array:
    """Return the pose of the second in the frame of the first, poses (..., 3)."""
    c, s = np.cos(one[..., 2]), np.sin(one[..., 2])
    dx, dy = other[..., 0] - one[..., 0], other[..., 1] - one[..., 1]
    return np.stack([c * dx + s * dy, c * dy - s * dx, wrap_angles(other[..., 2] - one[..., 2])], axis=-1)


def step_errors(ones: Array, others: Array, steps: Array) -> tuple[Array, Array, Array]:
    """Return how far poses are from measured steps (k, 3), and the derivatives by both poses (k, 3, 3)."""
    found = step_between(ones, others)
    error = found - steps
    error[:, 2] = wrap_angles(error[:, 2])
    c, s = np.cos(ones[:, 2]), np.sin(ones[:, 2])
    A, B = np.zeros((len(ones), 3, 3)), np.zeros((len(ones), 3, 3))
    B[:, 0, 0], B[:, 0, 1], B[:, 1, 0], B[:, 1, 1], B[:, 2, 2] = c, s, -s, c, 1.0
    A[:, :, :2] = -B[:, :, :2]
    A[:, 0, 2], A[:, 1, 2], A[:, 2, 2] = found[:, 1], -found[:, 0], -1.0
    return error, A, B


def carried(pose: Array, first: Array) -> Array:
    """Return how a pose changes with the first one of its graph, which turns and shifts all of it, shape (3, 3)."""
    dx, dy = pose[:2] - first[:2]
    return np.array([[1.0, 0.0, -dy], [0.0, 1.0, dx], [0.0, 0.0, 1.0]])
