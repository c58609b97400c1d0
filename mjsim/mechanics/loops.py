"""Constraints between the bodies of a linkage (closed loops, gears, distances), and values that satisfy them.

References:
    Haug, Computer-Aided Kinematics and Dynamics of Mechanical Systems (1989), chapters 3 and 4.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from mjsim.geometry import Array
from mjsim.mechanics.linkage import Linkage, Placement
from mjsim.mechanics.transforms import rotation_vector

CLOSE_ENOUGH = 1e-10
"""Residuals below this are zero [rad, m]."""
CLOSING_TOLERANCE = 1e-6
"""Closing error of redundantly constrained loops with lengths of six digits [rad, m]."""
MAX_NEWTON_STEPS, MAX_STARTS = 60, 6
"""Maximum number of steps of Newton's method from one start, and number of starts."""
MAX_EVALUATIONS, MIN_EVALUATIONS = 8000, 40
"""Maximum number of joint evaluations in one search, and minimum number of residual evaluations: it must end within a
second."""
MIN_REDUCTION, MAX_SLOW_STEPS = 0.995, 4
"""A start is abandoned after this many consecutive steps that reduce the residuals to more than this ratio."""
MAX_STEP = 0.6
"""Maximum step of Newton's method in one value [rad, m]."""
NO_RANK = 1e-9
"""Singular values below this, relative to the largest, count as zero."""
DERIVATIVE_STEP = 1e-5
"""Step for the numerical derivative of a Jacobian."""


class Rows(Protocol):
    """Constraint equations between the values of a linkage."""

    def residual(self, linkage: Linkage, placed: Placement, values: Array) -> Array:
        """Return their residuals, shape (rows,) [rad, m]."""

    def jacobian(self, linkage: Linkage, placed: Placement, values: Array) -> Array:
        """Return the derivative of the residuals, shape (rows, values)."""


@dataclass(frozen=True, slots=True)
class Coincide:
    """The frames of two bodies are the same: a ghost and the body that it stands for."""

    ghost: int
    body: int

    def residual(self, linkage: Linkage, placed: Placement, values: Array) -> Array:
        """Return position and rotation vector of the body from its ghost, frame of the ground, shape (6,)."""
        ghost, body = placed.poses[self.ghost], placed.poses[self.body]
        turned = ghost[:3, :3] @ rotation_vector(ghost[:3, :3].T @ body[:3, :3])
        return np.concatenate([body[:3, 3] - ghost[:3, 3], turned])

    def jacobian(self, linkage: Linkage, placed: Placement, values: Array) -> Array:
        """Return its derivative, exact where the residual is 0, shape (6, values)."""
        ends = []
        for number in (self.body, self.ghost):
            point = linkage.point_jacobian(placed, number, placed.poses[number, :3, 3])
            ends.append(np.concatenate([point, linkage.turn_jacobian(placed, number)]))
        return np.asarray(ends[0] - ends[1])


@dataclass(frozen=True, slots=True)
class Linear:
    """A sum of values times factors is a constant: gears, screws, and joints that are held."""

    factors: Mapping[int, float]
    """By column."""
    constant: float = 0.0

    def residual(self, linkage: Linkage, placed: Placement, values: Array) -> Array:
        """Return the sum without the constant, shape (1,)."""
        return np.array([sum(factor * values[column] for column, factor in self.factors.items()) - self.constant])

    def jacobian(self, linkage: Linkage, placed: Placement, values: Array) -> Array:
        """Return the factors, shape (1, values)."""
        row = np.zeros((1, linkage.size))
        for column, factor in self.factors.items():
            row[0, column] = factor
        return row


@dataclass(frozen=True, slots=True, eq=False)
class BodyPoint:
    """A point of a body."""

    body: int
    at: Array
    """Position in the frame of the body, shape (3,) [m]."""

    def place(self, placed: Placement) -> Array:
        """Return where it is in the frame of the ground, shape (3,) [m]."""
        pose = placed.poses[self.body]
        return np.asarray(pose[:3, :3] @ self.at + pose[:3, 3])


