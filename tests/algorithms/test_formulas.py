"""Formulas of estimators and controllers, each computed another way: graphs, teams, balancing, laws, roadmaps."""

import json
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.linalg import block_diag
from scipy.stats import chi2

from mjsim.algorithms.cooperative_slam import CooperativeSlam, ReportingWaypoints, TeamEstimate, map_from
from mjsim.algorithms.estimation.ekf_models import innovation, odometry_motion, range_bearing
from mjsim.geometry import Pose, wrap_angle
from mjsim.interface import (
    Estimate,
    Message,
    Observation,
    Odometry,
    Sighting,
)
from tests.algorithms.test_monte_carlo import started
from tests.robots import pioneer

R = np.diag([0.05, np.radians(1.0)]) ** 2
Q = np.diag([0.01, 0.002, 0.01]) ** 2
POSTS = {f"post-{k}": (5.0 * np.cos(0.6 * k), 5.0 * np.sin(0.6 * k) + 3.0) for k in range(10)}
RNG = np.random.default_rng(0)


def drive(estimator, *, steps=40, noise=1.0, scale=1.0, range_scale=1.0, every=4, prior=None):
    """Drive an arc among posts; return true poses (steps, 3), beliefs, and poses of odometry alone."""
    rng, motion = np.random.default_rng(3), odometry_motion()
    prior = prior or Pose(0.5, -0.5, 0.3)
    estimator.start(pioneer(prior=prior, dt=0.1), {}, np.random.default_rng(1))
    truth = told = prior.as_array()
    truths, beliefs, odometry = [], [], []
    for k in range(steps):
        step = np.array([0.08, 0.0, 0.08 / 3.0])
        truth, _, _ = motion(truth, step)
        read = scale * step + noise * rng.normal(0, np.sqrt(np.diag(Q)))
        told, _, _ = motion(told, read)
        z, _, _ = range_bearing(truth, np.array(list(POSTS.values())))
        z = z * [range_scale, 1.0] + noise * rng.normal(0, np.sqrt(np.diag(R)), z.shape)
        seen = tuple(
            Sighting(0.1 * k, name, float(r), wrap_angle(float(b)), R)
            for name, (r, b) in zip(POSTS, z, strict=True)
            if r < 7.0 and abs(wrap_angle(float(b))) < 2.0 and k % every == 0
        )
        beliefs.append(estimator.update(Observation(0.1 * k, 0.1, Odometry(*read, Q), sightings=seen)))
        truths.append(truth)
        odometry.append(told)
    return np.array(truths), beliefs, np.array(odometry)


def error(belief, truth):
    off = belief.pose.as_array() - truth
    return np.array([off[0], off[1], wrap_angle(off[2])])


@pytest.fixture(scope="module")
def graph_slam():
    pytest.importorskip("gtsam", reason="an extra")
    from mjsim.algorithms.graph_slam import GraphSlam

    return GraphSlam


def test_of_exact_measurements_a_graph_is_exact(graph_slam):
    estimator = graph_slam(frame="start", distance=0.3, turn_deg=10.0)
    truth, beliefs, _ = drive(estimator, noise=0.0)
    for belief, true in zip(beliefs, truth, strict=True):
        assert np.abs(error(belief, true)).max() < 2e-3
    for name, (mean, covariance) in beliefs[-1].landmarks.items():
        np.testing.assert_allclose(mean, POSTS[name], atol=5e-3)
        assert 0.0 < np.linalg.eigvalsh(covariance).min() < np.linalg.eigvalsh(covariance).max() < 0.1
    path = estimator.path()
    assert [time for time, _ in path] == pytest.approx(0.1 * np.arange(40))
    assert max(np.abs(pose.as_array() - true).max() for (_, pose), true in zip(path, truth, strict=True)) < 2e-3
    offsets, covariance = estimator.range_errors
    assert np.abs(offsets).max() < 0.01
    assert np.linalg.eigvalsh(covariance).min() > 0.0


