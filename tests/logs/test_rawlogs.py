"""Rawlogs of MRPT, written here byte by byte as its documentation says, come in with their scans and odometry."""

import gzip
import math
import struct
from pathlib import Path

import numpy as np
import pytest

from mjsim.errors import UsageError
from mjsim.logs import Wishes, import_log
from mjsim.logs.formats.rawlog import is_rawlog, read_rawlog

EPOCH = 11_644_473_600
START = 1_000_000_000.0


def obj(name: str, version: int, data: bytes, *, space: str = "") -> bytes:
    called = f"{space}{name}".encode()
    return bytes([0x80 | len(called)]) + called + bytes([version]) + data + b"\x88"


def ticks(seconds: float | None) -> bytes:
    return struct.pack("<Q", 0 if seconds is None else round((seconds + EPOCH) * 1e7))


def text(words: str) -> bytes:
    return struct.pack("<I", len(words)) + words.encode()


def pose2(x: float, y: float, heading: float, *, space: str = "") -> bytes:
    return obj("CPose2D", 1, struct.pack("<3d", x, y, heading), space=space)


def pose3(version: int, x: float, y: float, z: float, yaw: float, *, upside_down: bool = False) -> bytes:
    """Return a pose in one of the forms that MRPT had over time."""
    c, s, sign = math.cos(yaw), math.sin(yaw), -1.0 if upside_down else 1.0
    turn = np.array([[c, -s * sign, 0.0], [s, c * sign, 0.0], [0.0, 0.0, sign]])
    if version == 3:
        return obj("CPose3D", 3, struct.pack("<12d", x, y, z, *turn.ravel()))
    if version == 2:
        return obj("CPose3D", 2, struct.pack("<7d", x, y, z, math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)))
    whole = np.eye(4)
    whole[:3, :3], whole[:3, 3] = turn, (x, y, z)
    kind, form = ("CMatrixD", "d") if version else ("CMatrix", "f")
    return obj("CPose3D", version, obj(kind, 0, struct.pack(f"<2I16{form}", 4, 4, *whole.ravel())))


def scan(
    version: int,
    at: float | None,
    ranges,
    *,
    pose: bytes,
    leftwards: bool = True,
    space: str = "",
    reach: float = 10.0,
    label: str = "FRONT LASER",
    claims: int | None = None,
) -> bytes:
    """Return a scan as a version writes it; it may claim another."""
    valid = [value < 10.0 for value in ranges]
    data = struct.pack("<fBf", math.pi, leftwards, reach) + pose
    if version < 6:
        data += obj("CMatrix", 0, struct.pack("<2I", 0, 0))
    data += struct.pack(f"<I{len(ranges)}f{len(ranges)}?", len(ranges), *ranges, *valid)
    data += struct.pack("<f", 0.01) + ticks(at)
    if version >= 4:
        data += struct.pack("<f", 0.004)
    if version >= 5:
        data += text(label) + struct.pack("<d", 0.0)
    if version >= 7:
        data += b"\x00"
    if version >= 8:
        data += struct.pack("<f", 0.05)
    return obj("CObservation2DRangeScan", version if claims is None else claims, data, space=space)


def odometry(at: float | None, x: float = 0.0) -> bytes:
    return obj("CObservationOdometry", 0, pose2(x, 0.0, 0.2) + text("ODO") + ticks(at))


def landmarks(
    *, spread: float = 0.1, elevation: float = 0.0, claims: int = 3, pose: bytes | None = None, at: float = START
) -> bytes:
    """Return an observation of three landmarks; it may claim to have more."""
    data = struct.pack("<4f", 0.0, 5.0, 1.0, 1.0) + (pose or pose3(3, 0.5, 0.0, 0.2, 0.0)) + ticks(at) + b"\x00"
    data += struct.pack("<3fI", spread, 0.02, 0.02, claims) + 3 * struct.pack("<3fi", 2.0, 0.1, elevation, 7)
    return obj("CObservationBearingRange", 3, data + text("CAM"))


def action(x: float, y: float, heading: float) -> bytes:
    noise = struct.pack("<i6fi6f", 0, *[0.01] * 6, 100, *[0.1] * 6)
    move = struct.pack("<i", 0) + pose2(x, y, heading) + noise + b"\x00" + b"\x00" + ticks(START)
    return obj("CActionCollection", 0, struct.pack("<I", 1) + obj("CActionRobotMovement2D", 7, move))


def frame(*observations: bytes) -> bytes:
    return obj("CSensoryFrame", 2, struct.pack("<I", len(observations)) + b"".join(observations))


def written(folder: Path, data: bytes, *, packed: bool = True) -> Path:
    path = folder / "run.rawlog"
    path.write_bytes(gzip.compress(data) if packed else data)
    return path


RANGES = [1.0, 2.0, 3.0, 12.0, 0.0]


def scans_of(log):
    (readings,) = log.robot.scans.values()
    return [readings.take(number) for number in range(len(readings.stamps))]


