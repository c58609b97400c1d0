"""EKF-SLAM: the filter against an independent run and its own statistics, the estimator against bad sightings."""

import json
import time
from collections.abc import Iterator

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from mjsim.algorithms.ekf_slam.ekf_slam import (
    EkfSlam,
    EkfSlamFilter,
    bicycle_motion,
    odometry_motion,
)
from mjsim.algorithms.estimation.ekf_models import landmark_from, range_bearing
from mjsim.geometry import Array, Pose, wrap_angles
from mjsim.interface import Estimate, Observation, Odometry, Sighting
from tests.algorithms.golden import DATA, golden
from tests.robots import pioneer

R = np.diag([0.05**2, np.radians(1.0) ** 2])


@pytest.fixture(scope="module", autouse=True)
def one_thread() -> Iterator[None]:
    """As in a run: small matrices are several times faster so."""
    with threadpool_limits(1, user_api="blas"):
        yield


def run_golden(run: dict[str, Array]) -> tuple[EkfSlamFilter, Array, Array]:
    """Return the standard filter at the end, its poses (N, 3) and their variances (N, 3)."""
    config = json.loads((DATA / "config.json").read_text())
    motion = bicycle_motion(config["wheelbase_m"], config["period_s"])
    Q = np.diag([config["sigma_speed_mps"], np.radians(config["sigma_steering_deg"])]) ** 2
    noise = np.diag([config["sigma_range_m"], np.radians(config["sigma_bearing_deg"])]) ** 2
    slam = EkfSlamFilter()
    bounds = np.searchsorted(run["observation_step"], np.arange(len(run["control"]) + 1))
    poses, variances = [], []
    for k, control in enumerate(run["control"]):
        slam.predict(motion, control, Q)
        now = slice(bounds[k], bounds[k + 1])
        slam.update(run["observation_id"][now].tolist(), run["observation"][now], noise)
        poses.append(slam.pose)
        variances.append(np.diag(slam.covariance))
    return slam, np.array(poses), np.array(variances)


@pytest.mark.slow
def test_the_standard_filter_repeats_an_independent_run_to_1e_8():
    atrium = golden("atrium_1")
    slam, poses, variances = run_golden(atrium)
    difference = poses - atrium["estimate"]
    difference[:, 2] = wrap_angles(difference[:, 2])
    assert np.abs(difference).max() < 1e-8
    assert np.abs(variances - atrium["pose_covariance_diagonal"]).max() < 1e-8
    means = np.concatenate([mean for mean, _ in slam.landmarks().values()])
    np.testing.assert_allclose(means, atrium["final_state"][3:], atol=1e-8)
    np.testing.assert_allclose(slam.joint_covariance, atrium["final_covariance"], atol=1e-8)


@pytest.mark.parametrize("motion", [bicycle_motion(0.5, 0.04), odometry_motion()], ids=["bicycle", "odometry"])
def test_motion_derivatives_match_central_differences(motion):
    rng, step = np.random.default_rng(0), 1e-6
    size = 2 if motion.__qualname__.startswith("bicycle") else 3
    for _ in range(30):
        pose, control = rng.uniform(-1.0, 1.0, 3), rng.uniform(-1.0, 1.0, size)
        _, F, G = motion(pose, control)
        for column, offset in enumerate(np.eye(3) * step):
            slope = (motion(pose + offset, control)[0] - motion(pose - offset, control)[0]) / (2 * step)
            np.testing.assert_allclose(slope, F[:, column], atol=1e-8)
        for column, offset in enumerate(np.eye(size) * step):
            slope = (motion(pose, control + offset)[0] - motion(pose, control - offset)[0]) / (2 * step)
            np.testing.assert_allclose(slope, G[:, column], atol=1e-8)


def test_measurement_derivatives_match_central_differences():
    rng, step = np.random.default_rng(0), 1e-6
    for pose in rng.uniform(-1.0, 1.0, (30, 3)):
        places = rng.uniform(2.0, 3.0, (4, 2))
        _, H_pose, H_landmark = range_bearing(pose, places)
        for column, offset in enumerate(np.eye(3) * step):
            slope = (range_bearing(pose + offset, places)[0] - range_bearing(pose - offset, places)[0]) / (2 * step)
            np.testing.assert_allclose(slope, H_pose[:, :, column], atol=1e-8)
        for column, offset in enumerate(np.eye(2) * step):
            slope = (range_bearing(pose, places + offset)[0] - range_bearing(pose, places - offset)[0]) / (2 * step)
            np.testing.assert_allclose(slope, H_landmark[:, :, column], atol=1e-8)


