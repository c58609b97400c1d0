"""Scans of a robot whose odometry says nothing."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

import mjsim
from mjsim.algorithms.ekf_slam.ekf_slam import EkfSlam
from mjsim.algorithms.estimation.pose_graph import compose
from mjsim.algorithms.lidar_slam import LidarSlam
from mjsim.algorithms.scans import scan_walls
from mjsim.algorithms.scans.level_scan import LevelLidar
from mjsim.algorithms.scans.scan_odometry import FLOOR, GYROSCOPE, JITTER, LASTING, SPEED, ScanOdometry
from mjsim.algorithms.scans.scan_walls import walls_of
from mjsim.algorithms.waypoints import Waypoints
from mjsim.interface import Odometry

ROOM = """
mjsim: 1
name: room
walls:
  - {points: [[0, 0], [9, 0], [9, 7], [0, 7]], closed: true}
  - {points: [[3, 0], [3, 4]]}
obstacles: [{box: [0.8, 0.6, 1.0], at: [6.5, 3]}, {box: [0.6, 0.4, 1.0], at: [5, 6.7], heading_deg: 20}]
beacons:
  - {name: a, at: [0.1, 3], width: 0.1}
  - {name: b, at: [4, 6.9], width: 0.1}
  - {name: c, at: [8.9, 5], width: 0.1}
  - {name: d, at: [5, 0.1], width: 0.1}
  - {name: e, at: [1.5, 0.1], width: 0.1}
robots:
  - name: scout
    preset: pioneer3dx
    at: [1.3, 1]
    heading_deg: 90
    sensors:
      - {lidar: scan, at: [0.1, 0, 0.3],
         beams: 270, fov_deg: 270, range: [0.1, 8], rate_hz: 12.5, noise: {range: 0.02}}
      - {beacons: eyes, range: [0.1, 12], fov_deg: 360, rate_hz: 5, noise: {range: 0.05, bearing_deg: 1}}
