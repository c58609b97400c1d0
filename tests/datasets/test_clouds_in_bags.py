"""Point clouds in bags of ROS 2, read back by rosbags."""

from pathlib import Path

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

import mjsim
from mjsim.datasets import export_rosbag2
from mjsim.world import parse_world

WORLD = """
mjsim: 1
walls: [{points: [[0, 0], [5, 0], [5, 4], [0, 4]], closed: true}]
robots: [{name: scout, at: [2, 2], sensors: [{lidar3d: top, rings: 4, columns: 60}]}]
"""
KINDS = {4: "<u2", 7: "<f4"}
"""UINT16 and FLOAT32 of sensor_msgs/PointField."""


@pytest.mark.slow
def test_clouds_have_every_point_with_its_time_ring_and_intensity(tmp_path: Path):
    with mjsim.Simulation(parse_world(WORLD)) as sim:
        run = mjsim.run(sim, seconds=0.2, record=tmp_path / "run.mcap")
    clouds = [seen.clouds["top"] for seen in run.observations("scout") if seen.clouds]
    with AnyReader([export_rosbag2(run, tmp_path / "bag")]) as reader:
        chosen = [each for each in reader.connections if each.topic == "/scout/points"]
        messages = [reader.deserialize(raw, each.msgtype) for each, _, raw in reader.messages(connections=chosen)]
    assert len(messages) == len(clouds) > 1
    for message, cloud in zip(messages, clouds, strict=True):
        rows = np.frombuffer(message.data.tobytes(), dtype=[(f.name, KINDS[f.datatype]) for f in message.fields])
        assert (message.height, message.width, message.row_step) == (1, len(rows), message.point_step * len(rows))
        np.testing.assert_array_equal(np.stack([rows[axis] for axis in "xyz"], axis=-1), cloud.points)
        np.testing.assert_array_equal(rows["intensity"], cloud.intensities)
        np.testing.assert_array_equal(rows["time"], cloud.times)
        np.testing.assert_array_equal(rows["ring"], cloud.rings)
        assert message.header.frame_id == "top"
        assert message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec == cloud.stamp
