"""Rooms of landmarks: what hides them, and sensors with faults."""

import math

import numpy as np
import pytest

from mjsim.bench.disturbed import Disturbance, Errors
from mjsim.bench.landmark_rooms import ROOMS, Faults
from mjsim.interface import Odometry, Sighting


def test_a_block_hides_what_is_behind_it_and_not_what_is_beside():
    ring, robot = ROOMS["ring"], np.array([1.5, 1.5])
    assert not ring.shows(np.array([13.8, 8.0]), 0.0, robot)
    assert ring.shows(np.array([11.0, 0.2]), 0.0, robot)


def test_a_door_is_open_half_of_the_time_and_when_the_robot_is_near():
    doors, beyond = ROOMS["doors"], np.array([11.0, 2.0])
    far = [doors.shows(beyond, 0.5 * k, np.array([1.0, 2.0])) for k in range(40)]
    assert sum(far) == 20
    assert all(doors.shows(beyond, 0.5 * k, np.array([5.5, 2.0])) for k in range(40))


def test_faults_change_what_sensors_tell():
    told = Faults(distance=1.1, turn=0.5, drift=0.1).of_odometry(Odometry(1.0, 0.0, 0.2, np.eye(3)), 0.0)
    assert (told.forward, told.turn) == pytest.approx((1.1, 0.104))
    seen = Faults(bearing=0.1, range=2.0).of_sighting(Sighting(0.0, "a", 1.0, math.pi - 0.05, np.eye(2)))
    assert (seen.range, seen.bearing) == pytest.approx((2.0, 0.05 - math.pi))


def test_a_disturbance_may_come_again():
    push = Disturbance(20.0, 1.0, every=20.0)
    assert [time for time in range(0, 80, 10) if push.acts(time)] == [20, 40, 60]
    assert [time for time in range(0, 80, 10) if Disturbance(20.0, 1.0).acts(time)] == [20]


def test_the_longest_time_surely_wrong_has_no_break():
    nees = np.array([30.0, 1.0, 30.0, 30.0, 2.0, 26.0])
    assert Errors(nees, nees, nees, nees, nees).longest_wrong() == pytest.approx(0.08)