@pytest.mark.parametrize("version", range(3, 9))
@pytest.mark.parametrize("packed", [True, False])
def test_pairs_of_actions_and_observations_are_odometry_and_scans(version, packed, tmp_path):
    pose = pose3(min(version % 4, 3), 0.2, 0.1, 0.4, 0.5)
    data = frame(scan(version, START, RANGES, pose=pose))
    for number in range(1, 5):
        data += action(0.5, 0.0, math.pi / 2) + frame(scan(version, START + number, RANGES, pose=pose))
    path = written(tmp_path, data, packed=packed)
    assert is_rawlog(path)
    log = read_rawlog(path)
    # A square: after four times half a metre and a quarter of a turn it is back.
    assert log.robot.track[:, 0] == pytest.approx(START + np.arange(5), abs=1e-5)
    assert log.robot.track[:, 1:3] == pytest.approx(
        np.array([[0, 0], [0.5, 0], [0.5, 0.5], [0, 0.5], [0, 0]]), abs=1e-9
    )
    (mount,) = log.mounts.values()
    assert (mount.at, mount.yaw) == (pytest.approx((0.2, 0.1, 0.4), abs=1e-6), pytest.approx(0.5, abs=1e-3))
    assert set(log.robot.scans) == ({"FRONT_LASER"} if version >= 5 else {"laser"})
    first = scans_of(log)[0]
    assert first.ranges.tolist() == [1.0, 2.0, 3.0, math.inf, -math.inf]
    assert (first.angle_min, first.angle_increment) == pytest.approx((-math.pi / 2, math.pi / 4))
    assert not {key for key in log.notes if "left out" in key}


@pytest.mark.parametrize(("leftwards", "upside_down"), [(True, False), (False, False), (True, True), (False, True)])
def test_beams_are_in_order_from_right_to_left_however_the_scanner_hangs(leftwards, upside_down, tmp_path):
    pose = pose3(3, 0.0, 0.0, 0.4, 0.0, upside_down=upside_down)
    data = b"".join(frame(scan(8, START + k, RANGES, pose=pose, leftwards=leftwards)) for k in range(3))
    found = scans_of(read_rawlog(written(tmp_path, data)))[0].ranges.tolist()
    assert (found if leftwards != upside_down else found[::-1])[:3] == [1.0, 2.0, 3.0]


def test_observations_one_after_the_other_have_their_own_times_and_others_are_counted(tmp_path):
    space = "mrpt::obs::"
    data = b""
    for number in range(4):
        place = pose2(0.1 * number, 0.0, 0.2, space="mrpt::poses::")
        data += obj("CObservationOdometry", 2, place + text("ODO") + ticks(START + number) + b"\x00\x00", space=space)
        data += scan(8, START + number + 0.5, RANGES, pose=pose3(3, 0, 0, 0.3, 0), space=space)
        data += obj("CObservationIMU", 4, b"\x01" * 40 + pose3(3, 0, 0, 0, 0) + b"\x07" * 9, space=space)
    log = read_rawlog(written(tmp_path, data))
    assert log.robot.track[:, 1] == pytest.approx([0.0, 0.1, 0.2, 0.3])
    assert log.robot.track[:, 0] == pytest.approx(START + np.arange(4), abs=1e-5)
    assert log.notes == {"CObservationIMU left out": "4"}
    assert scans_of(log)[0].time_increment == pytest.approx(0.05 / 4)


def test_scans_come_in_order_of_their_times_each_once(tmp_path):
    data = b"".join(
        obj(
            "CObservationOdometry", 2, pose2(0.1 * number, 0.0, 0.0) + text("ODO") + ticks(START + number) + b"\x00\x00"
        )
        + scan(8, START + late, [1.0 + late, *RANGES[1:]], pose=pose3(3, 0, 0, 0.3, 0))
        for number, late in enumerate([2.5, 0.5, 1.5, 0.5])
    )
    scans = scans_of(read_rawlog(written(tmp_path, data)))
    assert [scan.stamp - START for scan in scans] == pytest.approx([0.5, 1.5, 2.5], abs=1e-5)
    assert [scan.ranges[0] for scan in scans] == pytest.approx([1.5, 2.5, 3.5])


def test_landmarks_are_sightings_from_the_robot(tmp_path):
    def seen(at: float) -> bytes:
        head = struct.pack("<4f", 0.0, 5.0, 1.0, 1.0) + pose3(3, 0.5, 0.0, 0.2, math.pi / 2) + ticks(at) + b"\x00"
        marks = struct.pack("<3fI", 0.1, 0.02, 0.02, 2)
        marks += struct.pack("<3fi", 2.0, -math.pi / 2, 0.0, 7) + struct.pack("<3fi", 2.0, 0.0, math.pi / 3, -1)
        return obj("CObservationBearingRange", 3, head + marks + text("CAM"))

    data = b"".join(frame(seen(START + number)) + action(0.1, 0, 0) for number in range(3))
    known, nameless, *_ = read_rawlog(written(tmp_path, data)).robot.sightings
    assert (known.name, known.range, known.bearing) == ("landmark7", pytest.approx(2.5), pytest.approx(0.0, abs=1e-6))
    assert (nameless.name, nameless.range) == (None, pytest.approx(math.hypot(0.5, 1.0)))
    assert nameless.bearing == pytest.approx(math.atan2(1.0, 0.5))
    assert np.sqrt(np.diag(known.covariance)) == pytest.approx([0.1, 0.02])


