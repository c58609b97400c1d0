"""Errors that sightings share: with others of their moment as the robot nods, and with those before them."""

import dataclasses

import numpy as np
import pytest
from scipy.stats import chi2
from threadpoolctl import threadpool_limits

from mjsim.algorithms.ekf_slam.ekf_slam import EkfSlam, EkfSlamFilter, InvariantEkfSlamFilter, odometry_motion
from mjsim.algorithms.estimation.ekf_models import range_bearing
from mjsim.algorithms.fastslam import FastSlam
from mjsim.algorithms.graph_slam import GraphSlam
from mjsim.algorithms.picture_errors import PictureErrors
from mjsim.geometry import Pose, wrap_angle
from mjsim.interface import Intrinsics, Observation, Odometry, SensorInfo, Sighting
from tests.robots import pioneer

PLACES = np.array([[6.0 * np.cos(angle), 3.0 + 6.0 * np.sin(angle)] for angle in np.arange(0, 2 * np.pi, 0.5)])
R = np.diag([0.001, np.radians(0.005)]) ** 2
Q = np.diag([0.004, 0.002, 0.002]) ** 2
NOD = np.radians(0.15)


def with_camera(height):
    """Return a robot with a camera at a height [m], which starts at the origin."""
    robot_from_camera = np.eye(4)
    robot_from_camera[2, 3] = height
    camera = SensorInfo("camera", robot_from_camera, 12.5, intrinsics=Intrinsics(640, 480, 500.0, 500.0, 319.5, 239.5))
    prior = {"prior": Pose(0.0, 0.0, 0.0), "prior_covariance": np.zeros((3, 3))}
    return dataclasses.replace(pioneer(), sensors={"front": camera}, **prior)


def nees_of_a_round(slam, seed):
    """Look around at rest, then drive a circle of 3 m radius, the camera nodding at 1 m; return NEES of the pose."""
    rng, motion, truth, nees = np.random.default_rng(seed), odometry_motion(), np.zeros(3), []
    slam.start(with_camera(1.0), {}, rng)
    for tick in range(120):
        step, own = (np.zeros(3), 1e-12 * Q) if tick < 10 else (np.array([0.16, 0.0, 0.16 / 3.0]), Q)
        nod = 0.0 if tick < 10 else NOD
        truth = motion(truth, step)[0]
        nodding = motion(truth, np.array([*rng.normal(0.0, nod, 2), 0.0]))[0]
        Z = range_bearing(nodding, PLACES)[0] + rng.normal(0.0, np.sqrt(np.diag(R)), PLACES.shape)
        ahead = [row for row in range(len(Z)) if abs(wrap_angle(float(Z[row, 1]))) < 0.6]
        seen = [Sighting(0.04 * tick, f"post-{row}", *Z[row], R, corners=np.zeros((4, 2))) for row in ahead]
        told = Odometry(*(step + rng.normal(0.0, np.sqrt(np.diag(own)))), own)
        belief = slam.update(Observation(0.04 * tick, 0.04, told, sightings=tuple(seen)))
        error = belief.pose.as_array() - truth
        error[2] = wrap_angle(error[2])
        nees.append(error @ np.linalg.solve(belief.covariance, error))
    return np.array(nees)


@pytest.mark.slow
def test_the_estimator_of_a_nodding_robot_is_consistent_and_that_which_holds_it_for_level_is_not():
    runs = 5
    low, high = chi2.ppf([0.025, 0.975], 3 * runs) / runs
    with threadpool_limits(1, user_api="blas"):
        average, level = (
            np.mean(
                [nees_of_a_round(EkfSlam(nod_deg=assumed, repeat=0.0, delay=0.0), seed) for seed in range(runs)], axis=0
            )
            for assumed in (0.15, 0.0)
        )
    # It is rather too careful than too sure: sensors might err by more than stated.
    assert np.mean(average < high) > 0.95
    assert 2.0 < average.mean() < 3.0
    assert np.mean((level > low) & (level < high)) < 0.6 < np.median(level) / high


@pytest.mark.slow
@pytest.mark.parametrize(("make", "most"), [(FastSlam, 0.4), (GraphSlam, 0.7)])
def test_particles_and_graphs_of_a_nodding_robot_are_less_confident_than_those_that_hold_it_for_level(make, most):
    """Of a graph the difference is smaller: its robust loss bounds what a sighting counts for."""
    if make is GraphSlam:
        pytest.importorskip("gtsam", reason="an extra")
    with threadpool_limits(1, user_api="blas"):
        nodding, level = (
            np.mean(nees_of_a_round(make(nod_deg=assumed, repeat=0.5 if assumed else 0.0), seed=1))
            for assumed in (0.15, 0.0)
        )
    assert nodding < 3.0
    assert nodding < most * level


def test_a_robot_without_a_camera_is_taken_for_level():
    both = []
    for nod in (0.0, 5.0):
        slam = EkfSlam(nod_deg=nod, confirmations=1)
        slam.start(dataclasses.replace(pioneer(), prior_covariance=np.diag([0.1, 0.1, 0.1])), {}, None)
        for tick in range(3):
            seen = (Sighting(0.0, "post", 2.0, 0.1 * tick, R),)
            told = Odometry(0.1, 0.0, 0.1, Q)
            belief = slam.update(Observation(0.04 * tick, 0.04, told, sightings=seen))
        both.append(belief)
    assert both[0].pose == both[1].pose
    np.testing.assert_array_equal(both[0].covariance, both[1].covariance)


