"""SLAM estimators in a ring of posts, worked out without the simulator, and pose from bearings."""

import dataclasses
import math

import numpy as np
import pytest

from mjsim.algorithms.ekf_slam.ekf_slam import EkfSlam
from mjsim.algorithms.estimation.ekf_models import odometry_motion, range_bearing
from mjsim.algorithms.fastslam import FastSlam
from mjsim.algorithms.filterpy_slam import FilterpySlam
from mjsim.algorithms.triangulation import Triangulation, bearings_only
from mjsim.geometry import Pose, wrap_angle
from mjsim.interface import BeaconInfo, Observation, Odometry, Sighting
from tests.robots import pioneer

POSTS = {f"post-{i}": (5.0 * np.cos(i * 0.6), 5.0 * np.sin(i * 0.6) + 3.0) for i in range(10)}
R = np.diag([0.05, np.radians(1.0)]) ** 2
Q = np.diag([0.01, 0.002, 0.01]) ** 2
KNOWN = {name: BeaconInfo(name, None, 0.3, 0.3, pose=Pose(*place, 0.0), center=1.0) for name, place in POSTS.items()}


def ring_run(estimator, seed, steps=250, catalogue=KNOWN):
    """Drive one loop of radius 3; return true pose, belief and the pose of odometry alone."""
    rng, motion = np.random.default_rng(seed), odometry_motion()
    info = dataclasses.replace(pioneer(), prior=Pose(0, 0, 0), prior_covariance=np.zeros((3, 3)))
    estimator.start(info, catalogue, np.random.default_rng(seed + 100))
    truth = told = np.zeros(3)
    for k in range(steps):
        step = np.array([0.08, 0.0, 0.08 / 3.0])
        truth, _, _ = motion(truth, step)
        read = step + rng.normal(0, np.sqrt(np.diag(Q)))
        told, _, _ = motion(told, read)
        z, _, _ = range_bearing(truth, np.array(list(POSTS.values())))
        z += rng.normal(0, np.sqrt(np.diag(R)), z.shape)
        seen = [
            Sighting(0.1 * k, name, float(r), wrap_angle(float(b)), R)
            for name, (r, b) in zip(POSTS, z, strict=True)
            if r < 6.0 and abs(wrap_angle(float(b))) < 2.0 and k % 5 == 0
        ]
        belief = estimator.update(Observation(0.1 * k, 0.1, Odometry(*read, Q), sightings=tuple(seen)))
    return truth, belief, told


def apart(truth, belief):
    return np.hypot(*(truth[:2] - belief.pose.as_array()[:2]))


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_fastslam_finds_pose_and_map_where_odometry_drifts(seed):
    truth, belief, told = ring_run(FastSlam(), seed)
    assert apart(truth, belief) < 0.12
    for name, (mean, covariance) in belief.landmarks.items():
        error = mean - POSTS[name]
        assert np.hypot(*error) < 0.35  # 10 m away at a heading known to 0.025 rad
        assert np.linalg.eigvalsh(covariance).min() > 0
    assert len(belief.landmarks) == len(POSTS)
    assert np.hypot(*(truth - told)[:2]) > 2 * apart(truth, belief)


@pytest.mark.slow
def test_the_filter_of_filterpy_is_the_standard_ekf_slam():
    # The same sums in another program; sightings of one tick one after the other instead of in one batch.
    truth, belief, _ = ring_run(FilterpySlam(), 3)
    _, ours, _ = ring_run(EkfSlam(jacobians="standard", confirmations=1, systematic=math.inf), 3)
    np.testing.assert_allclose(belief.pose.as_array(), ours.pose.as_array(), atol=0.005)
    np.testing.assert_allclose(np.diag(belief.covariance), np.diag(ours.covariance), rtol=0.05)
    assert apart(truth, belief) < 0.12
    # Asymmetry grows by a factor with each precise sighting; in the world 'empty' it ended runs after 32 s.
    np.testing.assert_array_equal(belief.covariance, belief.covariance.T)


def test_three_exact_bearings_give_the_pose_exactly():
    rng = np.random.default_rng(4)
    for _ in range(200):
        places, pose = rng.uniform(-5, 5, (3, 2)), np.array([*rng.uniform(-5, 5, 2), rng.uniform(-3, 3)])
        z, _, _ = range_bearing(pose, places)
        if on_a_circle(places, pose) or z[:, 0].min() < 0.3:
            continue
        found, _ = bearings_only(places, z[:, 1], 0.01)
        np.testing.assert_allclose(found.as_array(), pose, atol=1e-6)


def on_a_circle(places, pose):
    """Whether robot and beacons nearly share a circle or a line: then no method can tell the pose."""
    points = np.vstack([places, pose[:2]])
    rows = np.column_stack([(points**2).sum(axis=1), points, np.ones(4)])
    return np.linalg.svd(rows / np.linalg.norm(rows, axis=0), compute_uv=False)[-1] < 1e-2


@pytest.mark.slow
def test_the_covariance_of_a_pose_from_bearings_is_what_many_trials_show():
    places, pose, sigma = np.array([(4, 0), (-3, 3), (0, -4), (2, 5)], dtype=float), np.array([0.5, 0.3, 0.4]), 0.01
    exact, _, _ = range_bearing(pose, places)
    rng, nees = np.random.default_rng(5), []
    for _ in range(500):
        found, covariance = bearings_only(places, exact[:, 1] + rng.normal(0, sigma, 4), sigma)
        error = found.as_array() - pose
        nees.append(error @ np.linalg.solve(covariance, error))
    # Chi-square with three degrees of freedom: mean 3, variance 6.
    assert np.mean(nees) == pytest.approx(3.0, abs=3.0 * np.sqrt(6.0 / 500))


def test_beacons_on_one_circle_with_the_robot_are_told():
    angles = np.array([0.3, 1.5, 4.0])
    places = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    z, _, _ = range_bearing(np.array([-1.0, 0.0, 0.2]), places)
    with pytest.raises(ValueError, match="circle"):
        bearings_only(places, z[:, 1], 0.01)
    with pytest.raises(ValueError, match="needs three"):
        bearings_only(places[:2], z[:2, 1], 0.01)


@pytest.mark.slow
def test_triangulation_follows_the_robot():
    # Each moment stands for itself: the error stays that of one look, however far the robot drives.
    runs = [ring_run(Triangulation(), seed, steps=700) for seed in (6, 7, 8)]
    assert np.mean([apart(truth, belief) for truth, belief, _ in runs]) < 0.25
    assert np.mean([np.hypot(*(truth - told)[:2]) for truth, _, told in runs]) > 0.4


@pytest.mark.slow
def test_graph_slam_finds_pose_and_map_and_its_covariance_is_honest():
    pytest.importorskip("gtsam", reason="an extra")
    from mjsim.algorithms.graph_slam import GraphSlam

    nees = []
    for seed in range(4):
        truth, belief, _ = ring_run(GraphSlam(), seed)
        error = belief.pose.as_array() - truth
        error[2] = wrap_angle(error[2])
        nees.append(error @ np.linalg.solve(belief.covariance, error))
        assert apart(truth, belief) < 0.15
        assert max(np.hypot(*(mean - POSTS[name])) for name, (mean, _) in belief.landmarks.items()) < 0.4
    assert 1.0 < np.mean(nees) < 5.5  # 3 is honest; chi-square over 4 runs
