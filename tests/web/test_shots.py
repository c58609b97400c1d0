"""Colours of depths and of instances, and their names, in pictures for the page."""

import cv2
import numpy as np
import pytest

from mjsim.interface import CameraFrame, Intrinsics
from mjsim.video import INK, PAPER
from mjsim.web.run.shots import FAR, NEAR, NO_HIT_COLOR, depth_shown, instance_colour, jpeg, segmentation_shown

WIDE, HIGH = 200, 120


def frame_of(segmentation, instances):
    picture = np.zeros((*segmentation.shape, 3), np.uint8)
    return CameraFrame(0.0, picture, Intrinsics(WIDE, HIGH, 1, 1, 0, 0), segmentation=segmentation, instances=instances)


def test_a_jpeg_keeps_red_red():
    picture = np.zeros((16, 16, 3), np.uint8)
    picture[..., 0] = 255
    back = cv2.cvtColor(cv2.imdecode(np.frombuffer(jpeg(picture), np.uint8), cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)
    assert np.abs(back.astype(int) - picture).max() < 8


def test_depths_are_warm_near_cold_far_and_grey_where_there_is_nothing():
    depth = np.array([[NEAR / 2, NEAR, np.sqrt(NEAR * FAR), FAR, 2 * FAR, np.inf, np.nan]])
    (row,) = depth_shown(depth)
    scale = cv2.applyColorMap(np.arange(256, dtype=np.uint8)[None], cv2.COLORMAP_TURBO)[0, :, ::-1]
    np.testing.assert_array_equal(row[0], row[1])
    np.testing.assert_array_equal(row[1], scale[255])
    np.testing.assert_array_equal(row[2], scale[128])
    np.testing.assert_array_equal(row[3], scale[0])
    np.testing.assert_array_equal(row[4], scale[0])
    assert [tuple(each) for each in row[5:].tolist()] == [NO_HIT_COLOR, NO_HIT_COLOR]
    assert row[1][0] > row[1][2]  # red before blue


def test_an_instance_has_one_colour_in_all_pictures_and_buildings_are_muted():
    names = [f"thing-{k}" for k in range(40)]
    colours = [instance_colour(name) for name in names]
    assert colours == [instance_colour(name) for name in names]
    assert len(set(colours)) > 35
    assert all(max(colour) in range(149, 222) for colour in colours)
    for name in ("wall", "floor", "ceiling"):
        assert np.ptp(instance_colour(name)) < 20


def test_large_instances_have_their_names_on_plates_that_do_not_cover_each_other():
    seen = np.full((HIGH, WIDE), -1)
    seen[20:100, 10:110] = 0
    seen[20:100, 120:190] = 1
    seen[2:4, 2:4] = 2
    frame = frame_of(seen, ("room/lion", "owl", "speck"))
    shown = segmentation_shown(frame)
    assert tuple(shown[99, 10]) == instance_colour("room/lion")
    assert tuple(shown[99, 125]) == instance_colour("owl")
    assert tuple(shown[2, 2]) == instance_colour("speck")
    assert tuple(shown[0, 199]) == NO_HIT_COLOR
    plates = (shown == PAPER).all(axis=-1)
    count, _, boxes, middles = cv2.connectedComponentsWithStats(cv2.dilate(plates.astype(np.uint8), np.ones((5, 5))))
    assert count == 3
    assert sorted(middles[1:, 0].tolist()) == pytest.approx([60, 155], abs=25)
    assert middles[1:, 1] == pytest.approx([60, 60], abs=25)
    assert {box[cv2.CC_STAT_HEIGHT] for box in boxes[1:]} == {22}
    ink = (np.abs(shown.astype(int) - INK).max(axis=-1) < 40).sum()
    assert ink > 20


def test_names_at_the_edge_stay_in_the_picture_and_the_larger_of_two_is_named():
    seen = np.full((HIGH, WIDE), -1)
    seen[45:75, -12:] = 0
    seen[50:70, -20:-12] = 1
    shown = segmentation_shown(frame_of(seen, ("a long name", "another")))
    rows, columns = np.nonzero((shown == PAPER).all(axis=-1))
    assert columns.max() == WIDE - 1
    assert np.ptp(rows) == 17  # one plate
