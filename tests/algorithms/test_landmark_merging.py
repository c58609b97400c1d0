"""Landmarks without a name that were mapped twice and become one, beside the textbook's least squares."""

import itertools

import numpy as np
import pytest

from mjsim.algorithms.ekf_slam.ekf_slam import EkfSlam, EkfSlamFilter, InvariantEkfSlamFilter, odometry_motion
from mjsim.geometry import Array
from mjsim.interface import Estimate, Observation, Odometry, Sighting
from tests.robots import pioneer

R = np.diag([0.1, 0.02]) ** 2
DT = 0.04
TREES = np.array([[3.0, 0.5], [4.0, -1.5], [5.0, 1.5]])
NEIGHBOUR = np.array([[3.0, 0.85]])
INFO = pioneer()
DRIFT = 0.4
"""How far odometry is off when the robot comes back [m]; it claims 0.03."""


def driven(trees: Array, *, jacobians: str = "first-estimates", drift: float = DRIFT) -> list[Estimate]:
    """Return what a robot believes that sees the trees, goes away without a look and comes back a drift off."""
    slam = EkfSlam(association="joint", jacobians=jacobians)
    slam.start(INFO, {}, np.random.default_rng(0))
    ticks = itertools.count(1)
    places = np.hypot(*trees.T), np.arctan2(*trees.T[::-1])

    def tell(left: float, *, looking: bool) -> Estimate:
        time = DT * next(ticks)
        seen = tuple(Sighting(time, None, r, b, R) for r, b in np.transpose(places).tolist()) if looking else ()
        moved = Odometry(0.0, left, 0.0, np.diag([1e-8, (0.05 * left) ** 2, 1e-8]))
        return slam.update(Observation(time=time, dt=DT, odometry=moved, sightings=seen))

    beliefs = [tell(0.0, looking=True) for _ in range(10)]
    tell(0.5, looking=False)
    tell(drift - 0.5, looking=False)
    return beliefs + [tell(0.0, looking=True) for _ in range(10)]


@pytest.mark.parametrize("jacobians", ["standard", "first-estimates", "invariant"])
def test_trees_that_were_mapped_twice_are_one_again(jacobians):
    *_, last = driven(TREES, jacobians=jacobians)
    assert sorted(last.landmarks) == [0, 1, 2]
    start = INFO.prior
    off = [last.landmarks[name][0] - tree - (start.x, start.y) for name, tree in enumerate(TREES)]
    assert np.abs(off).max() < 0.5 * DRIFT
    assert abs(last.pose.y - start.y) < 0.75 * DRIFT


def test_neighbours_that_are_seen_at_one_moment_stay_two():
    *_, last = driven(np.vstack([TREES, NEIGHBOUR]), drift=0.0)
    assert len(last.landmarks) == 4


@pytest.mark.parametrize("kind", [EkfSlamFilter, InvariantEkfSlamFilter])
def test_two_landmarks_become_one_as_least_squares_have_it(kind):
    slam = kind(covariance=np.diag([0.01, 0.02, 1e-3]))
    slam.update(["a", "b"], [[3.0, 0.2], [5.0, -0.4]], R)
    slam.predict(odometry_motion(), [0.4, 0.1, 0.05], 1e-3 * np.eye(3))
    slam.update(["c"], [[2.75, 0.14]], R)
    names = list(slam.names())
    mean = np.concatenate([slam.pose, *(slam.landmarks()[name][0] for name in names)])
    information, variance = np.linalg.inv(slam.joint_covariance), 0.02
    H = np.zeros((2, 9))
    H[:, 3:5], H[:, 7:9] = np.eye(2), -np.eye(2)
    P = np.linalg.inv(information + H.T @ H / variance)
    better = mean - P @ H.T @ (H @ mean) / variance
    slam.unite("a", "c", variance)
    rows = np.arange(7)
    assert slam.names() == ("a", "b")
    tolerance = 1e-12 if kind is EkfSlamFilter else 2e-3
    np.testing.assert_allclose(slam.pose, better[:3], atol=tolerance)
    np.testing.assert_allclose(slam.positions(["a", "b"]).ravel(), better[3:7], atol=tolerance)
    if kind is EkfSlamFilter:
        np.testing.assert_allclose(slam.joint_covariance, P[np.ix_(rows, rows)], atol=1e-12)
