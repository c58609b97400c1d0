"""Logs of CARMEN, written from motions that are known exactly."""

import lzma
import math
from pathlib import Path

import numpy as np
import pytest

import mjsim
from mjsim.algorithms.lidar_slam import LidarSlam
from mjsim.datasets import export_carmen, export_rosbag2
from mjsim.errors import UsageError
from mjsim.geometry import Pose
from mjsim.logs import Wishes
from mjsim.logs.formats.carmen import read_carmen
from mjsim.record import export_tum
from tests.real_logs import circle, imported, run_command

START = 976052857.3
HEAD = "# CARMEN Logfile\n# ODOM x y theta tv rv accel\nPARAM robot_frontlaser_offset 0.2 nohost 0\n"
WALL = 3.0
"""Distance of a straight wall ahead of where the robot starts [m]."""


def scan_words(pose: Pose, count: int = 181) -> str:
    """Return the ranges of a laser 0.2 m ahead of a pose to a wall across x, 81.83 where there is none."""
    angles = np.radians(np.arange(count) - 90.0) + pose.heading
    ahead = np.cos(angles)
    gap = WALL - (pose.x + 0.2 * math.cos(pose.heading))
    ranges = np.where(ahead > 0.1, gap / np.maximum(ahead, 0.1), 81.83)
    return " ".join(f"{value:.4f}" for value in ranges)


def write_carmen(path: Path, *, seconds: float = 6.0, count: int = 181, old: bool = True) -> None:
    lines = []
    for row, time in enumerate(np.arange(0.0, seconds, 0.1)):
        pose = Pose.from_array(circle(Pose(0.0, 0.0, 0.0), 0.2, 0.1, np.array([time]))[0])
        place = f"{pose.x:.9f} {pose.y:.9f} {pose.heading:.9f}"
        stamp = f"{START + time:.6f} nohost {time:.6f}"
        lines.append(f"ODOM {place} 0.2 0.1 0 {stamp}")
        if row % 2:
            continue
        if old:
            lines.append(f"FLASER {count} {scan_words(pose, count)} {place} {place} {stamp}")
        else:
            laser = pose @ Pose(0.2, 0.0, 0.0)
            seat = f"{laser.x:.9f} {laser.y:.9f} {laser.heading:.9f}"
            head = f"0 {-math.pi / 2:.9f} {math.pi:.9f} {math.radians(1.0):.12f} 81.0 0.01 0 {count}"
            lines.append(f"ROBOTLASER1 {head} {scan_words(pose, count)} 0 {seat} {place} 0.2 0.1 0.5 0.3 0 {stamp}")
    path.write_text(HEAD + "\n".join(lines) + "\n")


@pytest.mark.parametrize("old", [True, False])
def test_a_log_becomes_a_recording_whose_scans_lie_on_the_wall_at_the_pose_of_odometry(old, tmp_path):
    write_carmen(tmp_path / "room.clf", old=old)
    run = imported(tmp_path / "room.clf")
    assert run.metadata["log"] == "carmen"
    assert run.metadata["front scans left out"] == "0"
    assert float(run.metadata["log start"]) == pytest.approx(START, abs=1e-6)
    seen = [(row, tick) for row, tick in enumerate(run.observations("robot")) if tick.scans]
    assert len(seen) == 30
    track = run.robots["robot"]
    for row, tick in seen:
        at = Pose.from_array(track.odometry[row]) @ Pose(0.2, 0.0, 0.0)
        walls = at.transform(tick.scans["front"].points())
        assert len(walls) > 100
        # Ranges have four decimals; farther aside they stand for more along the wall.
        np.testing.assert_allclose(walls[:, 0], WALL, atol=1e-3)
        assert np.isinf(tick.scans["front"].ranges).sum() > 5
    end = circle(Pose(0.0, 0.0, 0.0), 0.2, 0.1, np.array([run.time[-1]]))[0]
    np.testing.assert_allclose(track.odometry[-1, :2], end[:2], atol=2e-3)
    assert np.isnan(track.truth).all()


