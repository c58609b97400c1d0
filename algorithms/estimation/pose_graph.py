"""A graph of planar poses: measured steps between them, and the poses that fit all steps best."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bsr_array, csc_array
from scipy.sparse.linalg import SuperLU, splu

from mjsim.geometry import Array, wrap_angle, wrap_angles

COMMON = 6
"""Number of errors common to all steps: the systematic errors of odometry."""
HUBER = 2.0
"""Huber threshold of a step between distant poses, in standard deviations."""


@dataclass
class PoseGraph:
    """Poses (x, y, heading) and measured steps from one to another; the first pose is fixed.

    References:
        Grisetti, Kuemmerle, Stachniss, Burgard, A Tutorial on Graph-Based SLAM, IEEE ITS Magazine 2(4), 2010,
        section IV: Gauss-Newton on a sparse system.
    """

    poses: Array
    """Shape (n, 3) [m, m, rad]."""
    ends: NDArray[np.intp] = field(default_factory=lambda: np.zeros((0, 2), dtype=np.intp))
    """Indices of the first and second pose of each step, shape (k, 2)."""
    steps: Array = field(default_factory=lambda: np.zeros((0, 3)))
    """Pose of the second in the frame of the first, shape (k, 3)."""
    informations: Array = field(default_factory=lambda: np.zeros((0, 3, 3)))
    """Weight of each step, the inverse of a covariance, shape (k, 3, 3)."""
    error_covariances: Array = field(default_factory=lambda: np.zeros((0, 3, 3)))
    """Covariance of the error of each step, shape (k, 3, 3); weights may be more conservative."""
    slopes: Array = field(default_factory=lambda: np.zeros((0, 3, COMMON)))
    """Derivative of each step by the common errors, shape (k, 3, 6); `steps` are given for common errors of 0."""
    errors: Array = field(default_factory=lambda: np.zeros(COMMON))
    """Estimate of the common errors of all steps, shape (6,)."""
    _expected: Array = field(default_factory=lambda: np.zeros(COMMON), init=False, repr=False)
    _prior_covariance: Array = field(default_factory=lambda: np.eye(COMMON), init=False, repr=False)
    _solution: "GraphSolution | None" = field(default=None, init=False, repr=False)
    """Factors of the normal equations of the last iteration."""

    def add_pose(self, pose: Array) -> int:
        """Add a pose and return its index."""
        self.poses = np.concatenate([self.poses, pose[None]])
        return len(self.poses) - 1

    def expect(self, errors: Array, covariance: Array) -> None:
        """Set the prior of the common errors: mean (6,) and covariance (6, 6)."""
        self._expected, self._prior_covariance = errors, covariance

    def add_step(
        self,
        one: int,
        other: int,
        step: Array,
        information: Array,
        covariance: Array | None = None,
        slopes: Array | None = None,
    ) -> None:
        """Add a measured step from one pose to another.

        Args:
            one: Index of the first pose.
            other: Index of the second pose.
            step: Pose of the second in the frame of the first for common errors of 0, shape (3,).
            information: Its weight, shape (3, 3).
            covariance: Covariance of its own error, shape (3, 3); by default the inverse of the weight.
            slopes: Its derivative by the common errors, shape (3, 6); by default 0.
        """
        covariance = np.asarray(np.linalg.inv(information), dtype=float) if covariance is None else covariance
        self.ends = np.concatenate([self.ends, np.array([[one, other]], dtype=np.intp)])
        self.steps = np.concatenate([self.steps, step[None]])
        self.informations = np.concatenate([self.informations, information[None]])
        self.error_covariances = np.concatenate([self.error_covariances, covariance[None]])
        slopes = np.zeros((3, COMMON)) if slopes is None else slopes
        self.slopes = np.concatenate([self.slopes, slopes[None]])

    def solve(self, *, rounds: int = 8) -> float:
        """Fit the poses to all steps; return the remaining mean squared normalized error."""
        squared = np.zeros(0)
        for _ in range(rounds):
            self._solution, b, squared = self._system()
            solved = self._solution.solve(-b[:, None])[:, 0]
            change = solved[:-COMMON].reshape(-1, 3)
            self.poses = self.poses + change
            self.poses[:, 2] = wrap_angles(self.poses[:, 2])
            self.errors = self.errors + solved[-COMMON:]
            if np.abs(change).max() < 1e-6:
                break
        return float(np.mean(squared)) if len(squared) else 0.0

    def drop_misfits(self, limit: float) -> int:
        """Drop steps between distant poses whose squared normalized error exceeds a limit; return their number."""
        _, _, squared = self._errors()
        consistent = (np.abs(self.ends[:, 0] - self.ends[:, 1]) == 1) | (squared <= limit)
        self.ends, self.steps = self.ends[consistent], self.steps[consistent]
        self.informations, self.error_covariances = self.informations[consistent], self.error_covariances[consistent]
        self.slopes = self.slopes[consistent]
        return int(np.sum(~consistent))

    def covariance(self, number: int) -> Array:
        """Return the covariance of one pose, given the first, from the spreads of the steps, shape (3, 3).

        If the weights are the inverses of the spreads, it equals that of `covariances`.
        """
        return self.joint_covariance(number)[:3, :3]

    def joint_covariance(self, number: int) -> Array:
        """Return the covariance of one pose and of the common errors of all steps, shape (9, 9).

        References:
            White, A heteroskedasticity-consistent covariance matrix estimator, Econometrica 48, 1980: least squares
            whose weights are not those of the errors.
        """
        if self.solved < len(self.poses):
            self.factorise()
        every = self._columns([number])
        columns, common = every[:-COMMON].reshape(-1, 3, 3 + COMMON), every[-COMMON:]
        _, J, squared = self._errors()
        first, second = self.ends.T
        change = J[:, :, :3] @ columns[first] + J[:, :, 3:] @ columns[second] - self.slopes @ common
        weighed = self.informations @ change
        each = weighed.transpose(0, 2, 1) @ self.error_covariances @ weighed
        by_steps = np.einsum("k,kij->ij", self._weights(squared), each)
        return np.asarray(by_steps + common.T @ np.linalg.solve(self._prior_covariance, common))

    @property
    def solved(self) -> int:
        """Number of poses, from the first, in the last solution; 0 before the first one."""
        return 0 if self._solution is None else len(self._solution.across) // 3

    def factorise(self) -> None:
        """Prepare covariances of the poses at their current values."""
        self._solution = self._system()[0]

    def covariances(self, numbers: Sequence[int]) -> Array:
        """Return the joint covariance of k poses, given the first of the graph, by the weights, shape (3 k, 3 k).

        It is that of the last solution if that contains all of these poses.
        """
        number = 3 * len(numbers)
        return self._columns(numbers)[_rows(numbers), :number]

    def step_covariances(self, ones: Sequence[int], other: int) -> list[Array]:
        """Return the covariances of the steps from some poses to another, shape (3, 3) each."""
        return [joint[:3, :3] for joint in self.joint_step_covariances(ones, other)]

    def joint_step_covariances(self, ones: Sequence[int], other: int) -> list[Array]:
        """Return the joint covariances of each of these steps and of the common errors, shape (9, 9) each."""
        numbers = [*ones, other]
        columns = self._columns(numbers)
        joint = columns[_ends(numbers, len(columns))]
        last = 3 * len(ones) + np.arange(3 + COMMON)
        found = []
        for k, one in enumerate(ones):
            _, A, B = step_errors(self.poses[one][None], self.poses[other][None], np.zeros((1, 3)))
            both = np.concatenate([3 * k + np.arange(3), last])
            J = np.zeros((3 + COMMON, 6 + COMMON))
            J[:3, :3], J[:3, 3:6], J[3:, 6:] = A[0], B[0], np.eye(COMMON)
            found.append(np.asarray(J @ joint[np.ix_(both, both)] @ J.T, dtype=float))
        return found

    def _columns(self, numbers: Sequence[int]) -> Array:
        """Return the columns of the inverse of H of k poses and of the common errors, shape (3 n + 6, 3 k + 6)."""
        if self._solution is None or max(numbers) >= self.solved:
            self.factorise()
        assert self._solution is not None
        size = 3 * self.solved + COMMON
        rows = _ends(numbers, size)
        columns = np.zeros((size, len(rows)))
        columns[rows, np.arange(len(rows))] = 1.0
        return self._solution.solve(columns)

    def _weights(self, squared: Array) -> Array:
        """Return the robust weight of each step from its squared normalized error, shape (k,)."""
        # Steps along the path are trusted; those that close a loop might be wrong.
        far = np.abs(self.ends[:, 0] - self.ends[:, 1]) > 1
        return np.where(far, np.minimum(1.0, HUBER / np.sqrt(np.maximum(squared, 1e-12))), 1.0)

    def _errors(self) -> tuple[Array, Array, Array]:
        """Return each step's error (k, 3), its derivatives by both poses (k, 3, 6), and its normalized square (k,)."""
        first, second = self.ends.T
        error, A, B = step_errors(self.poses[first], self.poses[second], self.steps + self.slopes @ self.errors)
        squared = np.einsum("ki,ki->k", error, (self.informations @ error[:, :, None])[:, :, 0])
        return error, np.concatenate([A, B], axis=2), squared

    def _system(self) -> tuple["GraphSolution", Array, Array]:
        """Return the factors of H and b (3 n + 6,) of the normal equations, and each step's squared error."""
        number, ends = len(self.poses), self.ends
        error, J, squared = self._errors()
        weighted = J.transpose(0, 2, 1) @ (self.informations * self._weights(squared)[:, None, None])
        at = 3 * ends[:, :, None] + np.arange(3)
        b = np.asarray(np.bincount(at.ravel(), (weighted @ error[:, :, None]).ravel(), 3 * number), dtype=float)
        blocks = (weighted @ J).reshape(-1, 2, 3, 2, 3).transpose(0, 1, 3, 2, 4).reshape(-1, 3, 3)
        # The first pose is held by a very stiff spring.
        blocks = np.concatenate([blocks, 1e12 * np.eye(3)[None]])
        rows = np.append(np.repeat(ends, 2, axis=1), 0)
        columns = np.append(np.tile(ends, (1, 2)), 0)
        factors = _factors(_of_blocks(blocks, rows, columns, number))
        mixed = -(weighted @ self.slopes).reshape(-1, COMMON)
        summed = [np.bincount(at.ravel(), column, 3 * number) for column in mixed.T]
        across = np.asarray(np.stack(summed, axis=1), dtype=float)
        # The derivative of a step's error by the common errors is minus its slopes.
        by_slopes = (self.slopes.transpose(0, 2, 1) @ self.informations) * self._weights(squared)[:, None, None]
        known = np.linalg.inv(self._prior_covariance)
        common = known + (by_slopes @ self.slopes).sum(axis=0)
        pull = known @ (self.errors - self._expected) - (by_slopes @ error[:, :, None]).sum(axis=0)[:, 0]
        return GraphSolution.of(factors, across, common), np.concatenate([b, pull]), squared


