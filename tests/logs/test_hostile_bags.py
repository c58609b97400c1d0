"""Bags that claim more than they hold, or hold more than memory."""

import math
import os
import struct
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import Writer
from rosbags.typesys import Stores, get_typestore

from mjsim.errors import UsageError
from mjsim.geometry import Pose, Pose3
from mjsim.logs.bags.bag_file import Bag as RosBag
from tests.bags import START, Bag, new_bag, write_scans, zstd
from tests.real_logs import imported


def _mcap(chunk: bytes, size: int) -> bytes:
    """Return an MCAP file of ROS 2 with one zstd chunk that says it has a size."""

    def record(kind: int, data: bytes) -> bytes:
        return struct.pack("<BQ", kind, len(data)) + data

    def text(word: bytes) -> bytes:
        return struct.pack("<I", len(word)) + word

    head = struct.pack("<QQQI", 0, 10, size, 0) + text(b"zstd") + struct.pack("<Q", len(chunk))
    magic = b"\x89MCAP0\r\n"
    ends = record(15, bytes(4)) + record(2, bytes(20))
    return magic + record(1, text(b"ros2") + text(b"")) + record(6, head + chunk) + ends + magic


def test_a_chunk_that_is_larger_than_it_says_is_not_unpacked(tmp_path: Path):
    (tmp_path / "bomb.mcap").write_bytes(_mcap(zstd.compress(bytes(100_000)), 1000))
    with pytest.raises(UsageError, match="is not a readable bag"):
        imported(tmp_path / "bomb.mcap")


def test_files_of_a_bag_are_what_they_are_said_to_be(tmp_path: Path):
    write_scans(tmp_path / "packed", "sqlite-file")
    (file,) = (tmp_path / "packed").glob("*.zstd")
    file.write_bytes(zstd.compress(bytes(100_000)))
    with pytest.raises(UsageError, match="is not a readable bag"):
        imported(tmp_path / "packed")
    write_scans(tmp_path / "pipe", "sqlite")
    (file,) = (tmp_path / "pipe").glob("*.db3")
    file.unlink()
    os.mkfifo(file)
    with pytest.raises(UsageError, match=r"run\.db3|pipe\.db3.*: it is not a file"):
        imported(tmp_path / "pipe")


def test_metadata_of_any_length_is_left_out_and_said(tmp_path: Path):
    write_scans(tmp_path / "run", "mcap")
    with (tmp_path / "run" / "metadata.yaml").open("a") as file:
        file.write("#" * (17 << 20))
    run = imported(tmp_path / "run")
    assert run.metadata["metadata.yaml left out"].startswith("it has 17,8")
    assert "bag breaks off" not in run.metadata


def test_scans_in_degrees_are_left_out_with_the_reason(tmp_path: Path):
    with new_bag(tmp_path / "run") as bag:
        for k in range(5):
            at = START + 0.1 * k
            bag.put("/scan", at, bag.scan(bag.header(at, "laser"), np.full(360, 2.0), -180.0, 1.0, (0.1, 5.0)))
            bag.put("/odom", at, bag.odometry(bag.header(at, "odom"), "base_link", Pose3(0, 0, 0, 0, 0, 0, 1)))
    run = imported(tmp_path / "run")
    assert run.metadata["first message of /scan left out"] == "a scan over 359 rad; angles are in radians"


def test_messages_in_a_file_without_chunks_may_be_out_of_order(tmp_path: Path):
    store = get_typestore(Stores.LATEST)
    made = Bag(None, store, ros1=False)
    with (tmp_path / "run.mcap").open("wb") as file:
        writer = Writer(file, use_chunking=False)
        writer.start("ros2", "")
        kind = "nav_msgs/msg/Odometry"
        channel = writer.register_channel("/odom", "cdr", writer.register_schema(kind, "ros2msg", b""))
        for k in (*range(10), *range(20, 30), *range(10, 20)):
            at = START + 0.1 * k
            told = made.odometry(made.header(at, "odom"), "base_link", Pose3.from_planar(Pose(0.05 * k, 0.0, 0.0)))
            writer.add_message(channel, round(at * 1e9), bytes(store.serialize_cdr(told, kind)), round(at * 1e9))
        writer.finish()
    run = imported(tmp_path / "run.mcap")
    moved = [seen.odometry.forward for seen in run.observations("robot")]
    assert math.isclose(sum(moved), 1.45, abs_tol=1e-6)
    assert min(moved) >= 0.0


def test_a_bag_without_index_is_whole_unless_it_was_cut(tmp_path: Path):
    write_scans(tmp_path / "run.bag", "bag")
    data = bytearray((tmp_path / "run.bag").read_bytes())
    place = data.index(b"index_pos=") + len(b"index_pos=")
    end = int.from_bytes(data[place : place + 8], "little")
    data[place : place + 8] = bytes(8)
    # Connections and infos of chunks come behind the data; a recorder that was killed has not written them.
    for cut, size in ((False, end), (True, end // 2)):
        (tmp_path / "open.bag.active").write_bytes(data[:size])
        with RosBag(tmp_path / "open.bag.active") as bag:
            assert bool(bag.cut) == cut
            assert 0 < len(list(bag.messages(["/scan"]))) <= 10
