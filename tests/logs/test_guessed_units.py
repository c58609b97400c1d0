"""Bags whose units are not those of ROS: readings come in as a robot can have them, and what was guessed is told."""

import numpy as np
import pytest

from mjsim.geometry import Pose, Pose3
from mjsim.logs import listed
from tests.bags import START, new_bag
from tests.real_logs import imported


def test_units_of_clouds_and_limits_of_scans_that_are_guessed_are_told(tmp_path):
    points = np.zeros((1, 60), dtype=[("x", "<i2"), ("y", "<i2"), ("z", "<i2"), ("t", "<u4")])
    points["x"], points["t"] = 4000, np.linspace(0, 99_000, 60)
    with new_bag(tmp_path / "run") as bag:
        for k in range(5):
            header = bag.header(START + 0.1 * k, "laser")
            bag.put("/points", START + 0.1 * k, bag.cloud(header, points))
            bag.put("/scan", START + 0.1 * k, bag.scan(header, np.ones(9), 0.0, 0.1, (0.0, 0.0)))
    run = imported(tmp_path / "run")
    cloud = next(cloud for seen in run.observations("robot") for cloud in seen.clouds.values())
    np.testing.assert_allclose(cloud.points, [[4.0, 0.0, 0.0]] * 60, rtol=1e-6)
    np.testing.assert_allclose(cloud.times, np.linspace(-0.099, 0.0, 60), atol=2e-6)
    told = "\n".join(listed(run))
    assert "guessed: coordinates of points of cloud: mm, not m: the farthest point is at 4000" in told
    assert "guessed: times of points of cloud: 't' in us, so that a scan lasts 0.099 s" in told
    assert "guessed: range limits of scan: 0.01 to 100 m; the bag gives 0 to 0" in told


def test_readings_in_units_that_no_robot_reaches_are_in_those_that_it_does(tmp_path):
    with new_bag(tmp_path / "run") as bag:
        for k in range(12):
            at = START + 0.1 * k
            moved = Pose3.from_planar(Pose(50.0 * k, 0.0, 0.0))
            bag.put("/odom", at, bag.odometry(bag.header(at, "odom"), "base_link", moved))
            bag.put("/scan", at, bag.scan(bag.header(at, "base_link"), np.full(9, 2500.0), 0.0, 0.1, (150.0, 12e3)))
            bag.put(
                "/imu", at, bag.imu(bag.header(at, "base_link"), np.array([0.0, 0.0, 1.01]), np.array([0, 0, 90.0]))
            )
            bag.put("/good", at, bag.imu(bag.header(at, "base_link"), np.array([0.0, 0.0, 9.8]), np.array([0, 0, 1.5])))
    run = imported(tmp_path / "run")
    scan = next(seen.scans["scan"] for seen in run.observations("robot") if seen.scans)
    np.testing.assert_allclose(scan.ranges, 2.5, rtol=1e-6)
    assert (scan.range_min, scan.range_max) == pytest.approx((0.15, 12.0))
    readings = [reading for seen in run.observations("robot") for reading in seen.imu]
    assert {round(float(each.acceleration[2]), 3) for each in readings} == {9.905, 9.8}
    assert {round(float(each.turn[2]), 4) for each in readings} == {1.5708, 1.5}
    told = "\n".join(listed(run))
    assert "guessed: range limits of scan: 0.15 to 12 m; the bag gives 150 to 1.2e+04, which can only be in mm" in told
    assert "guessed: acceleration of imu: in g, not m/s^2: its median is 1.01" in told
    assert "guessed: turn rate of imu: in deg/s, not rad/s: it reaches 90" in told
    assert "guessed: speed of odometry: 500 m/s (median)" in told
    assert "of good" not in told
