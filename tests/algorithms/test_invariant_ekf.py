"""The right-invariant filter: it gains nothing where nobody looks, and mends the loops that bend the standard one."""

import json
from functools import partial

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.stats import chi2
from threadpoolctl import threadpool_limits

from mjsim.algorithms.ekf_slam.ekf_group import derivatives_by_step, moved_along, shear
from mjsim.algorithms.ekf_slam.ekf_slam import (
    EkfSlam,
    EkfSlamFilter,
    InvariantEkfSlamFilter,
    bicycle_motion,
    odometry_motion,
)
from mjsim.bench.consistency import ring_nees
from mjsim.geometry import Array
from tests.algorithms.golden import DATA, golden, mean_error

R = np.diag([0.1**2, np.radians(3.0) ** 2])
PRIOR = np.diag([0.3**2, 0.3**2, 0.2**2])


def told_about_the_world(slam: EkfSlamFilter) -> Array:
    """Return the information on a shift and a turn of the whole world, robot and landmarks with it, shape (3, 3)."""
    points = np.array([slam.pose[:2], *[mean for mean, _ in slam.landmarks().values()]])
    N = np.zeros((3 + 2 * (len(points) - 1), 3))
    rows = np.r_[0, np.arange(3, len(N), 2)]
    N[rows, 0], N[rows + 1, 1] = 1.0, 1.0
    N[rows, 2], N[rows + 1, 2], N[2, 2] = -points[:, 1], points[:, 0], 1.0
    return np.asarray(N.T @ np.linalg.solve(slam.joint_covariance, N))


def look_around(slam: EkfSlamFilter, updates: int) -> list[Array]:
    """Add four landmarks, then see them again and again; return what is told about the world after each time."""
    rng, names = np.random.default_rng(3), ["a", "b", "c", "d"]
    Z = np.array([[2.0, 0.3], [3.0, -0.8], [1.5, 2.0], [4.0, -2.5]])
    told = []
    for _ in range(updates + 1):
        slam.update(names, Z + rng.normal(0, np.sqrt(np.diag(R)), (4, 2)), R)
        told.append(told_about_the_world(slam))
    return told


def test_looking_tells_nothing_about_where_the_world_is_or_how_it_is_turned():
    first, *later = look_around(InvariantEkfSlamFilter(pose=(2.0, -1.0, 0.4), covariance=PRIOR), 20)
    for told in later:
        np.testing.assert_allclose(told, first, rtol=1e-6, atol=1e-6)


def test_the_standard_filter_believes_to_learn_how_the_world_is_turned():
    told = look_around(EkfSlamFilter(pose=(2.0, -1.0, 0.4), covariance=PRIOR), 20)
    assert told[-1][2, 2] > 1.01 * told[0][2, 2]


def test_small_corrections_are_those_of_the_standard_filter():
    """Both filters differ by terms of second order in the correction: a tenth of it makes a hundredth of them."""

    def apart(scale: float) -> float:
        both = [make(pose=(2.0, -1.0, 0.4), covariance=PRIOR) for make in (EkfSlamFilter, InvariantEkfSlamFilter)]
        Z = np.array([[2.0, 0.3], [3.0, -0.8]])
        for slam in both:
            slam.update(["a", "b"], Z, R)
            slam.predict(odometry_motion(), (0.0, 0.0, 0.0), np.diag([0.1, 0.1, 0.1]))
            slam.update(["a", "b"], Z + scale * np.array([[0.1, 0.2], [-0.1, 0.1]]), R)
        return float(np.abs(both[0].pose - both[1].pose).max())

    assert apart(0.1) < 0.02 * apart(1.0)


@pytest.mark.slow
def test_the_covariance_stays_symmetric_and_positive():
    slam = InvariantEkfSlamFilter(pose=(2.0, -1.0, 0.4), covariance=PRIOR)
    look_around(slam, 50)
    P = slam.joint_covariance
    np.testing.assert_allclose(P, P.T, atol=1e-15)
    assert np.linalg.eigvalsh(P).min() > 0


def drive(slam: EkfSlamFilter, run: dict[str, Array]) -> Array:
    """Return the poses of a filter on a golden run, shape (N, 3)."""
    config = json.loads((DATA / "config.json").read_text())
    motion = bicycle_motion(config["wheelbase_m"], config["period_s"])
    Q = np.diag([config["sigma_speed_mps"], np.radians(config["sigma_steering_deg"])]) ** 2
    noise = np.diag([config["sigma_range_m"], np.radians(config["sigma_bearing_deg"])]) ** 2
    bounds = np.searchsorted(run["observation_step"], np.arange(len(run["control"]) + 1))
    poses = np.empty((len(run["control"]), 3))
    for k, control in enumerate(run["control"]):
        slam.predict(motion, control, Q)
        now = slice(bounds[k], bounds[k + 1])
        slam.update(run["observation_id"][now].tolist(), run["observation"][now], noise)
        poses[k] = slam.pose
    return poses


