"""Bags of ROS 1 without an index or without chunks, and those of version 1.2: the same messages as in a usual one."""

import struct
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest

from mjsim.errors import UsageError
from mjsim.logs.bags.bag_file import Bag
from tests.bags import write_scans
from tests.real_logs import imported

LEAST = 4096
"""Size of the head of a bag [bytes]."""


def _fields(data: bytes) -> dict[str, bytes]:
    """Return the fields of a header, each with its length before it."""
    fields, at = {}, 0
    while at < len(data):
        (size,) = struct.unpack_from("<I", data, at)
        name, _, value = data[at + 4 : at + 4 + size].partition(b"=")
        fields[name.decode()] = value
        at += 4 + size
    return fields


def _records(data: bytes) -> Iterator[tuple[dict[str, bytes], bytes, bytes]]:
    """Yield the fields, the data and all bytes of each record."""
    file = BytesIO(data)
    while file.tell() < len(data):
        begin = file.tell()
        fields = _fields(file.read(struct.unpack("<I", file.read(4))[0]))
        content = file.read(struct.unpack("<I", file.read(4))[0])
        yield fields, content, data[begin : file.tell()]


def _record(fields: dict[str, bytes], content: bytes) -> bytes:
    head = b"".join(struct.pack("<I", len(k) + 1 + len(v)) + k.encode() + b"=" + v for k, v in fields.items())
    return struct.pack("<I", len(head)) + head + struct.pack("<I", len(content)) + content


def _inner(path: Path) -> list[tuple[dict[str, bytes], bytes, bytes]]:
    """Return the records in the chunks of a bag."""
    data = path.read_bytes().partition(b"\n")[2]
    chunks = [content for fields, content, _ in _records(data) if fields["op"] == b"\x05"]
    return [record for chunk in chunks for record in _records(chunk)]


def _without_chunks(path: Path, *, indexed: bool) -> bytes:
    numbers = {"index_pos": LEAST if indexed else 0}
    head = {"op": b"\x03", **{name: struct.pack("<Q", each) for name, each in numbers.items()}}
    head |= {"conn_count": struct.pack("<I", 2), "chunk_count": bytes(4)}
    empty = _record(head, b"")
    return b"#ROSBAG V2.0\n" + _record(head, b" " * (LEAST - len(empty))) + b"".join(raw for *_, raw in _inner(path))


def _old(path: Path) -> bytes:
    parts, topics = [_record({"op": b"\x03", "index_pos": bytes(8)}, b"")], {}
    for fields, content, _ in _inner(path):
        if fields["op"] == b"\x07":
            about = _fields(content)
            named = {"topic": fields["topic"], "md5": about["md5sum"], "type": about["type"]}
            topics[fields["conn"]] = named
            parts.append(_record({"op": b"\x01", **named, "def": about["message_definition"]}, b""))
        else:
            time = {"sec": fields["time"][:4], "nsec": fields["time"][4:]}
            parts.append(_record({"op": b"\x02", **topics[fields["conn"]], **time}, content))
    return b"#ROSBAG V1.2\n" + b"".join(parts)


@pytest.mark.parametrize("form", ["unindexed", "no chunks", "no chunks, unindexed", "1.2", "1.2, cut"])
def test_bags_without_an_index_or_chunks_and_old_ones_hold_the_same_messages(form, tmp_path):
    usual, other = tmp_path / "usual.bag", tmp_path / "other.bag.active"
    write_scans(usual, "bag")
    data = bytearray(usual.read_bytes())
    at = data.index(b"index_pos=") + len(b"index_pos=")
    data[at : at + 8] = bytes(8)
    changed = {
        "unindexed": bytes(data),
        "no chunks": _without_chunks(usual, indexed=True),
        "no chunks, unindexed": _without_chunks(usual, indexed=False),
        "1.2": _old(usual),
        "1.2, cut": _old(usual)[:-40],
    }
    other.write_bytes(changed[form])
    found = {}
    for path in (usual, other):
        with Bag(path) as bag:
            found[path] = list(bag.messages(bag.types)), bag.types, bool(bag.cut)
    is_cut = form.endswith("cut")
    assert found[other][0] == (found[usual][0][:-1] if is_cut else found[usual][0])
    assert found[other][1:] == (found[usual][1], is_cut)
    scans = [seen.scans["scan"].ranges for seen in imported(other).observations("robot") if seen.scans]
    expected = [seen.scans["scan"].ranges for seen in imported(usual).observations("robot") if seen.scans]
    np.testing.assert_array_equal(scans, expected[: len(scans)])
    assert len(scans) >= len(expected) - is_cut


@pytest.mark.parametrize("magic", [b"#ROSBAG V1.1\n", b"#ROSBAG V3.0\n", b"#ROSBAG V1.2\n", b"#ROSBAG V2.0\n"])
def test_bags_of_other_versions_and_empty_ones_are_one_line(magic, tmp_path):
    (tmp_path / "x.bag").write_bytes(magic + bytes(50))
    with pytest.raises(UsageError, match=r"x\.bag' (is not a readable bag|holds no odometry)") as caught:
        imported(tmp_path / "x.bag")
    assert "\n" not in str(caught.value)
