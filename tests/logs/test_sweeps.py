"""Scans of a lidar that moves while it turns."""

import math

import numpy as np
import pytest

from mjsim.geometry import Pose, Pose3
from mjsim.interface import Scan, swept
from mjsim.logs import Wishes
from tests.bags import START, new_bag
from tests.real_logs import imported

HALF = 3.0
"""Half the width of a square room [m]."""


def _range(place: Pose, angle: float) -> float:
    """Return the distance to the wall of the room along an angle from a place in it [m]."""
    c, s = math.cos(place.heading + angle), math.sin(place.heading + angle)
    across = ((math.copysign(HALF, d) - at) / d for at, d in ((place.x, c), (place.y, s)) if abs(d) > 1e-12)
    return min(across)


def _driven(time: float) -> Pose:
    """Return where a robot is that drives 1 m/s on a circle, 1.5 rad/s [s]."""
    turned = 1.5 * time
    return Pose(math.sin(turned) / 1.5, (1.0 - math.cos(turned)) / 1.5, turned)


MOUNT = Pose(0.2, -0.1, 0.5)


def _lidar(time: float) -> Pose:
    return _driven(time) @ MOUNT


@pytest.mark.parametrize("span", [2.0 * math.pi, math.radians(270.0)])
def test_a_scan_taken_on_the_way_is_as_one_taken_at_its_end(span):
    beams, end, lasting = 720, 0.6, 0.1
    step = span / beams
    angles = -span / 2.0 + step * np.arange(beams)
    times = np.linspace(-lasting, 0.0, beams)
    measured = [_range(_lidar(end + time), angle) for time, angle in zip(times, angles, strict=True)]
    still = np.array([_range(_lidar(end), angle) for angle in angles])
    track = np.array([[t, *_driven(t).as_array()] for t in np.arange(0.0, 1.0, 0.02)])
    scan = swept(Scan(end, np.array(measured), angles[0], step, 0.1, 20.0), times, track, MOUNT)
    known = np.isfinite(scan.ranges)
    # A turn of 8.6 degrees leaves as much of a part of a circle unseen.
    assert known.mean() > (0.999 if span > 6.0 else 0.96)
    assert np.abs(np.array(measured) - still).max() > 0.3
    # Corners between two beams.
    assert np.quantile(np.abs(scan.ranges - still)[known], 0.99) < 0.01
    assert np.abs(scan.ranges - still)[known].max() < 0.05


def test_a_scan_of_a_robot_that_stands_and_beams_without_return_stay():
    ranges = np.array([1.0, np.inf, -np.inf, 2.0])
    scan = Scan(1.0, ranges, 0.0, 0.1, 0.1, 5.0, np.arange(4.0))
    times, track = np.linspace(-0.1, 0.0, 4), np.array([[0.0, 1.0, 2.0, 3.0], [2.0, 1.0, 2.0, 3.0]])
    assert swept(scan, times, track, MOUNT) is scan
    moved = swept(scan, times, track + np.array([[0, 0, 0, 0], [0, 0.02, 0, 0]]), MOUNT)
    np.testing.assert_allclose(moved.ranges, ranges, atol=2e-3)
    np.testing.assert_array_equal(moved.intensities, np.arange(4.0))


@pytest.mark.parametrize("sense", [1, -1])
def test_the_beams_of_a_bag_are_where_they_were_measured(sense, tmp_path):
    beams, increment = 360, 0.08 / 359
    step = sense * 2.0 * math.pi / beams
    with new_bag(tmp_path / "run") as bag:
        for k in range(60):
            time = 0.02 * k
            pose = Pose3.from_planar(_driven(time))
            bag.put("/odom", START + time, bag.odometry(bag.header(START + time, "odom"), "base_link", pose))
        for k in range(10):
            time = 0.1 * k
            ranges = [_range(_driven(time + increment * n), step * n) for n in range(beams)]
            told = bag.scan(bag.header(START + time, "base_link"), np.array(ranges), 0.0, step, (0.1, 20.0))
            told.time_increment = increment
            bag.put("/scan", START + time + 0.08, told)
        bag.transforms("/tf_static", START, [("base_link", "other", np.eye(4))])
    raw = imported(tmp_path / "run")
    assert raw.metadata["sweep of scan"] == "0.080 s; beams stay as measured without --deskew"
    first = next(seen.scans["scan"] for seen in raw.observations("robot") if seen.scans)
    assert first.stamp == pytest.approx(0.0, abs=1e-6)
    measured = sorted(_range(_driven(increment * n), step * n) for n in range(beams))
    np.testing.assert_allclose(np.sort(first.ranges), measured, rtol=1e-6)
    run = imported(tmp_path / "run", wishes=Wishes(deskew=True))
    scans = [seen.scans["scan"] for seen in run.observations("robot") if seen.scans]
    assert len(scans) == 10
    for k, scan in enumerate(scans):
        end = 0.1 * k + 0.08
        assert scan.stamp == pytest.approx(end, abs=1e-6)
        still = np.array([_range(_driven(end), angle) for angle in scan.angles()])
        assert np.quantile(np.abs(scan.ranges - still), 0.97) < 0.02


def test_a_duration_that_cannot_be_is_not_used(tmp_path):
    with new_bag(tmp_path / "run") as bag:
        for k in range(10):
            at = START + 0.1 * k
            told = bag.scan(bag.header(at, "laser"), np.full(100, 2.0), 0.0, 0.01, (0.1, 5.0))
            told.time_increment = 0.01
            bag.put("/scan", at, told)
            pose = Pose3.from_planar(Pose(0.1 * k, 0.0, 0.0))
            bag.put("/odom", at, bag.odometry(bag.header(at, "odom"), "base_link", pose))
    run = imported(tmp_path / "run", wishes=Wishes(deskew=True))
    scans = [seen.scans["scan"] for seen in run.observations("robot") if seen.scans]
    np.testing.assert_array_equal([scan.ranges for scan in scans], np.full((10, 100), 2.0))
    np.testing.assert_allclose([scan.stamp for scan in scans], 0.1 * np.arange(10), atol=1e-6)
