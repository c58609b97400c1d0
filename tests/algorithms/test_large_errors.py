"""A robot whose odometry or sensor errs by far more than stated is not sure of a wrong pose."""

import numpy as np
import pytest

from mjsim.algorithms import GraphSlam, TextbookEkfSlam
from mjsim.algorithms.ekf_slam.ekf_slam import EkfSlam, EkfSlamFilter
from mjsim.algorithms.ekf_slam.large_errors import LargeErrors
from mjsim.algorithms.estimation.constant_errors import KINDS, LARGE, LARGE_MOTION, LARGE_SENSOR, averaged, reweighted
from mjsim.bench import disturbed
from mjsim.bench.disturbed import CASES


class Sheets(EkfSlam):
    """As if data sheets were right."""

    def start(self, *given):
        super().start(*given)
        self._rivals._wide = self._rivals._rough = None


def _density(z, covariance):
    return -0.5 * (z @ np.linalg.solve(covariance, z) + np.linalg.slogdet(covariance)[1])


@pytest.mark.parametrize("kind", range(len(KINDS)))
def test_the_belief_with_other_priors_is_that_of_regression_with_them(kind):
    # A linear model of z by pose and errors, solved anew with each prior.
    rng, usual = np.random.default_rng(kind), LARGE * np.linspace(0.01, 0.3, len(LARGE))
    H, noise = rng.normal(size=(20, 3 + len(LARGE))), 0.02**2 * np.eye(20)
    z = H @ rng.normal(0.0, np.sqrt([*np.full(3, 0.1), *LARGE]))

    def solved(variances):
        prior = np.diag([*np.full(3, 0.01), *variances])
        P = np.linalg.inv(np.linalg.inv(prior) + H.T @ np.linalg.solve(noise, H))
        return P @ H.T @ np.linalg.solve(noise, z), P, _density(z, H @ prior @ H.T + noise)

    large = LargeErrors(EkfSlamFilter(parameters=len(LARGE_MOTION), sensor=len(LARGE_SENSOR)))
    large.gain(usual[:4])
    large.expect_ranges(usual[5:7])
    usual[[4, 7]] = 1e-6 * LARGE[[4, 7]]
    size = large.slam._size
    large.slam._mean[:size], large.slam._P[:size, :size], with_all = solved(LARGE)
    mean, P, likelihood = solved(np.where(np.isin(range(len(LARGE)), KINDS[kind]), LARGE, usual))
    found_mean, found_P = large.averaged(np.eye(len(KINDS))[kind])
    np.testing.assert_allclose(found_mean, mean, rtol=1e-5, atol=1e-9)
    np.testing.assert_allclose(found_P, P, rtol=1e-4, atol=1e-9)
    assert large._conditions()[1][kind] == pytest.approx(likelihood - with_all, abs=1e-4)


@pytest.mark.parametrize("factor", [0.01, 1.0, 30.0])
def test_a_belief_under_another_prior_is_that_of_regression_with_it(factor):
    rng, noise = np.random.default_rng(1), 0.1**2 * np.eye(12)
    H, prior = rng.normal(size=(12, 5)), np.array([0.3, 0.2, 0.1])  # of two unknowns and three errors
    z = H @ rng.normal(size=5)

    def solved(variances):
        P0 = np.diag([*variances, 1.0, 2.0])
        P = np.linalg.inv(np.linalg.inv(P0) + H.T @ np.linalg.solve(noise, H))
        return P @ H.T @ np.linalg.solve(noise, z), P, _density(z, H @ P0 @ H.T + noise)

    mean, P, explained = solved(prior)
    others = np.array([prior * factor, prior * (1.0, factor, 1.0)])
    A, ratios = reweighted(mean[:3], P[:3, :3], prior, others)
    for row, other in enumerate(others):
        step, changed = averaged(P, P[:, :3], mean[:3], A, np.eye(2)[row])
        expected, covariance, likelihood = solved(other)
        np.testing.assert_allclose(mean + step, expected, atol=1e-9)
        np.testing.assert_allclose(changed, covariance, atol=1e-9)
        assert ratios[row] == pytest.approx(likelihood - explained, abs=1e-6)
    # The average of two is a mixture.
    step, mixed = averaged(P, P[:, :3], mean[:3], A, np.array([0.25, 0.75]))
    means, covariances, _ = zip(*map(solved, others), strict=True)
    np.testing.assert_allclose(mean + step, 0.25 * means[0] + 0.75 * means[1], atol=1e-9)
    spread = [np.outer(each, each) for each in means - (mean + step)]
    np.testing.assert_allclose(
        mixed, 0.25 * (covariances[0] + spread[0]) + 0.75 * (covariances[1] + spread[1]), atol=1e-9
    )


@pytest.mark.slow
@pytest.mark.parametrize(("case", "nees"), [("turns by 0.5 degrees per second", 9.0), ("symmetrical hall", 4.0)])
def test_a_graph_is_as_good_as_the_textbook_whether_or_not_there_are_errors(case, nees):
    room, _ = CASES[case]
    run = disturbed.drive({"graph": GraphSlam(), "book": TextbookEkfSlam()}, 0, room=room, seconds=50.0)
    assert run["graph"].position.mean() < 1.2 * run["book"].position.mean()
    assert run["graph"].nees.mean() < nees


@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "seed", "seconds"),
    [("turns by 0.5 degrees per second", 10, 60), ("bearings off by 2 degrees", 1, 60), ("wheels spin", 1, 100)],
)
def test_a_robot_whose_sensors_err_by_more_than_stated_is_surely_wrong_for_less_long(case, seed, seconds):
    room, _ = CASES[case]
    run = disturbed.drive({"slam": EkfSlam(), "sheets": Sheets()}, seed, room=room, seconds=seconds)
    assert run["sheets"].surely_wrong() > 1.0
    assert run["slam"].surely_wrong() < 0.35 * run["sheets"].surely_wrong()
    assert run["slam"].position.mean() < 1.02 * run["sheets"].position.mean()


@pytest.mark.slow
def test_errors_beyond_data_sheets_are_not_believed_where_there_are_none():
    run = disturbed.drive({"slam": EkfSlam(), "sheets": Sheets()}, 0, seconds=60.0)
    assert run["slam"].position.mean() < 1.02 * run["sheets"].position.mean()
