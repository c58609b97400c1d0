"""Tables of the joints and sensors of mechanisms, from arrays instead of a run."""

from types import SimpleNamespace

import numpy as np
from scipy.spatial.transform import Rotation

from mjsim.record.joint_tables import _matrices, mechanism_tables


def test_a_mechanism_has_a_table_of_its_joints_and_one_of_its_sensors():
    rng = np.random.default_rng(2)
    values, tools = rng.normal(size=(4, 3, 2)), np.full((3, 7), np.nan)
    track = SimpleNamespace(
        names=("q1", "q2"),
        **dict(zip(("positions", "velocities", "accelerations", "torques"), values, strict=True)),
        goal=values[0],
        tool=tools,
    )
    read = SimpleNamespace(
        names=("q1.velocity", "energy"), units=("rad/s", "J"), values=np.array([[1, 2], [3, np.nan], [5, 6.0]])
    )
    time = np.array([0.0, 0.1, 0.2])
    recording = SimpleNamespace(time=time, joints={"m": track, "r/arm": track}, readings={"m": read, "n": read})
    tables = mechanism_tables(recording)
    assert {name: [table.name for table in each] for name, each in tables.items()} == {
        "m": ["joints", "sensors"],
        "n": ["sensors"],
    }
    joints, sensors = tables["m"]
    assert list(joints.columns)[:2] == ["time", next(name for name in joints.columns if name.startswith("q1_"))]
    assert list(sensors.columns) == ["time", "q1.velocity", "energy"]
    assert list(sensors.columns["energy"]) == [2.0, None, 6.0]
    np.testing.assert_array_equal(sensors.arrays["values"], read.values)
    assert (sensors.arrays["names"].tolist(), sensors.arrays["units"].tolist()) == ([*read.names], [*read.units])
    assert "T" not in joints.arrays, "it has no tool"


def test_poses_of_a_tool_become_matrices():
    turns = Rotation.random(5, rng=np.random.default_rng(3))
    places = np.random.default_rng(4).normal(size=(5, 3))
    T = _matrices(np.column_stack([places, turns.as_quat()]))
    np.testing.assert_allclose(T[:, :3, :3], turns.as_matrix(), atol=1e-12)
    np.testing.assert_array_equal(T[:, :3, 3], places)
    np.testing.assert_array_equal(T[:, 3], np.broadcast_to([0.0, 0.0, 0.0, 1.0], (5, 4)))
