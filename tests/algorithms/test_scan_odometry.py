"""Scans of a robot whose odometry says nothing."""

from dataclasses import replace

import numpy as np
import pytest

import mjsim
from mjsim.algorithms.ekf_slam.ekf_slam import EkfSlam
from mjsim.algorithms.estimation.pose_graph import compose
from mjsim.algorithms.lidar_slam import LidarSlam
from mjsim.algorithms.scans import scan_walls
from mjsim.algorithms.scans.level_scan import LevelLidar
from mjsim.algorithms.scans.scan_odometry import ScanOdometry
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
