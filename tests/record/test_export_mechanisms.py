"""Joints and sensors of mechanisms in tables and arrays, as readers of others find them."""

import csv

import numpy as np
import pytest
from scipy.io import loadmat

import mjsim
from mjsim.record import export_csv, export_mat, export_npz

WORLD = """mjsim: 1
name: swing
mechanisms:
  - name: four-bar.1
    at: [0, 0]
    bodies: [{name: crank, rod: [1.0, 0.05]}]
    joints: [{revolute: q2, of: [ground, crank], axis: [0, 1, 0], start_deg: 28.6}]
    sensors: [{joint: q2}]
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """The recording of a pendulum without any robot."""
    with mjsim.Simulation(mjsim.parse_world(WORLD)) as sim:
        return mjsim.run(sim, seconds=0.4, record=tmp_path_factory.mktemp("swing") / "run.mcap")


@pytest.mark.slow
def test_joints_and_sensors_of_a_mechanism_are_exported(run, tmp_path):
    track, read = run.joints["four-bar.1"], run.readings["four-bar.1"]
    assert np.ptp(track.positions) > 0.1
    files = export_csv(run, tmp_path)
    assert {file.name for file in files} == {"four-bar.1_joints.csv", "four-bar.1_sensors.csv"}
    for file, column, expected in (
        (tmp_path / "four-bar.1_joints.csv", "q2_q", track.positions[:, 0]),
        (tmp_path / "four-bar.1_sensors.csv", "q2.velocity", read.column("q2.velocity")),
    ):
        with file.open(newline="") as text:
            rows = list(csv.DictReader(text))
        np.testing.assert_array_equal([float(row[column]) for row in rows], expected)
        np.testing.assert_array_equal([float(row["time"]) for row in rows], run.time)
    arrays = np.load(export_npz(run, tmp_path / "run.npz"))
    np.testing.assert_array_equal(arrays["four-bar.1/joints/qd"], track.velocities)
    np.testing.assert_array_equal(arrays["four-bar.1/sensors/values"], read.values)
    assert arrays["four-bar.1/sensors/units"].tolist() == list(read.units)
    found = loadmat(export_mat(run, tmp_path / "run.mat"), simplify_cells=True)["mechanisms"]["four_bar_1"]
    assert found["name"] == "four-bar.1"
    np.testing.assert_array_equal(found["joints"]["q"], track.positions[:, 0])
    np.testing.assert_array_equal(found["sensors"]["values"], read.values)
