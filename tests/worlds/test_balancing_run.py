"""A robot that balances finds out where it is, and where the pictures of the gallery hang."""

import numpy as np
import pytest

import mjsim
from mjsim.geometry import roll_and_pitch


@pytest.mark.slow
def test_picture_slam_on_two_wheels_errs_by_less_than_10_cm_and_knows_by_how_much(tmp_path):
    with mjsim.Simulation(mjsim.load_world("balancing", settings=["robots.joe.sensors.front.rate_hz=5"])) as sim:
        recording = mjsim.run(sim, seconds=8.0, record=tmp_path / "run.mcap", pictures=False)
    figures = mjsim.statistics(recording)["joe"]
    joe = recording.robots["joe"]
    assert figures["distance_m"] > 2.5
    assert not joe.events
    # It leans by degrees, which at the height of the camera are centimetres.
    assert np.degrees(np.abs(roll_and_pitch(joe.truth_pose[:, 3:])[:, 1])).max() > 2.0
    assert figures["position_error_m"]["mean"] < 0.03
    assert figures["nees"]["mean"] < 6.0
    assert figures["landmark_error_m"]["aligned_rms"] < 0.02
