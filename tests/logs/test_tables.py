"""Tables of one's own and observations of one's own become recordings."""

import gzip
import itertools
import math
import re
from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from pathlib import Path

import numpy as np
import pytest

import mjsim
from mjsim.algorithms.ekf_slam.ekf_slam import EkfSlam
from mjsim.errors import MjsimError, UsageError
from mjsim.geometry import Pose
from mjsim.interface import Message, Observation, Odometry, Scan, Sighting, WheelTicks
from mjsim.logs import Wishes, write_log
from mjsim.logs.files.csv_table import read_csv
from mjsim.logs.formats.columns import read_columns
from mjsim.run import drivers_of
from tests.real_logs import circle, imported, run_command

MARKS = {"a": (2.0, 1.0), "b": (1.0, 3.0), "c": (-1.0, 1.5)}
LOG = """log: tables
time_unit: ms
odometry: {file: odometry.csv, time: t, x: x, y: y, heading_deg: yaw}
truth: {file: truth.txt, time: 1, x: 2, y: 3, heading: 4}
sightings: {file: seen.csv.gz, time: t, name: what, range: r, bearing_deg: b}
landmarks: {file: marks.csv, name: id, x: x, y: y}
scans: [{file: scan.csv, time: t, ranges: r_, from_deg: 90, step_deg: -45, range: [0.1, 8]}]
imu: {file: imu.csv, time: t, acceleration: [ax, ay, az], turn: [wx, wy, wz]}
noise: {range: 0.02, bearing_deg: 0.5}
"""


def write_tables(folder: Path) -> None:
    """Write a circle of 6 s: odometry in a frame of its own, truth in that of the world."""
    times = np.arange(0.0, 6.0, 0.1)
    start = Pose(0.5, -0.2, 0.3)
    poses = circle(start, 0.3, 0.25, times)
    local = circle(Pose(0.0, 0.0, 0.0), 0.3, 0.25, times)
    rows = [
        f"{1e3 * t:.3f};{x!r};{y!r};{math.degrees(a)!r}" for t, (x, y, a) in zip(times, local.tolist(), strict=True)
    ]
    (folder / "odometry.csv").write_text("t;x;y;yaw\n" + "\n".join(reversed(rows)) + "\n")
    lines = [f"{1e3 * t:.3f} {x!r} {y!r} {a!r}" for t, (x, y, a) in zip(times, poses.tolist(), strict=True)]
    (folder / "truth.txt").write_text("# without names\n" + "\n".join(lines) + "\n")
    seen = []
    for t, pose in zip(times, poses, strict=True):
        for name, place in MARKS.items():
            ahead, left = Pose.from_array(pose).inverse().transform(place)
            seen.append(f"{1e3 * t:.3f},{name},{math.hypot(ahead, left)!r},{math.degrees(math.atan2(left, ahead))!r}")
    (folder / "seen.csv.gz").write_bytes(gzip.compress(("t,what,r,b\n" + "\n".join(seen) + "\n").encode()))
    (folder / "marks.csv").write_text("id,x,y\n" + "\n".join(f"{n},{x},{y}" for n, (x, y) in MARKS.items()) + "\n")
    scans = "\n".join(f"{1e3 * t + 20:.3f},1,2,3,9,nan" for t in times[::2])
    (folder / "scan.csv").write_text("t,r_0,r_1,r_2,r_3,r_4\n" + scans + "\n")
    (folder / "odd.csv").write_text("t,r_0,r_1\n1,nan,x\n")
    imu = "\n".join(f"{1e3 * t:.3f},0,0,9.81,0,0,0.25" for t in times)
    (folder / "imu.csv").write_text("t,ax,ay,az,wx,wy,wz\n" + imu + "\n")
    (folder / "twice.csv").write_text("id,x,x,y\na,1,2,3\n")
    (folder / "log.yaml").write_text(LOG)


