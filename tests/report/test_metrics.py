"""Errors of trajectories and maps against evo, filterpy, scipy and closed forms."""

import numpy as np
import pytest
from filterpy import stats
from scipy.signal import lfilter
from scipy.stats import chi2

from mjsim.geometry import Pose
from mjsim.report import chi_square_bounds, metrics
from mjsim.report.consistency import independent_count, nees_figures


@pytest.fixture(scope="module")
def paths():
    """A wandering truth and a drifting estimate of it, shape (400, 3) each."""
    rng = np.random.default_rng(3)
    heading = np.cumsum(rng.normal(0.0, 0.1, 400))
    truth = np.column_stack([np.cumsum(0.05 * np.cos(heading)), np.cumsum(0.05 * np.sin(heading)), heading])
    estimate = truth + np.cumsum(rng.normal(0.0, 0.005, (400, 3)), axis=0)
    return truth, estimate


def evo_trajectory(poses):
    from evo.core.trajectory import PoseTrajectory3D

    half = poses[:, 2] / 2.0
    zeros = np.zeros(len(poses))
    return PoseTrajectory3D(
        positions_xyz=np.column_stack([poses[:, :2], zeros]),
        orientations_quat_wxyz=np.column_stack([np.cos(half), zeros, zeros, np.sin(half)]),
        timestamps=np.arange(len(poses)) * 0.04,
    )


def test_absolute_trajectory_errors_equal_those_of_evo_after_alignment(paths):
    from evo.core.metrics import APE, PoseRelation

    truth, estimate = map(evo_trajectory, paths)
    estimate.align(truth)
    ape = APE(PoseRelation.translation_part)
    ape.process_data((truth, estimate))
    np.testing.assert_allclose(metrics.absolute_trajectory_errors(*paths), ape.error, atol=1e-9)


def test_relative_pose_errors_over_a_metre_equal_those_of_evo(paths):
    from evo.core.metrics import RPE, PoseRelation, Unit

    rpe = RPE(PoseRelation.translation_part, delta=1.0, delta_unit=Unit.meters)
    rpe.process_data(tuple(map(evo_trajectory, paths)))
    ours = metrics.relative_pose_errors(*paths)
    assert len(ours) > 10
    np.testing.assert_allclose(ours, rpe.error, atol=1e-9)


def test_a_path_shorter_than_a_stretch_has_no_relative_error():
    poses = np.zeros((5, 3))
    assert len(metrics.relative_pose_errors(poses, poses)) == 0


def test_normalised_errors_equal_those_of_filterpy(paths):
    truth, estimate = paths
    rng = np.random.default_rng(0)
    factors = rng.normal(size=(len(truth), 3, 3))
    covariance = factors @ factors.transpose(0, 2, 1) + 0.1 * np.eye(3)
    theirs = stats.NEES(truth, estimate, covariance)
    np.testing.assert_allclose(metrics.normalised_errors(truth, estimate, covariance), theirs, rtol=1e-9)


def test_a_heading_error_across_the_seam_is_small_in_every_measure():
    truth, estimate = np.array([[0.0, 0.0, np.pi - 0.01]]), np.array([[0.0, 0.0, -np.pi + 0.01]])
    np.testing.assert_allclose(metrics.heading_errors(truth, estimate), [0.02])
    np.testing.assert_allclose(metrics.normalised_errors(truth, estimate, np.eye(3)[None] * 0.01), [0.04])


def test_a_singular_covariance_has_no_normalised_error():
    covariances = np.stack([np.zeros((3, 3)), np.eye(3), np.diag([1.0, 1.0, 0.0]), np.diag([1e-9, 1e-9, 1e-9])])
    nees = metrics.normalised_errors(np.zeros((4, 3)), np.zeros((4, 3)), covariances)
    np.testing.assert_array_equal(np.isnan(nees), [True, False, True, False])


def test_the_95_percent_bounds_are_quantiles_of_chi_square():
    for freedom, count in ((1, 1), (2, 1), (3, 1), (3, 20), (2, 1000.5)):
        bounds = chi_square_bounds(freedom, count=count)
        np.testing.assert_allclose(bounds, chi2.ppf([0.025, 0.975], freedom * count) / count, rtol=1e-9)


def test_landmark_errors_vanish_after_alignment_when_the_map_is_only_moved():
    truth = np.random.default_rng(1).uniform(-5.0, 5.0, (12, 2))
    raw, aligned = metrics.landmark_errors(truth, Pose(0.3, -0.2, 0.05).transform(truth))
    assert raw.min() > 0.05
    np.testing.assert_allclose(aligned, 0.0, atol=1e-12)


def test_a_summary_takes_sizes_of_signed_errors():
    assert metrics.summary(np.array([-3.0, 1.0])) == {"mean": 2.0, "rmse": np.sqrt(5.0), "max": 3.0, "final": 1.0}


def test_a_series_that_remembers_counts_as_fewer_independent_values():
    rng = np.random.default_rng(2)
    draws = rng.normal(size=20_000)
    assert independent_count(draws) == pytest.approx(20_000, rel=0.1)
    # An autoregressive series with coefficient a is worth (1 - a) / (1 + a) of its length.
    series = lfilter([1.0], [1.0, -0.9], draws)
    assert independent_count(series) == pytest.approx(20_000 * 0.1 / 1.9, rel=0.15)
    assert independent_count(np.full(7, 2.5)) == 7
    assert independent_count(np.zeros(0)) == 1


def test_the_mean_nees_of_a_remembering_error_lies_in_its_band_as_often_as_the_band_says():
    rng = np.random.default_rng(5)
    inside = []
    for _ in range(200):
        errors = lfilter([np.sqrt(1 - 0.95**2)], [1.0, -0.95], rng.normal(size=(1600, 3)), axis=0)[100:]
        figures = nees_figures(np.sum(errors**2, axis=1))
        inside.append(figures["mean_band"][0] <= figures["mean"] <= figures["mean_band"][1])
    # 200 draws of 95 %: the standard deviation is 1.5 %; the count is itself estimated, which costs a few per cent.
    assert 0.88 <= np.mean(inside) <= 0.995


def test_relative_turn_errors_equal_those_of_evo(paths):
    from evo.core.metrics import RPE, PoseRelation, Unit

    rpe = RPE(PoseRelation.rotation_angle_rad, delta=1.0, delta_unit=Unit.meters)
    rpe.process_data(tuple(map(evo_trajectory, paths)))
    np.testing.assert_allclose(metrics.relative_turn_errors(*paths), rpe.error, atol=1e-7)