@dataclass(frozen=True, slots=True, eq=False)
class GraphSolution:
    """Factors of the normal equations of n poses and the common errors of all steps."""

    factors: SuperLU
    """Factors of the poses' part."""
    across: Array
    """Minus the derivative of the poses by the common errors, steps held, shape (3 n, 6)."""
    common: Array
    """Inverse of the Schur complement of the common errors' part, shape (6, 6)."""

    @classmethod
    def of(cls, factors: SuperLU, across: Array, common: Array) -> "GraphSolution":
        """Return the solution, given factors of the poses' part of H, its mixed part (3 n, 6) and errors' part (6, 6).

        References:
            Golub, Van Loan, Matrix Computations (2013), section 3.2.11: the Schur complement.
        """
        follow = np.asarray(factors.solve(across), dtype=float)
        return cls(factors, follow, np.asarray(np.linalg.inv(common - across.T @ follow), dtype=float))

    def solve(self, right: Array) -> Array:
        """Return the solution of H x = the right side (3 n + 6, m)."""
        poses = np.asarray(self.factors.solve(np.ascontiguousarray(right[:-COMMON])), dtype=float)
        # `across` is A^-1 B with A symmetric, so its transpose times the right side is B^T A^-1 times it.
        errors = self.common @ (right[-COMMON:] - self.across.T @ right[:-COMMON])
        return np.concatenate([poses - self.across @ errors, errors])


