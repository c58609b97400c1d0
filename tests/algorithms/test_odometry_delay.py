"""Odometry that is older or newer than the scans with its stamps, as in many logs."""

from collections import deque
from dataclasses import replace

import numpy as np
import pytest

import mjsim
from mjsim.algorithms.lidar_slam import LidarSlam
from mjsim.algorithms.scans.odometry_delay import OdometryDelay, retimed
from mjsim.geometry import wrap_angles
from mjsim.interface import Odometry

ROOM = """
mjsim: 1
name: room
walls: [{points: [[0, 0], [6, 0], [6, 3], [4, 3], [4, 5], [0, 5]], closed: true}]
robots:
  - name: scout
    preset: pioneer3dx
    at: [2, 2]
    odometry: {noise: {distance: 0.02, turn: 0.04}}
    sensors: [{lidar: scan, beams: 180, fov_deg: 180, range: [0.05, 20], rate_hz: 5, noise: {range: 0.01}}]
"""


def heading(time):
    """Return the heading of a robot that turns to and fro."""
    return np.cumsum(np.where(np.sin(1.3 * time) > 0.0, 0.06, -0.06) * (np.abs(np.sin(1.3 * time)) > 0.4))


def estimated(late, *, gain=1.0, slips=0.0):
    """Return the delay that is found in 40 s of turns, with odometry as late as given."""
    rng, delay = np.random.default_rng(1), OdometryDelay()
    times = np.arange(0.0, 40.0, 0.1)
    true = heading(times)
    told = gain * np.interp(times - late, times, true) + np.cumsum(
        slips * rng.normal(size=len(times)) * (rng.random(len(times)) < 0.01)
    )
    before = 0
    for number, time in enumerate(times.tolist()):
        delay.move(told[number] - told[max(number - 1, 0)], time)
        if number % 5 == 0:
            delay.add(time, true[number] - true[before] + rng.normal(0.0, 0.005), 0.5, 0.02**2)
            before = number
    return delay.seconds


@pytest.mark.parametrize("late", [0.25, -0.15])
def test_the_delay_of_odometry_is_found_though_turns_are_told_too_large_and_wheels_slip(late):
    assert abs(estimated(late, gain=1.08, slips=0.4) - late) < 0.03


def test_odometry_of_the_time_of_the_scans_has_no_delay():
    assert estimated(0.0) == 0.0
    assert estimated(0.0, gain=1.08, slips=0.4) == 0.0


def test_poses_of_late_odometry_are_put_where_the_robot_was_by_then():
    times = np.arange(0.0, 5.0, 0.1)
    true = np.stack([0.5 * times, 0.0 * times, wrap_angles(times)], axis=-1)
    late = np.stack([0.5 * (times - 0.2), 0.0 * times, wrap_angles(times - 0.2)], axis=-1)
    np.testing.assert_allclose(retimed(times, times - 0.2, list(late))[:-2], true[:-2], atol=1e-9)
    np.testing.assert_array_equal(retimed(times, times, list(true)), true)


@pytest.mark.slow
@pytest.mark.parametrize("late", [6, -4])
def test_the_path_and_the_belief_are_those_of_the_scans_though_odometry_is_late_or_early(late):
    seen, truth, estimator = list[mjsim.Observation](), list[np.ndarray](), LidarSlam()
    with mjsim.Simulation(mjsim.parse_world(ROOM), seed=2) as sim:
        robot = sim.robots["scout"]
        for tick in range(500):
            seen.append(sim.sense("scout"))
            truth.append(sim.truths()["scout"].as_array())
            sim.apply("scout", mjsim.Command(0.0, 0.0, (1.2, 0.0, -1.2, 0.0)[tick // 25 % 4]))
            sim.step()
    estimator.start(robot, {}, np.random.default_rng(0))
    rest = Odometry(0.0, 0.0, 0.0, seen[0].odometry.covariance)
    told = deque(each.odometry for each in seen)
    told.rotate(late)
    online = []
    for number, each in enumerate(seen):
        odometry = told[number] if number and 0 <= number - late < len(seen) else rest
        online.append(estimator.update(replace(each, odometry=odometry)).pose.heading)
    final = np.array([pose.heading for _, pose in estimator.path()])
    by_path, by_belief = (np.abs(wrap_angles(each - np.array(truth)[:, 2]))[250:450] for each in (final, online))
    # Odometry lags behind by up to 0.24 s of 1.2 rad/s.
    assert by_path.mean() < 0.015
    assert by_belief.mean() < (0.1 if late > 0 else 0.03)