def test_all_codes_of_a_scanner_for_no_return_tell_nothing(tmp_path):
    # A SICK scanner says 8183 to 8191 for no return, too much light and other faults.
    write_carmen(tmp_path / "room.clf")
    words = (tmp_path / "room.clf").read_text().split(" ")
    lost = [number for number, word in enumerate(words) if word == "81.8300"]
    for row, number in enumerate(lost):
        words[number] = ("81.83", "81.83", "81.87", "81.91")[row % 4]
    (tmp_path / "room.clf").write_text(" ".join(words))
    run = imported(tmp_path / "room.clf")
    scans = [scan for seen in run.observations("robot") for scan in seen.scans.values()]
    assert sum(int(np.isinf(scan.ranges).sum()) for scan in scans) == len(lost) > 100
    guessed = (
        f"guessed: none where the range is 81.91 m, its largest: {len(lost)} of {scans[0].ranges.size * len(scans)}"
    )
    assert run.metadata["returns of front"] == f"{guessed} ranges"
    assert max(scan.ranges[np.isfinite(scan.ranges)].max() for scan in scans) <= WALL / 0.1
    assert scans[0].range_max < 60.0


def test_scans_that_were_logged_all_at_once_are_told_one_a_tick(tmp_path):
    write_carmen(tmp_path / "room.clf")
    lines = (tmp_path / "room.clf").read_text().splitlines()
    # Six scans in a row within a millisecond, as they come out of a buffer that was full.
    scans = [line for line in lines if line.startswith("FLASER")][:6]
    late = [" ".join([*line.split()[:-3], f"{START + 1.0 + 0.0001 * k:.6f}", "x", "0"]) for k, line in enumerate(scans)]
    kept = [line for line in lines if not (line.startswith("FLASER") and float(line.split()[-3]) < START + 1.15)]
    (tmp_path / "burst.clf").write_text("\n".join([*kept, *late]) + "\n")
    run = imported(tmp_path / "burst.clf", wishes=Wishes(rate_hz=10.0))
    rows = [row for row, tick in enumerate(run.observations("robot")) if tick.scans]
    assert run.metadata["front scans left out"] == "0"
    assert len(rows) == 30
    assert rows[:6] == [10, 11, 12, 13, 14, 15]


def test_a_log_with_a_byte_order_mark_that_was_cut_in_its_last_line_is_read_up_to_there(tmp_path):
    write_carmen(tmp_path / "room.clf", seconds=1.0)
    whole = imported(tmp_path / "room.clf")
    data = (tmp_path / "room.clf").read_bytes()
    (tmp_path / "cut.clf").write_bytes(b"\xef\xbb\xbf" + data + b"FLASER 180 1.0 2.0")
    cut = imported(tmp_path / "cut.clf")
    assert cut.metadata["last line of cut.clf, cut short, left out"] == "1"
    np.testing.assert_array_equal(cut.robots["robot"].odometry, whole.robots["robot"].odometry)


def test_scans_of_a_laser_that_interlaces_its_beams_are_all_kept_with_their_own_angles(tmp_path):
    lines = []
    for k in range(12):  # 181 beams in each fourth scan, else 180 that begin a quarter of a degree later each time
        first, count = math.radians(-90.0 + 0.25 * (k % 4) + (k % 4 > 0)), 181 - (k % 4 > 0)
        ahead = np.cos(first + np.radians(np.arange(count)))
        ranges = " ".join(f"{value:.4f}" for value in np.where(ahead > 0.1, WALL / np.maximum(ahead, 0.1), 81.91))
        head = f"0 {first:.9f} 3.14159 {math.radians(1.0):.12f} 81.9 0.01 0 {count}"
        lines.append(f"ROBOTLASER1 {head} {ranges} 0 0 {k / 10} 0 0 {k / 10} 0 0 0 0 0 0 {k / 5} h {k / 5}")
    (tmp_path / "room.clf").write_text("\n".join(lines))
    run = imported(tmp_path / "room.clf")
    scans = [scan for each in run.observations("robot") for scan in each.scans.values()]
    assert len(scans) == 12
    for scan in scans:
        assert len(scan.points()) > 165
        np.testing.assert_allclose(scan.points()[:, 0], WALL, atol=1e-3)
    said = "mended: 9; the other beams are not measured"
    assert run.metadata["front scans with fewer than 181 beams"] == said