@dataclass(frozen=True, slots=True, eq=False)
class Apart:
    """Two points have a given distance."""

    ends: tuple[BodyPoint, BodyPoint]
    length: float
    """[m]"""

    def residual(self, linkage: Linkage, placed: Placement, values: Array) -> Array:
        """Return the error of their distance, shape (1,) [m]."""
        return np.array([np.linalg.norm(self._between(placed)) - self.length])

    def jacobian(self, linkage: Linkage, placed: Placement, values: Array) -> Array:
        """Return its derivative, shape (1, values)."""
        between = self._between(placed)
        along = between / max(float(np.linalg.norm(between)), 1e-12)
        first, second = (linkage.point_jacobian(placed, end.body, end.place(placed)) for end in self.ends)
        return np.asarray((along @ (second - first))[None])

    def _between(self, placed: Placement) -> Array:
        return self.ends[1].place(placed) - self.ends[0].place(placed)


@dataclass(frozen=True, slots=True, eq=False)
class Meet:
    """The origin of a ghost is at a point of a body."""

    ghost: int
    spot: BodyPoint

    def residual(self, linkage: Linkage, placed: Placement, values: Array) -> Array:
        """Return the vector from the ghost to the point, frame of the ground, shape (3,) [m]."""
        return np.asarray(self.spot.place(placed) - placed.poses[self.ghost, :3, 3])

    def jacobian(self, linkage: Linkage, placed: Placement, values: Array) -> Array:
        """Return its derivative, shape (3, values)."""
        point = linkage.point_jacobian(placed, self.spot.body, self.spot.place(placed))
        return point - linkage.point_jacobian(placed, self.ghost, placed.poses[self.ghost, :3, 3])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Closed:
    """Values that satisfy all rows, or the best ones found."""

    values: Array
    """Shape (values,) [rad, m]."""
    miss: float
    """Largest residual [rad, m]."""

    @property
    def good(self) -> bool:
        """Whether all rows are satisfied, within the precision of written lengths."""
        return self.miss < CLOSING_TOLERANCE


def residual(linkage: Linkage, rows: Sequence[Rows], values: Array) -> Array:
    """Return the residuals of all rows, shape (rows,)."""
    placed = linkage.place(values)
    return np.concatenate([np.zeros(0), *(row.residual(linkage, placed, values) for row in rows)])


def jacobian(linkage: Linkage, rows: Sequence[Rows], values: Array) -> Array:
    """Return the derivative of the residuals by the values, shape (rows, values)."""
    placed = linkage.place(values)
    return np.concatenate([np.zeros((0, linkage.size)), *(row.jacobian(linkage, placed, values) for row in rows)])


