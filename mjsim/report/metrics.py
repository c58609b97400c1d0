"""Standard error metrics of trajectories and maps, on arrays.

Trajectories are (N, 3) arrays of x [m], y [m], heading [rad], truth and estimate at the same times.
"""

import math

import numpy as np

from mjsim.geometry import Array, align_rigid, wrap_angles

SAME_TIME = 1e-6
"""Times that differ by less are equal [s]."""


def position_errors(truth: Array, estimate: Array) -> Array:
    """Return the distance between both positions at each time, not aligned, shape (N,) [m]."""
    return np.asarray(np.hypot(*(estimate[:, :2] - truth[:, :2]).T))


def heading_errors(truth: Array, estimate: Array) -> Array:
    """Return estimate minus truth in [-pi, pi), shape (N,) [rad], left positive."""
    return wrap_angles(estimate[:, 2] - truth[:, 2])


def poses_at(times: Array, known: Array, poses: Array) -> Array:
    """Return a trajectory at other times, interpolated linearly; NaN where it has no pose nearby.

    Args:
        times: Shape (M,) [s].
        known: Times of the trajectory, ascending, shape (N,) [s].
        poses: Shape (N, 3).

    Returns:
        Shape (M, 3).
    """
    turns = np.unwrap(poses[:, 2])
    columns = [np.interp(times, known, values) for values in (poses[:, 0], poses[:, 1], turns)]
    after = np.clip(np.searchsorted(known, times), 1, max(len(known) - 1, 1))
    period = float(np.median(np.diff(known))) if len(known) > 1 else 0.0
    nearest = np.minimum(np.abs(times - known[after - 1]), np.abs(times - known[np.minimum(after, len(known) - 1)]))
    return np.where((nearest > period + SAME_TIME)[:, None], np.nan, np.column_stack(columns))


def absolute_trajectory_errors(truth: Array, estimate: Array) -> Array:
    """Return the position errors after the rigid alignment of the whole estimate to the truth, shape (N,) [m].

    For a single pose there is no alignment, and so no error: shape (0,).

    References:
        Sturm et al., A Benchmark for the Evaluation of RGB-D SLAM Systems, IROS 2012: the ATE; alignment by
        Umeyama 1991 without scale. Equals `evo_ape tum --align`.
    """
    if len(truth) < 2:
        return np.zeros(0)
    aligned = align_rigid(estimate[:, :2], truth[:, :2]).transform(estimate[:, :2])
    return np.asarray(np.linalg.norm(aligned - truth[:, :2], axis=1))


def relative_pose_errors(truth: Array, estimate: Array, *, delta: float = 1.0) -> Array:
    """Return the translation part of the error in motion over consecutive stretches of the estimated path.

    Args:
        truth: Shape (N, 3).
        estimate: Shape (N, 3).
        delta: Length of a stretch along the estimate [m].

    Returns:
        One error per stretch, shape (K,) [m]; empty if the path is shorter than one stretch.

    References:
        Sturm et al., IROS 2012: the RPE. Pairs are those of `evo_rpe --delta 1 --delta_unit m`.
    """
    first, last = stretches(estimate, delta)
    moved_truth, turned_truth = _motion(truth[first], truth[last])
    moved_estimate, _ = _motion(estimate[first], estimate[last])
    c, s = np.cos(turned_truth), np.sin(turned_truth)
    dx, dy = (moved_estimate - moved_truth).T
    return np.asarray(np.hypot(c * dx + s * dy, -s * dx + c * dy))


def relative_turn_errors(truth: Array, estimate: Array, *, delta: float = 1.0) -> Array:
    """Return the size of the error in turn over the same stretches as the RPE, shape (K,) [rad, in [0, pi]].

    References:
        `evo_rpe --pose_relation angle_deg`, in radians.
    """
    first, last = stretches(estimate, delta)
    return np.abs(wrap_angles(estimate[last, 2] - estimate[first, 2] - truth[last, 2] + truth[first, 2]))