@pytest.mark.slow
def test_tables_are_read_by_their_description(tmp_path):
    write_tables(tmp_path)
    run = imported(tmp_path / "log.yaml", wishes=Wishes(rate_hz=10.0, known_map=True))
    track = run.robots["robot"]
    at = circle(Pose(0.5, -0.2, 0.3), 0.3, 0.25, run.time)
    # Ticks with scans stand for the moments of the scans, at most a tick earlier; poses lie on chords.
    np.testing.assert_allclose(track.truth[1:-1, :2], at[1:-1, :2], atol=0.031)
    ticks = list(run.observations("robot"))
    scan = next(tick.scans["scan"] for tick in ticks if tick.scans)
    assert scan.angle_min == pytest.approx(-math.pi / 2)
    assert scan.angle_increment == pytest.approx(math.pi / 4)
    np.testing.assert_array_equal(scan.ranges, [-np.inf, np.inf, 3.0, 2.0, 1.0])
    assert sum(bool(tick.scans) for tick in ticks) == 30
    # The last tick stands for a scan that was before the last reading.
    assert sum(len(tick.imu) for tick in ticks) == len(ticks) - 1
    assert ticks[6].imu[0].turn[2] == 0.25
    assert {beacon.name: tuple(beacon.at) for beacon in run.world.beacons} == MARKS
    assert run.world.run.map == "known"
    again = mjsim.replay(run, robot="robot", estimator=EkfSlam())
    figures = mjsim.statistics(again)["robot"]
    assert figures["landmark_error_m"]["count"] == 3
    assert figures["ate_m"]["rmse"] < 0.03


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("odometry: {file", "odometri: {file", "log.yaml:3:1: unknown key 'odometri'; did you mean 'odometry'?"),
        ("heading_deg: yaw", "heading_deg: jaw", "no column 'jaw' in"),
        (", heading_deg: yaw", "", "name one of heading [rad], heading_deg and quaternion"),
        ("file: marks.csv", "file: mark.csv", "cannot read"),
        ("file: marks.csv", "file: ../marks.csv", "is outside the folder of the description"),
        ("time: 1, x: 2", "time: 1, x: 9", "has 4 columns; there is no column 9"),
        ("range: r,", "range: what,", "what is 'a'; it must be a finite number"),
        ("scan.csv, time: t, ranges: r_", "odd.csv, time: t, ranges: r_", "odd.csv:2: r_1 is 'x'; it must be a number"),
        ("ranges: r_", "ranges: q_", "0 columns whose names begin with 'q_'; a scan needs at least 2"),
        ("time_unit: ms", "time_unit: h", "log.yaml:2:12: "),
        ("file: marks.csv", "file: twice.csv", "has 2 columns 'x'; give its number, from 1"),
    ],
)
def test_a_fault_in_a_description_is_one_line(old, new, said, tmp_path):
    write_tables(tmp_path)
    (tmp_path / "log.yaml").write_text(LOG.replace(old, new))
    with pytest.raises(MjsimError) as caught:
        imported(tmp_path / "log.yaml")
    (line,) = str(caught.value).splitlines()
    assert said in line


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("t;x;y;yaw\n1;2;3\n", r"odometry\.csv:2: 3 values; the table has 4 columns"),
        ("t;x;y;yaw\n1;2;inf;4\n", r"odometry\.csv:2: y is 'inf'; it must be a finite number"),
        ("t;x;y;yaw\n", "holds no rows, only names of columns"),
        ("", "holds no rows"),
        ("t;x;y;yaw\n" + "9" * 200_000 + ";2;3;4\n", "is not a table with the separator ';': field larger"),
    ],
)
def test_a_fault_in_a_table_names_its_line(content, said, tmp_path):
    write_tables(tmp_path)
    (tmp_path / "odometry.csv").write_text(content)
    with pytest.raises(UsageError, match=said):
        imported(tmp_path / "log.yaml")


def observations(count: int = 40, first: float = 100.0) -> list[Observation]:
    """Return what a robot sees that drives 0.02 m a tick at 10 Hz beside one mark."""
    walk = Odometry(0.02, 0.0, 0.0, np.diag([1e-6, 1e-8, 1e-6]))
    rest = Odometry(0.0, 0.0, 0.0, np.zeros((3, 3)))
    noise = np.diag([0.01**2, 0.01**2])
    seen = []
    for k in range(count):
        time, x = first + 0.1 * k, 0.02 * k
        mark = Sighting(time, "post", math.hypot(2.0 - x, 1.0), math.atan2(1.0, 2.0 - x), noise)
        scan = Scan(time, np.full(9, 2.0), -1.0, 0.25, 0.1, 8.0)
        seen.append(Observation(time, 0.1, walk if k else rest, sightings=(mark,), scans={"front": scan}))
    return seen


@pytest.mark.slow
def test_observations_of_ones_own_become_a_recording_that_replay_report_and_export_take(tmp_path):
    seen = observations()
    truth = [[0.02 * k, 0.0, 0.0] for k in range(len(seen))]
    run = write_log(tmp_path / "own.mcap", seen, truth=truth, landmarks={"post": (2.0, 1.0)}, metadata={"who": "me"})
    assert run.metadata["who"] == "me"
    assert run.metadata["log start"] == "100.0"
    for told, given in zip(run.observations("robot"), seen, strict=True):
        assert told.time == pytest.approx(given.time - 100.0, abs=1e-9)
        assert told.sightings[0].range == given.sightings[0].range
        np.testing.assert_array_equal(told.scans["front"].ranges, given.scans["front"].ranges)
        np.testing.assert_array_equal(told.odometry.covariance, given.odometry.covariance)
    again = mjsim.replay(run, robot="robot", estimator=EkfSlam(), record=tmp_path / "again.mcap")
    figures = mjsim.statistics(again)["robot"]
    assert figures["position_error_m"]["max"] < 1e-6
    assert figures["landmark_error_m"]["count"] == 1
    assert run_command("report", again.path, "-o", tmp_path / "report") == 0
    assert run_command("export", again.path, "--tum", tmp_path, "--csv", tmp_path / "csv") == 0
    assert len(np.loadtxt(tmp_path / "robot_estimate.tum")) == len(seen)
    with pytest.raises(UsageError, match="exists"):
        write_log(tmp_path / "own.mcap", seen)