def close(linkage: Linkage, rows: Sequence[Rows], values: Array, *, held: Sequence[int] = ()) -> Closed:
    """Return values that satisfy all rows, near those given; the best ones if none are found.

    Args:
        linkage: The bodies.
        rows: The constraints.
        values: Initial values, shape (values,).
        held: Columns that are fixed.
    """
    free = np.setdiff1d(np.arange(linkage.size), np.array(held, dtype=int))
    rng, left = np.random.default_rng(0), max(MAX_EVALUATIONS // max(len(linkage.joints), 1), MIN_EVALUATIONS)
    best, used = _newton(linkage, rows, values, free, effort=left)
    for _ in range(MAX_STARTS):
        left -= used
        if best.good or not len(free) or left <= 0:
            break
        begin = values.copy()
        begin[free] += rng.uniform(-1.5, 1.5, len(free))
        found, used = _newton(linkage, rows, begin, free, effort=left)
        best = min(best, found, key=lambda each: each.miss)
    return best if best.good or not len(free) else _nearest(linkage, rows, best.values, free)


def _nearest(linkage: Linkage, rows: Sequence[Rows], values: Array, free: Array) -> Closed:
    """Return values that minimise the sum of squares of all residuals, near those given."""
    from scipy.optimize import least_squares

    def whole(part: Array) -> Array:
        found = values.copy()
        found[free] = part
        return found

    found = least_squares(
        lambda part: residual(linkage, rows, whole(part)),
        values[free],
        jac=lambda part: jacobian(linkage, rows, whole(part))[:, free],
        max_nfev=max(MAX_EVALUATIONS // (8 * max(len(linkage.joints), 1)), MIN_EVALUATIONS),
    )
    return Closed(values=whole(found.x), miss=float(np.abs(found.fun).max(initial=0.0)))


def followed(linkage: Linkage, rows: Sequence[Rows], values: Array, *, held: Sequence[int] = ()) -> Closed:
    """Return values that satisfy the rows as well as possible, near those given: like `close`, from one start."""
    free = np.setdiff1d(np.arange(linkage.size), np.array(held, dtype=int))
    return _newton(linkage, rows, values, free, effort=MAX_EVALUATIONS)[0]


def tracked(linkage: Linkage, rows: Sequence[Rows], values: Array, *, columns: Sequence[int]) -> Array:
    """Return values in which some columns are adapted to the others, near those given, to minimise the residuals.

    Args:
        linkage: The bodies.
        rows: The constraints, nearly satisfied.
        values: Shape (values,).
        columns: Columns to adapt.
    """
    values, own = values.copy(), np.array(columns, dtype=int)
    for _ in range(MAX_NEWTON_STEPS):
        step = solved(jacobian(linkage, rows, values)[:, own], -residual(linkage, rows, values))
        values[own] += np.clip(step, -MAX_STEP, MAX_STEP)
        if np.abs(step).max(initial=0.0) < CLOSE_ENOUGH:
            break
    return values


def _newton(linkage: Linkage, rows: Sequence[Rows], values: Array, free: Array, *, effort: int) -> tuple[Closed, int]:
    """Return the result of Newton's method from one start; each step is halved until it improves.

    Returns:
        closed: The values.
        used: Number of residual evaluations; about `effort` at most.
    """
    values, used, slow = values.copy(), 1, 0
    missed = residual(linkage, rows, values)
    for _ in range(MAX_NEWTON_STEPS):
        if not len(missed) or np.abs(missed).max() < CLOSE_ENOUGH * 1e-3 or not len(free):
            break
        if used > effort or slow == MAX_SLOW_STEPS:
            break
        step = solved(jacobian(linkage, rows, values)[:, free], -missed)
        step *= min(1.0, MAX_STEP / max(float(np.abs(step).max()), 1e-300))
        before, size = float(np.linalg.norm(missed)), 1.0
        while size > 1e-3:
            tried = values.copy()
            tried[free] += size * step
            missed = residual(linkage, rows, tried)
            used += 1
            if np.linalg.norm(missed) < before:
                break
            size *= 0.5
        if size <= 1e-3:
            missed = residual(linkage, rows, values)
            break
        slow = slow + 1 if np.linalg.norm(missed) > MIN_REDUCTION * before else 0
        values = tried
    return Closed(values=values, miss=float(np.abs(missed).max(initial=0.0))), used


def solved(matrix: Array, right: Array) -> Array:
    """Return the least-squares solution of matrix @ x = right side with the smallest norm."""
    return np.asarray(np.linalg.lstsq(matrix, right, rcond=NO_RANK)[0])


def rates(
    linkage: Linkage, rows: Sequence[Rows], values: Array, *, held: Mapping[int, float], targets: Array
) -> tuple[Array, float]:
    """Return the rates of the values that keep all rows satisfied, and their residual.

    Args:
        linkage: The bodies.
        rows: The constraints.
        values: Shape (values,).
        held: Known rates, by column.
        targets: Required rate of each residual, shape (rows,): 0, or the rate of a followed motion.
    """
    matrix, found = jacobian(linkage, rows, values), np.zeros(linkage.size)
    known = np.array(sorted(held), dtype=int)
    found[known] = [held[column] for column in known.tolist()]
    free = np.setdiff1d(np.arange(linkage.size), known)
    right = targets - matrix[:, known] @ found[known]
    found[free] = solved(matrix[:, free], right)
    return found, float(np.abs(matrix @ found - targets).max(initial=0.0))


def turning(linkage: Linkage, rows: Sequence[Rows], values: Array, speeds: Array) -> Array:
    """Return the part of the residuals' second derivatives due to speeds, shape (rows,)."""
    size = float(np.abs(speeds).max(initial=0.0))
    if size == 0.0 or not rows:
        return np.zeros(len(residual(linkage, rows, values)))
    step = DERIVATIVE_STEP / size
    ahead = jacobian(linkage, rows, values + step * speeds)
    behind = jacobian(linkage, rows, values - step * speeds)
    return np.asarray((ahead - behind) @ speeds / (2.0 * step))


def freedoms(linkage: Linkage, rows: Sequence[Rows], values: Array) -> int:
    """Return the number of degrees of freedom of the values under the constraints."""
    matrix = jacobian(linkage, rows, values)
    return linkage.size - (int(np.linalg.matrix_rank(matrix, rtol=1e-8)) if len(matrix) else 0)
