"""Recordings from strangers: whatever a file holds, reading it ends soon, takes little memory, fails in one line."""

import base64
import re
import struct
import sys
from collections.abc import Callable
from io import BytesIO
from pathlib import Path

import cv2
import numpy as np
import pytest
from mcap.records import Message
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType

import mjsim
from mjsim.errors import RecordingError
from mjsim.record import container, export_csv, export_images
from tests.children import LIMIT, completed
from tests.cli.shell import typed
from tests.hostile_recordings import Content, Parts, refused

FUZZ = Path(__file__).parents[2] / "scripts" / "fuzz"


def test_what_was_taken_apart_reads_back_as_it_was(parts: Parts, good: bytes, tmp_path: Path):
    (tmp_path / "good.mcap").write_bytes(good)
    first = mjsim.read_recording(tmp_path / "good.mcap")
    for kind in CompressionType:
        again = mjsim.read_recording(parts.write(tmp_path / f"{kind.name}.mcap", compression=kind))
        np.testing.assert_array_equal(again.qpos, first.qpos)
        np.testing.assert_array_equal(again.robots["scout"].estimate, first.robots["scout"].estimate)
        assert again.whole


ODD: dict[str, tuple[str, Callable[[Content], object], str]] = {
    "a pose of text": ("/scout/truth", lambda c: c.update(heading="north"), "heading: Input should be a valid number"),
    "a pose that is null": ("/scout/estimate", lambda c: c["pose"]["position"].update(x=None), "pose.position.x"),
    "a pose that is not finite": ("/scout/odometry", lambda c: c.update(heading=float("nan")), "finite number"),
    "infinity": ("/state", lambda c: c["qpos"].append(float("inf")), "qpos.14: Input should be a finite number"),
    "a covariance of eight": ("/scout/estimate", lambda c: c["covariance"].pop(), "at least 9 items"),
    "a message without a key": ("/scout/command", lambda c: c.pop("command"), "command: Field required"),
    "a list for an object": ("/timing", lambda c: c.update(parts=[[]]), "parts.0: Input should be"),
    "a name of numbers": ("/scout/landmarks", lambda c: c.update(names=[1] * len(c["names"])), "names.0"),
    "fewer names": ("/scout/landmarks", lambda c: c["names"].pop(), "zip()"),
    "fewer covariances": ("/scout/landmarks", lambda c: c["covariances"].pop(), "cannot reshape"),
    "a number that is none": ("/scout/landmarks", lambda c: c.update(names=["x"], numbered=[True]), "invalid literal"),
    "an unknown event": ("/scout/events", lambda c: c.update(kind="fire"), "kind: Input should be 'bump'"),
    "a truth value for a number": ("/state", lambda c: c.update(time=True), "time: Input should be a valid number"),
    "states of other sizes": ("/state", lambda c: c["qpos"].extend([0.0] * int(c["time"] > 0.1)), "has 15 numbers"),
    "ticks in one place": ("/state", lambda c: c.update(time=0.0), "its ticks are not 0.04 s apart"),
    "ticks far apart": ("/state", lambda c: c.update(time=1e9 * c["time"]), "its ticks are not 0.04 s apart"),
}


