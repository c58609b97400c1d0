"""A robot whose odometry or sensor errs by far more than stated is not sure of a wrong pose."""

import numpy as np
import pytest

from mjsim.algorithms.ekf_slam.ekf_slam import EkfSlam, EkfSlamFilter
from mjsim.algorithms.ekf_slam.large_errors import KINDS, LARGE, LARGE_MOTION, LARGE_SENSOR, LargeErrors
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


@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "share", "ratio"),
    [
        ("turns by 0.5 degrees per second", 0.35, 1.02),
        ("bearings off by 2 degrees", 0.35, 1.02),
        ("ranges 4 % long", 0.35, 1.02),
        ("turns 10 % short", 0.8, 1.02),
        ("wheels spin", 0.35, 1.05),
    ],
)
def test_a_robot_whose_sensors_err_by_more_than_stated_is_surely_wrong_for_less_long(case, share, ratio):
    room, _ = CASES[case]
    runs = [disturbed.drive({"slam": EkfSlam(), "sheets": Sheets()}, seed, room=room) for seed in (1, 10)]
    wrong = {name: np.sum([run[name].surely_wrong() for run in runs]) for name in ("slam", "sheets")}
    error = {name: np.mean([run[name].position.mean() for run in runs]) for name in ("slam", "sheets")}
    assert wrong["slam"] < share * wrong["sheets"]
    assert error["slam"] < ratio * error["sheets"]


@pytest.mark.slow
def test_errors_beyond_data_sheets_are_not_believed_where_there_are_none():
    runs = [disturbed.drive({"slam": EkfSlam(), "sheets": Sheets()}, seed) for seed in range(3)]
    error = {name: np.mean([run[name].position.mean() for run in runs]) for name in ("slam", "sheets")}
    assert error["slam"] < 1.02 * error["sheets"]
