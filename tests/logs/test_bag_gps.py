"""Fixes of a satellite receiver in a bag: places in local metres, and the truth of a robot made of them."""

import math

import numpy as np
import pytest

import mjsim
from mjsim.geometry import Pose, Pose3, wrap_angles
from mjsim.logs import Wishes
from mjsim.logs.bags.bag_gps import Fix, east_north
from tests.bags import START, new_bag
from tests.real_logs import imported

LATITUDE, LONGITUDE, HEIGHT = 48.1, 11.6, 520.0
"""Of the start of a drive [deg, deg, m]."""
ANTENNA = (-0.4, 0.3)
"""Of the robot, ahead and to the left [m]."""
MIDDLE, TURN, SPEED = Pose(12.0, -5.0, 2.0), 0.05, 1.0
"""The robot starts here in the map of east and north, and drives a circle [rad/s, m/s]."""


def degrees_at(east: float, north: float) -> tuple[float, float, float]:
    """Return latitude, longitude and altitude near the start, by the radii of curvature of the ellipsoid of WGS 84.

    References:
        Torge, Müller, Geodesy, 4th edition, 2012, section 4.1.2: meridian and prime vertical.
    """
    sine, squared = math.sin(math.radians(LATITUDE)), 0.00669437999014
    prime = 6378137.0 / math.sqrt(1.0 - squared * sine**2)
    meridian = prime * (1.0 - squared) / (1.0 - squared * sine**2)
    return (
        LATITUDE + math.degrees(north / (meridian + HEIGHT)),
        LONGITUDE + math.degrees(east / ((prime + HEIGHT) * math.cos(math.radians(LATITUDE)))),
        HEIGHT,
    )


def fix_at(east: float, north: float) -> Fix:
    latitude, longitude, height = degrees_at(east, north)
    return Fix(0.0, math.radians(latitude), math.radians(longitude), height, 1.0)


def test_places_near_the_start_are_metres_east_and_north():
    places = np.random.default_rng(0).uniform(-100.0, 100.0, (50, 2))
    found = east_north([fix_at(0.0, 0.0), *(fix_at(*place) for place in places.tolist())])
    # Over 140 m, meridians converge by 1.7 mm, and the plane leaves the ellipsoid by as much.
    np.testing.assert_allclose(found[1:], places, atol=4e-3)


def test_places_are_right_at_the_poles_the_equator_and_the_date_line():
    squared, quarter = 0.00669437999014, math.pi / 2
    pole = east_north([Fix(0.0, quarter, 0.0, 0.0, 1.0), Fix(0.0, quarter, 2.0, 0.0, 1.0)])
    np.testing.assert_allclose(pole, 0.0, atol=1e-9)
    # From the equator the pole is the semi-minor axis to the north.
    (_, north) = east_north([Fix(0.0, 0.0, 0.5, 0.0, 1.0), Fix(0.0, quarter, 0.5, 0.0, 1.0)])
    np.testing.assert_allclose(north, [0.0, 6378137.0 * math.sqrt(1.0 - squared)], atol=1e-5)
    (_, east) = east_north([Fix(0.0, 0.0, math.pi - 1e-6, 0.0, 1.0), Fix(0.0, 0.0, 1e-6 - math.pi, 0.0, 1.0)])
    np.testing.assert_allclose(east, [2e-6 * 6378137.0, 0.0], atol=1e-3)


def place_at(time: float) -> Pose:
    """Return the pose of the robot in the map of east and north, which begins at the first place of the antenna."""
    radius = SPEED / TURN
    arc = Pose(radius * math.sin(TURN * time), radius * (1.0 - math.cos(TURN * time)), TURN * time)
    return Pose(0.0, 0.0, MIDDLE.heading) @ arc


def antenna_at(time: float) -> tuple[float, float]:
    place, start = (pose @ Pose(*ANTENNA, 0.0) for pose in (place_at(time), place_at(0.0)))
    return place.x - start.x, place.y - start.y


