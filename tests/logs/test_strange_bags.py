"""Bags with clocks from 0, corrected frames, unmerged databases, odd paths, or an IMU alone."""

import shutil
import sqlite3
from contextlib import closing

import cv2
import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import Writer
from rosbags.highlevel import AnyReader

import mjsim
from mjsim.errors import UsageError
from mjsim.geometry import Pose3
from mjsim.logs.bags import Bag
from tests.bags import START, new_bag, write_scans
from tests.real_logs import imported


def test_a_stamp_of_zero_is_a_time_where_the_clock_begins_at_zero(tmp_path):
    with new_bag(tmp_path / "run") as bag:
        for k in range(20):
            header, recorded = bag.header(0.1 * k, "laser"), START + 0.13 * k
            bag.put(
                "/odom", recorded, bag.odometry(bag.header(0.1 * k, "odom"), "base_link", Pose3(0.1 * k, *[0] * 5, 1))
            )
            bag.put("/scan", recorded, bag.scan(header, np.full(9, 1.0 + k), -0.4, 0.1, (0.1, 50.0)))
    run = imported(tmp_path / "run")
    scans = [seen.scans["scan"] for seen in run.observations("robot") if seen.scans]
    assert [scan.ranges[0] for scan in scans] == [1.0 + k for k in range(20)]
    assert run.metadata["log start"] == "0.0"
    assert sum(seen.odometry.forward for seen in run.observations("robot")) == pytest.approx(1.9)
    assert run.metadata["/scan messages left out"] == "0"


def test_headers_that_nobody_filled_in_have_the_time_of_the_recorder(tmp_path):
    with new_bag(tmp_path / "run") as bag:
        for k in range(20):
            at = START + 0.1 * k
            bag.put("/odom", at, bag.odometry(bag.header(at, "odom"), "base_link", Pose3(0.1 * k, *[0] * 5, 1)))
            bag.put("/scan", at, bag.scan(bag.header(0.0, "laser"), np.full(9, 1.0 + k), -0.4, 0.1, (0.1, 50.0)))
    run = imported(tmp_path / "run")
    assert len([seen for seen in run.observations("robot") if seen.scans]) == 20


def test_the_last_fixed_frame_counts_and_the_first_of_a_moving_one(tmp_path):
    with new_bag(tmp_path / "run") as bag:
        for k in range(20):
            at, place = START + 0.1 * k, np.eye(4)
            place[0, 3] = 0.5 if k < 9 else 0.2
            bag.transforms("/tf_static", at, [("base_link", "laser", place)])
            bag.transforms("/tf", at, [("base_link", "head", place)])
            for name in ("laser", "head"):
                bag.put(f"/{name}", at, bag.scan(bag.header(at, name), np.full(9, 1.0), -0.4, 0.1, (0.1, 50.0)))
    (robot,) = imported(tmp_path / "run").world.robots
    assert {sensor.lidar: sensor.at[0] for sensor in robot.sensors} == {"laser": 0.2, "head": 0.5}


def test_pictures_beside_scans_keep_the_times_at_which_they_were_taken(tmp_path):
    taken = START + 0.017 + 0.1 * np.arange(20)
    with new_bag(tmp_path / "run") as bag:
        for k, at in enumerate(taken.tolist()):
            picture = cv2.imencode(".png", np.full((32, 32, 3), k, dtype=np.uint8))[1].tobytes()
            bag.put("/scan", at - 0.017, bag.scan(bag.header(at - 0.017, "laser"), np.ones(9), -0.4, 0.1, (0.1, 50.0)))
            bag.put("/cam/image/compressed", at, bag.compressed(bag.header(at, "cam"), "png", picture))
    run = imported(tmp_path / "run")
    stamps = np.array([stamp for stamp, _ in run.images("robot", "cam")]) + float(run.metadata["log start"])
    np.testing.assert_allclose(stamps, taken, atol=1e-6)  # Doubles of times since 1970 have 2.4e-7 s.
    again = mjsim.replay(run, robot="robot", estimator=Counting())
    assert [stamp for stamp, _ in again.images("robot", "cam")] == [stamp for stamp, _ in run.images("robot", "cam")]


class Counting:
    """An estimator that looks at each picture."""

    def start(self, robot, catalogue, rng):
        self.seen = 0

    def update(self, seen):
        for frame in seen.cameras.values():
            assert (frame.image == self.seen).all()
            assert frame.stamp <= seen.time
            self.seen += 1
        return mjsim.Estimate(mjsim.Pose(0.0, 0.0, 0.0), np.eye(3))


@pytest.mark.parametrize("merged", [0, 11])
def test_a_database_of_a_killed_recorder_is_read_with_its_log_which_stays_as_it_is(merged, tmp_path):
    write_scans(tmp_path / "whole", "sqlite")
    (file,) = (tmp_path / "whole").glob("*.db3")
    killed = tmp_path / "killed"
    killed.mkdir()
    with closing(sqlite3.connect(file)) as whole, closing(sqlite3.connect(tmp_path / "live.db3")) as live:
        live.execute("PRAGMA journal_mode=WAL")
        live.execute("PRAGMA wal_autocheckpoint=0")
        for number, line in enumerate(line for line in whole.iterdump() if line.startswith(("CREATE", "INSERT"))):
            live.execute(line)
            if number == merged:
                live.commit()
                live.execute("PRAGMA wal_checkpoint")
        live.commit()
        for part in ("live.db3", "live.db3-wal"):
            shutil.copy(tmp_path / part, killed / part)
    before = {each.name: each.read_bytes() for each in killed.iterdir()}
    run = imported(killed)
    assert len([seen for seen in run.observations("robot") if seen.scans]) == 10
    assert {each.name: each.read_bytes() for each in killed.iterdir()} == before


