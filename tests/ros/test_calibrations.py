"""Calibrations of cameras as messages."""

import numpy as np
import pytest

from mjsim.interface import Intrinsics
from mjsim.logs.bags.bag_messages import intrinsics_of
from mjsim.ros.messages import camera_info

RATIONAL = (0.3, -0.2, 0.001, -0.002, 0.05, 0.6, -0.1, 0.02)


@pytest.mark.parametrize(
    ("lens", "distortion", "model", "count"),
    [
        ("pinhole", (), "plumb_bob", 5),
        ("brown", (0.1, 0.0, 0.001, 0.0), "plumb_bob", 5),
        ("brown", RATIONAL, "rational_polynomial", 8),
        ("fisheye", (0.02, -0.004, 0.0, 0.001), "equidistant", 4),
    ],
)
def test_every_coefficient_of_a_lens_goes_out_and_comes_in_again(lens, distortion, model, count):
    camera = Intrinsics(64, 48, 50.0, 51.0, 31.0, 24.0, lens, distortion)
    told = camera_info(0.0, "eye", camera)
    assert (told.distortion_model, told.d.tolist()) == (model, [*distortion, *([0.0] * (count - len(distortion)))])
    again = intrinsics_of(told, width=64, height=48, rectified=False)
    assert (again.lens, np.trim_zeros(again.distortion, "b")) == (lens, np.trim_zeros(distortion, "b"))
    np.testing.assert_array_equal(again.matrix(), camera.matrix())
