"""The truth of a base is a pose in space: on a ramp it has a height and a pitch, in recordings, figures and exports."""

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import mjsim
from mjsim.geometry import Pose, Pose3, roll_and_pitch
from mjsim.record import export_csv, export_npz, export_tum

SLOPE = np.degrees(np.arctan2(0.35, 4.0))
RAMP = """
mjsim: 1
obstacles: [{ramp: [4, 1.6, 0.35], at: [4, 0]}]
robots: [{name: scout, preset: pioneer3dx, at: [1, 0]}]
run:
  seconds: 6
  drivers: {scout: {navigator: {use: "mjsim.algorithms.constant:ConstantCommand", forward: 0.6}}}
"""


@pytest.fixture(scope="module")
def climb(tmp_path_factory):
    path = tmp_path_factory.mktemp("climb") / "run.mcap"
    with mjsim.Simulation(mjsim.parse_world(RAMP), seed=1) as sim:
        recording = mjsim.run(sim, record=path)
        return recording, sim.pose("scout"), sim.data.body("scout/base").xmat.reshape(3, 3).copy()


def test_a_pose_in_space_is_the_rotation_that_scipy_makes():
    for values in np.random.default_rng(0).normal(size=(50, 7)):
        quaternion = values[3:] / np.linalg.norm(values[3:])
        pose, rotation = Pose3(*values[:3], *quaternion), Rotation.from_quat(quaternion)
        np.testing.assert_allclose(pose.matrix()[:3, :3], rotation.as_matrix(), atol=1e-14)
        np.testing.assert_array_equal(pose.matrix()[:, 3], [*values[:3], 1.0])
        roll, pitch, yaw = rotation.as_euler("xyz")
        np.testing.assert_allclose(roll_and_pitch(quaternion), [roll, pitch], atol=1e-7)
        assert pose.planar().heading == pytest.approx(yaw, abs=1e-7)


def test_a_planar_pose_goes_into_space_and_back():
    for x, y, heading in np.random.default_rng(0).uniform(-3.1, 3.1, (50, 3)).tolist():
        back = Pose3.from_planar(Pose(x, y, heading)).planar()
        assert (back.x, back.y) == (x, y)
        assert back.heading == pytest.approx(heading, abs=1e-14)


@pytest.mark.slow
def test_on_a_ramp_the_simulation_tells_height_and_pitch(climb):
    _, world_from_base, rotation = climb
    np.testing.assert_allclose(world_from_base[:3, :3], rotation, atol=1e-12)
    # The base's origin is on the slope, as high as that is there; tyres and casters sink in by under 5 mm.
    assert world_from_base[2, 3] == pytest.approx((world_from_base[0, 3] - 2.0) * 0.35 / 4.0, abs=5e-3)


def test_a_recording_holds_the_pose_in_space_and_the_planar_one_as_it_is(climb):
    recording, *_ = climb
    track = recording.robots["scout"]
    np.testing.assert_array_equal(track.truth_pose[:, :2], track.truth[:, :2])
    yaw = Rotation.from_quat(track.truth_pose[:, 3:]).as_euler("xyz")[:, 2]
    np.testing.assert_allclose(track.truth[:, 2], yaw, atol=1e-12)
    np.testing.assert_allclose(track.truth_pose[:, :3], recording.qpos[:, :3], atol=0)
    pitch = np.degrees(roll_and_pitch(track.truth_pose[:, 3:]))[:, 1]
    assert abs(pitch[0]) < 0.5
    assert pitch[-1] == pytest.approx(-SLOPE, abs=0.3)  # nose up; casters give way by some millimetres


def test_statistics_tell_height_roll_and_pitch(climb):
    recording, *_ = climb
    figures, track = mjsim.statistics(recording)["scout"], recording.robots["scout"]
    assert figures["height_m"]["max"] == track.truth_pose[:, 2].max()
    assert figures["pitch_deg"]["min"] == pytest.approx(-SLOPE, abs=1.0)
    assert abs(figures["roll_deg"]["mean"]) < 0.1


def test_a_tum_file_and_a_table_hold_the_pose_in_space(climb, tmp_path):
    recording, *_ = climb
    track = recording.robots["scout"]
    export_tum(recording, tmp_path)
    np.testing.assert_array_equal(
        np.loadtxt(tmp_path / "scout_truth.tum"), np.column_stack([track.time, track.truth_pose])
    )
    assert not np.loadtxt(tmp_path / "scout_odometry.tum")[:, 3:6].any()
    export_csv(recording, tmp_path)
    table = np.genfromtxt(tmp_path / "scout_track.csv", delimiter=",", names=True)
    np.testing.assert_array_equal(table["truth_z"], track.truth_pose[:, 2])
    np.testing.assert_allclose(np.degrees(table["truth_pitch"])[-1], -SLOPE, atol=0.3)
    with np.load(export_npz(recording, tmp_path / "run.npz")) as arrays:
        np.testing.assert_array_equal(arrays["scout/truth_pose"], track.truth_pose)


def test_the_frame_of_the_base_is_the_truth_in_space(climb):
    recording, *_ = climb
    message = [json.loads(data) for data in recording.messages("/scout/truth")][-1]
    pose = recording.robots["scout"].truth_pose[-1]
    assert [message["pose"]["position"][axis] for axis in "xyz"] == pose[:3].tolist()
    assert [message["pose"]["orientation"][axis] for axis in "xyzw"] == pose[3:].tolist()