def test_a_landmark_seen_from_a_pose_is_measured_there_again():
    rng, step = np.random.default_rng(0), 1e-6
    for _ in range(30):
        pose, z = rng.uniform(-3.0, 3.0, 3), np.array([rng.uniform(0.5, 8.0), rng.uniform(-3.0, 3.0)])
        place, J = landmark_from(pose, z)
        np.testing.assert_allclose(range_bearing(pose, place[None])[0][0], z, atol=1e-12)
        for column, offset in enumerate(np.eye(2) * step):
            slope = (landmark_from(pose, z + offset)[0] - landmark_from(pose, z - offset)[0]) / (2 * step)
            np.testing.assert_allclose(slope, J[:, column], atol=1e-8)


def test_odometry_motion_is_the_product_of_poses():
    pose, step = Pose(1.0, -2.0, 2.5), Pose(0.3, 0.1, 1.2)
    new, _, _ = odometry_motion()(pose.as_array(), step.as_array())
    np.testing.assert_allclose(new, (pose @ step).as_array(), atol=1e-12)


@pytest.mark.parametrize("jacobians", ["standard", "first-estimates"])
def test_an_update_is_the_dense_kalman_update(jacobians):
    """At the first update all estimates are first ones: both filters equal K = P H^T S^-1 with full matrices."""
    slam = EkfSlamFilter(jacobians=jacobians, pose=(0.2, -0.1, 0.3), covariance=np.diag([0.04, 0.05, 0.01]))
    names, Z = ["a", "b", "c"], np.array([[2.0, 0.3], [3.0, -0.8], [1.5, 2.0]])
    slam.update(names, Z, R)
    mean = np.concatenate([slam.pose, *[place for place, _ in slam.landmarks().values()]])
    P = slam.joint_covariance
    seen, Z2 = ["c", "a"], np.array([[1.55, 1.97], [2.04, 0.31]])
    slam.update(seen, Z2, R)

    expected, H_pose, H_landmark = range_bearing(mean[:3], mean[[[7, 8], [3, 4]]])
    H = np.zeros((4, 9))
    H[:2, :3], H[:2, 7:9], H[2:, :3], H[2:, 3:5] = H_pose[0], H_landmark[0], H_pose[1], H_landmark[1]
    S = H @ P @ H.T + np.kron(np.eye(2), R)
    K = P @ H.T @ np.linalg.inv(S)
    new = mean + K @ (Z2 - expected).ravel()
    np.testing.assert_allclose(slam.pose, new[:3], atol=1e-12)
    np.testing.assert_allclose(slam.landmarks()["c"][0], new[7:], atol=1e-12)
    np.testing.assert_allclose(slam.joint_covariance, (np.eye(9) - K @ H) @ P, atol=1e-12)


def test_the_order_within_a_batch_does_not_matter():
    def build(order: list[int]) -> EkfSlamFilter:
        slam = EkfSlamFilter(covariance=np.diag([0.1, 0.1, 0.02]))
        names, Z = np.array(["a", "b", "c"]), np.array([[2.0, 0.3], [3.0, -0.8], [1.5, 2.0]])
        noise = R * np.array([1.0, 2.0, 3.0])[:, None, None]
        slam.update(["a", "b"], Z[:2], R)
        slam.update(names[order].tolist(), Z[order] + 0.02, noise[order])
        return slam

    one, other = build([0, 1, 2]), build([2, 1, 0])
    np.testing.assert_allclose(one.pose, other.pose, atol=1e-12)
    np.testing.assert_allclose(one.landmarks()["c"][0], other.landmarks()["c"][0], atol=1e-12)


def test_the_covariance_stays_symmetric_to_the_last_bit_as_the_map_grows():
    rng = np.random.default_rng(0)
    slam, motion = EkfSlamFilter(jacobians="first-estimates"), odometry_motion()
    for k in range(60):
        slam.predict(motion, (0.1, 0.0, 0.02), np.diag([1e-4, 1e-8, 1e-4]))
        slam.update([k, max(k - 3, 0)][: 1 + (k > 3)], rng.uniform(1.0, 2.0, (1 + (k > 3), 2)), R)
    P = slam.joint_covariance
    assert P.shape == (123, 123)
    assert np.array_equal(P[3:, 3:], P[3:, 3:].T)
    assert np.linalg.eigvalsh(P).min() > -1e-12


def test_two_sightings_of_a_new_landmark_in_one_batch_are_both_used():
    slam = EkfSlamFilter()
    slam.update(["a", "a"], [[2.0, 0.0], [2.2, 0.0]], R)
    mean, covariance = slam.landmarks()["a"]
    np.testing.assert_allclose(mean, [2.1, 0.0], atol=1e-9)
    np.testing.assert_allclose(covariance[0, 0], R[0, 0] / 2, rtol=1e-9)