def test_scans_without_beams_are_left_out_and_told_while_their_odometry_stays(tmp_path):
    write_carmen(tmp_path / "room.clf")
    whole = imported(tmp_path / "room.clf")
    lines = (tmp_path / "room.clf").read_text().splitlines()
    at = next(number for number, line in enumerate(lines) if line.startswith("FLASER") and number > 10)
    words = lines[at].split()
    lines[at] = " ".join(["FLASER", "0", *words[2 + int(words[1]) :]])
    (tmp_path / "empty.clf").write_text("\n".join(lines) + "\n")
    run = imported(tmp_path / "empty.clf")
    assert run.metadata["scans of less than 2 beams left out"] == "1"
    np.testing.assert_array_equal(run.robots["robot"].odometry, whole.robots["robot"].odometry)


def test_strengths_of_returns_come_in(tmp_path):
    tail = "0 0 0 0 0 0 0.5 0 0 0 0"
    lines = [f"ROBOTLASER1 0 -0.5 1 0.5 9 0 1 3 1 2 3 3 0.25 {k} 1e3 {tail} {k / 10} h {k / 10}" for k in range(1, 9)]
    (tmp_path / "room.log").write_text("\n".join(lines))
    seen = imported(tmp_path / "room.log").observations("robot")
    scans = [scan for each in seen for scan in each.scans.values()]
    assert [scan.intensities.tolist() for scan in scans] == [[0.25, k, 1000.0] for k in range(1, 9)]


def test_packed_logs_true_poses_and_unknown_messages_are_read(tmp_path):
    write_carmen(tmp_path / "room.clf", seconds=2.0)
    text = (tmp_path / "room.clf").read_text()
    text += (
        f"TRUEPOS 1.0 2.0 0.5 0.0 0.0 0.0 {START} h 0\nTRUEPOS 1.1 2.0 0.5 0.1 0.0 0.0 {START + 0.9} h 0\nGPS 1 2 3\n"
    )
    (tmp_path / "room.clf.xz").write_bytes(lzma.compress(text.encode()))
    run = imported(tmp_path / "room.clf.xz", record=tmp_path / "run.mcap")
    assert run.metadata["messages of GPS left out"] == "1"
    np.testing.assert_allclose(run.robots["robot"].truth[0], [1.0, 2.0, 0.5], atol=1e-6)
    assert np.isnan(run.robots["robot"].truth[-1]).all()


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("FLASER 181 1 2 3", "FLASER has 4 values"),
        ("FLASER many 1 2 3", "a laser scan has many values"),
        ("FLASER 99999999 1", "a laser scan has 99999999 values; it must have 0 to 10000"),
        ("ODOM 1 2 nan 0 0 0 1.0 h 0", "ODOM holds 'nan'; numbers must be finite"),
        ("ODOM 1 2 3 0 0 0", "ODOM has no time at its end"),
        ("ODOM 1 2 x 0 0 0 1.0 h 0", "could not convert string to float: 'x'"),
        ("ROBOTLASER1 0 0 3 0 80 0 0 2 1 1 0", "begins at 0 rad, with 0 rad a beam"),
        ("RAWLASER1 0", "RAWLASER1 has 1 values"),
        ("PARAM", "PARAM has too few values"),
    ],
)
def test_a_line_that_is_not_as_it_must_be_is_named(line, said, tmp_path):
    write_carmen(tmp_path / "room.clf", seconds=0.5)
    with (tmp_path / "room.clf").open("a") as file:
        file.write(line + "\n")
    number = len((tmp_path / "room.clf").read_text().splitlines())
    with pytest.raises(UsageError, match=rf"room\.clf:{number}: ") as caught:
        read_carmen(tmp_path / "room.clf")
    assert said in str(caught.value)