def test_a_graph_learns_that_odometry_and_ranges_read_long(graph_slam):
    estimator = graph_slam(frame="start")
    truth, beliefs, told = drive(estimator, noise=0.3, scale=1.08, steps=60)
    assert np.hypot(*error(beliefs[-1], truth[-1])[:2]) < 0.5 * np.hypot(*(told[-1] - truth[-1])[:2])
    path = np.array([pose.as_array()[:2] for _, pose in estimator.path()])
    assert np.linalg.norm(path - truth[:, :2], axis=1).mean() < 0.05
    blind = graph_slam(systematic=math.inf)
    drive(blind, noise=0.0, steps=12)
    assert blind.range_errors[0].shape == (0,)


@pytest.mark.parametrize("frame", ["map", "start"])
def test_the_covariance_of_a_graph_is_as_large_as_its_error(graph_slam, frame):
    truth, beliefs, told = drive(graph_slam(frame=frame), steps=60)
    off = error(beliefs[-1], truth[-1])
    assert off @ np.linalg.solve(beliefs[-1].covariance, off) < 12.0
    assert np.trace(beliefs[-1].covariance[:2, :2]) < 0.05
    assert np.hypot(*off[:2]) < np.hypot(*(told[-1] - truth[-1])[:2]) + 0.02


def test_a_graph_without_a_wrong_frame_is_made(graph_slam):
    with pytest.raises(ValueError, match="frame is 'world'; it must be map or start"):
        graph_slam(frame="world")


def measured(graph_slam, *, errors=(0.0, 0.0, 0.0, 0.0), noise=1.0, pushed=(0.0, 0.0, 0.0)):
    """Return a drive of 30 legs whose steps lack what the systematic errors add, with looks of known noise.

    In leg 15 the robot is pushed, and turned about the origin.
    """
    from mjsim.algorithms.estimation.graph_refinement import Leg, MeasuredGraph
    from mjsim.algorithms.estimation.pose_graph import composed, step_between

    assert graph_slam
    rng, motion = np.random.default_rng(5), odometry_motion()
    poses = [np.array([0.0, 0.0, 0.2])]
    for k in range(30):
        poses.append(motion(poses[-1], np.array([0.2, 0.0, 0.1 * math.sin(0.4 * k)]))[0])
    poses = np.array(poses)
    steps = step_between(poses[:-1], poses[1:])
    poses[16:] = composed(np.array(pushed), poses[16:])
    slopes = rng.normal(size=(30, 3, 4)) * [[[0.2], [0.05], [0.1]]]
    covariance = np.diag([1e-3, 5e-4, 1e-3]) ** 2
    legs = [Leg(step - D @ np.array(errors), covariance, D) for step, D in zip(steps, slopes, strict=True)]
    sightings = []
    for row in range(0, 31, 2):
        z, _, _ = range_bearing(poses[row], np.array(list(POSTS.values())))
        z += noise * rng.normal(0, np.sqrt(np.diag(R)), z.shape)
        sightings += [
            (row, Sighting(0.0, name, float(r), wrap_angle(float(b)), R)) for name, (r, b) in zip(POSTS, z, strict=True)
        ]
    places = {name: np.array(place) for name, place in POSTS.items()}
    return poses, MeasuredGraph(
        poses=poses, landmarks=places, first_covariance=1e-8 * np.eye(3), legs=legs, sightings=sightings,
        systematic_variances=np.full(4, 0.01),
    )  # fmt: skip


def test_systematic_errors_of_odometry_are_those_of_weighted_least_squares(graph_slam):
    from mjsim.algorithms.estimation.graph_refinement import systematic_errors

    errors = np.array([0.05, -0.02, 0.03, 0.01])
    poses, drive_ = measured(graph_slam, errors=errors)
    found = systematic_errors(drive_, poses, errors)
    D = np.concatenate([leg.slopes for leg in drive_.legs])
    W = np.kron(np.eye(30), np.linalg.inv(drive_.legs[0].covariance))
    y = (D @ errors)[:, None]
    expected = np.linalg.solve(D.T @ W @ D + np.eye(4) / 0.01, D.T @ W @ y)[:, 0]
    np.testing.assert_allclose(found, expected, rtol=1e-6)
    none = SimpleNamespace(legs=[])
    np.testing.assert_array_equal(systematic_errors(none, poses, errors), errors)