@pytest.mark.slow
def test_both_mended_filters_hold_what_they_promise_on_a_golden_run():
    run = golden("cloister_1")
    ticks = 10_000  # of 13,946: by then the large loop is closed
    run["control"], run["truth"] = run["control"][:ticks], run["truth"][:ticks]
    standard = mean_error(run["estimate"][:ticks], run["truth"])
    with threadpool_limits(1, user_api="blas"):
        for slam in (EkfSlamFilter(jacobians="first-estimates"), InvariantEkfSlamFilter()):
            assert mean_error(drive(slam, run), run["truth"]) < 0.7 * standard
    # The standard filter fails.
    assert standard > 2.0


@pytest.mark.slow
@pytest.mark.parametrize("make", [partial(EkfSlamFilter, jacobians="first-estimates"), InvariantEkfSlamFilter])
def test_it_is_consistent_on_a_loop(make):
    runs = 10
    low, high = chi2.ppf([0.025, 0.975], 3 * runs) / runs
    average = np.mean([ring_nees(make(pose=(10.0, 0.0, np.pi / 2)), seed) for seed in range(runs)], 0)
    assert np.mean((average > low) & (average < high)) > 0.8


def test_an_unknown_kind_of_jacobians_is_refused_with_all_there_are():
    with pytest.raises(ValueError, match="jacobians is 'odd'; it must be standard, first-estimates or invariant"):
        EkfSlam(jacobians="odd")  # type: ignore[arg-type]


def exponential(mean: Array, step: Array, rows: NDArray[np.intp]) -> Array:
    """Return where a step along the exponential of SE_(1+n)(2) moves points, by that of a matrix."""
    turn, count = step[2], len(rows)
    whole = np.zeros((2 + count, 2 + count))
    whole[:2, :2] = turn * np.array([[0.0, -1.0], [1.0, 0.0]])
    # The shift of a point is its own step less what the turn about the origin moves it by.
    whole[:2, 2:] = (step[rows] - turn * np.stack([-mean[rows][:, 1], mean[rows][:, 0]], axis=-1)).T
    moved = expm(whole)
    return (moved[:2, :2] @ mean[rows].T + moved[:2, 2:]).T


@pytest.mark.parametrize("turn", [0.7, -2.0, 3e-5, 0.0])
def test_a_step_along_the_exponential_is_that_of_a_matrix_and_so_are_its_derivatives(turn):
    rng = np.random.default_rng(4)
    mean, step, rows = rng.normal(0.0, 2.0, 11), rng.normal(0.0, 0.5, 11), np.array([[0, 1], [5, 6], [9, 10]])
    step[2] = turn
    new = moved_along(mean, step, rows)
    np.testing.assert_allclose(new[rows], exponential(mean, step, rows), atol=1e-12)
    others = np.setdiff1d(np.arange(11), rows)
    np.testing.assert_allclose(new[others], (mean + step)[others])
    H_pose, H_landmark = rng.normal(size=(2, 2, 3)), rng.normal(size=(2, 2, 2))
    by_pose, by_landmark = derivatives_by_step(mean, step, rows[1:], H_pose, H_landmark)
    d = 1e-4
    slopes = [(moved_along(mean, step + e, rows) - moved_along(mean, step - e, rows)) / (2 * d) for e in d * np.eye(11)]
    J = np.stack(slopes, axis=-1)
    for k, columns in enumerate(rows[1:]):
        expected = H_pose[k] @ J[:3] + H_landmark[k] @ J[columns]
        np.testing.assert_allclose(by_pose[k], expected[:, :3], atol=1e-6)
        np.testing.assert_allclose(by_landmark[k], expected[:, columns], atol=1e-6)


@pytest.mark.parametrize("size", [9, 75])
def test_a_shear_adds_the_headings_error_to_the_points_after_the_correction(size):
    rng = np.random.default_rng(size)
    A, W, rows = rng.normal(size=(size, size)), 0.1 * rng.normal(size=(4, size)), np.array([[0, 1], [5, 6], [7, 8]])
    P, moved = A @ A.T, rng.normal(size=(3, 2))
    S = np.eye(size)
    S[rows, 2] += moved
    expected = S @ (P - W.T @ W) @ S.T
    shear(P, moved, rows, W, np.empty(size * size))
    np.testing.assert_allclose(P, expected, atol=1e-9 * np.abs(expected).max())
    np.testing.assert_array_equal(P, P.T)
