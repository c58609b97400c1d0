"""Pictures, sweeps and old logs, decoded from bytes and lines that are written here by their standards."""

import math
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from mjsim.errors import UsageError
from mjsim.geometry import Pose
from mjsim.interface import Scan, swept
from mjsim.logs.bags.bag_order import set_backs
from mjsim.logs.bags.bag_pictures import _picture, shown_depth
from mjsim.logs.formats.carmen import _Found, _take
from mjsim.logs.formats.mrclam import _number, _numbers
from mjsim.logs.resampling.resample import (
    MotionNoise,
    motions,
    restarts_of,
    track_motions,
    track_of,
    unknown_motion,
)


def image(encoding: str, rows: np.ndarray, *, height: int = 4, width: int = 6, big: bool = False, pad: int = 3):
    """Return a message whose rows are padded."""
    data = np.zeros((len(rows), rows.shape[1] + pad), np.uint8)
    data[:, : rows.shape[1]] = rows
    return SimpleNamespace(
        encoding=encoding, data=data.ravel(), step=data.shape[1], height=height, width=width, is_bigendian=big
    )


RGB = np.random.default_rng(3).integers(0, 256, (4, 6, 3), dtype=np.uint8)


@pytest.mark.parametrize(
    ("encoding", "rows", "big"),
    [
        ("rgb8", RGB.reshape(4, -1), False),
        ("bgr8", RGB[..., ::-1].reshape(4, -1), False),
        ("rgba8", np.dstack([RGB, np.full((4, 6), 9, np.uint8)]).reshape(4, -1), False),
        ("rgb16", (RGB.astype("<u2") * 256 + 7).view(np.uint8).reshape(4, -1), False),
        ("bgr16", (RGB[..., ::-1].astype(">u2") * 256 + 7).astype(">u2").view(np.uint8).reshape(4, -1), True),
    ],
)
def test_pixels_are_red_green_and_blue_whatever_their_order(encoding, rows, big):
    assert np.array_equal(_picture(image(encoding, rows, big=big)), RGB)


def test_grey_and_halved_colours_are_grey():
    grey = RGB[..., 0]
    assert np.array_equal(_picture(image("mono8", grey)), np.repeat(grey[..., None], 3, axis=2))
    # Luma alone, with neutral colour.
    planes = np.concatenate([np.full((4, 6), 126, np.uint8), np.full((2, 6), 128, np.uint8)])
    for height in (4, 6):  # some count the rows of colour, too
        found = _picture(image("nv21", planes, height=height, pad=0))
        assert found.shape == (4, 6, 3)
        assert np.ptp(found) <= 1
    with pytest.raises(ValueError, match="not supported"):
        _picture(image("hsv8", grey))
    for rows, keys in ((RGB.reshape(4, -1)[:, :17], {}), (RGB.reshape(4, -1), {"height": 5})):
        with pytest.raises(ValueError, match=r"a picture of 6 x . pixels in"):
            _picture(image("rgb8", rows, pad=0, **keys))


def test_near_depth_is_bright_and_missing_depth_black():
    shown = shown_depth(np.array([[0.0, 1.0, math.inf, 1e6]]))
    assert shown.shape == (1, 4, 3)
    assert shown[0, 0, 0] == 255
    assert 0 < shown[0, 1, 0] < 255
    assert shown[0, 2:].max() == 0


def room(place: np.ndarray, heading: float, angles: np.ndarray) -> np.ndarray:
    """Return the distances to the walls of a square of 10 m from a place."""
    ways = heading + angles
    c, s = np.cos(ways), np.sin(ways)
    with np.errstate(divide="ignore"):
        far = [
            np.where(c > 0, (5 - place[0]) / c, (-5 - place[0]) / c),
            np.where(s > 0, (5 - place[1]) / s, (-5 - place[1]) / s),
        ]
    return np.min(np.abs(far), axis=0)


@pytest.mark.parametrize("mount", [Pose(0.0, 0.0, 0.0), Pose(0.2, 0.1, 0.5)])
def test_a_scan_of_a_moving_robot_is_as_from_one_place(mount):
    angles = np.linspace(-2.0, 2.0, 401)
    times = np.linspace(-0.2, 0.0, 401)
    track = np.array([[t, 1.0 * t, 0.5 * t, 1.5 * t] for t in np.linspace(-1.0, 1.0, 201)])

    def lidar(time: float) -> tuple[np.ndarray, float]:
        heading = 1.5 * time
        c, s = math.cos(heading), math.sin(heading)
        x, y = mount.x, mount.y
        return np.array([time + c * x - s * y, 0.5 * time + s * x + c * y]), heading + mount.heading

    ranges = np.array([room(*lidar(t), np.array([a]))[0] for t, a in zip(times, angles, strict=True)])
    scan = Scan(0.0, ranges, -2.0, 0.01, 0.1, 30.0)
    found = swept(scan, times, track, mount)
    true = room(*lidar(0.0), angles)
    seen = np.isfinite(found.ranges)
    assert np.count_nonzero(seen) > 300
    assert np.median(np.abs(found.ranges - true)[seen]) < 0.02
    assert np.median(np.abs(ranges - true)) > 0.05
    still = np.column_stack([track[:, :1], np.zeros((201, 3))])
    assert swept(scan, times, still, mount) is scan