def test_beams_that_are_no_numbers_and_messages_of_others_that_come_first_are_read(tmp_path):
    write_carmen(tmp_path / "room.clf", seconds=0.5)
    head, first, rest = (tmp_path / "room.clf").read_text().partition("FLASER")
    _, count, *ranges = f"{first}{rest}".split(" ")
    ranges[:3] = ["inf", "nan", "-inf"]
    text = f"NMEAGGA 1 2 3\nIMU 1 2\n{head}FLASER {count} {' '.join(ranges)}"
    # Packed, though its name does not say so.
    (tmp_path / "odd.clf").write_bytes(lzma.compress(text.encode()))
    log = imported(tmp_path / "odd.clf")
    scan = next(seen.scans["front"] for seen in log.observations("robot") if seen.scans)
    np.testing.assert_array_equal(scan.ranges[:3], [np.inf, -np.inf, -np.inf])
    assert log.metadata["messages of IMU left out"] == "1"


@pytest.mark.parametrize(
    ("value", "said"), [("much", "is 'much'; it must be a number"), ("-1", "is -1; it must be 0 to 10"), ("nan", "nan")]
)
def test_invalid_noise_of_odometry_is_named(value, said, tmp_path):
    write_carmen(tmp_path / "room.clf", seconds=0.5)
    with (tmp_path / "room.clf").open("a") as file:
        file.write(f"PARAM odometry_noise_turn {value}\n")
    with pytest.raises(UsageError, match=f"room.clf': odometry_noise_turn.*{said}"):
        imported(tmp_path / "room.clf")


def test_a_log_is_never_replaced_by_its_recording(tmp_path):
    log = tmp_path / "room.clf"
    write_carmen(log, seconds=0.5)
    before = log.read_bytes()
    with pytest.raises(UsageError, match=r"room\.clf' is a file of the log; name another file"):
        mjsim.import_log(log, record=log, overwrite=True)
    assert log.read_bytes() == before


def test_an_impossible_rate_is_an_error_without_a_file_line(tmp_path, capsys):
    write_carmen(tmp_path / "room.clf", seconds=0.5)
    assert run_command("import-log", tmp_path / "room.clf", "-o", tmp_path / "run.mcap", "--rate", 7) == 2
    assert capsys.readouterr().err.startswith("--rate: rate_hz is 7 Hz; a tick must be a whole number of 4 ms steps")


def test_files_that_are_no_logs_are_refused_in_one_line(tmp_path):
    for name, content, said in (
        ("a.tar.xz", b"x", "is an archive; unpack it and name the folder"),
        ("a.csv", b"t,x\n1,2\n", "is a table of numbers; describe its columns in a YAML file"),
        ("a.clf", b"", "is empty"),
        ("b.clf", b"\x00\xff" * 4000, "is not a supported log"),
        ("a.xz", b"no xz at all", "cannot unpack"),
        ("a.gz", b"no gzip at all", "cannot unpack"),
        ("b.gz", b"\x1f\x8b\x08" + bytes(7) + b"\xff" * 40, "cannot unpack"),
        ("c.clf", b"PARAM a b c 0\n", "holds neither odometry nor scans of CARMEN"),
    ):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(UsageError, match=said):
            imported(tmp_path / name)
    with pytest.raises(UsageError, match="no file or folder"):
        mjsim.import_log(tmp_path / "away.clf")
    write_carmen(tmp_path / "room.clf", seconds=0.5)
    for wishes, said in (
        (Wishes(robots=(1,)), "has one robot; leave out --robot"),
        (Wishes(known_map=True), "has no known map; leave out --known-map"),
        (Wishes(begin=9.0), "two ticks are 0.08 s apart"),
    ):
        with pytest.raises(UsageError, match=said):
            imported(tmp_path / "room.clf", wishes=wishes)


