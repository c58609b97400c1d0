"""A recording from a stranger takes little time and memory, whatever it says that it holds."""

import json
import struct
import sys
import time
from collections.abc import Callable
from pathlib import Path

import lz4.frame
import pytest
import zstandard
from mcap.writer import CompressionType

from tests.children import completed
from tests.hostile_recordings import Content, Parts, refused, taken_apart

BOMB = """
import resource, sys, time
resource.setrlimit(resource.RLIMIT_AS, (3 << 30, 3 << 30))
import mjsim
for path in sys.argv[1:]:
    before = time.process_time()
    try:
        mjsim.read_recording(path)
    except mjsim.RecordingError as error:
        print(time.process_time() - before < 10, error)
"""


def _chunk(kind: str, data: bytes, size: int) -> bytes:
    content = struct.pack("<QQQI", 0, 0, size, 0) + struct.pack("<I", len(kind)) + kind.encode()
    content += struct.pack("<Q", len(data)) + data
    return b"\x06" + struct.pack("<Q", len(content)) + content


def _small_messages(count: int) -> bytes:
    return (b"\x05" + struct.pack("<Q", 22) + bytes(22)) * count


BOMBS: dict[str, tuple[Callable[[], bytes], str]] = {
    "zstd": (
        lambda: _chunk("zstd", zstandard.compress(bytes(1 << 28), 1), 1 << 28),
        "a record of more than 134 MB",
    ),
    "lz4": (lambda: _chunk("lz4", lz4.frame.compress(bytes(1 << 28)), 1 << 28), "a record of more than 134 MB"),
    "chunks": (
        lambda: _chunk("zstd", zstandard.compress(bytes(1 << 27), 1), 1 << 27) * 9,
        "decompresses to far more",
    ),
    "messages": (
        lambda: _chunk("zstd", zstandard.compress(_small_messages(400_000), 1), 31 * 400_000) * 5,
        "far more messages",
    ),
    "gzip": (lambda: _chunk("gzip", b"", 0), "is compressed by 'gzip', not by zstd or lz4"),
}
"""What makes the chunks of a file, and what is said of it."""


@pytest.mark.slow
def test_what_unpacks_to_far_more_is_refused_in_little_memory(good: bytes, tmp_path: Path):
    paths = [tmp_path / f"{name}.mcap" for name in BOMBS]
    for path, (make, _) in zip(paths, BOMBS.values(), strict=True):
        path.write_bytes(good[: good.index(b"\x06", 8)][:8] + make())
    done = completed([sys.executable, "-c", BOMB, *paths], check=False)
    lines = done.stdout.splitlines()
    for path, line, (_, said) in zip(paths, lines, BOMBS.values(), strict=True):
        assert line.startswith(f"True '{path}'"), done.stderr
        assert said in line


PEAK = """
import sys, time
import mjsim
from mjsim.record import recording_reader
def peak():
    return 1024 * next(int(line.split()[1]) for line in open("/proc/self/status") if line.startswith("VmHWM"))
good, *paths = sys.argv[1:]
mjsim.read_recording(good)
recording_reader.MIN_MEMORY = 0
for path in paths:
    open("/proc/self/clear_refs", "w").write("5")
    held, before = peak(), time.process_time()
    try:
        mjsim.read_recording(path)
    except mjsim.RecordingError as error:
        print(peak() - held, time.process_time() - before, error)
"""
TINY_SIGHTING = {"stamp": 0, "range": 1, "bearing": 0, "covariance": [1, 0, 0, 1], "name": "a"}
TINY_INNOVATION = {"name": "a", "numbered": False, "nu": [0, 0], "S": [0, 0, 0, 0]}
GREEDY: dict[str, tuple[str, Content, int]] = {
    "sightings": ("/scout/sightings", {"time": 0, "sightings": [TINY_SIGHTING] * 1000}, 300),
    "innovations": ("/scout/innovations", {"time": 0, "innovations": [TINY_INNOVATION] * 1000}, 350),
    "parts of one tick": ("/timing", {"time": 0, "clock": 0, "parts": [{"part": "a", "seconds": 0}] * 60_000}, 1),
    "a long text": ("/timing", {"time": 0, "clock": 0, "parts": [{"part": "\N{GRINNING FACE}" * (1 << 22)}]}, 1),
}


def greedy(good: bytes, path: Path, topic: str, content: Content, times: int) -> int:
    """Write a recording with a message that takes far more memory than bytes; return what it may take [bytes]."""
    parts = taken_apart(good)
    _, schema, encoding, *_ = next(message for message in parts.messages if message[0] == topic)
    state = next(message for message in parts.messages if message[0] == "/state")
    one = (topic, schema, encoding, 0, json.dumps(content, separators=(",", ":"), ensure_ascii=False).encode())
    parts.messages = [one, state] * times if times > 1 else [one, *[state] * 36_000]
    data = parts.write(path, compression=CompressionType.ZSTD).read_bytes()
    size = max(400_000, len(data) + 1000)
    room = size - len(data)
    # What is passed over lets the file look larger, so that it may take more.
    path.write_bytes(data[:8] + b"\x7f" + struct.pack("<Q", room) + bytes(room) + data[8:])
    return 64 * size + 4 * len(one[-1])  # in its chunk, by itself, as text and as what it says


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="only Linux tells how much memory there was at most")
def test_few_megabytes_take_no_more_memory_than_is_said(good: bytes, tmp_path: Path):
    (tmp_path / "good.mcap").write_bytes(good)
    paths = [tmp_path / f"{name}.mcap" for name in GREEDY]
    limits = [greedy(good, path, *what) for path, what in zip(paths, GREEDY.values(), strict=True)]
    done = completed([sys.executable, "-c", PEAK, tmp_path / "good.mcap", *paths], check=False)
    for line, most in zip(done.stdout.splitlines(), limits, strict=True):
        memory, seconds, said = line.split(" ", 2)
        assert "it would take far more memory" in said
        assert int(memory) < most, said
        assert float(seconds) < 15


def test_lengths_that_say_more_than_the_file_has_end_it_and_ask_for_no_memory(good: bytes, tmp_path: Path):
    path = tmp_path / "run.mcap"
    attachment = struct.pack("<QQII", 0, 0, 0, 0)
    for length in (1 << 20, 1 << 40, (1 << 63) - 1, (1 << 64) - 1):
        for record_ in (
            b"\x09" + struct.pack("<Q", length),
            b"\x09" + struct.pack("<Q", len(attachment) + 12) + attachment + struct.pack("<Q", length) + bytes(4),
            b"\x04" + struct.pack("<Q", 8) + bytes(4) + struct.pack("<I", length & 0xFFFFFFFF),
        ):
            path.write_bytes(good[:8] + record_)
            before = time.process_time()
            assert "holds no tick" in refused(path)
            assert time.process_time() - before < 1.0


@pytest.mark.slow
def test_many_ticks_times_many_names_are_refused_before_the_arrays_are_made(
    parts: Parts, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    from mjsim.record import recording_reader

    monkeypatch.setattr(recording_reader, "MIN_MEMORY", 0)
    monkeypatch.setattr(recording_reader, "MEMORY_GROWTH", 1)
    many = [f"l{number}" for number in range(2000)]

    def grow(content: Content) -> None:
        content.update(
            names=many,
            numbered=[False] * len(many),
            poses=[content["poses"][0]] * len(many),
            covariances=[0.0] * 4 * len(many),
        )

    assert "far more memory" in refused(parts.change("/scout/landmarks", grow).write(tmp_path / "run.mcap"))
