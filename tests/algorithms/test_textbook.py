"""The estimators as the textbook prints them: equal to others' where a result is exact, short enough to be read."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
import shapely

import mjsim.algorithms.textbook as textbook
from mjsim.algorithms.filterpy_slam import FilterpySlam
from mjsim.algorithms.textbook import TextbookEkfSlam, TextbookFastSlam, TextbookMonteCarlo
from mjsim.algorithms.textbook.monte_carlo import BEAMS, CELL, SIGMA_HIT, Z_RAND
from mjsim.geometry import Pose
from mjsim.interface import BeaconInfo, Observation, Odometry, Sighting
from tests.algorithms.test_monte_carlo import FACES, LIDAR, MAP, scan_from
from tests.algorithms.test_slam_estimators import POSTS, R, apart, ring_run
from tests.robots import pioneer

STILL = Odometry(0.0, 0.0, 0.0, np.zeros((3, 3)))
MODULES = sorted(Path(textbook.__file__).parent.glob("*.py"))


def known_pose(pose, **sheet):
    return dataclasses.replace(pioneer(), prior=pose, prior_covariance=np.zeros((3, 3)), **sheet)


@pytest.mark.parametrize("path", MODULES, ids=lambda path: path.stem)
def test_an_estimator_of_the_textbook_is_one_file_below_150_lines(path):
    assert len(path.read_text(encoding="utf-8").splitlines()) < 150


def test_the_ekf_is_that_of_another_program():
    truth, belief, _ = ring_run(TextbookEkfSlam(), 3, steps=100)
    _, other, _ = ring_run(FilterpySlam(), 3, steps=100)
    np.testing.assert_allclose(belief.pose.as_array(), other.pose.as_array(), atol=1e-9)
    np.testing.assert_allclose(belief.covariance, other.covariance, atol=1e-9)
    assert belief.landmarks.keys() == other.landmarks.keys()
    for name in belief.landmarks:
        for own, others in zip(belief.landmarks[name], other.landmarks[name], strict=True):
            np.testing.assert_allclose(own, others, atol=1e-9)
    assert apart(truth, belief) < 0.12


@pytest.mark.parametrize("kind", [TextbookEkfSlam, TextbookFastSlam])
def test_from_a_pose_that_is_known_a_landmark_is_the_mean_of_its_sightings(kind):
    """Without an error of the pose, n equal sightings leave a n-th of one's covariance; seen ahead it is diagonal."""
    slam, rng = kind(), np.random.default_rng(1)
    slam.start(known_pose(Pose(1.0, 2.0, np.pi / 2)), {}, rng)
    ranges = 4.0 + np.array([0.03, -0.03, 0.01, -0.01])
    for r in ranges:
        belief = slam.update(Observation(0.0, 0.1, STILL, sightings=(Sighting(0.0, "post", float(r), 0.0, R),)))
    mean, covariance = belief.landmarks["post"]
    np.testing.assert_allclose(mean, (1.0, 6.0), atol=1e-9)
    along, across = R[0, 0] / 4, 4.0**2 * R[1, 1] / 4
    np.testing.assert_allclose(covariance, np.diag([across, along]), rtol=0.02, atol=1e-12)
    np.testing.assert_allclose(belief.covariance, 0.0, atol=1e-15)


def test_fastslam_finds_pose_and_map_where_odometry_drifts():
    truth, belief, told = ring_run(TextbookFastSlam(), 1, steps=120)
    assert apart(truth, belief) < 0.3 < np.hypot(*(truth - told)[:2])
    assert all(np.hypot(*(mean - POSTS[name])) < 0.5 for name, (mean, _) in belief.landmarks.items())


def localized(prior, spread, **update):
    """Return the belief after one observation with nothing moved."""
    filter = TextbookMonteCarlo(particles=2000)
    filter.take_map(MAP)
    catalogue = {"post": BeaconInfo("post", None, 0.3, 0.3, pose=Pose(6.0, 4.0, 0.0), center=1.0)}
    info = dataclasses.replace(pioneer(), prior=prior, prior_covariance=spread, sensors={"scan": LIDAR})
    filter.start(info, catalogue, np.random.default_rng(0))
    return filter.update(Observation(0.0, 0.1, STILL, **update))