@pytest.mark.slow
def test_an_update_at_200_landmarks_takes_about_a_millisecond():
    rng, motion = np.random.default_rng(0), odometry_motion()
    slam = EkfSlamFilter(jacobians="first-estimates")
    Z = np.stack([rng.uniform(1, 9, 200), rng.uniform(-3, 3, 200)], axis=1)
    slam.update(list(range(200)), Z, R)
    predicts, updates = [], []
    for _ in range(30):
        begin = time.perf_counter()
        slam.predict(motion, (0.0, 0.0, 0.0), np.zeros((3, 3)))
        middle = time.perf_counter()
        seen = rng.choice(200, 10, replace=False)
        slam.update(seen.tolist(), Z[seen], R)
        updates.append(time.perf_counter() - middle)
        predicts.append(middle - begin)
    # 0.04 and 0.64 ms by themselves with one BLAS thread; the margin is for busy machines and more threads.
    assert min(predicts) < 0.3e-3
    assert min(updates) < 4e-3


INFO = pioneer()


def look(slam: EkfSlam, tick: int, *seen: tuple[str | None, float, float], forward: float = 0.0) -> Estimate:
    """Feed one tick with sightings (name, range, bearing)."""
    odometry = Odometry(forward, 0.0, 0.0, np.diag([1e-4 * abs(forward), 0.0, 1e-8]))
    sightings = tuple(Sighting(tick * 0.04, name, distance, bearing, R) for name, distance, bearing in seen)
    return slam.update(Observation(time=tick * 0.04, dt=0.04, odometry=odometry, sightings=sightings))


@pytest.fixture
def slam() -> EkfSlam:
    estimator = EkfSlam(confirmations=3, joint_covariance=True)
    estimator.start(INFO, {}, np.random.default_rng(0))
    return estimator


def test_a_beacon_enters_the_map_at_the_third_sighting_that_agrees(slam):
    assert not look(slam, 1, ("lion", 2.0, 0.0)).landmarks
    assert not look(slam, 2, ("lion", 2.0, 0.01)).landmarks
    belief = look(slam, 3, ("lion", 2.0, 0.0))
    # All three looks count, and the robot knew where it was.
    np.testing.assert_allclose(belief.landmarks["lion"][0], [3.0, 1.0 + 2.0 * 0.01 / 3.0], atol=1e-4)
    assert belief.joint_covariance is not None
    assert belief.joint_covariance.shape == (5, 5)


def test_one_bad_first_look_does_not_poison_the_map(slam):
    look(slam, 1, ("lion", 6.0, 1.0))
    for tick in (2, 3):
        assert not look(slam, tick, ("lion", 2.0, 0.0)).landmarks
    np.testing.assert_allclose(look(slam, 4, ("lion", 2.0, 0.0)).landmarks["lion"][0], [3.0, 1.0], atol=1e-9)


def test_looks_that_lie_too_far_apart_in_time_do_not_confirm_each_other(slam):
    for tick in (1, 200, 400):
        belief = look(slam, tick, ("lion", 2.0, 0.0))
    assert not belief.landmarks


def test_a_gross_outlier_changes_nothing(slam):
    for tick in range(1, 10):
        before = look(slam, tick, ("lion", 2.0, 0.0), ("owl", 3.0, 1.0))
    assert [name for name, _, _ in before.innovations] == ["lion", "owl"]
    after = look(slam, 10, ("lion", 4.0, 0.0))
    assert not after.innovations
    assert after.pose == before.pose


def test_anonymous_sightings_are_left_to_those_who_can_use_them(slam):
    for tick in range(1, 6):
        belief = look(slam, tick, (None, 2.0, 0.0))
    assert not belief.landmarks


def test_without_sightings_the_estimate_is_dead_reckoning(slam):
    for tick in range(1, 26):
        belief = look(slam, tick, forward=0.04)
    assert belief.pose == Pose(pytest.approx(2.0), 1.0, 0.0)
    # Its scale may be off too: over 1 m by as much as the noise adds, less the beginning, which tells how much that is.
    assert 1.7 < belief.covariance[0, 0] / (25 * 1e-4 * 0.04) < 2.0


def test_a_tick_in_which_odometry_claims_no_error_does_not_make_good_sightings_outliers(slam):
    for tick in range(1, 20):
        look(slam, tick, ("lion", 2.0 - 0.04 * tick, 0.0), forward=0.04)
    sure = Odometry(0.04, 0.0, 0.0, np.zeros((3, 3)))
    belief = slam.update(Observation(time=0.8, dt=0.04, odometry=sure))
    spread = np.diag(belief.covariance)
    belief = slam.update(Observation(time=0.84, dt=0.04, odometry=sure))
    assert np.all(np.diag(belief.covariance)[[0, 2]] > spread[[0, 2]])


