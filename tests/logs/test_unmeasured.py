"""What a bag says that it does not measure, restarts of odometry, frames of unusual names, and reasons of what is left
out."""

from itertools import pairwise

import numpy as np
import pytest
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from mjsim.datasets import export_euroc, export_rosbag2, export_tum_rgbd
from mjsim.geometry import Pose, Pose3
from mjsim.logs.bags.bag_messages import imu_of
from mjsim.logs.resampling.resample import joined, restarts_of
from tests.bags import START, Bag, new_bag
from tests.real_logs import imported

NOT_MEASURED = -1.0
"""First element of a covariance."""


@pytest.mark.slow
@pytest.mark.parametrize("missing", ["linear_acceleration", "angular_velocity"])
def test_what_an_inertial_sensor_does_not_measure_is_not_zero(missing, tmp_path, capsys):
    felt, turn = np.array([0.1, 0.2, 9.8]), np.array([0.0, 0.0, 0.3])
    with new_bag(tmp_path / "bag") as bag:
        for k in range(40):
            told = bag.imu(bag.header(START + 0.05 * k, "base_link"), felt, turn)
            covariance = np.zeros(9)
            covariance[0] = NOT_MEASURED
            setattr(told, f"{missing}_covariance", covariance)
            bag.put("/imu", START + 0.05 * k, told)
            picture = np.zeros((16, 16, 3), dtype=np.uint8)
            bag.put("/eye/image_raw", START + 0.05 * k, bag.image(bag.header(START + 0.05 * k, "eye"), "rgb8", picture))
    run = imported(tmp_path / "bag", record=tmp_path / "run.mcap")
    readings = [reading for seen in run.observations("robot") for reading in seen.imu]
    values = {"linear_acceleration": felt, "angular_velocity": turn}
    known = {name: value if name != missing else np.full(3, np.nan) for name, value in values.items()}
    np.testing.assert_array_equal([each.acceleration for each in readings], [known["linear_acceleration"]] * 40)
    np.testing.assert_array_equal([each.turn for each in readings], [known["angular_velocity"]] * 40)
    with AnyReader([export_rosbag2(run, tmp_path / "again")]) as reader:
        (connection,) = (each for each in reader.connections if each.topic == "/robot/imu")
        assert "/robot/proximity" not in reader.topics
        for _, _, data in reader.messages([connection]):
            told = reader.deserialize(data, connection.msgtype)
            for name in values:
                vector, first = getattr(told, name), getattr(told, f"{name}_covariance")[0]
                expected = (np.zeros(3), NOT_MEASURED) if name == missing else (values[name], 0.0)
                np.testing.assert_array_equal([vector.x, vector.y, vector.z], expected[0])
                assert min(first, 0.0) == expected[1]
    (folder,) = export_tum_rgbd(run, tmp_path / "tum")
    assert (folder / "accelerometer.txt").exists() == (missing == "angular_velocity")
    # The format has no sign for what is not measured, and programs do not expect 'nan'.
    (folder,) = export_euroc(run, tmp_path / "euroc")
    assert {each.name for each in (folder / "mav0").iterdir()} == {"cam0", "body.yaml"}
    assert "'imu' of robot 'robot' does not measure turn rates and accelerations" in capsys.readouterr().err


@pytest.mark.parametrize("ros1", [True, False])
def test_inertial_readings_decoded_by_hand_are_those_of_rosbags(ros1):
    rng = np.random.default_rng(0)
    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.LATEST)
    bag, kind = Bag(None, store, ros1=ros1), "sensor_msgs/msg/Imu"
    for letters in range(9):
        told = bag.imu(bag.header(START, "f" * letters), rng.normal(size=3), rng.normal(size=3))
        told.orientation_covariance = rng.normal(size=9)
        force, turn = told.linear_acceleration, told.angular_velocity
        for little in (True,) if ros1 else (True, False):
            packed = store.serialize_ros1(told, kind) if ros1 else store.serialize_cdr(told, kind, little_endian=little)
            data = bytes(packed)
            assert imu_of(data, is_ros2=not ros1) == (force.x, force.y, force.z, turn.x, turn.y, turn.z)
            for cut in (0, 1, 15, 16, len(data) - 1):
                with pytest.raises(ValueError, match="a truncated inertial reading"):
                    imu_of(data[:cut], is_ros2=not ros1)