def test_scans_and_poses_have_their_own_times_from_the_log_to_the_final_path(tmp_path):
    write_carmen(tmp_path / "room.clf", seconds=8.0)
    # Ticks come every 0.08 s, scans every 0.2 s.
    lines = (tmp_path / "room.clf").read_text().splitlines()
    stamps = [float(line.split()[-3]) for line in lines if line.startswith("FLASER")]
    run = imported(tmp_path / "room.clf", wishes=Wishes(rate_hz=12.5))
    start = float(run.metadata["log start"])
    seen = [tick for tick in run.observations("robot") if tick.scans]
    np.testing.assert_allclose([start + tick.scans["front"].stamp for tick in seen], stamps, atol=1e-6)
    assert max(tick.time - tick.moment for tick in seen) > 0.04
    replayed = mjsim.replay(run, robot="robot", estimator=LidarSlam(), record=tmp_path / "slam.mcap")
    track = replayed.robots["robot"]
    expected = circle(Pose(0.0, 0.0, 0.0), 0.2, 0.1, track.path[:, 0])
    # Half a tick would be 8 mm.
    np.testing.assert_allclose(track.path[:, 1:3], expected[:, :2], atol=3e-3)
    written = export_tum(replayed, tmp_path / "tum")
    for file in written:
        rows = np.loadtxt(file)
        expected = circle(Pose(0.0, 0.0, 0.0), 0.2, 0.1, rows[:, 0])
        np.testing.assert_allclose(rows[:, 1:3], expected[:, :2], atol=3e-3, err_msg=file.name)


def test_a_log_without_odometry_says_that_the_motion_is_unknown(tmp_path):
    write_carmen(tmp_path / "room.clf")
    kept = []
    for line in (tmp_path / "room.clf").read_text().splitlines():
        words = line.split()
        if words[0] == "ODOM":
            continue
        if words[0] == "FLASER":
            words[-9:-3] = ["0"] * 6
        kept.append(" ".join(words))
    (tmp_path / "carried.clf").write_text("\n".join(kept) + "\n")
    run = imported(tmp_path / "carried.clf")
    assert run.metadata["odometry"] == "left out: none; the motion of each tick is unknown"
    first, *later = run.observations("robot")
    assert not first.odometry.covariance.any()
    for tick in later:
        assert (tick.odometry.forward, tick.odometry.left, tick.odometry.turn) == (0.0, 0.0, 0.0)
        # Walking pace, as a random walk: 1 m in 1 s.
        np.testing.assert_allclose(tick.odometry.covariance, tick.dt * np.eye(3))
    assert "odometry" not in imported(tmp_path / "room.clf").metadata


def test_a_log_that_is_exported_has_its_scans_where_and_when_they_were_taken(tmp_path):
    write_carmen(tmp_path / "room.clf")
    run = imported(tmp_path / "room.clf", wishes=Wishes(rate_hz=12.5))
    export_carmen(run, tmp_path / "again.clf")
    log = read_carmen(tmp_path / "again.clf").robot
    wanted = read_carmen(tmp_path / "room.clf").robot.scans["front"].stamps - START
    stamps = log.scans["front"].stamps
    np.testing.assert_allclose(stamps, wanted, atol=1e-6)
    places = circle(Pose(0.0, 0.0, 0.0), 0.2, 0.1, stamps)
    at = [log.track[np.flatnonzero(np.abs(log.track[:, 0] - stamp) < 1e-9)] for stamp in stamps]
    for rows, place in zip(at, places, strict=True):
        np.testing.assert_allclose(rows[:, 1:], np.tile(place, (len(rows), 1)), atol=2e-4)


@pytest.mark.slow
def test_frames_of_an_exported_bag_have_the_times_of_their_scans(tmp_path):
    rosbags = pytest.importorskip("rosbags.highlevel")
    write_carmen(tmp_path / "room.clf")
    run = imported(tmp_path / "room.clf", wishes=Wishes(rate_hz=12.5))
    bag = export_rosbag2(run, tmp_path / "bag")
    stamps: dict[str, set[float]] = {}
    with rosbags.AnyReader([bag]) as reader:
        for connection, _, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            each = message.transforms[0] if connection.topic == "/tf" else message
            if hasattr(each, "header"):
                time = each.header.stamp.sec + 1e-9 * each.header.stamp.nanosec
                stamps.setdefault(connection.topic.rpartition("/")[2], set()).add(round(time, 6))
    assert stamps["scan"] <= stamps["tf"] == stamps["odom"]
