"""A graph of poses in the plane: measured steps between them, and the poses that agree with all best."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import coo_array, csc_array
from scipy.sparse.linalg import SuperLU, splu

from mjsim.geometry import Array, wrap_angle, wrap_angles

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
            change = _factors(H).solve(-b).reshape(-1, 3)
            self.poses = self.poses + change
            self.poses[:, 2] = wrap_angles(self.poses[:, 2])
            if np.abs(change).max() < 1e-6:
                break
        return float(np.mean(squared)) if len(squared) else 0.0

    def drop_misfits(self, limit: float) -> int:
        """Forget steps between far poses whose squared error is above a limit, in units; return how many."""
        _, _, squared = self._system()
        kept = [k for k, (one, other) in enumerate(self.ends) if abs(one - other) == 1 or squared[k] <= limit]
        dropped = len(self.ends) - len(kept)
        self.ends, self.steps = [self.ends[k] for k in kept], [self.steps[k] for k in kept]
        self.informations = [self.informations[k] for k in kept]
        return dropped

    def covariance(self, number: int) -> Array:
        """Return the covariance of one pose, given the first, shape (3, 3)."""
        return self.covariances([number])

    def covariances(self, numbers: Sequence[int]) -> Array:
        """Return the joint covariance of k poses, given the first of the graph, shape (3 k, 3 k)."""
        H, _, _ = self._system()
        rows = (3 * np.asarray(numbers)[:, None] + np.arange(3)).ravel()
        columns = np.zeros((H.shape[0], len(rows)))
        columns[rows, np.arange(len(rows))] = 1.0
        return np.asarray(_factors(H).solve(columns)[rows], dtype=float)

    def step_covariances(self, ones: Sequence[int], other: int) -> list[Array]:
        """Return the covariances of the steps from some poses to another, shape (3, 3) each."""
        joint = self.covariances([*ones, other])
        last = 3 * len(ones) + np.arange(3)
        found = []
        for k, one in enumerate(ones):
            _, A, B = step_errors(self.poses[one][None], self.poses[other][None], np.zeros((1, 3)))
            both = np.concatenate([3 * k + np.arange(3), last])
            J = np.concatenate([A[0], B[0]], axis=1)
            found.append(np.asarray(J @ joint[np.ix_(both, both)] @ J.T, dtype=float))
        return found

    def _system(self) -> tuple[csc_array, Array, Array]:
        """Return H (3 n, 3 n) and b (3 n,) of the normal equations, and each step's squared error."""
        number = len(self.poses)
        first, second = np.array(self.ends, dtype=np.intp).reshape(-1, 2).T
        error, A, B = step_errors(self.poses[first], self.poses[second], np.array(self.steps).reshape(-1, 3))
        information = np.array(self.informations).reshape(-1, 3, 3)
        squared = np.einsum("ki,kij,kj->k", error, information, error)
        # Steps along the way are trusted; those that close a loop might be wrong.
        far = np.abs(first - second) > 1
        weight = np.where(far, np.minimum(1.0, HUBER / np.sqrt(np.maximum(squared, 1e-12))), 1.0)
        J = np.concatenate([A, B], axis=2)
        weighted = J.transpose(0, 2, 1) @ (information * weight[:, None, None])
        # Rows of both poses of each step, shape (k, 6).
        at = np.concatenate([3 * first[:, None] + np.arange(3), 3 * second[:, None] + np.arange(3)], axis=1)
        b = np.asarray(np.bincount(at.ravel(), (weighted @ error[:, :, None]).ravel(), 3 * number), dtype=float)
        rows, columns = np.broadcast_arrays(at[:, :, None], at[:, None, :])
        # The first pose is held by a very stiff spring.
        fixed = np.arange(3)
        values = np.concatenate([(weighted @ J).ravel(), np.full(3, 1e12)])
        place = (np.concatenate([rows.ravel(), fixed]), np.concatenate([columns.ravel(), fixed]))
        return coo_array((values, place), shape=(3 * number, 3 * number)).tocsc(), b, squared


def _factors(H: csc_array) -> SuperLU:
    """Return the factors of a symmetric positive definite matrix: without pivots, in an order that keeps symmetry."""
    return splu(H, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})


def step_between(one: Array, other: Array) -> Array:
    """Return the pose of the second in the frame of the first, poses (..., 3)."""
    c, s = np.cos(one[..., 2]), np.sin(one[..., 2])
    dx, dy = other[..., 0] - one[..., 0], other[..., 1] - one[..., 1]
    return np.stack([c * dx + s * dy, c * dy - s * dx, wrap_angles(other[..., 2] - one[..., 2])], axis=-1)


def compose(outer: Array, inner: Array) -> Array:
    """Return the pose (3,) in the world of one that is given in the frame of another."""
    c, s = np.cos(outer[2]), np.sin(outer[2])
    x, y, heading = inner
    return np.array(
        [outer[0] + c * x - s * y, outer[1] + s * x + c * y, wrap_angle(float(outer[2] + heading))], dtype=float
    )


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
