"""What panels of Foxglove draw beside scans and pictures: the map as a grid, joints, inertial readings one by one."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader

import mjsim
from mjsim.record import Recording, read_recording
from mjsim.world import grid_of

TEXT = """
mjsim: 1
walls: [{points: [[0, 0], [4, 0], [4, 3], [0, 3]], closed: true}]
obstacles: [{box: [0.6, 0.4, 1], at: [3, 2], heading_deg: 20}]
robots:
  - name: joe
    at: [1, 2]
    sensors: [{imu: inner, rate_hz: 50}]
    arms: [{name: left, preset: puma560}, {name: right, preset: puma560, at: [0, 0.3, 0.2]}]
mechanisms:
  - name: crank
    at: [2, 2]
    elevation: 1
    bodies: [{name: bar, rod: [0.3, 0.02]}]
    joints: [{revolute: q, of: [ground, bar], axis: [0, 1, 0]}]
run: {seconds: 0.2, rate_hz: 25, drivers: {joe: {}}}
"""


COLUMNS = {"position": "positions", "velocity": "velocities", "acceleration": "accelerations", "effort": "torques"}


def decoded(schema: Any, data: bytes) -> Any:
    """Return a message of Protocol Buffers by the schema that stands in the file, as the reference library reads it."""
    descriptors = pytest.importorskip("google.protobuf.descriptor_pb2")
    from google.protobuf import descriptor_pool, message_factory

    pool = descriptor_pool.DescriptorPool()
    for file in descriptors.FileDescriptorSet.FromString(schema.data).file:
        pool.Add(file)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName(schema.name)).FromString(data)


def messages(path: Path) -> dict[str, list[tuple[int, str, Any]]]:
    """Return log time [ns], name of the schema and content of each message, by topic, as mcap reads them."""
    found: dict[str, list[tuple[int, str, Any]]] = {}
    with path.open("rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages():
            content = json.loads(message.data) if channel.message_encoding == "json" else decoded(schema, message.data)
            found.setdefault(channel.topic, []).append((message.log_time, schema.name, content))
    return found


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    path: Path = tmp_path_factory.mktemp("panels") / "run.mcap"
    with mjsim.Simulation(mjsim.parse_world(TEXT)) as sim:
        mjsim.run(sim, record=path)
    return read_recording(path)


@pytest.fixture(scope="module")
def told(recording: Recording) -> dict[str, list[tuple[int, str, Any]]]:
    return messages(recording.path)


def test_the_map_is_a_grid_of_what_is_occupied_free_and_unknown(recording: Recording, told):
    ((time, schema, grid),) = told["/grid"]
    expected = grid_of(recording.world)
    assert (time, schema, grid.frame_id) == (0, "foxglove.Grid", "world")
    rows, columns = expected.occupied.shape
    stride = grid.cell_stride
    assert (grid.column_count, grid.row_stride) == (columns, columns * stride)
    assert (grid.cell_size.x, grid.cell_size.y) == (0.05, 0.05)
    place, corner, turn = grid.pose.position, expected.world_from_grid, grid.pose.orientation
    assert [place.x, place.y, place.z] == [corner.x, corner.y, 0.0]
    assert [turn.x, turn.y, turn.z, turn.w] == [0.0, 0.0, 0.0, 1.0]
    cells = np.frombuffer(grid.data, dtype=np.uint8).reshape(rows, columns, stride)
    places = {each.name: each.offset for each in grid.fields}
    assert list(places) == ["red", "green", "blue", "alpha", "occupancy"]
    occupancy = cells[..., places["occupancy"]].view(np.int8)
    np.testing.assert_array_equal(
        occupancy, np.where(expected.occupied, 100, np.where(expected.free, 0, -1)).astype(np.int8)
    )
    # What nobody knows is transparent; what is occupied is darker than what is free.
    np.testing.assert_array_equal(cells[..., places["alpha"]] == 0, occupancy == -1)
    assert cells[occupancy == 100][:, : places["alpha"]].max() < cells[occupancy == 0][:, : places["alpha"]].min()
    # The middle of the box is where the world has it.
    column, row = expected.cells(np.array([3.0, 2.0])).astype(int).tolist()
    assert occupancy[row, column] == 100


def test_joints_are_told_in_one_message_a_tick_for_each_robot_and_mechanism(recording: Recording, told):
    joints = recording.joints
    for topic, names, tracks in (
        (
            "/joe/joint_states",
            [f"{arm}/joint{k}" for arm in ("left", "right") for k in range(1, 7)],
            ("joe/left", "joe/right"),
        ),
        ("/crank/joint_states", ["q"], ("crank",)),
    ):
        assert len(told[topic]) == len(recording.time) > 3
        for row, (time, schema, message) in enumerate(told[topic]):
            assert schema == "foxglove.JointStates"
            assert message["timestamp"]["sec"] * 10**9 + message["timestamp"]["nsec"] == time
            assert [each["name"] for each in message["joints"]] == names
            for key, column in COLUMNS.items():
                assert [each[key] for each in message["joints"]] == [
                    value for name in tracks for value in getattr(joints[name], column)[row]
                ]


def test_inertial_readings_come_one_by_one_with_the_fields_of_ros(recording: Recording, told):
    given = [each for seen in recording.observations("joe") for each in seen.imu if each.name == "inner"]
    assert len(given) == len(told["/joe/inner/imu"]) > 7
    for reading, (_, schema, message) in zip(given, told["/joe/inner/imu"], strict=True):
        assert (schema, message["header"]["frame_id"]) == ("sensor_msgs/Imu", "joe/inner")
        stamp = message["header"]["stamp"]
        assert stamp["sec"] * 10**9 + stamp["nsec"] == round(reading.stamp * 1e9)
        assert list(message["linear_acceleration"].values()) == reading.acceleration.tolist()
        assert list(message["angular_velocity"].values()) == reading.turn.tolist()
        assert message["orientation_covariance"][0] == -1.0
    frames = {each.child_frame_id: each.parent_frame_id for each in told["/tf"][0][2].transforms}
    assert frames["joe/inner"] == "joe/base"