def driven(count: int = 60) -> np.ndarray:
    """Return odometry of a robot that drives an arc at 0.5 m/s, rows of time, x, y and heading."""
    place, rows = Pose(3.0, 1.0, 0.4), []
    for k in range(count):
        rows.append([0.1 * k, *place.as_array()])
        place = place @ Pose(0.05, 0.0, 0.01)
    return np.array(rows)


def steps_of(track: np.ndarray) -> np.ndarray:
    poses = [Pose(*row) for row in track[:, 1:].tolist()]
    return np.array([(a.inverse() @ b).as_array() for a, b in pairwise(poses)])


def test_odometry_that_starts_again_goes_on_where_it_was():
    track = driven()
    again = np.concatenate([track[:25], track[:35]])
    again[:, 0] = track[:, 0]
    (row,) = restarts_of(again)
    assert row == 25
    steps = steps_of(joined(again, restarts_of(again)))
    np.testing.assert_allclose(steps[24], 0.0, atol=1e-12)
    np.testing.assert_allclose(np.delete(steps, 24, axis=0), [[0.05, 0.0, 0.01]] * 58, atol=1e-12)


def test_odometry_whose_heading_starts_again_goes_on_as_it_was():
    # A robot that turned on the spot, and whose driver starts again.
    track = np.tile(driven(1), (60, 1))
    track[:, 0], track[:, 1:] = 0.1 * np.arange(60), 0.0
    track[:30, 3], track[30:, 3] = 0.1 * np.arange(30), 0.1 * np.arange(30)
    assert restarts_of(track).tolist() == [30]
    whole = joined(track, restarts_of(track))
    np.testing.assert_allclose(whole[30, 3], whole[29, 3], atol=1e-12)


def test_what_moves_fast_or_has_gaps_does_not_jump():
    fast = driven()
    fast[:, 1:3] *= 60.0  # at 30 m/s
    gap = np.delete(driven(600), slice(100, 500), axis=0)
    still = np.tile(driven(1), (200, 1))
    still[:, 0] = 0.1 * np.arange(200)
    starts = np.concatenate([still[:150], driven(50)])
    starts[150:, 0] += 15.0
    # Odometry that slips, or whose time comes in bursts: it is not where it began.
    elsewhere = driven()
    elsewhere[30:, 3] += 2.0
    for track in (fast, gap, starts, elsewhere, still, still[:2]):
        assert not len(restarts_of(track))


@pytest.mark.slow
def test_a_restart_of_odometry_in_a_bag_is_no_motion_and_is_said(tmp_path):
    with new_bag(tmp_path / "bag") as bag:
        for k in range(60):
            at, x = START + 0.1 * k, 0.05 * (k if k < 30 else k - 30)
            bag.put("/odom", at, bag.odometry(bag.header(at, "odom"), "base_link", Pose3(x, 0, 0, 0, 0, 0, 1)))
            bag.put("/scan", at, bag.scan(bag.header(at, "base_link"), np.ones(9), -0.4, 0.1, (0.1, 50.0)))
    run = imported(tmp_path / "bag")
    moved = [seen.odometry.forward for seen in run.observations("robot")]
    assert sum(moved) == pytest.approx(0.05 * 58, abs=1e-6)
    assert min(moved) > -1e-9
    assert run.metadata["restarts of odometry left out"].startswith("1; it begins again at 17000000")


