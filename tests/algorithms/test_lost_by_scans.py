"""LidarSlam when the robot slips, is pushed or is carried away, and when its odometry stalls."""

import numpy as np
import pytest

from mjsim.algorithms.lidar_slam import LidarSlam
from mjsim.algorithms.scans.odometry_delay import SynchronousOdometry
from mjsim.algorithms.scans.scan_search import ANYWHERE, Fit, match_pose
from mjsim.algorithms.scans.scan_walls import surface_of
from mjsim.bench import disturbed_scans
from mjsim.bench.disturbed_scans import DISTURBED
from mjsim.interface import Odometry

NOISE = np.diag([0.03, 0.03, 0.02]) ** 2


def test_motion_that_comes_all_at_once_after_a_stall_is_spread_over_the_stall():
    odometry, spread = SynchronousOdometry(), 1e-6 * np.eye(3)
    for tick in range(1, 21):
        # At 0.5 m/s; from 1.0 to 1.6 s nothing is told, then the whole way.
        forward = 0.0 if 10 < tick < 17 else 0.35 if tick == 17 else 0.05
        odometry.update(Odometry(forward, 0.0, 0.0, spread), 0.1 * tick)
    for time in (1.05, 1.3, 1.65, 1.85):
        np.testing.assert_allclose(odometry.since(time)[0], 0.5 * (2.0 - time), atol=1e-9)


def test_motion_after_a_rest_is_not_spread():
    odometry, spread = SynchronousOdometry(), 1e-6 * np.eye(3)
    for tick in range(1, 21):
        odometry.update(Odometry(0.0 if tick < 16 else 0.05, 0.0, 0.0, spread), 0.1 * tick)
    assert odometry.since(1.2)[0] == odometry.since(1.5)[0] == pytest.approx(0.25)


def corner(pose):
    """Return the walls of an L-shaped corner, in the frame of a pose."""
    x = np.linspace(-3.0, 3.0, 200)
    points = np.concatenate(
        [np.column_stack([x, np.full(200, 2.0)]), np.column_stack([np.full(80, 3.0), x[:80] + 2.0])]
    )
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return surface_of((points - pose[:2]) @ np.array([[c, -s], [s, c]]))


def test_a_scan_that_walls_contradict_where_odometry_says_is_sought_in_all_headings():
    turned = np.array([0.1, 0.0, 2.0])
    found = match_pose(
        corner(turned), corner(np.zeros(3)), np.zeros(3), NOISE, through=lambda pose: (abs(pose[2] - 2.0),) * 2
    )
    assert found.fit is Fit.SLIPPED
    np.testing.assert_allclose(found.pose, turned, atol=0.02)


def test_a_robot_whose_scan_fits_nowhere_is_lost():
    found = match_pose(
        corner(np.array([0.1, 0.0, 2.0])), corner(np.zeros(3)), np.zeros(3), NOISE, through=lambda pose: (1.0, 1.0)
    )
    assert found.fit is Fit.LOST
    np.testing.assert_array_equal(found.covariance, ANYWHERE)


@pytest.mark.slow
@pytest.mark.parametrize("case", ["turned by 180 degrees", "carried to a mapped place"])
def test_a_robot_that_is_turned_or_carried_is_found_and_never_surely_wrong_for_long(case):
    estimator = LidarSlam()
    errors = disturbed_scans.drive({"lidar": estimator}, 0, DISTURBED[case], seconds=100.0)["lidar"]
    assert errors.position[-50:].mean() < 0.05
    assert errors.nees.mean() < 15.0
    assert errors.surely_wrong() < 0.5
    assert errors.seconds_lost() < 5.0
    assert not estimator.lost()