def write_drive(path, *, topics=("/gps/fix",), deviation=0.02, seconds=40, moves=True) -> None:
    """Write a drive with fixes at 2 Hz, odometry in another frame, and scans."""
    place = np.eye(4)
    place[:2, 3] = ANTENNA
    rng = np.random.default_rng(1)
    with new_bag(path) as bag:
        bag.transforms("/tf_static", START, [("base_link", "gps", place)])
        for k in range(10 * seconds):
            at, pose = START + 0.1 * k, place_at(0.1 * k if moves else 0.0)
            told = bag.odometry(bag.header(at, "odom"), "base_link", Pose3.from_planar(place_at(0.0).inverse() @ pose))
            bag.put("/odom", at, told)
            bag.put("/scan", at, bag.scan(bag.header(at, "base_link"), np.ones(9), -0.4, 0.1, (0.1, 50.0)))
            for topic in topics if k % 5 == 0 else ():
                east, north = np.array(antenna_at(0.1 * k if moves else 0.0)) + rng.normal(0.0, deviation or 0.0, 2)
                # Every twentieth time there is no fix, and once it jumps.
                status = -1 if k % 100 == 50 else 0
                east += 30.0 if k == 205 else 0.0
                fix = bag.fix(bag.header(at, "gps"), degrees_at(east, north), status=status, deviation=deviation)
                bag.put(topic, at, fix)


@pytest.mark.slow
def test_the_truth_of_a_bag_with_fixes_is_where_the_robot_was_in_metres_from_the_first(tmp_path):
    write_drive(tmp_path / "bag")
    run = imported(tmp_path / "bag")
    track = run.robots["robot"]
    start = place_at(0.0) @ Pose(*ANTENNA, 0.0)
    since = track.moments + float(run.metadata["log start"]) - START
    expected = np.array([place_at(time).as_array() for time in since.tolist()])
    expected[:, :2] -= start.x, start.y
    known = np.isfinite(track.truth).all(axis=1)
    # Half a second around a missing fix is unknown, and the first fix is the origin, with its error.
    assert known.mean() > 0.8
    off = track.truth[known] - expected[known]
    assert np.hypot(off[:, 0], off[:, 1]).max() < 0.12
    assert np.abs(wrap_angles(off[:, 2])).max() < 0.02
    assert run.metadata["outlier fixes left out"] == "1"
    assert run.metadata["/gps/fix messages left out"] == "4"
    told = run.metadata["truth"]
    assert told.startswith("75 fixes of topic /gps/fix; x is east and y is north of latitude 48.1")
    assert told.endswith("standard deviation 0.02 m, as reported")
    assert mjsim.statistics(run)["robot"]["odometry_error_m"]["max"] < 0.15


@pytest.mark.slow
def test_fixes_that_are_no_truth_are_said_to_be_left_out(tmp_path):
    write_drive(tmp_path / "two", topics=("/front/fix", "/rear/fix"), seconds=20)
    run = imported(tmp_path / "two")
    assert np.isnan(run.robots["robot"].truth).all()
    assert run.metadata["/front/fix left out"] == "40 messages of sensor_msgs/msg/NavSatFix"
    run = imported(tmp_path / "two", wishes=Wishes(topics={"gps": ["/front/fix"]}))
    assert run.metadata["truth"].startswith("38 fixes of topic /front/fix;")
    assert "/rear/fix left out" in run.metadata
    write_drive(tmp_path / "still", seconds=5, moves=False)
    run = imported(tmp_path / "still")
    assert run.metadata["truth"] == "left out: without odometry the heading at 10 fixes of /gps/fix is unknown"


def test_fixes_that_do_not_report_an_accuracy_are_used_and_it_is_said(tmp_path):
    write_drive(tmp_path / "bag", deviation=None, seconds=5)
    run = imported(tmp_path / "bag")
    assert run.metadata["truth"].endswith("standard deviation not reported")
