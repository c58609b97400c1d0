"""Steps of Monte Carlo localization against shapely, sums and recursions by hand."""

import dataclasses
import math

import numpy as np
import pytest
import shapely

from mjsim.algorithms.monte_carlo import MonteCarloLocalization
from mjsim.geometry import Pose, wrap_angle
from mjsim.interface import BeaconInfo, Observation, Odometry, Sighting
from tests.algorithms.test_monte_carlo import FACES, LIDAR, MAP, NOISE, scan_from
from tests.robots import pioneer

POSE = Pose(4.0, 2.0, 3.0)
R = np.diag([0.1, 0.05]) ** 2
LION = Pose(0.0, 3.0, 0.0)


@pytest.fixture(scope="module")
def looks():
    """What the lidar sees from a pose and from another place, as ends of beams in the robot's frame."""
    rng = np.random.default_rng(1)
    found = []
    for pose in (POSE, Pose(8.0, 1.2, 0.4)):
        scan = scan_from(pose, rng, beams=36)
        angles = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
        found.append(scan.ranges[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1))
    return found


@pytest.fixture(scope="module")
def field():
    estimator = MonteCarloLocalization()
    estimator.take_map(MAP)
    return estimator._field


@pytest.fixture
def mcl(field):
    spread = np.diag([0.05, 0.05, 0.02]) ** 2
    info = dataclasses.replace(pioneer(), prior=POSE, prior_covariance=spread, sensors={"scan": LIDAR})
    lion = BeaconInfo("lion", picture=None, width=0.3, height=0.3, pose=LION)
    estimator = MonteCarloLocalization(particles=800)
    estimator._field = field
    estimator.start(info, {"lion": lion}, np.random.default_rng(0))
    return estimator


def test_a_scan_fits_by_the_distances_of_its_ends_from_walls(mcl, looks):
    poses = np.array([[4.0, 2.0, 3.0], [4.1, 1.9, 3.1], [8.0, 1.2, 0.4]])
    for pose, fit in zip(poses, mcl._scan_fit(poses, looks[0], 0.1), strict=True):
        away = shapely.distance(shapely.points(Pose(*pose).transform(looks[0])), FACES)
        assert fit == pytest.approx(np.log(0.95 * np.exp(-0.5 * (away / 0.1) ** 2) + 0.05).mean(), abs=0.15)
    np.testing.assert_array_equal(mcl._scan_fit(poses, np.zeros((0, 2)), 0.1), 0.0)
    seen = Sighting(0.0, "lion", 4.2, 3.0, R)
    for pose, fit in zip(poses, mcl._sighting_fit(poses, [seen, seen]), strict=True):
        x, y = LION.x - pose[0], LION.y - pose[1]
        off, turned = math.hypot(x, y) - 4.2, wrap_angle(math.atan2(y, x) - pose[2] - 3.0)
        squared = off**2 / (2 * 0.1**2) + turned**2 / (2 * 0.05**2)
        assert fit == pytest.approx(2 * math.log(0.95 * math.exp(-0.5 * squared) + 0.05))


def test_how_badly_scans_fit_is_a_fast_mean_against_a_slow_one(mcl):
    mcl._weights = np.full(2, 0.5)
    fast = slow = 0.0
    for value in (-0.5, -0.6, -3.0, -3.0, -0.4, -2.0):
        mean = (math.exp(value) + math.exp(value - 0.2)) / 2
        told = mcl._misfitting(np.array([value, value - 0.2]))
        fast += (0.3 if fast else 1.0) * (mean - fast)
        slow += ((0.03 if mean > slow else 0.0005) if slow else 1.0) * (mean - slow)
        assert told == pytest.approx(max(0.0, 1.0 - 1.5 * fast / slow))
    assert told > 0.1


