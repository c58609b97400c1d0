"""The data sheets of exported sensors: noise as densities, calibrations as they are read."""

import math

import numpy as np
import pytest

from mjsim.datasets.euroc_out import _camera_yaml, _imu_yaml
from mjsim.errors import UsageError
from mjsim.interface import Intrinsics, SensorInfo


def sheet(kind, **more):
    return SensorInfo(kind=kind, robot_from_sensor=np.eye(4), rate_hz=100.0, **more)


def values(text):
    return dict(line.split(": ", 1) for line in text.splitlines() if ": " in line)


def test_densities_of_an_inertial_sensor_are_those_of_its_noise_in_a_hertz():
    noise = {"turn": 0.02, "turn_walk": 0.003, "acceleration": 0.5, "acceleration_walk": 0.07}
    told = values(_imu_yaml("r/imu", sheet("imu", noise=noise), np.eye(4)))
    # White noise of n readings a second, averaged over a second, has the deviation of one over sqrt(n).
    assert float(told["gyroscope_noise_density"]) == pytest.approx(0.02 / 10.0)
    assert float(told["accelerometer_noise_density"]) == pytest.approx(0.5 / 10.0)
    assert float(told["gyroscope_random_walk"]) == 0.003
    assert float(told["accelerometer_random_walk"]) == 0.07
    assert told["rate_hz"] == "100"


def test_the_pose_of_a_sensor_is_written_row_by_row():
    pose = np.arange(16.0).reshape(4, 4)
    assert values(_imu_yaml("r/imu", sheet("imu", noise={}), pose))["  data"] == str(list(map(float, range(16))))


@pytest.mark.parametrize(
    ("lens", "coefficients", "model", "written"),
    [
        ("brown", (0.1, 0.2, 0.3, 0.4), "radial-tangential", [0.1, 0.2, 0.3, 0.4]),
        ("brown", (0.1, 0.2, 0.3, 0.4, 0.5), "radial-tangential", [0.1, 0.2, 0.3, 0.4, 0.5]),
        ("fisheye", (0.1, 0.2, 0.3, 0.4), "equidistant", [0.1, 0.2, 0.3, 0.4]),
    ],
)
def test_a_lens_is_written_by_its_model(lens, coefficients, model, written):
    camera = Intrinsics(64, 48, 50.0, 51.0, 31.0, 23.0, lens, coefficients)
    told = values(_camera_yaml("r/eye", sheet("camera", intrinsics=camera), np.eye(4)))
    assert told["resolution"] == "[64, 48]"
    assert told["intrinsics"] == "[50.0, 51.0, 31.0, 23.0]"
    assert told["distortion_model"] == model
    assert told["distortion_coefficients"] == str(written)


def test_a_lens_that_the_format_cannot_hold_is_refused():
    camera = Intrinsics(64, 48, 50.0, 51.0, 31.0, 23.0, "brown", (0.1, 0.2, 0.0, 0.0, 0.1, 0.1, 0.1, 0.1))
    with pytest.raises(UsageError, match=r"^camera 'r/eye' has a rational lens model with 8 coefficients"):
        _camera_yaml("r/eye", sheet("camera", intrinsics=camera), np.eye(4))
    assert math.isfinite(camera.fx)