def test_what_is_seen_of_a_landmark_before_it_is_told_corrects_the_pose(slam):
    look(slam, 1, ("lion", 2.0, 0.0))
    for tick in range(2, 30):
        look(slam, tick, forward=0.04)
    before = look(slam, 30)
    after = look(slam, 31, ("lion", 0.88, 0.0))
    # Two looks do not tell where the lion is, but how far the robot has come between them.
    assert not after.landmarks
    assert [name for name, _, _ in after.innovations] == ["lion"]
    assert after.covariance[0, 0] < before.covariance[0, 0]


def test_a_landmark_that_is_removed_leaves_the_others_as_they_were():
    slam, motion = EkfSlamFilter(jacobians="first-estimates", covariance=np.diag([0.04, 0.05, 0.01])), odometry_motion()
    slam.update(["a", "b", "c"], [[2.0, 0.3], [3.0, -0.8], [1.5, 2.0]], R)
    slam.predict(motion, (0.2, 0.0, 0.1), 1e-4 * np.eye(3))
    slam.update(["c", "b"], [[1.6, 1.9], [2.8, -0.9]], R)
    before, P = slam.landmarks(), slam.joint_covariance
    slam.remove("b")
    assert slam.names() == ("a", "c")
    np.testing.assert_array_equal(slam.joint_covariance, np.delete(np.delete(P, (5, 6), 0), (5, 6), 1))
    for name in ("a", "c"):
        np.testing.assert_array_equal(slam.landmarks()[name][0], before[name][0])
    slam.update(["c", "b"], [[1.6, 1.9], [2.8, -0.9]], R)
    assert slam.names() == ("a", "c", "b")


@pytest.mark.slow
def test_a_sighting_of_nothing_without_a_name_is_forgotten():
    slam = EkfSlam(association="joint", joint_covariance=True)
    slam.start(INFO, {}, np.random.default_rng(0))
    look(slam, 1, (None, 6.0, 1.0))
    for tick in range(2, 200):
        belief = look(slam, tick, (None, 2.0, 0.0))
    assert list(belief.landmarks) == [1]
    look(slam, 200, (None, 5.0, -2.0))
    for tick in range(201, 204):
        belief = look(slam, tick, (None, 5.0, -2.0))
    assert sorted(belief.landmarks) == [0, 1]


@pytest.mark.parametrize("first", ["poor", "good"])
def test_a_poor_first_look_is_not_frozen_and_a_good_one_is(first):
    slam = EkfSlamFilter(jacobians="first-estimates", covariance=1e-4 * np.eye(3))
    if first == "poor":
        slam.update(["lion"], [[6.0, 1.0]], np.diag([4.0, 1.0]))
    else:
        slam.update(["lion"], [[2.2, 0.05]], R)
    places = slam._places(["lion"])
    slam.update(["lion"], [[2.0, 0.0]], R)
    _, _, newest = range_bearing(slam.pose, slam.landmarks()["lion"][0][None])
    _, used = slam._expect(places)
    assert np.allclose(used.landmark, newest, atol=1e-12) == (first == "poor")


def turned_back(**keys: float) -> EkfSlamFilter:
    """Return a filter that has seen one landmark, turned by a radian less than it was told, and found that out."""
    slam, noise = EkfSlamFilter(jacobians="first-estimates", covariance=1e-6 * np.eye(3), **keys), 1e-4 * np.eye(2)
    slam.update(["near"], [[2.0, 0.0]], noise)
    slam.predict(odometry_motion(), [0.0, 0.0, 1.0], np.diag([1e-6, 1e-6, 1.0]))
    for _ in range(5):
        slam.update(["other"], [[4.0, 0.5]], noise)
    slam.update(["near"], [[2.0, 0.0]], noise)
    slam.update(["other"], [[4.0, 0.5]], noise)
    return slam


def off_derivatives(slam: EkfSlamFilter, name: str) -> float:
    """Return how far the spread of an expected sighting is off that by derivatives at the newest estimates, a share."""
    place = slam.landmarks([name])[name][0]
    _, H_pose, H_landmark = range_bearing(slam.pose, place[None])
    H = np.hstack([H_pose[0], H_landmark[0]])
    newest = H @ slam.joint_covariance_of([name]) @ H.T
    return float(np.linalg.norm(slam.expect([name])[1][0] - newest) / np.linalg.norm(newest))


def test_a_map_that_has_turned_by_a_radian_gets_new_derivatives_where_that_is_asked_for():
    assert off_derivatives(turned_back(), "other") > 0.5
    assert off_derivatives(turned_back(renew=0.5), "other") < 0.05


def test_a_robot_that_is_put_elsewhere_on_its_map_gets_new_derivatives():
    slam = turned_back()
    slam.relocate(slam.pose, 0.01 * np.eye(3))
    assert off_derivatives(slam, "other") < 1e-9
