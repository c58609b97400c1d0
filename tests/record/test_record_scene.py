from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from mjsim.record import Recording, read_recording
from mjsim.record.drawn.map import prism
from mjsim.record.drawn.scene_messages import quaternion
from tests.record_ticks import CAMERA, hand_made_ticks, record


def test_a_quaternion_turns_as_its_matrix_does():
    rng = np.random.default_rng(0)
    for rotation in [
        *Rotation.random(50, rng).as_matrix(),
        np.eye(3),
        np.diag([1.0, -1.0, -1.0]),
        np.diag([-1.0, -1.0, 1.0]),
    ]:
        np.testing.assert_allclose(Rotation.from_quat(quaternion(rotation)).as_matrix(), rotation, atol=1e-12)


def test_a_prism_is_closed_and_its_faces_look_outward():
    outline = np.array([[0.0, 0.0], [2.0, 0.0], [2.5, 1.0], [1.0, 2.0], [-0.5, 1.0]])
    corners, triangles = prism(outline, 0.5, 2.0)
    x, y = outline.T
    area = (x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2
    # The divergence theorem: outward faces sum to the volume, and only a closed surface gives it from any origin.
    for origin in (0.0, 7.0):
        volume = np.linalg.det(corners[triangles] - origin).sum() / 6
        np.testing.assert_allclose(volume, area * 1.5, rtol=1e-12)


def test_foxglove_finds_every_frame_at_every_tick(tmp_path: Path):
    recording: Recording = read_recording(record(tmp_path / "run.mcap", hand_made_ticks(3)))
    frames = list(recording.messages("/tf"))
    assert len(frames) == 3
    for frame in (b"world", b"scout/base", b"scout/estimate", b"scout/odometry", b"scout/front"):
        assert all(frame in message for message in frames)
    # The first number of the camera's mount, a little-endian double in the message.
    assert np.float64(CAMERA.robot_from_sensor[0, 3]).tobytes() in frames[0]


def test_the_map_holds_walls_obstacles_and_beacons(tmp_path: Path):
    recording = read_recording(record(tmp_path / "run.mcap", hand_made_ticks(1)))
    (scene,) = recording.messages("/map")
    for entity in (b"walls", b"obstacles", b"beacons", b"lion"):
        assert entity in scene
    assert np.float64(1.1).tobytes() in scene, "the height of the box"