def test_the_belief_is_the_mean_of_the_heaviest_place_and_the_spread_of_all(mcl):
    rng = np.random.default_rng(0)
    # Across the seam of headings, and a few particles elsewhere.
    near = np.array([4.2, 2.2, math.pi]) + rng.normal(0.0, 0.03, (300, 3))
    near[:, 2] = (near[:, 2] + math.pi) % (2 * math.pi) - math.pi
    far = np.array([8.0, 1.0, 0.0]) + rng.normal(0.0, 0.03, (30, 3))
    mcl._particles, mcl._weights = np.concatenate([near, far]), np.full(330, 1 / 330)
    belief = mcl._belief()
    heading = math.atan2(np.sin(near[:, 2]).mean(), np.cos(near[:, 2]).mean())
    assert (belief.pose.x, belief.pose.y) == pytest.approx(near[:, :2].mean(axis=0))
    assert wrap_angle(belief.pose.heading - heading) == pytest.approx(0.0, abs=1e-3)
    away = mcl._particles - belief.pose.as_array()
    away[:, 2] = (away[:, 2] + math.pi) % (2 * math.pi) - math.pi
    np.testing.assert_allclose(belief.covariance, away.T @ away / 330 + 1e-8 * np.eye(3), atol=1e-9)


def test_particles_in_few_places_are_200(mcl):
    # For two bins KLD-sampling asks for 164.
    assert mcl._needed(np.repeat([[0.2, 0.2, 0.1], [0.8, 0.2, 0.1]], 20, axis=0)) == 200


def test_particles_move_by_odometry_with_its_noise(mcl):
    before, moved = mcl._particles.copy(), np.array([0.3, 0.1, 0.2])
    mcl._move(Observation(0.04, 0.04, Odometry(*moved, NOISE)))
    pairs = zip(before, mcl._particles, strict=True)
    steps = np.array([(Pose(*one).inverse() @ Pose(*other)).as_array() for one, other in pairs])
    np.testing.assert_allclose(steps.mean(axis=0), moved, atol=4 * 0.015 / math.sqrt(800))
    np.testing.assert_allclose(steps.std(axis=0), 1.5 * np.sqrt(np.diag(NOISE)), rtol=0.12)


def test_a_robot_that_was_carried_away_is_looked_for_where_its_scan_fits(mcl, looks):
    mcl._misfit = 0.05
    found = mcl._better_places(looks[1], [], float(mcl._scan_fit(mcl._particles, looks[1], 0.08).mean()))
    assert 0 < len(found) <= 15
    assert np.hypot(*(found[:, :2] - (8.0, 1.2)).T).min() < 0.1
    assert len(mcl._better_places(looks[0], [], float(mcl._scan_fit(POSE.as_array()[None], looks[0], 0.08)[0]))) == 0
    mcl._draw(found)
    assert mcl._weights.sum() == pytest.approx(1.0)
    assert mcl._weights[-len(found) :].sum() == pytest.approx(0.025)


def test_a_scan_from_the_same_place_counts_for_none_until_the_robot_has_moved(mcl, looks):
    def weights():
        mcl._weights = np.full(len(mcl._particles), 1 / len(mcl._particles))
        mcl._weigh(looks[0], [], 0.0)
        return mcl._weights

    mcl._draw = lambda found: None
    first = weights().copy()
    assert first.max() > 1.5 / 800
    np.testing.assert_allclose(weights(), 1 / 800)
    mcl._moved = 0.005
    half = weights()
    np.testing.assert_allclose(2 * np.log(half / half.max()), np.log(first / first.max()), atol=1e-6)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"start": "here"}, "must be 'prior' or 'global'"),
        ({"particles": 99}, "at least 100 and 1"),
        ({"beams": 0}, "at least 100 and 1"),
        ({"show": -1}, "show is -1"),
    ],
)
def test_settings_that_make_no_filter_are_refused(keys, message):
    with pytest.raises(ValueError, match=message):
        MonteCarloLocalization(**keys)
    with pytest.raises(ValueError, match="map: known"):
        MonteCarloLocalization().take_map(None)