@pytest.mark.slow
def test_odometry_in_tf_may_be_of_any_frame_but_a_map(tmp_path):
    mounted, moved, placed = np.eye(4), np.eye(4), np.eye(4)
    mounted[0, 3] = 0.2
    with new_bag(tmp_path / "bag") as bag:
        for k in range(30):
            moved[0, 3], placed[1, 3], at = 0.05 * k, 0.01 * k, START + 0.1 * k
            bag.transforms("/tf", at, [("wheel_odom", "chassis", moved), ("wheel_odom", "map", placed)])
            bag.transforms("/tf_static", at, [("chassis", "laser", mounted)])
            bag.put("/scan", at, bag.scan(bag.header(at, "laser"), np.ones(9), -0.4, 0.1, (0.1, 50.0)))
    run = imported(tmp_path / "bag")
    assert run.metadata["odometry"] == "frame chassis in /tf"
    assert sum(seen.odometry.forward for seen in run.observations("robot")) == pytest.approx(0.05 * 29, abs=1e-6)
    assert run.world.robots[0].sensors[0].at == pytest.approx((0.2, 0.0, 0.0))


@pytest.mark.slow
def test_the_first_message_that_is_left_out_says_why(tmp_path):
    with new_bag(tmp_path / "bag") as bag:
        for k in range(10):
            at = START + 0.1 * k
            bag.put("/odom", at, bag.odometry(bag.header(at, "odom"), "base_link", Pose3(0.1 * k, 0, 0, 0, 0, 0, 1)))
            told = bag.image(bag.header(at, "eye"), "nv99", np.zeros((24, 16), dtype=np.uint8))
            bag.put("/eye/image_raw", at, told)
    run = imported(tmp_path / "bag")
    assert run.metadata["/eye/image_raw messages left out"] == "10"
    assert (
        run.metadata["first message of /eye/image_raw left out"]
        == "pictures with the encoding 'nv99' are not supported"
    )


def write_carmen(folder) -> None:
    lines = [
        f"ODOM {0.05 * (k % 30)} 0 0 0.5 0 0 {100.0 + 0.1 * k} h {0.1 * k}\n"
        f"FLASER 5 1 1 1 1 1 0 0 0 {0.05 * (k % 30)} 0 0 {100.0 + 0.1 * k} h {0.1 * k}\n"
        for k in range(60)
    ]
    (folder / "log.clf").write_text("".join(lines))


def write_tables(folder) -> None:
    (folder / "log.yaml").write_text("log: tables\nodometry: {file: o.csv, time: t, x: x, y: y, heading: h}\n")
    rows = "".join(f"{100.0 + 0.1 * k},{0.05 * (k % 30)},0,0\n" for k in range(60))
    (folder / "o.csv").write_text(f"t,x,y,h\n{rows}")


@pytest.mark.slow
@pytest.mark.parametrize(("write", "name"), [(write_carmen, "log.clf"), (write_tables, "log.yaml")])
def test_a_restart_of_odometry_in_a_log_of_text_is_no_motion(write, name, tmp_path):
    write(tmp_path)
    run = imported(tmp_path / name)
    moved = [seen.odometry.forward for seen in run.observations("robot")]
    assert sum(moved) == pytest.approx(0.05 * 58, abs=1e-6)
    assert min(moved) > -1e-9
    assert run.metadata["restarts of odometry left out"] == "1; it begins again at 103.000 s"


def test_infinite_numbers_of_an_inertial_table_are_not_measured(tmp_path):
    (tmp_path / "mav0" / "imu0").mkdir(parents=True)
    rows = [f"{10**18 + k * 10**7},0,0,0.1,0,{'inf' if k == 3 else '-1e200' if k == 5 else 0},9.81" for k in range(30)]
    (tmp_path / "mav0" / "imu0" / "data.csv").write_text("#t,wx,wy,wz,ax,ay,az\n" + "\n".join(rows) + "\n")
    run = imported(tmp_path)
    readings = [reading for seen in run.observations("robot") for reading in seen.imu]
    assert [k for k, each in enumerate(readings) if np.isnan(each.acceleration).all()] == [3, 5]
    assert all(np.isfinite(each.turn).all() for each in readings)
    assert run.metadata["infinite or huge numbers of imu0/data.csv left out"] == "2"
