"""What odometry errs by all the time is one error of the whole way, not a new one at each step."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

import mjsim
from mjsim.algorithms.estimation.pose_graph import COMMON, PoseGraph
from mjsim.algorithms.lidar_slam import LidarSlam
from mjsim.algorithms.scans.scan_search import match_pose
from mjsim.algorithms.scans.scan_walls import surface_of
from mjsim.algorithms.waypoints import Waypoints
from mjsim.geometry import wrap_angle

GAIN = 1.1
"""By this factor odometry tells ways that are too long."""
SCOUT = """
robots:
  - name: scout
    preset: pioneer3dx
    at: [AT]
    drive: {noise: {speed: 0.02, turn: 0.02}}
    odometry: {noise: {distance: 0.01, turn: 0.02}}
    sensors:
      - {lidar: scan, at: [0.1, 0, 0.3], beams: 181, fov_deg: 180, range: [0.05, RANGE], rate_hz: 5, noise: {range: N}}
"""
CORRIDOR = """
mjsim: 1
name: corridor
walls: [{points: [[0, 0], [20, 0], [20, 2.2], [0, 2.2]], closed: true}]
"""
PILLARS = """
mjsim: 1
name: pillars
walls: [{points: [[0, 0], [30, 0], [30, 20], [0, 20]], closed: true}]
obstacles: [{cylinder: [0.25, 2.0], at: [4, 4], repeat: [{times: 6, offset: [4.4, 0]}, {times: 4, offset: [0, 4]}]}]
"""


def world(walls, at, *, farthest, noise):
    robot = SCOUT.replace("AT", at).replace("RANGE", str(farthest)).replace("range: N", f"range: {noise}")
    return mjsim.parse_world(walls + robot)


def test_a_graph_finds_the_error_that_its_steps_have_in_common_as_least_squares_do():
    graph, sigma, doubt, loop = PoseGraph(np.zeros((1, 3))), 0.02, 0.05, 0.03
    slopes = np.zeros((3, COMMON))
    slopes[0, 0] = -GAIN
    for k in range(1, 5):
        graph.add_pose(np.array([GAIN * k, 0.0, 0.0]))
        graph.add_step(
            k - 1, k, np.array([GAIN, 0.0, 0.0]), np.diag(np.array([sigma, 1e-3, 1e-3]) ** -2.0), slopes=slopes
        )
    graph.add_step(0, 3, np.array([3.0, 0.0, 0.0]), np.diag(np.array([loop, 1e-3, 1e-3]) ** -2.0))
    graph.expect(np.zeros(COMMON), doubt**2 * np.eye(COMMON))
    graph.solve()
    # Unknown: four places on the line, and the share by which odometry's way is too long.
    A = np.zeros((6, 5))
    A[np.arange(4), np.arange(4)], A[np.arange(1, 4), np.arange(3)], A[:4, 4] = 1.0, -1.0, GAIN
    A[4, 2], A[5, 4] = 1.0, 1.0
    z, weight = np.array([GAIN] * 4 + [3.0, 0.0]), 1.0 / np.array([sigma] * 4 + [loop, doubt])
    P = np.linalg.inv((A.T * weight**2) @ A)
    x = P @ (A.T * weight**2) @ z
    np.testing.assert_allclose(graph.poses[1:, 0], x[:4], atol=1e-9)
    np.testing.assert_allclose(graph.errors, [x[4], *[0.0] * (COMMON - 1)], atol=1e-9)
    both = np.ix_([0, 3], [0, 3])
    np.testing.assert_allclose(graph.joint_covariance(4)[both], P[np.ix_([3, 4], [3, 4])], rtol=1e-6)
    np.testing.assert_allclose(graph.joint_step_covariances([0], 4)[0][both], P[np.ix_([3, 4], [3, 4])], rtol=1e-6)
    # The last step, which no loop spans, is longer than odometry tells by what the others have shown.
    assert abs(np.diff(graph.poses[:, 0])[-1] - 1.0) < 0.02


def test_a_match_follows_odometry_where_walls_tell_nothing_and_only_there():
    wall = surface_of(np.column_stack([np.linspace(-4, 4, 400), np.full(400, 1.0)]))
    noise, doubt = np.diag([0.03, 0.03, 0.01]) ** 2, np.diag([0.05, 0.0, 0.02]) ** 2
    laid = match_pose(wall, wall, np.array([0.3, 0.0, 0.0]), noise, systematic=doubt)
    assert laid.follows[0, 0] > 0.9
    assert np.abs(laid.follows[1:]).max() < 0.1
    # What odometry errs by all the time is not in the part that is new at each step.
    assert np.sqrt(laid.own[0, 0]) == pytest.approx(0.03, rel=0.1)
    assert laid.covariance[0, 0] > 2.0 * laid.own[0, 0]


class Told:
    """An estimator that is told the truth from outside, so that the robot gets where it should."""

    def start(self, robot, catalogue, rng):
        self.pose = robot.prior

    def update(self, seen):
        return mjsim.Estimate(self.pose, 1e-4 * np.eye(3))


def driven(world, way, *, spoilt, seconds):
    """Return the estimator after a drive, its errors (n, 3), their covariances (n, 3, 3), and the truth (n, 3)."""
    slam, told, errors, covariances, truth = LidarSlam(), Told(), [], [], []
    driver = mjsim.Driver(estimator=told, navigator=Waypoints(way, speed=0.7), avoidance=True)
    with mjsim.Simulation(world, seed=1) as sim:
        slam.start(sim.robots["scout"], {}, np.random.default_rng(0))
        for tick in itertools.takewhile(lambda tick: tick.time < seconds, mjsim.ticks(sim, {"scout": driver})):
            told.pose = tick.truth["scout"]
            truth.append(told.pose.as_array())
            belief = slam.update(spoilt(tick.seen["scout"]))
            off = belief.pose.as_array() - truth[-1]
            off[2] = wrap_angle(float(off[2]))
            errors.append(off)
            covariances.append(belief.covariance)
    return slam, np.array(errors), np.array(covariances), np.array(truth)


def too_long(seen):
    return replace(seen, odometry=replace(seen.odometry, forward=GAIN * seen.odometry.forward))


def turned_and_noisy(seen):
    """Return an observation of a cheap robot: odometry turns by 2 degrees a second, ranges err by 5 cm."""
    rng = np.random.default_rng(round(1000 * seen.time))
    scans = {
        name: replace(s, ranges=s.ranges + rng.normal(0.0, 0.05, s.ranges.shape)) for name, s in seen.scans.items()
    }
    moved = seen.odometry
    moved = replace(moved, forward=1.03 * moved.forward, turn=moved.turn + np.radians(2.0) * seen.dt)
    return replace(seen, scans=scans, odometry=moved)


@pytest.mark.slow
def test_along_a_bare_corridor_the_robot_knows_how_far_too_long_its_way_may_be_and_corrects_it_at_the_end():
    corridor = world(CORRIDOR, "2, 1.1", farthest=3.0, noise=0.01)
    _, errors, covariances, truth = driven(corridor, [(18.5, 1.1)], spoilt=too_long, seconds=26.0)
    sure = np.sqrt(covariances[:, 0, 0])
    before, after = np.argmax(truth[:, 0] > 15.0), -1
    assert errors[before, 0] > 0.4
    assert errors[before, 0] < 2.5 * sure[before]
    # A tenth is twice what is expected; the last 2 m, on which the end of the corridor is seen, tell half of it.
    assert abs(errors[after, 0]) < 0.6 * errors[before, 0]


@pytest.mark.slow
def test_in_a_hall_of_pillars_poor_odometry_leaves_decimetres_and_the_covariance_says_so():
    way = [(10.6, 2.0), (10.6, 10.0), (2.0, 10.0), (2.0, 2.0), (10.6, 2.0), (10.6, 10.0)]
    hall = world(PILLARS, "2, 2", farthest=4.0, noise=0.01)
    slam, errors, covariances, truth = driven(hall, way, spoilt=turned_and_noisy, seconds=75.0)
    nees = np.einsum("ni,nij,nj->n", errors, np.linalg.pinv(covariances, hermitian=True), errors)
    path = np.array([pose.as_array() for _, pose in slam.path()])
    assert slam.loops > 2
    assert np.hypot(*(path - truth)[:, :2].T).mean() < 0.5
    # 3 is meant.
    assert np.mean(nees) < 5.0
