"""EkfSlam averages a filter with errors of odometry and one without."""

import numpy as np
import pytest

from mjsim.algorithms.ekf_slam.ekf_slam import EkfSlamFilter, InvariantEkfSlamFilter, odometry_motion
from mjsim.algorithms.ekf_slam.rival_filters import RivalFilters
from mjsim.algorithms.estimation.ekf_models import range_bearing


@pytest.mark.parametrize("scale", [0.0, 0.1])
@pytest.mark.parametrize("make", [EkfSlamFilter, InvariantEkfSlamFilter])
def test_the_belief_is_averaged_by_likelihoods_once_the_data_speak_for_odometry_without_errors(make, scale):
    rng, motion, places = np.random.default_rng(1), odometry_motion(), np.array([[3.0, 2.0], [4.0, -2.0]])
    Q, R, prior = np.diag([0.02, 0.01, 0.01]) ** 2, np.diag([0.03, 0.01]) ** 2, np.array([0.1**2])
    with_errors, without = make(parameters=1), make(parameters=1)
    rivals, log, counts = RivalFilters(make(parameters=1), make(parameters=1)), 0.0, False
    truth, slopes, told = np.zeros(3), np.array([[0.2], [0.0], [0.0]]), np.array([0.2, 0.0, 0.0])
    for tick in range(20):
        truth = motion(truth, told * (1.0 + scale) + rng.normal(0.0, np.sqrt(np.diag(Q))))[0]
        z = range_bearing(truth, places)[0] + rng.normal(0.0, np.sqrt(np.diag(R)), (2, 2))
        gained = prior if not tick else np.zeros(1)
        rivals.predict(motion, told, Q, errors=(told, slopes, gained))
        with_errors.predict(motion, told, Q, slopes=slopes, wander=gained)
        without.predict(motion, told, Q)
        for sign, slam in ((1.0, without), (-1.0, with_errors)):
            if tick:
                nu, S = (z - slam.expect([0, 1])[0]).ravel(), slam.expect_together([0, 1]) + np.kron(np.eye(2), R)
                log -= sign * 0.5 * (nu @ np.linalg.solve(S, nu) + np.linalg.slogdet(S)[1])
            slam.update([0, 1], z, R)
        rivals.update([0, 1], z, R)
        counts = counts or log > 1.0
        none = counts / (1.0 + np.exp(-log))
        assert rivals.without_errors == pytest.approx(none, abs=1e-6)
        believed, apart = rivals.believed(), without.pose - with_errors.pose
        if none > 1e-3:
            np.testing.assert_allclose(believed.pose, with_errors.pose + none * apart, atol=1e-9)
            spread = none * without.covariance + (1.0 - none) * with_errors.covariance
            np.testing.assert_allclose(believed.covariance, spread + none * (1.0 - none) * np.outer(apart, apart))
        else:
            assert believed is rivals.leading
    # Where there are errors, averaging harms nothing: little evidence at the beginning does not count.
    assert counts == (not scale)


def test_without_a_rival_the_belief_is_that_of_the_one_filter():
    slam = EkfSlamFilter()
    rivals = RivalFilters(slam, None)
    rivals.update(["a"], [[2.0, 0.1]], np.diag([0.05, 0.02]) ** 2)
    rivals.change(lambda each: each.remove("a"))
    assert rivals.believed() is slam
    assert rivals.without_errors == 0.0
    assert "a" not in slam