def stretches(path: Array, delta: float) -> tuple[list[int], list[int]]:
    """Return start and end row of each stretch of a path (N, 2 or 3) [m]; each ends once it has length `delta`."""
    steps = np.linalg.norm(np.diff(path[:, :2], axis=0), axis=1)
    ends, length = [0], 0.0
    for index, step in enumerate(steps.tolist(), start=1):
        length += step
        if length >= delta:
            ends.append(index)
            length = 0.0
    return ends[:-1], ends[1:]


def _motion(before: Array, after: Array) -> tuple[Array, Array]:
    """Return the position of the later pose in the frame of the earlier one (K, 2), and the turn (K,)."""
    c, s = np.cos(before[:, 2]), np.sin(before[:, 2])
    dx, dy = (after[:, :2] - before[:, :2]).T
    return np.stack([c * dx + s * dy, -s * dx + c * dy], axis=-1), after[:, 2] - before[:, 2]


def normalised_errors(truth: Array, estimate: Array, covariance: Array) -> Array:
    """Return the NEES of (x, y, heading) at each time; NaN where the covariance is singular.

    Args:
        truth: Shape (N, 3).
        estimate: Shape (N, 3).
        covariance: Shape (N, 3, 3).

    Returns:
        e^T P^-1 e, shape (N,); 3 on average for a consistent filter.

    References:
        Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation (2001), eq. 5.4.2-3.
    """
    errors = estimate - truth
    errors[:, 2] = wrap_angles(errors[:, 2])
    return normalised_squares(errors, covariance)


def normalised_squares(errors: Array, covariance: Array) -> Array:
    """Return e^T P^-1 e of each row; NaN where the covariance is singular, indefinite or not finite.

    Args:
        errors: Shape (N, n).
        covariance: Shape (N, n, n).

    Returns:
        Shape (N,); n on average if the errors match the covariance.

    References:
        Bar-Shalom, Li, Kirubarajan (2001), eqs. 5.4.2-3 (NEES) and 5.4.2-5 (NIS).
    """
    squares = np.full(len(errors), np.nan)
    variances = np.einsum("nii->ni", covariance)
    regular = np.isfinite(covariance).all(axis=(1, 2)) & np.isfinite(errors).all(axis=1) & (variances > 0.0).all(axis=1)
    scale = np.sqrt(variances[regular])
    correlation = covariance[regular] / (scale[:, :, None] * scale[:, None, :])
    # Singular relative to its own scale: states that are reported as equal, or as more strongly correlated than
    # possible.
    definite = np.isfinite(correlation).all(axis=(1, 2))
    definite[definite] = np.linalg.eigvalsh(correlation[definite])[:, 0] > 1e-12
    regular[regular] = definite
    e = errors[regular] / scale[definite]
    squares[regular] = np.einsum("ni,ni->n", e, np.linalg.solve(correlation[definite], e[..., None])[..., 0])
    return squares


def landmark_errors(truth: Array, estimate: Array) -> tuple[Array, Array]:
    """Return the errors of landmark positions, as estimated and after rigid alignment.

    Args:
        truth: Shape (K, 2) [m].
        estimate: The same landmarks, shape (K, 2) [m].

    Returns:
        Two arrays of shape (K,) [m]; with fewer than two landmarks no alignment is made.
    """
    raw = np.asarray(np.linalg.norm(estimate - truth, axis=1))
    if len(truth) < 2:
        return raw, raw
    return raw, np.asarray(np.linalg.norm(align_rigid(estimate, truth).transform(estimate) - truth, axis=1))


def summary(errors: Array) -> dict[str, float]:
    """Return mean, rmse, max and final of the sizes of a series of at least one error."""
    sizes = np.abs(errors)
    return {
        "mean": float(sizes.mean()),
        "rmse": math.sqrt(float(np.mean(sizes**2))),
        "max": float(np.max(sizes)),
        "final": float(sizes[-1]),
    }


def error_summary(errors: Array) -> dict[str, float | None]:
    """Return rmse, mean, median, max, min and std of errors, with evo's names; all None if there are none."""
    if not len(errors):
        return dict.fromkeys(("rmse", "mean", "median", "max", "min", "std"))
    return {
        "rmse": float(np.sqrt(np.mean(errors**2))),
        "mean": float(errors.mean()),
        "median": float(np.median(errors)),
        "max": float(np.max(errors)),
        "min": float(np.min(errors)),
        "std": float(errors.std()),
    }
