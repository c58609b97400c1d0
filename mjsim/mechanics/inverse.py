"""Inverse kinematics by damped least squares, for many poses at a time.

References:
    Sugihara, Solvability-Unconcerned Inverse Kinematics by the Levenberg-Marquardt Method, IEEE Trans. Robotics 27(5),
    2011; Corke, Robotics, Vision and Control (2017), section 7.2.2.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.mechanics.chain import Chain, jacobian, posture_at
from mjsim.mechanics.transforms import rotation_vector

POSE_TOLERANCE = 1e-10
"""Tolerances of position and rotation for a reached pose [m, rad]."""
MAX_STEPS, MAX_TRIES = 60, 40
"""Maximum number of steps per try, and number of tries: the first from the caller's start, the others from random
ones."""
MAX_ROWS = 64
"""Maximum number of starts that are tried at once."""
DAMPING = 1e-2
"""Multiple of the squared error that is added to the diagonal, and its minimum."""
MIN_DAMPING = 1e-14
MAX_DAMPING, MIN_GAIN = 1e9, 1e-12
"""Damping above which the search ends, and relative improvement per step below which it ends."""
NOTABLE_MISS = 1e-6
"""A goal out of reach keeps its solution unless another misses by this much less [m + rad]."""
MISS_TOLERANCE, AGREEING_TRIES = 1e-5, 2
"""For a goal out of reach, the search ends when this number of tries misses as little as the best, within [m + rad]."""
TURN = 2.0 * np.pi


@dataclass(frozen=True, slots=True, eq=False)
class Reached:
    """Result of inverse kinematics."""

    q: Array
    """Values of the joints, within their limits, shape (..., n) [rad, m]."""
    converged: NDArray[np.bool_]
    """Whether the pose was reached, bool, shape (...)."""
    distance: Array
    """Position error of the tool, shape (...) [m]."""
    angle: Array
    """Rotation error of the tool, shape (...) [rad]."""


@dataclass(frozen=True, slots=True, eq=False)
class PoseGoals:
    """Poses to reach, one per row."""

    chain: Chain
    lower: Array
    """Limits of the joints, shape (n,)."""
    upper: Array
    goals: Array
    """world_from_tool, shape (m, 4, 4)."""
    weights: Array
    """Weights of x, y, z and the rotation about them, shape (6,); 0 for free coordinates."""

    def part(self, rows: NDArray[np.intp]) -> "PoseGoals":
        """Return the task of some of the rows."""
        return PoseGoals(self.chain, self.lower, self.upper, self.goals[rows], self.weights)


def solve(task: PoseGoals, q0: Array) -> Reached:
    """Return joint values for each pose; for poses not reached, the best values found, within limits.

    Args:
        task: The poses.
        q0: Initial values for each of them, shape (m, n).
    """
    best = _inside(task, q0)
    distance, angle = _misses(task, best)
    left, beyond, alike = np.arange(len(best)), _beyond(task), np.zeros(len(best), dtype=int)
    rng = np.random.default_rng(0)  # the same result at each call
    tries = 0
    while left.size and tries < MAX_TRIES:
        # The first start alone, then several at once: few rows cost little more than one.
        count = min((1, 7, MAX_TRIES)[min(tries, 2)], MAX_TRIES - tries, max(1, MAX_ROWS // left.size))
        starts = [best[left] if tries + k == 0 else _anywhere(task, rng, q0[left]) for k in range(count)]
        tries += count
        part = task.part(np.tile(left, count))
        found = _inside(task, _descend(part, np.concatenate(starts)))
        offset, turned = _misses(part, found)
        for rows in np.arange(count * left.size).reshape(count, -1):
            there = np.maximum(offset, turned)[rows] <= POSE_TOLERANCE
            nearer = (offset + turned)[rows] < (distance + angle)[left] - (NOTABLE_MISS if tries > count else 0.0)
            better = (np.maximum(distance, angle) > POSE_TOLERANCE)[left] & (nearer | there)
            alike[left[nearer & better]] = 0
            chosen, fresh = left[better], rows[better]
            best[chosen], distance[chosen], angle[chosen] = found[fresh], offset[fresh], turned[fresh]
            alike[left] += np.abs((offset + turned)[rows] - (distance + angle)[left]) < MISS_TOLERANCE
        left = np.flatnonzero((np.maximum(distance, angle) > POSE_TOLERANCE) & ~(beyond & (alike >= AGREEING_TRIES)))
    return Reached(best, np.maximum(distance, angle) <= POSE_TOLERANCE, distance, angle)


def _beyond(task: PoseGoals) -> NDArray[np.bool_]:
    """Return which goals are farther from the first joint than all links together are long, bool, shape (m,)."""
    chain, path = task.chain, [task.chain.end]
    while chain.parents[path[-1]] >= 0:
        path.append(chain.parents[path[-1]])
    first, *others = path[::-1]
    travel = np.where(chain.slides > 0.0, np.maximum(np.abs(task.lower), np.abs(task.upper)), 0.0)
    x, y, z = chain.after[first, :3, 3]
    pose = chain.first @ chain.before[first]
    offsets = [chain.before[others, :3, 3], chain.after[others, :3, 3], chain.last[None, :3, 3]]
    reach = np.hypot(x, y) + travel[path].sum() + sum(np.linalg.norm(each, axis=-1).sum() for each in offsets)
    far = np.linalg.norm(task.goals[:, :3, 3] - pose[:3, 3] - pose[:3, 2] * z, axis=-1)
    return np.asarray((far > reach + POSE_TOLERANCE) & bool((task.weights[:3] > 0.0).all()))


def _descend(task: PoseGoals, q: Array) -> Array:
    """Return the result of damped least squares from `q`, shape (m, n)."""
    identity = np.eye(q.shape[-1])
    damping = np.full(len(q), DAMPING)
    error, slope = _error_and_slope(task, q)
    for _ in range(MAX_STEPS):
        squared = (error**2).sum(axis=-1)
        if squared.max(initial=0.0) < (0.01 * POSE_TOLERANCE) ** 2:
            break
        down = np.swapaxes(slope, -1, -2)
        added = damping * squared + MIN_DAMPING
        step = np.linalg.solve(down @ slope + added[:, None, None] * identity, down @ error[..., None])[..., 0]
        ahead, slope_ahead = _error_and_slope(task, q + step)
        after = (ahead**2).sum(axis=-1)
        good = after < squared
        still = ~good & (damping > MAX_DAMPING) | good & (squared - after < MIN_GAIN * squared)
        q = np.where(good[:, None], q + step, q)
        error, slope = np.where(good[:, None], ahead, error), np.where(good[:, None, None], slope_ahead, slope)
        damping = np.where(good, np.maximum(damping * 0.3, 1e-8), damping * 10.0)
        if still.all():
            break
    return q


def _error_and_slope(task: PoseGoals, q: Array) -> tuple[Array, Array]:
    """Return the errors to the goals, shape (m, 6), and the weighted Jacobian, shape (m, 6, n)."""
    posture = posture_at(task.chain, q)
    offset = task.goals[:, :3, 3] - posture.tool[:, :3, 3]
    turn = rotation_vector(task.goals[:, :3, :3] @ np.swapaxes(posture.tool[:, :3, :3], -1, -2))
    linear, angular = jacobian(task.chain, posture, posture.tool[:, :3, 3])
    slope = np.concatenate([linear, angular], axis=-2)
    return np.concatenate([offset, turn], axis=-1) * task.weights, slope * task.weights[:, None]


def _misses(task: PoseGoals, q: Array) -> tuple[Array, Array]:
    """Return distance and angle to the goals, shape (m,) each."""
    error, _ = _error_and_slope(task, q)
    return np.linalg.norm(error[:, :3], axis=-1), np.linalg.norm(error[:, 3:], axis=-1)


def _inside(task: PoseGoals, q: Array) -> Array:
    """Return values within the limits: shifted by whole turns for revolute joints, else clipped."""
    revolves = task.chain.slides == 0.0
    finite_lower, finite_upper = np.isfinite(task.lower), np.isfinite(task.upper)
    turns = np.zeros_like(q)
    turns += np.where(finite_lower, np.ceil(np.maximum(np.where(finite_lower, task.lower, 0.0) - q, 0.0) / TURN), 0.0)
    turns -= np.where(finite_upper, np.ceil(np.maximum(q - np.where(finite_upper, task.upper, 0.0), 0.0) / TURN), 0.0)
    unlimited = ~(finite_lower | finite_upper)
    wrapped = np.where(unlimited, (q + np.pi) % TURN - np.pi, q + TURN * turns)
    return np.clip(np.where(revolves, wrapped, q), task.lower, task.upper)


def _anywhere(task: PoseGoals, rng: np.random.Generator, q0: Array) -> Array:
    """Return random values within the limits, or within a turn and a metre, shape (m, n) like `q0`.

    Joints that do not move the tool keep their values of `q0`.
    """
    reach = np.where(task.chain.slides == 0.0, np.pi, 1.0)
    lower, upper = np.maximum(task.lower, -reach), np.minimum(task.upper, reach)
    # Limits may be entirely beyond one revolution.
    lower, upper = np.where(lower < upper, lower, task.lower), np.where(lower < upper, upper, task.upper)
    found = rng.uniform(lower, upper, q0.shape)
    return np.where(task.chain.carried[task.chain.end] > 0.0, found, q0)
