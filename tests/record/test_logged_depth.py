"""Depth of cameras as recordings store it: whole millimetres, or metres where a log has finer ones."""

from dataclasses import asdict

import numpy as np
import pytest

from mjsim.interface import CameraFrame, Intrinsics
from mjsim.record import LoggedCamera, logged_frame
from mjsim.record.drawn.logged_frame import decode_picture, depth_message, depth_of, depth_pixels, depth_values

SIZE = Intrinsics(4, 3, 10.0, 10.0, 1.5, 1.0)
IMAGE = np.random.default_rng(0).integers(0, 255, (3, 4, 3), dtype=np.uint8)


def frame(depth, *, stamp=None) -> CameraFrame:
    return CameraFrame(2.5, IMAGE, SIZE, np.asarray(depth, dtype=float), depth_stamp=stamp)


def test_millimetres_are_rounded_and_0_is_what_was_not_measured():
    depth = [[1.0, 0.0014, 0.0016, 65.535], [65.536, np.inf, -np.inf, np.nan], [0.0, 1e-4, -1.0, 2.0]]
    pixels = depth_values(frame(depth))
    assert pixels.dtype == np.uint16
    assert pixels.tolist() == [[1000, 1, 2, 65535], [0, 0, 0, 0], [0, 0, 0, 2000]]
    back = depth_of(depth_message(frame(depth), "eye").encode(), shape=(3, 4))
    np.testing.assert_allclose(back[0], [1.0, 0.001, 0.002, 65.535], rtol=1e-6)
    assert np.isposinf(back[1]).all()


@pytest.mark.parametrize(("step", "kind"), [(0.25, np.uint16), (0.001, np.uint16), (0.00025, np.float32)])
def test_the_depth_of_a_log_is_stored_without_loss(step, kind):
    depth = np.float32(1.0) + np.arange(12, dtype=np.float32).reshape(3, 4) * np.float32(step)
    depth = np.rint(depth * 1000).astype(np.float32) / np.float32(1000) if step >= 0.001 else depth
    logged = logged_frame(frame(depth))
    message = depth_message(logged, "eye").encode()
    assert depth_pixels(message).dtype == kind
    np.testing.assert_array_equal(depth_of(message, shape=(3, 4)), depth.astype(float))
    with pytest.raises(ValueError, match="another size"):
        depth_of(message, shape=(4, 3))
    np.testing.assert_array_equal(decode_picture(logged.encoded), IMAGE)
    assert logged_frame(logged) is logged


def test_a_data_sheet_of_a_camera_comes_back_from_its_text():
    place = np.eye(4)
    place[:3, 3] = 0.1, 0.2, 0.3
    for camera in (LoggedCamera(SIZE, place, has_depth=True), LoggedCamera(SIZE, None)):
        back = LoggedCamera.from_json(camera.to_json())
        assert asdict(back.intrinsics) == asdict(SIZE)
        assert back.has_depth == camera.has_depth
        np.testing.assert_array_equal(back.robot_from_camera, camera.robot_from_camera)