@pytest.mark.parametrize(("topic", "edit", "said"), ODD.values(), ids=ODD)
def test_a_message_that_mjsim_does_not_write_is_refused_by_its_topic(
    parts: Parts, tmp_path: Path, topic: str, edit: Callable[[Content], object], said: str
):
    line = refused(parts.change(topic, edit).write(tmp_path / "run.mcap"))
    assert said in line
    assert topic in line or "ticks" in said


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"", "Invalid JSON"),
        (b"\xff\xfe", "Invalid JSON"),
        (b"[" * 100_000, "recursion limit"),
        (b'{"time":' * 100_000, "recursion limit"),
        (b'{"time": 1' + b"0" * 10_000 + b"}", "number out of range"),
        (b"[" + b"[]," * 2_000_000 + b"[]]", "more than 1000000 values"),
    ],
)
def test_deep_long_and_broken_json_is_refused(parts: Parts, tmp_path: Path, data: bytes, said: str):
    assert said in refused(parts.put("/scout/truth", data).write(tmp_path / "run.mcap"))


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("seed", "-1"),
        ("seed", "1e3"),
        ("seed", "9" * 5000),
        ("seed", str(2**63)),
        ("seconds", "nan"),
        ("modules", "[1]"),
        ("modules", "{" * 1000),
        ("replayed modules", '{"estimator": 3}'),
        ("replayed estimator", "EkfSlam"),
    ],
)
def test_what_is_said_of_the_run_is_checked(parts: Parts, tmp_path: Path, key: str, value: str):
    parts.metadata["mjsim"][key] = value
    assert "is not as mjsim writes it" in refused(parts.write(tmp_path / "run.mcap"))


@pytest.mark.parametrize(
    ("name", "data", "said"),
    [
        ("world.yaml", b"\xff", "the world in "),
        ("world.yaml", b"mjsim: 1\nwals: []\n", "unknown key 'wals'"),
        ("world.yaml", b"mjsim: 1\nfloor: {texture: ../../etc/passwd}\n", "is outside its folder"),
        ("world.yaml", b"mjsim: 1\ninclude: [/etc/passwd]\n", "is outside its folder"),
        ("world.yaml", b"mjsim: 1\nbeacons: [{name: a, at: [0, 0], image: files/a.png}]\n", "no file 'files/a.png'"),
        ("world.yaml", b"- " * 3_000_000, "MB"),
        ("world.yaml", b"mjsim: 1\n", "holds no tick"),
    ],
)
def test_a_hostile_world_reads_nothing_outside_and_is_one_line(
    parts: Parts, tmp_path: Path, name: str, data: bytes, said: str
):
    parts.attachments[name] = data
    if said == "holds no tick":
        parts.messages = []
    assert said in refused(parts.write(tmp_path / "run.mcap"))


def test_an_attached_picture_of_many_pixels_is_refused_before_it_is_decoded(parts: Parts, tmp_path: Path):
    head, end = struct.pack(">I4sII5xI", 13, b"IHDR", 60_000, 60_000, 0), struct.pack(">I4sI", 0, b"IEND", 0)
    bomb = b"\x89PNG\r\n\x1a\n" + head + end
    parts.attachments["files/a.png"] = bomb
    parts.attachments["world.yaml"] = b"mjsim: 1\nbeacons: [{name: a, at: [0, 0], image: a.png}]\n"
    assert "'a.png' is a picture of 3600 megapixels" in refused(parts.write(tmp_path / "run.mcap"))


def test_readings_of_sensors_that_the_robot_does_not_have_are_refused_and_nothing_lands_outside(
    parts: Parts, tmp_path: Path
):
    ranges = base64.b64encode(np.zeros(3).tobytes()).decode()
    scan = {"name": "../../up", "stamp": 0.0, "angle_min": 0.0, "angle_increment": 1.0, "range_min": 0.0}
    scan |= {"range_max": 1.0, "ranges": ranges}
    parts.change("/scout/observation", lambda content: content.update(scans=[scan]))
    run = mjsim.read_recording(parts.write(tmp_path / "run.mcap"))
    with pytest.raises(RecordingError, match=r"a reading of '../../up', which is not a sensor of the robot"):
        list(run.observations("scout"))
    with pytest.raises(RecordingError, match="not a sensor"):
        export_csv(run, tmp_path / "deep" / "csv")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run.mcap"]