EVERYTHING = """mjsim: 1
name: room
walls: [{points: [[0, 0], [5, 0], [5, 4], [0, 4]], closed: true}]
beacons: [{name: a0, at: [0.2, 0.2], center: 2.3, anchor: true}, {name: post, at: [3, 1.5], width: 0.1}]
robots:
  - name: scout
    preset: pioneer3dx
    at: [1, 1]
    odometry: {ticks: 2048}
    arms: [{name: arm, dh: {rows: [{a: 0.3}, {a: 0.2}]}, at: [0, 0, 0.4]}]
    sensors:
      - {lidar: scan, at: [0.1, 0.05, 0.3], beams: 31, fov_deg: 180, range: [0.05, 3], intensity: true}
      - {lidar3d: top, at: [0, 0, 0.9], rings: 4, columns: 30, range: [0.3, 10]}
      - {camera: front, at: [0.15, 0, 0.35], width: 32, height: 24, rate_hz: 12.5, depth: {noise: 0.01}}
      - {imu: gyro, at: [0, 0.1, 0.2], rate_hz: 50}
      - {beacons: ring, rate_hz: 5}
      - {uwb: tag, at: [-0.1, 0, 1], range: [0, 30], noise: {range: 0.08}}
      - {encoders: wheels, bits: 16}
run: {rate_hz: 25, drivers: {scout: {navigator: {use: "mjsim.algorithms.waypoints:Waypoints", points: [[3, 1]]}}}}
"""


PLAIN = """mjsim: 1
robots: [{name: scout, preset: pioneer3dx, at: [1, 1], sensors: [{lidar: front, beams: 9, rate_hz: 10}]}]
run: {rate_hz: 10}
"""


def assert_same(told, given):
    """Compare values of any kind, to the bit."""
    if is_dataclass(given):
        for each in fields(given):
            assert_same(getattr(told, each.name), getattr(given, each.name))
    elif isinstance(given, Mapping):
        assert told.keys() == given.keys()
        for name in given:
            assert_same(told[name], given[name])
    elif isinstance(given, tuple):
        assert len(told) == len(given)
        for one, other in zip(told, given, strict=True):
            assert_same(one, other)
    else:
        np.testing.assert_array_equal(told, given)


@pytest.mark.slow
@pytest.mark.parametrize("placed", [True, False])
def test_every_kind_of_reading_comes_back_to_the_bit(placed, tmp_path):
    world = mjsim.parse_world(EVERYTHING)
    with mjsim.Simulation(world, seed=3) as sim:
        given = [tick.seen["scout"] for tick in itertools.islice(mjsim.ticks(sim, drivers_of(world)), 6)]
    given[3] = replace(given[3], messages=(Message("anna", given[3].time, "[1]"),), bump=(0.5,))
    for each in fields(given[0]):
        assert any(np.size(getattr(seen, each.name)) for seen in given), each.name
    run = write_log(tmp_path / "own.mcap", given, robot="scout", world=world if placed else None)
    for told, seen in zip(run.observations("scout"), given, strict=True):
        assert_same(told, replace(seen, cameras={}))
    replayed = []

    class Looker:
        def start(self, robot, catalogue, rng):
            pass

        def observe(self, seen):
            replayed.append(seen.cameras)
            return ()

    mjsim.replay(run, robot="scout", estimator=EkfSlam(), observer=Looker())
    for told, seen in zip(replayed, given, strict=True):
        assert told.keys() == seen.cameras.keys()
        for name, frame in seen.cameras.items():
            np.testing.assert_array_equal(told[name].image, frame.image)
            np.testing.assert_array_equal(told[name].depth, np.float32(frame.depth))


@pytest.mark.slow
def test_the_example_of_the_page_runs_and_keeps_its_pictures(tmp_path, monkeypatch, capsys):
    page = (Path(mjsim.__file__).parent.parent / "docs" / "replay.md").read_text(encoding="utf-8")
    (code,) = (code for code in re.findall("```python\n(.*?)```", page, re.DOTALL) if "write_log(" in code)
    monkeypatch.chdir(tmp_path)
    names = {}
    exec(code, names)
    assert "'count': 1" in capsys.readouterr().out
    kept = list(names["log"].images("robot", "front"))
    assert [int(picture[0, 0, 0]) for _, picture in kept] == [10 * k for k in range(20)]
    seen = []

    class Looker:
        def start(self, robot, catalogue, rng):
            assert (robot.sensors["front"].intrinsics.matrix() == names["lens"].matrix()).all()

        def observe(self, observation):
            seen.extend(frame.image[0, 0, 0] for frame in observation.cameras.values())
            return ()

    mjsim.replay(names["log"], robot="robot", estimator=EkfSlam(), observer=Looker())
    assert seen == [10 * k for k in range(20)]


