"""Corrections that are too large for derivatives taken before them, beside scipy's least squares."""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import least_squares

from mjsim.algorithms.ekf_slam.ekf_slam import EkfSlamFilter, InvariantEkfSlamFilter, odometry_motion
from mjsim.geometry import Array, wrap_angle

R = np.diag([0.1, np.radians(2.0)]) ** 2
SEEN = np.array([0.8, 1.1])
"""Of the landmark, by a robot that has driven for long without one [m, rad]."""
FILTERS = {
    "standard": lambda **rest: EkfSlamFilter(jacobians="standard", **rest),
    "first-estimates": lambda **rest: EkfSlamFilter(jacobians="first-estimates", **rest),
    "invariant": lambda **rest: InvariantEkfSlamFilter(**rest),
}


def lost(kind: str, *, far: float):
    """Return a filter that has seen a landmark once, and driven 2 m since with a heading that is 20 degrees unsure."""
    slam = FILTERS[kind](far=far, covariance=np.diag([1e-4, 1e-4, 1e-4]))
    slam.update(["door"], [[3.0, 0.2]], R)
    slam.predict(odometry_motion(), [2.0, 0.0, 1.0], np.diag([0.3, 0.2, np.radians(20.0)]) ** 2)
    return slam


def state_of(slam) -> Array:
    """Return pose and landmark, shape (5,)."""
    return np.concatenate([slam.pose, slam.landmarks()["door"][0]])


def moved(kind: str, mean: Array, error: Array) -> Array:
    """Return the state whose error from the mean is this, as the filter's errors are meant, shape (5,)."""
    if kind != "invariant":
        return mean + error
    points, turn = mean[[0, 1, 3, 4]].reshape(2, 2).T, error[2]
    generator = np.zeros((4, 4))
    generator[:2, :2] = turn * np.array([[0.0, -1.0], [1.0, 0.0]])
    generator[:2, 2:] = error[[0, 1, 3, 4]].reshape(2, 2).T - generator[:2, :2] @ points
    grown = expm(generator) @ np.vstack([points, np.eye(2)])
    return np.array([*grown[:2, 0], mean[2] + turn, *grown[:2, 1]])


def most_likely(kind: str, mean: Array, P: Array) -> Array:
    """Return the state that fits the prior and the sighting best, shape (5,)."""
    whitened, root = np.linalg.inv(np.linalg.cholesky(P)), np.sqrt(np.diag(R))

    def off(error: Array) -> Array:
        x, y, heading, mark_x, mark_y = moved(kind, mean, error)
        expected = np.hypot(mark_x - x, mark_y - y), np.arctan2(mark_y - y, mark_x - x) - heading
        apart = SEEN[0] - expected[0], wrap_angle(SEEN[1] - expected[1])
        return np.concatenate([whitened @ error, apart / root])

    return moved(kind, mean, least_squares(off, np.zeros(5), xtol=1e-12, ftol=1e-12, gtol=1e-12).x)


@pytest.mark.parametrize("kind", FILTERS)
def test_an_iterated_correction_ends_where_prior_and_sighting_agree_best(kind):
    slam, plain = lost(kind, far=0.2), lost(kind, far=np.inf)
    best = most_likely(kind, state_of(slam), slam.joint_covariance)
    for each in (slam, plain):
        each.update(["door"], SEEN[None], R)
    apart, without = (np.abs(state_of(each) - best) for each in (slam, plain))
    assert apart.max() < 2e-3
    assert without.max() > 0.2


@pytest.mark.parametrize("kind", FILTERS)
def test_a_small_correction_is_that_of_the_textbook(kind):
    both = [lost(kind, far=far) for far in (0.2, np.inf)]
    expected, _ = both[0].expect(["door"])
    for each in both:
        each.update(["door"], expected + np.array([0.02, 0.01]), R)
    np.testing.assert_array_equal(state_of(both[0]), state_of(both[1]))
    np.testing.assert_array_equal(both[0].joint_covariance, both[1].joint_covariance)