def test_monte_carlo_finds_the_pose_from_which_a_scan_was_taken():
    pose = Pose(4.1, 1.9, 0.1)
    scan = scan_from(pose, np.random.default_rng(2))
    belief = localized(Pose(4.3, 1.7, 0.0), np.diag([0.2, 0.2, 0.1]) ** 2, scans={"scan": scan})
    assert np.abs(belief.pose.as_array() - pose.as_array()).max() < 0.05


def test_monte_carlo_weighs_a_beacon_as_a_kalman_filter_does():
    """Ahead along x, range corrects x alone: the product of two Gaussians."""
    spread = np.diag([0.2, 1e-6, 1e-6]) ** 2
    look = Sighting(0.0, "post", 3.9, 0.0, np.diag([0.1, 1.0]) ** 2)
    belief = localized(Pose(2.0, 4.0, 0.0), spread, sightings=(look,))
    gain = 0.2**2 / (0.2**2 + 0.1**2)
    assert belief.pose.x == pytest.approx(2.0 + gain * 0.1, abs=0.01)
    assert belief.covariance[0, 0] == pytest.approx((1.0 - gain) * 0.2**2, rel=0.15)


def test_monte_carlo_measures_the_distance_to_walls_within_a_cell():
    filter, rng = TextbookMonteCarlo(), np.random.default_rng(3)
    filter.take_map(MAP)
    points = rng.uniform((0.1, 0.1), (9.9, 3.9), (200, 2))
    column, row = ((points - filter.corner) / CELL).astype(int).T
    exact = [shapely.Point(point).distance(FACES) for point in points]
    np.testing.assert_allclose(filter.distance[row, column], exact, atol=0.06)


@pytest.mark.parametrize("kind", [TextbookFastSlam, TextbookMonteCarlo])
def test_no_particles_are_refused(kind):
    with pytest.raises(ValueError, match="particles is 0"):
        kind(particles=0)


def test_monte_carlo_without_a_map_says_what_to_write():
    with pytest.raises(ValueError, match="map: known"):
        TextbookMonteCarlo().take_map(None)


def test_the_likelihood_of_a_scan_is_the_product_of_those_of_its_ends():
    locator = TextbookMonteCarlo(particles=3)
    locator.take_map(MAP)
    locator.poses = np.array([[0.5, 0.4, 0.0], [0.6, -0.3, 0.9], [-0.2, 0.1, -2.0]])
    scan = scan_from(Pose(0.5, 0.4, 0.0), np.random.default_rng(1))
    robot_from_sensor = Pose(0.1, -0.05, 0.3)
    space = np.eye(4)
    space[:2, :2], space[:2, 3] = robot_from_sensor.matrix()[:2, :2], (0.1, -0.05)
    told = locator.scan_log_likelihood(scan, space)
    ends = scan.points()
    ends = ends[np.linspace(0, len(ends) - 1, min(BEAMS, len(ends))).astype(int)]
    walls = shapely.union_all([shapely.LineString(segment) for segment in MAP.segments])
    for pose, value in zip(locator.poses, told, strict=True):
        places = (Pose(*pose) @ robot_from_sensor).transform(ends)
        distances = shapely.distance(shapely.points(places), walls)
        # A cell is as far as its middle: half its diagonal, and as much for the walls in it.
        near, far = (np.maximum(distances + side * math.sqrt(2) * CELL, 0.0) for side in (1, -1))
        bounds = [np.log((1 - Z_RAND) * np.exp(-0.5 * (d / SIGMA_HIT) ** 2) + Z_RAND).sum() for d in (near, far)]
        assert bounds[0] <= value <= bounds[1]


@pytest.mark.parametrize("kind", [TextbookMonteCarlo, TextbookFastSlam])
def test_particles_are_drawn_as_the_loop_of_the_book_draws_them(kind):
    # Table 4.4: one r of uniform distribution in [0, 1 / M), then the weights are passed in steps of 1 / M.
    for seed in range(20):
        estimator, rng = kind(particles=40), np.random.default_rng(seed)
        weights = rng.dirichlet(np.full(40, 0.5))
        estimator.rng, estimator.weights, estimator.poses = np.random.default_rng(seed), weights, np.eye(40)
        estimator.mu, estimator.Sigma = {}, {}
        drawn, r, total, index = [], np.random.default_rng(seed).uniform() / 40, weights[0], 0
        for m in range(40):
            while r + m / 40 > total:
                index += 1
                total += weights[index]
            drawn.append(index)
        estimator.resample()
        assert np.argmax(estimator.poses, axis=1).tolist() == drawn
        assert estimator.weights == pytest.approx(np.full(40, 1 / 40))
