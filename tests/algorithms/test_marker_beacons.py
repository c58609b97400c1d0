"""Markers read in drawn views: which, where, how surely, near and far."""

import cv2
import numpy as np
import pytest

from mjsim.algorithms.beacon_vision.beacon_vision import BeaconVision, MarkerBeacons
from mjsim.bench.views import INTRINSICS, MARKERS, Studio, Tally, marker_room, marker_sizes
from mjsim.interface import BeaconInfo, CameraFrame, MarkerInfo, Observation, Odometry, SensorInfo
from tests.robots import pioneer

WIDTH = 0.6


@pytest.fixture(scope="module")
def studio():
    studio = Studio(marker_room("4x4_50", WIDTH), marker_sizes(WIDTH))
    yield studio
    studio.canvas.close()


def finder(names=MARKERS):
    return MarkerBeacons("4x4_50", WIDTH, names={number: name for name, number in names.items()})


@pytest.mark.slow
def test_a_marker_is_found_where_it_hangs_and_strangers_are_not_reported(studio):
    rng = np.random.default_rng(1)
    for name, distance, yaw in (("tag-0", 1.5, 0.0), ("tag-5", 4.0, 30.0), ("tag-11", 7.5, -20.0)):
        shot = studio.before(name, distance, yaw, rng=rng)
        found = {each.name: each for each in finder().detect(shot.image, INTRINSICS)}
        assert set(found) <= set(MARKERS)
        np.testing.assert_allclose(found[name].position, shot.positions[name], atol=0.004 * distance)


@pytest.mark.slow
def test_without_names_it_is_called_by_its_number_and_its_corners_are_those_of_the_black_square(studio):
    shot = studio.before("tag-3", 2.0, 10.0)
    found = {each.name: each for each in MarkerBeacons("4x4_50", WIDTH).detect(shot.image, INTRINSICS)}
    corners = found["9"].corners
    seen, numbers, _ = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)).detectMarkers(
        cv2.cvtColor(shot.image, cv2.COLOR_RGB2GRAY)
    )
    expected = seen[numbers.ravel().tolist().index(9)].reshape(4, 2)
    np.testing.assert_allclose(corners, expected, atol=1.0)


@pytest.mark.slow
@pytest.mark.parametrize("dictionary", ["5x5_100", "apriltag_36h11", "apriltag_16h5"])
def test_markers_of_another_dictionary_are_never_reported(studio, dictionary):
    others, rng = MarkerBeacons(dictionary, WIDTH), np.random.default_rng(2)
    for name, distance, yaw in (("tag-1", 1.5, 0.0), ("tag-6", 3.0, 30.0), ("tag-10", 7.0, -10.0)):
        assert others.detect(studio.before(name, distance, yaw, rng=rng).image, INTRINSICS) == []


def test_an_unknown_dictionary_is_an_error():
    with pytest.raises(ValueError, match="no dictionary '4x4_51'"):
        MarkerBeacons("4x4_51", 0.3)


@pytest.mark.slow
def test_the_observer_follows_a_marker_of_the_catalogue(studio):
    vision = BeaconVision()
    camera = SensorInfo(kind="camera", robot_from_sensor=np.eye(4), rate_hz=12.5, intrinsics=INTRINSICS)
    catalogue = {
        name: BeaconInfo(name, None, WIDTH, WIDTH, marker=MarkerInfo("4x4_50", number))
        for name, number in MARKERS.items()
    }
    vision.start(pioneer(sensors={"front": camera}), catalogue, np.random.default_rng(0))
    shot = studio.before("tag-4", 3.0, 15.0)
    for k in range(3):
        frame = CameraFrame(0.08 * k, shot.image, INTRINSICS)
        still = Odometry(0.0, 0.0, 0.0, np.eye(3))
        sightings = vision.observe(Observation(0.08 * k, 0.08, still, cameras={"front": frame}))
        assert "tag-4" in {sighting.name for sighting in sightings}


@pytest.mark.slow
@pytest.mark.parametrize("dictionary", ["4x4_50", "apriltag_36h11"])
def test_markers_are_found_and_measured_from_1_to_8_metres_and_45_degrees(dictionary):
    studio, rng, tally = Studio(marker_room(dictionary, WIDTH), marker_sizes(WIDTH)), np.random.default_rng(4), Tally()
    markers = MarkerBeacons(dictionary, WIDTH, names={number: name for name, number in MARKERS.items()})
    for k in range(24):
        name, yaw = f"tag-{k % 12}", float(rng.uniform(-45.0, 45.0))
        shot = studio.before(name, float(rng.uniform(1.3, 8.0)), yaw, aside_deg=float(rng.uniform(-12, 12)), rng=rng)
        tally.add(name, yaw, shot, markers.detect(shot.image, INTRINSICS))
    studio.canvas.close()
    assert tally.gross == 0
    assert tally.found[30][0] >= 0.95 * tally.found[30][1] > 8
    assert tally.found[45][0] >= 0.85 * tally.found[45][1] > 3
    median = np.median(tally.errors, axis=0)
    assert median[0] < 0.01
    assert median[1] < 0.1
    assert 1.0 < np.mean(tally.distances) < 4.5