def test_pictures_of_another_format_or_size_and_broken_ones_are_refused(parts: Parts, tmp_path: Path):
    def picture(data: bytes, form: bytes) -> bytes:
        return b"\x12" + _varint(len(data)) + data + b"\x1a" + _varint(len(form)) + form

    large = cv2.imencode(".png", np.zeros((480, 640, 3), np.uint8))[1].tobytes()
    for data, said in (
        (picture(large, b"../../../x"), "a picture of format"),
        (picture(large, b"png"), "of another size than the camera's"),
        (picture(b"GIF89a", b"png"), "is not a PNG or JPEG"),
        (b"\x12\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff", "not as Foxglove defines it"),
        (b"\x12\x7f", "ends too early"),
        (b"", "a picture of format ''"),
    ):
        run = mjsim.read_recording(parts.put("/scout/front/image", data).write(tmp_path / "run.mcap"))
        with pytest.raises(RecordingError, match=said):
            list(run.images("scout", "front"))
    with pytest.raises(RecordingError):
        export_images(run, tmp_path / "pictures")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run.mcap"]


def _varint(number: int) -> bytes:
    return bytes([number & 0x7F | 0x80, number >> 7 & 0x7F | 0x80, number >> 14])


@pytest.mark.slow
def test_a_joint_covariance_of_more_rows_than_it_has_numbers_is_refused(parts: Parts, tmp_path: Path):
    names = ["a"] * 50_000
    parts.change("/scout/covariance", lambda c: c.update(names=names, numbered=[False] * len(names), size=100_003))
    run = mjsim.read_recording(parts.write(tmp_path / "run.mcap"))
    with pytest.raises(RecordingError, match=r"a covariance of 100003 rows for 50000 landmarks"):
        list(run.joint_covariances("scout"))


def test_topics_that_are_odd_or_missing_are_passed_over(parts: Parts, tmp_path: Path):
    kept = [message for message in parts.messages if message[0] in ("/state", "/scout/truth")]
    odd = [("", *kept[0][1:]), ("state", *kept[0][1:]), ("/nobody/truth", *kept[0][1:]), ("//", *kept[0][1:])]
    parts.messages = [*odd, *kept]
    run = mjsim.read_recording(parts.write(tmp_path / "run.mcap"))
    assert len(run.time) == 20
    assert np.isnan(run.robots["scout"].estimate).all()


@pytest.mark.slow
def test_every_command_says_in_one_line_that_a_recording_is_hostile(
    parts: Parts, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(tmp_path)
    path = parts.change("/scout/truth", lambda content: content.update(heading="north")).write(tmp_path / "run.mcap")
    for words in (
        ("report", path, "-o", "report"),
        ("video", path, "-o", "film.mp4"),
        ("export", path, "--csv", "csv"),
        ("compare", path, "-o", "both"),
        ("replay", path, "--robot", "scout", "--estimator", "mjsim.algorithms.ekf_slam:EkfSlam", "-o", "again.mcap"),
    ):
        code, out, err = typed(*map(str, words), capsys=capsys)
        assert (code, out) == (2, ""), words
        assert "heading: Input should be a valid number" in err.splitlines()[-1]
        assert not any(line.startswith("Traceback") for line in err.splitlines())
    assert sorted(item.name for item in tmp_path.iterdir()) == ["run.mcap"]


def test_bounds_leave_room_for_what_mjsim_writes(good: bytes, tmp_path: Path):
    path = tmp_path / "run.mcap"
    path.write_bytes(good)
    content = sum(len(item.data) for item in StreamReader(BytesIO(good)).records if isinstance(item, Message))
    assert content < container.DECOMPRESSION_LIMITS * len(good) / 4


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["records", "bytes"])
def test_hostile_recordings_by_the_dozen_are_read_or_refused_in_one_line(engine: str):
    # A process of its own: the bound on memory is that of the whole process, and other tests have used theirs.
    command = [sys.executable, str(FUZZ / "recordings.py"), "--engine", engine, "--inputs", "20", "--seed", "7"]
    done = completed(command, within=4 * LIMIT)
    found = re.search(r"20 inputs, (\d+) of them recordings, no traceback", done.stdout)
    assert found is not None
    assert int(found.group(1)) > 2