run: {map: unknown}
"""
WAY = [(1.5, 5.3), (5.0, 5.3), (7.6, 5.0), (7.6, 1.2)]


@pytest.fixture(scope="module")
def drive():
    """Return the data sheet of the robot, and its observations without odometry and true poses at each tick."""
    seen, truth = [], []
    with mjsim.Simulation(mjsim.parse_world(ROOM), seed=4) as sim:
        unknown = Odometry(0.0, 0.0, 0.0, sim.dt * np.eye(3))
        driver = mjsim.Driver(estimator=LidarSlam(), navigator=Waypoints(WAY, speed=0.6))
        for tick in mjsim.ticks(sim, {"scout": driver}):
            seen.append(replace(tick.seen["scout"], odometry=unknown))
            truth.append(tick.truth["scout"].as_array())
            if tick.time > 20.0:
                return sim.robots["scout"], seen, np.array(truth)


def errors_of(estimator, drive):
    robot, seen, truth = drive
    estimator.start(robot, {}, np.random.default_rng(0))
    poses = np.array([estimator.update(each).pose.as_array() for each in seen])
    return np.hypot(*(poses - truth)[:, :2].T)


def walls_seen(looked):
    return looked, None if looked is None else walls_of(looked)


@pytest.mark.slow
def test_scans_alone_tell_the_way_of_a_robot_to_centimetres(drive):
    robot, seen, truth = drive
    assert np.hypot(*np.diff(truth[:, :2], axis=0).T).sum() > 9.0
    lidar, odometry, pose = LevelLidar(robot, None), ScanOdometry(), truth[0]
    errors = []
    for each, true in zip(seen, truth, strict=True):
        assert ScanOdometry.is_needed(each)
        step = odometry.update(each, *walls_seen(lidar.update(each)))
        pose = compose(pose, np.array([step.forward, step.left, step.turn]))
        errors.append(np.hypot(*(pose - true)[:2]))
    # 0.6 m/s and a scan every second tick: between scans, the pose is predicted.
    assert max(errors) < 0.25
    assert errors[-1] < 0.15


@pytest.mark.slow
def test_lidar_slam_needs_no_odometry(drive):
    errors = errors_of(LidarSlam(), drive)
    assert errors.mean() < 0.05
    assert errors.max() < 0.2


@pytest.mark.slow
def test_without_odometry_walls_are_found_once_in_each_scan(drive, monkeypatch):
    robot, seen, _ = drive
    found, slam = [], LidarSlam()
    surface_of = scan_walls.surface_of
    monkeypatch.setattr(scan_walls, "surface_of", lambda *args, **keys: found.append(1) or surface_of(*args, **keys))
    slam.start(robot, {}, np.random.default_rng(0))
    for each in seen[:200]:
        slam.update(each)
    assert len(slam.keyframes) > 2
    assert len(found) == sum("scan" in each.scans for each in seen[:200])


@pytest.mark.slow
def test_a_scan_that_waited_for_late_odometry_has_its_own_walls(drive, monkeypatch):
    robot, seen, _ = drive
    added, slam = [], LidarSlam()
    extend = slam._extend
    monkeypatch.setattr(slam, "_extend", lambda *given: added.append(given) or extend(*given))
    slam.start(robot, {}, np.random.default_rng(0))
    for each in seen[:200]:
        slam._odometry.delay.seconds = 0.16  # that of two scans: one comes when another is due
        slam.update(each)
    assert len(added) > 2
    for level_scan, walls in added:
        np.testing.assert_array_equal(walls.points, walls_of(level_scan).points)


@pytest.mark.slow
def test_ekf_slam_needs_no_odometry_where_it_sees_beacons(drive):
    # Five sightings a second of each beacon, to 0.05 m and a degree; in between, nothing tells the way.
    errors = errors_of(EkfSlam(jacobians="invariant"), drive)
    assert np.median(errors) < 0.3


def test_odometry_of_wheels_is_used_as_it_is():
    with mjsim.Simulation(mjsim.parse_world(ROOM), seed=4) as sim:
        sim.apply("scout", mjsim.Command(0.5, 0.0, 0.3))
        for _ in range(50):
            sim.step()
        assert not ScanOdometry.is_needed(sim.sense("scout"))


@pytest.mark.slow
def test_a_robot_that_stands_still_does_not_drift(drive):
    robot, seen, _ = drive
    lidar, odometry, way = LevelLidar(robot, None), ScanOdometry(), np.zeros(3)
    rng = np.random.default_rng(1)
    for k in range(250):
        scan = seen[0].scans["scan"] if k % 2 == 0 else None
        if scan is not None:
            noisy = scan.ranges + rng.normal(0.0, 0.02, len(scan.ranges))
            scan = replace(scan, stamp=0.04 * k, ranges=noisy)
        each = replace(seen[0], time=0.04 * k, scans={} if scan is None else {"scan": scan})
        step = odometry.update(each, *walls_seen(lidar.update(each)))
        way = compose(way, np.array([step.forward, step.left, step.turn]))
    assert np.hypot(*way[:2]) < 0.02
    assert abs(way[2]) < 0.01


@pytest.mark.parametrize("gyroscope", [None, 0.3])
def test_a_predicted_step_is_that_of_a_velocity_which_decays_with_random_accelerations(gyroscope):
    estimator, since = ScanOdometry(), 0.4
    velocity, A = np.array([0.8, 0.1, 0.5]), np.random.default_rng(3).normal(0.0, 0.1, (6, 6))
    estimator._velocity, estimator._P = velocity.copy(), A @ A.T
    if gyroscope is not None:
        estimator._turned, estimator._has_gyroscope = gyroscope, True
    before = estimator._P.copy()
    estimator._predict(since)
    # Van Loan, Computing Integrals Involving the Matrix Exponential, IEEE T-AC 23(3), 1978, of x' = v, v' = -v/T + w.
    zero, one = np.zeros((3, 3)), np.eye(3)
    dynamics = np.block([[zero, one], [zero, -one / LASTING]])
    power = np.block([[zero, zero], [zero, np.diag(2.0 * SPEED**2 / LASTING)]])
    both = expm(np.block([[-dynamics, power], [np.zeros((6, 6)), dynamics.T]]) * since)
    F = both[6:, 6:].T
    Q = F @ both[:6, 6:]
    step = F[:3, 3:] @ velocity
    if gyroscope is not None:
        step[2] = gyroscope
    np.testing.assert_allclose(estimator._pose, step, atol=1e-12)
    np.testing.assert_allclose(estimator._velocity, F[3:, 3:] @ velocity, atol=1e-12)
    # The pose errs in the frame of the robot, which has turned; a stamp errs by a share of the time between scans.
    F[:2, :2] = Rotation.from_euler("z", -step[2]).as_matrix()[:2, :2]
    Q[:3, :3] += np.diag(FLOOR**2 + (JITTER * since * (np.abs(velocity) + 0.3 * SPEED)) ** 2)
    expected = F @ before @ F.T + Q
    if gyroscope is not None:
        expected[2, :] = expected[:, 2] = 0.0
        expected[2, 2] = before[2, 2] + FLOOR[2] ** 2 + (GYROSCOPE * since) ** 2
    np.testing.assert_allclose(estimator._P, expected, atol=1e-12)


def test_a_correction_moves_the_velocity_as_a_kalman_filter_that_measures_the_pose():
    rng, estimator = np.random.default_rng(5), ScanOdometry()
    A, B = rng.normal(0.0, 0.3, (6, 6)), rng.normal(0.0, 0.1, (3, 3))
    P, R, error, H = A @ A.T, B @ B.T, rng.normal(0.0, 0.1, 3), np.eye(3, 6)
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    estimator._P = P.copy()
    # A match leaves the pose where the measurement and the prediction together put it.
    estimator._correct(K[:3] @ error, (np.eye(6) - K @ H)[:3] @ P[:, :3])
    np.testing.assert_allclose(estimator._velocity, K[3:] @ error, atol=1e-10)
    np.testing.assert_allclose(estimator._P, (np.eye(6) - K @ H) @ P, atol=1e-10)