def _rows(numbers: Sequence[int]) -> NDArray[np.intp]:
    """Return the indices of the states of k poses, shape (3 k,)."""
    return (3 * np.asarray(numbers)[:, None] + np.arange(3)).ravel()


def _ends(numbers: Sequence[int], size: int) -> NDArray[np.intp]:
    """Return the indices of the states of k poses and, at the end, of the common errors, shape (3 k + 6,)."""
    return np.concatenate([_rows(numbers), np.arange(size - COMMON, size)])


def _of_blocks(blocks: Array, rows: NDArray[np.intp], columns: NDArray[np.intp], number: int) -> csc_array:
    """Return the matrix (3 n, 3 n) of summed blocks (k, 3, 3), given the block row and column of each."""
    order = np.argsort(rows * number + columns, kind="stable")
    rows, columns = rows[order], columns[order]
    begins = np.flatnonzero(np.concatenate([[True], (np.diff(rows) != 0) | (np.diff(columns) != 0)]))
    ends = np.searchsorted(rows[begins], np.arange(number + 1))
    summed = np.add.reduceat(blocks[order], begins, axis=0)
    return bsr_array((summed, columns[begins], ends), shape=(3 * number, 3 * number)).tocsc()


def _factors(H: csc_array) -> SuperLU:
    """Return the factors of a symmetric positive definite matrix, without pivoting, in a symmetric ordering."""
    return splu(H, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})