@pytest.mark.slow
def test_sightings_of_marks_that_nobody_surveyed_are_replayed_too(tmp_path):
    run = write_log(tmp_path / "own.mcap", observations())
    again = mjsim.replay(run, robot="robot", estimator=EkfSlam())
    assert again.robots["robot"].landmarks.names == ("post",)
    np.testing.assert_allclose(again.robots["robot"].landmarks.mean[-1, 0], [2.0, 1.0], atol=1e-3)


def test_observations_that_make_no_recording_are_refused_in_one_line(tmp_path):
    seen = observations(5)
    uneven = [*seen[:2], replace(seen[2], time=seen[2].time + 0.03), *seen[3:]]
    for given, keys, said in (
        ([], {}, "0 observations; a recording needs at least two"),
        (seen[::-1], {}, "do not increase"),
        (uneven, {}, "observation 2 is at 100.23 s, 0.03 s off a rate of 10 Hz"),
        (
            [replace(seen[0], encoders={"wheels": WheelTicks(seen[0].time, (1, 2), 100)}), *seen[1:]],
            {"world": mjsim.parse_world(PLAIN), "robot": "scout"},
            "observation 0: a reading of 'wheels', which is not a sensor of the robot",
        ),
        (
            [
                *seen[:2],
                replace(seen[2], scans={"front": Scan(seen[2].time, np.ones(7), 0.0, 0.1, 0.1, 8.0)}),
                *seen[3:],
            ],
            {},
            "observation 0: a scan of 9 beams; 'front' has 7|observation 2: a scan of 7 beams; 'front' has 9",
        ),
        (seen, {"truth": np.zeros((4, 3))}, r"has shape \(4, 3\); with 5 observations it must be \(5, 3\)"),
        (seen, {"robot": "no name!"}, "name"),
        (seen, {"landmarks": {"x]\nwalls: [": (0.0, 0.0)}}, "name"),
        (seen, {"world": mjsim.load_world("empty")}, "no robot 'robot' in the world"),
    ):
        with pytest.raises(MjsimError, match=said):
            write_log(tmp_path / "own.mcap", given, **keys)
        assert not (tmp_path / "own.mcap").exists()


@pytest.mark.parametrize("text", ["t;x\r\n1,5;-2,25e1\r\n", "1,5\t-22,5\r\n", "t\tx\n1.5\t-22.5\n"])
@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
def test_tables_of_spreadsheets_have_decimal_commas_and_wide_letters(text, encoding, tmp_path):
    (tmp_path / "a.csv").write_bytes(text.encode(encoding))
    table = read_csv(tmp_path / "a.csv")
    assert [float(table.column(table.names[k])[0]) for k in range(2)] == [1.5, -22.5]


def test_lengths_and_velocities_come_in_the_unit_that_is_told(tmp_path):
    (tmp_path / "way.csv").write_text("t,x,y,h,v,r\n0,0,0,0,1000,2500\n1,1000,-500,0.1,1000,2500\n")
    (tmp_path / "log.yaml").write_text(
        "log: tables\nlength_unit: mm\nodometry: {file: way.csv, time: t, x: x, y: y, heading: h}\n"
        "twist: {file: way.csv, time: t, forward: v, turn: h}\n"
        "truth: {file: way.csv, time: t, x: x, y: y, heading: h}\n"
        "landmarks: {file: way.csv, name: t, x: x, y: y}\nsightings: {file: way.csv, time: t, range: r, bearing: h}\n"
        "scans: [{file: way.csv, time: t, ranges: 5, from_deg: 0, step_deg: 1, range: [0.1, 2.4], at: [0.2, 0, 0.3]}]\n"
    )
    log = read_columns(tmp_path / "log.yaml", Wishes())
    np.testing.assert_array_equal(log.robot.track, [[0, 0, 0, 0], [1, 1, -0.5, 0.1]])
    np.testing.assert_array_equal(log.robot.truth, log.robot.track)
    np.testing.assert_array_equal(log.robot.twists[:, 1], [1, 1])
    assert log.landmarks["1"] == (1.0, -0.5)
    assert log.robot.sightings[0].range == 2.5
    # What the description itself says is in metres.
    np.testing.assert_array_equal(log.robot.scans["scan"].take(0).ranges, [1.0, np.inf])
    assert log.mounts["scan"].at == (0.2, 0.0, 0.3)