def test_a_rawlog_without_times_has_even_ones_and_says_so(tmp_path):
    data = b"".join(frame(scan(8, None, RANGES, pose=pose3(3, 0, 0, 0.3, 0))) + action(0.1, 0, 0) for _ in range(5))
    log = read_rawlog(written(tmp_path, data))
    assert np.diff(log.robot.track[:, 0]) == pytest.approx(0.1)
    assert log.notes["times"] == "guessed: 5 observations have none; 0.1 s from one to the next"


def test_the_lidars_and_the_kinds_of_what_is_left_out_are_bounded(tmp_path):
    """A scanner that is turned by a motor has another place in each scan; a hostile file, many classes."""
    places = b"".join(scan(8, START + k, RANGES, pose=pose3(3, 0.01 * k, 0, 0.3, 0)) for k in range(60))
    labels = b"".join(scan(8, START + k, RANGES, pose=pose3(3, 0, 0, 0.3, 0), label=f"L{k}") for k in range(60))
    others = b"".join(obj(f"CObservationX{k}", 0, b"") for k in range(500))
    for data in (places, labels):
        log = read_rawlog(written(tmp_path, odometry(START) + odometry(START + 60, 1.0) + data + others))
        assert len(log.robot.scans) == 20
        assert log.notes["scans of more than 20 lidars, or places of them left out"] == "40"
        assert sum(int(count) for key, count in log.notes.items() if "X" in key or "other" in key) == 500
        assert len(log.notes) < 60


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (obj("CObservationGPS", 1, b"\x00" * 30), "neither 2-D scans, landmarks nor odometry of MRPT; it has 1"),
        (scan(8, START, [1.0] * 5, pose=b"\x00" * 30), "it has 1 broken CObservation2DRangeScan"),
        (scan(8, START, [1.0] * 5, pose=pose3(3, math.nan, 0, 0, 0)), "it has 1 broken CObservation2DRangeScan"),
        (scan(8, START, [1.0], pose=pose3(3, 0, 0, 0, 0)), "it has 1 broken CObservation2DRangeScan"),
        (scan(8, START, [1.0] * 5, pose=pose3(3, 0, 0, 0, 0), reach=math.inf), "(its numbers are not a valid scan)"),
        (scan(8, START, [1.0] * 5, pose=pose3(3, 0, 0, 0, 0), claims=200), "CObservation2DRangeScan of version 200"),
        (scan(8, None, [1.0] * 5, pose=pose3(3, 0, 0, 0, 0)), "CObservation2DRangeScan (it has no time)"),
        (odometry(None), "it has 1 broken CObservationOdometry (it has no time)"),
        (landmarks(spread=math.nan), "CObservationBearingRange (its numbers are not valid landmarks)"),
        (landmarks(claims=5000), "CObservationBearingRange (its numbers are not valid landmarks)"),
        (landmarks(elevation=math.inf), "it has 3 landmarks without a range"),
        (landmarks(pose=obj("CPose3D", 3, struct.pack("<12d", *[0.0] * 3, *[9.0] * 9))), "a pose is not a rotation"),
    ],
)
def test_a_rawlog_without_anything_to_read_is_one_line(data, says, tmp_path):
    path = written(tmp_path, data)
    with pytest.raises(UsageError) as caught:
        read_rawlog(path)
    assert says in str(caught.value)


def test_a_rawlog_that_was_cut_is_read_as_far_as_it_goes(tmp_path):
    pose = pose3(3, 0, 0, 0.3, 0)
    rng = np.random.default_rng(0)
    data = b"".join(frame(scan(8, START + k, rng.uniform(1, 9, 181), pose=pose)) + action(0.1, 0, 0) for k in range(20))
    path = written(tmp_path, data)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    log = read_rawlog(path)
    assert 5 < len(log.robot.track) < 15
    assert "truncated or damaged" in log.notes["file"]
    assert not is_rawlog(Path(__file__))


@pytest.mark.slow
def test_a_rawlog_is_a_recording_by_way_of_the_guarded_reader(tmp_path):
    pose = pose3(3, 0.1, 0, 0.3, 0)
    data = b"".join(frame(scan(8, START + k / 5, [2.0] * 90, pose=pose)) + action(0.1, 0, 0.05) for k in range(20))
    recording = import_log(written(tmp_path, data), wishes=Wishes())
    assert recording.metadata["log"] == "rawlog"