def step_between(one: Array, other: Array) -> Array:
    """Return the pose of the second in the frame of the first, poses (..., 3)."""
    c, s = np.cos(one[..., 2]), np.sin(one[..., 2])
    dx, dy = other[..., 0] - one[..., 0], other[..., 1] - one[..., 1]
    return np.stack([c * dx + s * dy, c * dy - s * dx, wrap_angles(other[..., 2] - one[..., 2])], axis=-1)


def compose(outer: Array, inner: Array) -> Array:
    """Return a pose (3,) in the world from one given in the frame of another pose."""
    c, s = np.cos(outer[2]), np.sin(outer[2])
    x, y, heading = inner
    return np.array(
        [outer[0] + c * x - s * y, outer[1] + s * x + c * y, wrap_angle(float(outer[2] + heading))], dtype=float
    )


def composed(outers: Array, inners: Array) -> Array:
    """Return poses (..., 3) in the world from those in the frames of other poses (..., 3)."""
    c, s = np.cos(outers[..., 2]), np.sin(outers[..., 2])
    x, y = inners[..., 0], inners[..., 1]
    found = outers + inners
    found[..., 0], found[..., 1] = outers[..., 0] + c * x - s * y, outers[..., 1] + s * x + c * y
    found[..., 2] = wrap_angles(found[..., 2])
    return found


def step_errors(ones: Array, others: Array, steps: Array) -> tuple[Array, Array, Array]:
    """Return the errors of measured steps (k, 3), and their derivatives by both poses (k, 3, 3)."""
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
    """Return the derivative of a pose by the first pose of its graph, moved as one rigid body, shape (3, 3)."""
    dx, dy = pose[:2] - first[:2]
    return np.array([[1.0, 0.0, -dy], [0.0, 1.0, dx], [0.0, 0.0, 1.0]])