@pytest.mark.slow
@pytest.mark.parametrize("name", ["run #1", "was?", "50%41", "ünï cödé", "-x-"])
@pytest.mark.parametrize("form", ["sqlite", "mcap"])
def test_a_bag_may_have_any_name(name, form, tmp_path):
    write_scans(tmp_path / "plain", form)
    (tmp_path / "plain").rename(tmp_path / name)
    run = imported(tmp_path / name)
    assert len([seen for seen in run.observations("robot") if seen.scans]) == 10
    assert "bag breaks off" not in run.metadata


@pytest.mark.parametrize(("form", "profile"), [("mcap", ""), ("mcap", "merged"), ("bag", "ros1"), ("bag", "")])
def test_mcap_files_that_were_converted_or_merged_come_in_like_the_bags(form, profile, tmp_path):
    whole = tmp_path / f"whole.{form}"
    write_scans(whole, form)
    with (tmp_path / "run.mcap").open("wb") as stream:
        writer = Writer(stream, chunk_size=1000)
        writer.start(profile=profile)
        channels: dict[str, int] = {}
        with AnyReader([whole]) as reader:
            for connection, time, data in reader.messages():
                name = connection.msgtype if form == "mcap" else connection.msgtype.replace("/msg/", "/")
                if connection.topic not in channels:
                    old = ("ros1msg", "ros1") if form == "bag" else ("ros2msg", "cdr")
                    schema = writer.register_schema(name, old[0], b"")
                    channels[connection.topic] = writer.register_channel(connection.topic, old[1], schema)
                writer.add_message(channels[connection.topic], time, bytes(data), time)
        writer.finish()
    run, expected = imported(tmp_path / "run.mcap"), imported(whole)
    assert "bag breaks off" not in run.metadata
    pairs = zip(run.observations("robot"), expected.observations("robot"), strict=True)
    scans = [(seen.scans["scan"], other.scans["scan"]) for seen, other in pairs if other.scans]
    assert len(scans) == 10
    for scan, other in scans:
        np.testing.assert_array_equal(scan.ranges, other.ranges)
        assert scan.stamp == other.stamp
    # A recording of mjsim is an MCAP file too, but not of ROS.
    with pytest.raises(UsageError, match="is an MCAP file but not of ROS"):
        imported(run.path)


def test_an_mcap_of_other_types_than_those_of_ros_is_refused_with_their_names(tmp_path):
    path = tmp_path / "run.mcap"
    for language, names in (
        ("jsonschema", ["foxglove.LaserScan", "foxglove.PoseInFrame"]),
        ("protobuf", ["foxglove.Grid"]),
    ):
        with path.open("wb") as file:
            writer = Writer(file)
            writer.start(profile="", library="foxglove")
            for name in names:
                writer.register_channel(f"/{name}", "json", writer.register_schema(name, language, b"{}"))
            writer.finish()
        held = ", ".join(f"{name} ({language})" for name in names)
        with pytest.raises(UsageError) as refused:
            imported(path)
        assert f"is an MCAP file but not of ROS: it holds {held}; record topics of ROS (ros2 bag" in str(refused.value)


def test_a_bag_with_an_imu_alone_comes_in(tmp_path):
    with new_bag(tmp_path / "run") as bag:
        for k in range(100):
            at = START + 0.01 * k
            bag.put(
                "/imu/data", at, bag.imu(bag.header(at, "imu"), np.array([0.0, 0.0, 9.81]), np.array([0, 0, 0.01 * k]))
            )
    run = imported(tmp_path / "run")
    readings = [reading for seen in run.observations("robot") for reading in seen.imu]
    np.testing.assert_allclose([reading.turn[2] for reading in readings], 0.01 * np.arange(100))
    assert run.metadata["odometry"] == "left out: none; the motion of each tick is unknown"


@pytest.mark.parametrize("options", [{}, {"use_statistics": False}, {"use_chunking": False}])
def test_an_mcap_whose_summary_does_not_repeat_its_topics_holds_the_same_messages(options, tmp_path):
    write_scans(tmp_path / "usual")
    (usual,) = (tmp_path / "usual").glob("*.mcap")
    with usual.open("rb") as source, (tmp_path / "x.mcap").open("wb") as file:
        writer = Writer(file, repeat_channels=False, repeat_schemas=False, **options)
        writer.start("ros2", "another")
        numbers = {}
        for schema, channel, message in make_reader(source).iter_messages():
            if channel.topic not in numbers:
                about = writer.register_schema(schema.name, schema.encoding, schema.data)
                numbers[channel.topic] = writer.register_channel(channel.topic, channel.message_encoding, about)
            writer.add_message(numbers[channel.topic], message.log_time, message.data, message.publish_time)
        writer.finish()
    found = []
    for path in (usual, tmp_path / "x.mcap"):
        with Bag(path) as bag:
            found.append(
                (sorted(bag.messages(bag.types), key=lambda each: (each.time, each.topic)), dict(bag.types), bag.cut)
            )
    assert found[1] == found[0]
    assert len(found[0][0]) == 20