def test_lines_of_carmen_are_taken_word_by_word():
    found = _Found()
    _take(found, ["ODOM", "1", "2", "0.5", "0.3", "0.1", "0", "10.5", "host", "10.5"])
    _take(found, ["TRUEPOS", "3", "4", "0.6", "1.5", "2.5", "0.7", "11.5", "host", "11.5"])
    _take(found, ["PARAM", "laser_max", "80"])
    _take(found, ["PARAM", "empty"])
    assert found.twists == [(10.5, 0.3, 0.1)]
    assert found.odometry == [(10.5, 1.0, 2.0, 0.5), (11.5, 1.5, 2.5, 0.7)]
    assert found.truth == [(11.5, 3.0, 4.0, 0.6)]
    assert found.parameters == {"laser_max": "80", "empty": ""}


def test_robots_of_mrclam_are_numbers_that_its_folder_has(tmp_path):
    for name in ("Robot2_Odometry.dat", "Robot1_Odometry.dat", "Robot3_Measurement.dat"):
        (tmp_path / name).touch()
    assert _number("3") == 3
    with pytest.raises(UsageError, match="no robot 'x'; MRCLAM numbers"):
        _number("x")
    with pytest.raises(UsageError, match="no robot 3 in"):
        _numbers(tmp_path, [3])
    assert [_numbers(tmp_path, []), _numbers(tmp_path, [2])] == [[1, 2], [2]]
    (tmp_path / "in").mkdir()
    with pytest.raises(UsageError, match="it is not an MRCLAM data set"):
        _numbers(tmp_path / "in", [])


NOISE = MotionNoise(distance=0.1, turn=0.2, veer=0.05, aside=0.03)


def test_motions_are_arcs_under_the_twists_that_held():
    twists = np.array([[0.0, 1.0, 0.5, 0.2], [1.0, 2.0, -0.5, 0.0]])
    first, second = motions(twists, np.array([0.5, 1.5, 2.0]), NOISE)
    # Steps of a ten-thousandth of a second.
    x = y = heading = 0.0
    for k in range(10_000):
        forward, turn, left = (1.0, 0.5, 0.2) if k < 5000 else (2.0, -0.5, 0.0)
        c, s = math.cos(heading + turn * 5e-5), math.sin(heading + turn * 5e-5)
        x, y, heading = x + (c * forward - s * left) * 1e-4, y + (s * forward + c * left) * 1e-4, heading + turn * 1e-4
    assert (first.forward, first.left, first.turn) == pytest.approx((x, y, heading), abs=1e-6)
    # Half a second of an arc of radius -4 m.
    assert (second.forward, second.turn) == pytest.approx((4.0 * math.sin(0.25), -0.25))
    track = track_of(twists)
    assert track[1] == pytest.approx([1.0, *motions_end(twists)], abs=1e-9)
    assert np.linalg.eigvalsh(first.covariance).min() > 0.0
    assert unknown_motion(0.5).covariance == pytest.approx(0.5 * unknown_motion(1.0).covariance)


def motions_end(twists: np.ndarray) -> list[float]:
    (whole,) = motions(twists, np.array([0.0, 1.0]), NOISE)
    return [whole.forward, whole.left, whole.turn]


def test_motions_of_poses_are_in_the_frame_at_their_beginning():
    track = np.array([[0.0, 1.0, 2.0, math.pi / 2], [1.0, 1.0, 3.0, math.pi / 2], [2.0, 0.0, 3.0, -math.pi]])
    ahead, aside = track_motions(track, np.array([0.0, 1.0, 2.0]), NOISE)
    assert (ahead.forward, ahead.left, ahead.turn) == pytest.approx((1.0, 0.0, 0.0))
    assert (aside.forward, aside.left, aside.turn) == pytest.approx((0.0, 1.0, math.pi / 2))
    # 0.1 per root of a metre ahead; the heading veers by 0.05, half of which is an offset to the left.
    assert ahead.covariance[0, 0] == pytest.approx(0.01)
    assert ahead.covariance[2, 2] == pytest.approx(0.05**2)
    assert ahead.covariance[1, 1] == pytest.approx(0.03**2 + 0.25 * 0.05**2)
    assert [each.forward for each in track_motions(track[:1], np.array([0.0, 1.0]), NOISE)] == [0.0]


def test_odometry_that_jumps_to_its_origin_starts_again():
    time = np.arange(40.0) * 0.1
    track = np.column_stack([time, 0.5 + 0.05 * np.arange(40.0), np.zeros((40, 2))])
    assert restarts_of(track).tolist() == []
    again = track.copy()
    again[20:, 1] -= track[20, 1]
    again[:, 1] += 3.0 * (np.arange(40) < 20)
    assert restarts_of(again).tolist() == [20]
    assert restarts_of(again[:2]).tolist() == []


def test_a_recorder_set_back_is_seen_in_all_topics_or_in_none():
    rows = np.arange(60)
    times = rows * 0.05 - 2.0 * (rows >= 30)
    assert set_backs(rows % 3, times) == [(30, pytest.approx(2.0, abs=0.06))]
    # One topic of three goes on as before.
    other = np.where(rows % 3 == 0, rows * 0.05, times)
    assert [row for row, _ in set_backs(rows % 3, other)] in ([], [30], [31])
    assert set_backs(rows % 3, rows * 0.05) == []


def test_a_grey_bayer_mosaic_is_grey():
    mosaic = np.full((4, 6), 77, np.uint8)
    found = _picture(image("bayer_rggb8", mosaic))
    assert found.shape == (4, 6, 3)
    assert np.array_equal(found, cv2.cvtColor(cv2.cvtColor(found, cv2.COLOR_RGB2GRAY), cv2.COLOR_GRAY2RGB))
