"""Localization on a known map: both Kalman filters against closed forms and their own statistics."""

import dataclasses

import numpy as np
import pytest
from scipy.stats import chi2

from mjsim.algorithms.estimation.ekf_models import odometry_motion, range_bearing
from mjsim.algorithms.localization import EkfLocalization, UkfLocalization
from mjsim.geometry import Pose, wrap_angle
from mjsim.interface import BeaconInfo, Observation, Odometry, Sighting
from tests.robots import pioneer

PLACES = {"lion": (4.0, 1.0), "owl": (-2.0, 3.0), "pear": (1.0, -4.0)}
CATALOGUE = {
    name: BeaconInfo(name=name, picture=None, width=0.5, height=0.5, pose=Pose(*place, 0.0), center=1.0)
    for name, place in PLACES.items()
}
R = np.diag([0.05, np.radians(1.0)]) ** 2
BOTH = pytest.mark.parametrize("kind", [EkfLocalization, UkfLocalization])


def started(kind, prior, covariance):
    estimator = kind()
    info = dataclasses.replace(pioneer(), prior=Pose.from_array(prior), prior_covariance=covariance)
    estimator.start(info, CATALOGUE, np.random.default_rng(0))
    return estimator


def tick(step, covariance, sightings=()):
    return Observation(time=0.0, dt=0.04, odometry=Odometry(*step, covariance), sightings=tuple(sightings))


def sighting(name, z):
    return Sighting(0.0, name, *z, R)


@BOTH
def test_without_sightings_the_belief_is_that_of_odometry(kind):
    estimator = started(kind, (1.0, 2.0, 3.0), np.diag([1e-4, 1e-4, 1e-5]))
    pose, P = np.array([1.0, 2.0, 3.0]), np.diag([1e-4, 1e-4, 1e-5])
    Q = np.diag([1e-6, 1e-8, 1e-6])
    for _ in range(20):
        belief = estimator.update(tick((0.03, 0.0, 0.02), Q))
        pose, F, G = odometry_motion()(pose, np.array([0.03, 0.0, 0.02]))
        P = F @ P @ F.T + G @ Q @ G.T
    np.testing.assert_allclose(belief.pose.as_array(), pose, atol=1e-5)
    np.testing.assert_allclose(belief.covariance, P, rtol=1e-3, atol=1e-9)


@BOTH
def test_one_sighting_is_the_kalman_update(kind):
    P = np.diag([0.01, 0.01, 1e-4])
    estimator = started(kind, (0.0, 0.0, 0.0), P)
    z, H, _ = range_bearing(np.zeros(3), np.array([PLACES["lion"]]))
    seen = z[0] + (0.02, -0.01)
    belief = estimator.update(tick((0.0, 0.0, 0.0), np.zeros((3, 3)), [sighting("lion", seen)]))
    S = H[0] @ P @ H[0].T + R
    K = P @ H[0].T @ np.linalg.inv(S)
    # The unscented filter differs by the curvature of range and bearing over 0.1 m at 4 m.
    np.testing.assert_allclose(belief.pose.as_array(), K @ (0.02, -0.01), atol=2e-3)
    np.testing.assert_allclose(belief.covariance, P - K @ S @ K.T, atol=2e-4)


@BOTH
def test_a_gross_outlier_and_an_unknown_beacon_change_nothing(kind):
    estimator = started(kind, (0.0, 0.0, 0.0), np.diag([0.01, 0.01, 1e-4]))
    seen = [sighting("lion", (9.0, 2.0)), sighting("stranger", (1.0, 0.0)), sighting(None, (1.0, 0.0))]
    belief = estimator.update(tick((0.0, 0.0, 0.0), np.zeros((3, 3)), seen))
    np.testing.assert_allclose(belief.pose.as_array(), 0.0, atol=1e-12)
    assert not belief.innovations


@BOTH
def test_a_world_with_unknown_map_gets_an_error_with_a_remedy(kind):
    secret = {name: dataclasses.replace(info, pose=None, center=None) for name, info in CATALOGUE.items()}
    with pytest.raises(ValueError, match="map: known"):
        kind().start(pioneer(), secret, np.random.default_rng(0))


@pytest.mark.slow
@BOTH
def test_the_error_of_twenty_runs_is_what_the_covariance_says(kind):
    runs, motion, Q = 20, odometry_motion(), np.diag([0.01, 1e-4, 0.01]) ** 2
    nees = np.zeros((runs, 40))
    for run in range(runs):
        rng = np.random.default_rng(run)
        P = np.diag([0.1, 0.1, 0.05]) ** 2
        truth = rng.multivariate_normal(np.zeros(3), P)
        estimator = started(kind, np.zeros(3), P)
        for k in range(40):
            step = np.array([0.1, 0.0, 0.05])
            truth, _, _ = motion(truth, step + rng.normal(0, np.sqrt(np.diag(Q))))
            z, _, _ = range_bearing(truth, np.array(list(PLACES.values())))
            z += rng.normal(0, np.sqrt(np.diag(R)), z.shape)
            seen = [sighting(name, (r, wrap_angle(b))) for name, (r, b) in zip(PLACES, z, strict=True)]
            belief = estimator.update(tick(step, Q, seen if k % 2 else ()))
            error = belief.pose.as_array() - truth
            error[2] = wrap_angle(error[2])
            nees[run, k] = error @ np.linalg.solve(belief.covariance, error)
    low, high = chi2.ppf([0.025, 0.975], 3 * runs) / runs
    average = nees.mean(axis=0)
    assert np.mean((low < average) & (average < high)) > 0.8
