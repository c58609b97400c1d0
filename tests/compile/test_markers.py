"""ArUco and AprilTag beacons: any of OpenCV's dictionaries, read back from pictures of the simulated camera."""

import cv2
import numpy as np
import pytest

import mjsim
from mjsim.compile import marker_picture
from mjsim.errors import WorldError
from mjsim.world import modules_across, parse_world
from mjsim.world.items.markers import DICTIONARIES

ROOM = """
mjsim: 1
walls: [{{points: [[4.05, -3], [4.05, 3]]}}]
beacons:
  - name: tag
    marker: {{dictionary: {dictionary}, id: {id}}}
    at: [4, 0.3]
    heading_deg: 180
    width: 0.3
    center: 0.5
robots:
  - name: scout
    at: [{x}, 0]
    sensors: [{{camera: front, at: [0, 0, 0.35], width: 640, height: 480, fov_deg: 60, rate_hz: 25}}]
"""
OPENCV = {
    "4x4_50": cv2.aruco.DICT_4X4_50,
    "5x5_1000": cv2.aruco.DICT_5X5_1000,
    "7x7_250": cv2.aruco.DICT_7X7_250,
    "original": cv2.aruco.DICT_ARUCO_ORIGINAL,
    "mip_36h12": cv2.aruco.DICT_ARUCO_MIP_36h12,
    "apriltag_16h5": cv2.aruco.DICT_APRILTAG_16h5,
    "apriltag_36h11": cv2.aruco.DICT_APRILTAG_36h11,
}


def seen(dictionary, number, *, x):
    """Corners, shape (4, 2) [px], and the camera's picture."""
    world = parse_world(ROOM.format(dictionary=dictionary, id=number, x=x))
    with mjsim.Simulation(world) as simulation:
        frame = simulation.sense("scout").cameras["front"]
    found, ids = detected(frame.image, dictionary)
    assert ids == [number]
    return found[0], frame


def detected(picture, dictionary):
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(OPENCV[dictionary]), parameters)
    corners, ids, _ = detector.detectMarkers(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY))
    return [corner.reshape(4, 2) for corner in corners], [] if ids is None else np.ravel(ids).tolist()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("dictionary", "number"), [("4x4_50", 7), ("apriltag_36h11", 586), ("original", 1023), ("7x7_250", 0)]
)
def test_a_marker_on_the_wall_is_read_and_lies_where_the_world_says(dictionary, number):
    corners, frame = seen(dictionary, number, x=2.0)
    half = 0.15  # the width is that of the black square
    square = np.array([[-half, half, 0], [half, half, 0], [half, -half, 0], [-half, -half, 0]])
    K = frame.intrinsics.matrix()
    _, _, place = cv2.solvePnP(square, corners.astype(float), K, None, flags=cv2.SOLVEPNP_IPPE_SQUARE)
    # 0.3 m to the left and 0.15 m above the camera, whose z looks ahead; 2 m ahead but for the face of the wall.
    # The corners are good to a tenth of a pixel, of 83 px that the square is wide.
    np.testing.assert_allclose(place.ravel(), [-0.3, -0.15, 2.0], atol=0.012)


@pytest.mark.slow
def test_a_marker_is_read_eight_metres_away():
    seen("4x4_50", 49, x=-4.0)


@pytest.mark.parametrize("dictionary", OPENCV)
def test_the_picture_of_a_marker_has_whole_modules_and_a_white_border(dictionary):
    picture = marker_picture(dictionary, 3)
    modules = modules_across(dictionary) + 2
    side = picture.shape[0] // modules
    assert picture.shape == (modules * side, modules * side, 3)
    blocks = picture[..., 0].reshape(modules, side, modules, side)
    assert (blocks == blocks[:, :1, :, :1]).all()
    assert (blocks[[0, -1]] == 255).all()
    assert (blocks[1, :, 1:-1] == 0).all()
    assert detected(picture, dictionary)[1] == [3]


def test_every_dictionary_of_opencv_has_the_markers_that_we_say():
    by_name = {name.removeprefix("DICT_").removeprefix("ARUCO_").lower(): name for name in dir(cv2.aruco)}
    known = {name for name, original in by_name.items() if original.startswith("DICT_")}
    assert set(DICTIONARIES) == known
    for name, (modules, count) in DICTIONARIES.items():
        dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, by_name[name]))
        assert (dictionary.markerSize, len(dictionary.bytesList)) == (modules, count)


@pytest.mark.parametrize(
    ("marker", "message"),
    [
        ("{id: 50}", "world.yaml:2:46: id is 50; the dictionary 4x4_50 has ids from 0 to 49"),
        (
            "{dictionary: apriltag_36h1, id: 5}",
            "world.yaml:2:54: no dictionary 'apriltag_36h1'; did you mean 'apriltag_36h11'?",
        ),
    ],
)
def test_a_marker_outside_its_dictionary_is_an_error_at_its_place(marker, message):
    with pytest.raises(WorldError) as caught:
        parse_world(f"mjsim: 1\nbeacons: [{{name: a, at: [1, 2], marker: {marker}}}]")
    assert str(caught.value).startswith(message)


def test_modules_are_told_which_marker_a_beacon_is_but_not_where():
    world = parse_world(ROOM.format(dictionary="5x5_1000", id=999, x=0))
    with mjsim.Simulation(world) as simulation:
        info = simulation.catalogue["tag"]
    assert info.marker == mjsim.MarkerInfo("5x5_1000", 999)
    assert (info.width, info.height, info.picture, info.pose) == (0.3, 0.3, None, None)