@pytest.mark.parametrize("make", [EkfSlamFilter, InvariantEkfSlamFilter])
def test_an_update_with_shared_errors_is_the_dense_kalman_update(make):
    rng = np.random.default_rng(1)
    slam = make(pose=(0.2, -0.1, 0.3), covariance=np.diag([0.04, 0.05, 0.01]))
    names, Z = ["a", "b", "c"], np.array([[2.0, 0.3], [3.0, -0.8], [1.5, 2.0]])
    slam.update(names, Z, np.diag([0.05, 0.02]) ** 2)
    mean = np.concatenate([slam.pose, *[place for place, _ in slam.landmarks().values()]])
    P = slam.joint_covariance
    root = rng.normal(0.0, 0.03, (6, 6))
    together = root @ root.T
    expected, H_pose, H_landmark = range_bearing(mean[:3], mean[3:].reshape(3, 2))
    H = np.zeros((6, 9))
    for row in range(3):
        H[2 * row : 2 * row + 2, :3] = H_pose[row]
        H[2 * row : 2 * row + 2, 3 + 2 * row : 5 + 2 * row] = H_landmark[row]
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + together)
    slam.update(names, expected, together)
    np.testing.assert_allclose(slam.joint_covariance, (np.eye(9) - K @ H) @ P, atol=1e-12)
    # Nothing was unexpected, so nothing moves.
    np.testing.assert_allclose(slam.pose, mean[:3], atol=1e-12)


def test_known_ones_of_a_batch_with_shared_errors_are_corrected_by_their_own_part():
    rng = np.random.default_rng(2)
    root = rng.normal(0.0, 0.03, (4, 4))
    together, sightings = root @ root.T, np.array([[2.0, 0.3], [3.0, -0.8]])
    one, other = (EkfSlamFilter(covariance=np.diag([0.04, 0.05, 0.01])) for _ in range(2))
    for slam in (one, other):
        slam.update(["a"], sightings[:1], R)
        slam.predict(odometry_motion(), (0.1, 0.0, 0.1), 0.01 * np.eye(3))
    one.update(["new", "a"], sightings[::-1], together)
    other.update(["a"], sightings[:1], together[2:, 2:])
    np.testing.assert_allclose(one.pose, other.pose, atol=1e-12)
    assert abs(one.pose[0] - 0.1) > 1e-3


def test_many_looks_on_a_short_way_tell_what_their_mean_knows():
    """A part of each error stays the same on the way; the variance of the mean is estimated over many such ways."""
    looks, way, share, rng = 25, 2.0, 0.25, np.random.default_rng(3)
    same, new = rng.normal(0.0, np.sqrt(share), (20_000, 1)), rng.normal(0.0, np.sqrt(1.0 - share), (20_000, looks))
    of_the_mean = float(np.var((same + new).mean(axis=1)))
    errors, information = PictureErrors(with_camera(0.0), nod=0.0, repeat=share * way), 0.0
    look = [Sighting(0.0, "lion", 3.0, 0.2, np.eye(2), corners=np.zeros((4, 2)))]
    errors.move(Odometry(0.0, 0.0, 0.0, Q), look)
    for _ in range(looks):
        errors.move(Odometry(way / looks, 0.0, 0.0, Q), look)
        information += 1.0 / errors.covariance(look, scale=1.0)[0, 0]
    assert 1.0 / information == pytest.approx(of_the_mean, rel=0.06)  # 0.29 for 0.28: see the class


def test_looks_at_rest_add_little_information_except_those_of_a_beacon_sensor():
    picture = [Sighting(0.0, "lion", 3.0, 0.2, np.eye(2), corners=np.zeros((4, 2)))]
    reflector = [Sighting(0.0, "post", 3.0, 0.2, np.eye(2))]
    errors = PictureErrors(with_camera(0.0), nod=0.0, repeat=0.5)
    for _ in range(2):
        errors.move(Odometry(0.0, 0.0, 0.0, Q), picture)
    assert errors.covariance(picture, scale=1.0)[0, 0] > 100.0
    np.testing.assert_allclose(errors.covariance(reflector, scale=2.0), 4.0 * np.eye(2))


def test_a_robot_that_starts_or_brakes_is_taken_to_nod_farther():
    look = [Sighting(0.0, "lion", 3.0, 0.0, np.eye(2), corners=np.zeros((4, 2)))]
    errors, spread = PictureErrors(with_camera(1.0), nod=0.01, repeat=0.0), []
    for speed in [0.0] * 5 + [0.5] * 60 + [0.0] * 5:
        errors.move(Odometry(0.04 * speed, 0.0, 0.0, Q), look)
        spread.append(float(np.sqrt(errors.covariance(look, scale=1.0)[0, 0] - 1.0)))
    assert spread[4] == pytest.approx(0.01, rel=1e-6)
    assert spread[5] == pytest.approx(0.01 * np.hypot(1.0, 5.0 * 0.8 * 0.5 / 0.2), rel=1e-6)
    assert spread[64] == pytest.approx(0.01, rel=1e-3)
    assert spread[65] == pytest.approx(spread[5], rel=1e-3)