@pytest.mark.parametrize(("noise", "expected"), [(1.0, 1.0), (2.0, 2.0), (0.01, 0.25), (20.0, 4.0)])
def test_the_scale_of_looks_is_that_of_their_noise_within_limits(graph_slam, noise, expected):
    from mjsim.algorithms.estimation.graph_refinement import sighting_scales

    poses, drive_ = measured(graph_slam, noise=noise)
    assert sighting_scales(drive_, poses, drive_.landmarks) == pytest.approx([expected] * 2, rel=0.2)
    nothing = SimpleNamespace(sightings=[])
    assert sighting_scales(nothing, poses, {}).tolist() == [1.0, 1.0]


def test_a_solved_graph_is_where_all_measurements_agree(graph_slam):
    import gtsam

    from mjsim.algorithms.estimation.graph_refinement import refined_poses

    errors = np.array([0.05, -0.02, 0.03, 0.01])
    poses, drive_ = measured(graph_slam, errors=errors, noise=0.0)
    moved = np.random.default_rng(0).normal(0, 0.001, poses.shape) * (np.arange(31) > 0)[:, None]
    shifted = replace(drive_, poses=poses + moved)
    found, learned = refined_poses(gtsam, shifted)
    np.testing.assert_allclose(found, poses, atol=2e-3)
    np.testing.assert_allclose(learned, errors, atol=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("pushed", [(0.0, 0.0, 0.0), (0.4, -0.3, 0.2)])
def test_the_odds_of_displacements_are_those_of_the_likelihoods_of_all_measurements(graph_slam, pushed):
    from mjsim.algorithms.estimation.graph_refinement import CAUCHY, leg_odds
    from mjsim.algorithms.estimation.pose_graph import step_between
    from mjsim.algorithms.estimation.relocation import CARRIED

    poses, drive_ = measured(graph_slam, pushed=pushed)
    drive_ = replace(drive_, sightings=drive_.sightings[::3])

    def residuals(state):
        found, places = state[:93].reshape(31, 3), dict(zip(POSTS, state[93:].reshape(-1, 2), strict=True))
        off = [found[0] - poses[0], *(step_between(found[:-1], found[1:]) - [leg.step for leg in drive_.legs])]
        for row, seen in drive_.sightings:
            expected, _, _ = range_bearing(found[row], places[seen.name][None])
            off.append(-innovation(np.array([[seen.range, seen.bearing]]), expected)[0])
        return off

    state = np.concatenate([poses.ravel(), np.array(list(POSTS.values())).ravel()])
    off = residuals(state)
    noises = [drive_.first_covariance, *(leg.covariance for leg in drive_.legs)]
    noises += [R * (1.0 + r @ np.linalg.solve(R, r) / CAUCHY**2) for r in off[31:]]
    step = 1e-6
    J = np.array(
        [np.concatenate(residuals(state + d)) - np.concatenate(residuals(state - d)) for d in step * np.eye(len(state))]
    ).T / (2.0 * step)
    without = 100.0 * J @ J.T + block_diag(*noises)
    r, expected = np.concatenate(off), []
    for leg in range(30):
        S = without.copy()
        S[3 * leg + 3 : 3 * leg + 6, 3 * leg + 3 : 3 * leg + 6] += np.eye(3)
        likelihoods = [-0.5 * (r @ np.linalg.solve(C, r) + np.linalg.slogdet(C)[1]) for C in (S, without)]
        expected.append(math.log(CARRIED / 30) + likelihoods[0] - likelihoods[1])
    found = leg_odds(drive_, np.zeros(4), np.ones(2))
    np.testing.assert_allclose(found[:-1], expected, atol=0.02)
    assert np.argmax(found) in ((14, 15) if any(pushed) else (30,))


def test_a_push_is_in_the_solved_graph(graph_slam):
    import gtsam

    from mjsim.algorithms.estimation.graph_refinement import refined_poses

    poses, drive_ = measured(graph_slam, pushed=(0.4, -0.3, 0.2))
    unpushed, _ = measured(graph_slam)
    found, _ = refined_poses(gtsam, replace(drive_, poses=unpushed))
    # Nothing was seen from pose 15, between the two legs that may be the one.
    assert np.delete(np.hypot(*(found - poses)[:, :2].T), 15).max() < 0.03


def test_a_team_merges_what_it_is_told_and_reports_when_it_is_due():
    first = CooperativeSlam(period=0.5)
    _, beliefs, _ = drive(first, steps=21, noise=0.2)
    reports = [k for k, belief in enumerate(beliefs) if belief.report is not None]
    assert np.diff(reports).tolist() == [5, 5]
    told = beliefs[reports[-1]].report
    assert set(map_from(told).names) == set(told["names"])
    second = CooperativeSlam()
    second.start(pioneer(prior=Pose(0.0, 0.0, 0.0), dt=0.1), {}, np.random.default_rng(0))
    still = Odometry(0.0, 0.0, 0.0, Q)
    messages = (Message("ada", 0.0, json.dumps(told)), Message("bob", 0.0, '{"hello": 1}'))
    belief = second.update(Observation(0.0, 0.1, still, messages=messages))
    assert set(belief.landmarks) == set(told["names"])
    for name, place in zip(told["names"], told["places"], strict=True):
        np.testing.assert_allclose(belief.landmarks[name][0], place, atol=1e-6)
    assert belief.report is None  # it has seen nothing itself
    again = second.update(Observation(0.1, 0.1, still))
    assert set(again.landmarks) == set(told["names"])
    with pytest.raises(ValueError, match="frame is 'mine'"):
        CooperativeSlam(frame="mine")


def test_a_report_is_sent_with_the_command_that_drives():
    navigator = ReportingWaypoints([[4.0, 1.0]])
    navigator.start(pioneer(), None, np.random.default_rng(0))
    seen = Observation(0.0, 0.04, Odometry(0.0, 0.0, 0.0, Q))
    pose, P = Pose(1.0, 1.0, 0.0), np.zeros((3, 3))
    silent = navigator.command(seen, Estimate(pose, P))
    assert silent.messages == ()
    speaking = navigator.command(seen, TeamEstimate(pose, P, {}, (), P, {"places": []}))
    assert speaking.messages == ({"places": []},)
    assert speaking.forward > 0.0
    assert navigator.command(seen, TeamEstimate(pose, P, {}, (), P, None)).messages == ()


@pytest.mark.parametrize(("start", "wide"), [("prior", False), ("global", True)])
def test_particles_begin_about_the_prior_or_anywhere_in_the_room(start, wide):
    prior, spread = Pose(3.0, 5.0, 0.5), np.diag([0.04, 0.01, 0.0025])
    estimator = started(prior, spread, start=start)
    P = estimator._particles
    if wide:
        assert np.ptp(P, axis=0) == pytest.approx([10.0, 7.0, 2 * np.pi], rel=0.12)
        assert not ((P[:, 0] > 6.2) & (P[:, 1] > 4.2)).any()  # outside
    else:
        np.testing.assert_allclose(P.mean(axis=0), prior.as_array(), atol=0.02)
        np.testing.assert_allclose(np.cov(P.T), spread, atol=0.003)
        still = Observation(0.0, 0.04, Odometry(0.0, 0.0, 0.0, np.zeros((3, 3))))
        belief = estimator.update(still)
        np.testing.assert_allclose(belief.pose.as_array(), prior.as_array(), atol=0.1)
        np.testing.assert_allclose(belief.covariance, spread, atol=0.02)


@pytest.mark.parametrize("bins", [20, 60])
def test_as_many_particles_are_needed_as_chi_square_says(bins):
    estimator = started(Pose(3.0, 5.0, 0.0), np.zeros((3, 3)))
    apart = np.column_stack([2.0 * np.arange(bins), np.zeros(bins), np.zeros(bins)])
    # Fox, Adapting the sample size in particle filters (2003), equation 12, whose chi-square is approximated.
    exact = chi2.ppf(0.99, bins - 1) / (2 * 0.02)
    assert estimator._needed(np.repeat(apart, 3, axis=0)) == pytest.approx(exact, rel=0.005)
    assert estimator._needed(apart[:1]) == 200
