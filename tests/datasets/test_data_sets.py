"""Data sets, read back by evo, by csv, PyYAML and OpenCV, and by the importer of CARMEN logs; times, frames, units."""

import csv
import itertools
import math
import re
import shutil
import tracemalloc
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from evo.tools import file_interface

import mjsim
from mjsim.datasets import export_carmen, export_euroc, export_rosbag2, export_tum_rgbd
from mjsim.datasets.euroc_out import tables_of
from mjsim.datasets.recorded_robots import RecordedRobots, RecordedTick
from mjsim.errors import UsageError
from mjsim.geometry import Pose, Pose3
from mjsim.record import LoggedPictures, Recording
from tests.datasets.conftest import WORLD
from tests.real_logs import imported

ROBOT = "7.tip-top"
EYE = np.array([[0, 0, 1, 0.1], [-1, 0, 0, 0], [0, -1, 0, 0.5], [0, 0, 0, 1.0]])
"""robot_from_camera of 'eye', but level: it looks along x, its x axis is to the right and its y axis down."""
TILT = math.radians(10)


def robot_from_eye() -> np.ndarray:
    c, s = math.cos(TILT), math.sin(TILT)
    down = np.eye(4)
    down[:3, :3] = [[c, 0, s], [0, 1, 0], [-s, 0, c]]
    turned = EYE.copy()
    turned[:3, :3] = down[:3, :3] @ EYE[:3, :3]
    return turned


@pytest.fixture(scope="module")
def tum(run: Recording, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folders = export_tum_rgbd(run, tmp_path_factory.mktemp("tum") / "sets", redraw=True)
    assert [folder.name for folder in folders] == [f"{ROBOT}_eye", f"{ROBOT}_wide"]
    return folders[0]


@pytest.fixture(scope="module")
def euroc(run: Recording, tmp_path_factory: pytest.TempPathFactory) -> Path:
    (folder,) = export_euroc(run, tmp_path_factory.mktemp("euroc") / "sets")
    return folder / "mav0"


def listed(path: Path) -> list[list[str]]:
    return [line.split() for line in path.read_text().splitlines() if not line.startswith("#")]


@pytest.mark.slow
def test_evo_reads_where_the_camera_truly_was(tum: Path, run: Recording):
    read = file_interface.read_tum_trajectory_file(tum / "groundtruth.txt")
    np.testing.assert_allclose(read.timestamps, run.time, atol=1e-9)
    for pose, row in zip(read.poses_se3, run.robots[ROBOT].truth_pose.tolist(), strict=True):
        np.testing.assert_allclose(pose, Pose3(*row).matrix() @ robot_from_eye(), atol=1e-9)


def test_pictures_of_tum_are_those_of_the_run_without_loss(tum: Path, run: Recording):
    rows = listed(tum / "rgb.txt")
    recorded = list(run.images(ROBOT, "eye"))
    assert [float(stamp) for stamp, _ in rows] == pytest.approx([stamp for stamp, _ in recorded], abs=1e-9)
    for (_, name), (_, picture) in zip(rows, recorded, strict=True):
        drawn = cv2.imread(str(tum / name), cv2.IMREAD_COLOR_RGB)
        assert name.endswith(".png")
        assert np.abs(drawn.astype(int) - picture).mean() < 3.0  # what was recorded went through JPEG


def test_depth_of_tum_is_five_thousand_a_metre(tum: Path):
    rows = listed(tum / "depth.txt")
    assert [stamp for stamp, _ in rows] == [stamp for stamp, _ in listed(tum / "rgb.txt")]
    depth = cv2.imread(str(tum / rows[0][1]), cv2.IMREAD_UNCHANGED)
    assert (depth.dtype, depth.shape) == (np.uint16, (48, 64))
    # The floor in the lowest row: the camera is 0.5 m high, and looks 10 degrees down.
    below = 23.5 / (32 / math.tan(math.radians(30)))
    assert depth[47, 32] / 5000 == pytest.approx(0.5 / (math.sin(TILT) + below * math.cos(TILT)), rel=1e-3)


def test_the_calibration_and_the_accelerometer_of_tum(tum: Path, run: Recording):
    numbers = dict(line.split(": ") for line in (tum / "camera.yaml").read_text().splitlines()[1:])
    assert float(numbers["Camera.fx"]) == pytest.approx(32 / math.tan(math.radians(30)))
    assert (numbers["Camera.cx"], numbers["Camera.cy"], numbers["DepthMapFactor"]) == ("31.5", "23.5", "5000.0")
    felt = np.array([row for row in listed(tum / "accelerometer.txt")], dtype=float)
    given = [each for seen in run.observations(ROBOT) for each in seen.imu]
    np.testing.assert_allclose(felt[:, 0], [each.stamp for each in given], atol=1e-9)
    np.testing.assert_array_equal(felt[:, 1:], [each.acceleration for each in given])


def test_a_camera_without_depth_has_none(tum: Path):
    wide = tum.with_name(f"{ROBOT}_wide")
    assert {each.name for each in wide.iterdir()} == {
        "rgb",
        "rgb.txt",
        "groundtruth.txt",
        "accelerometer.txt",
        "camera.yaml",
    }
    assert "Camera.k4: 0.0\n" in (wide / "camera.yaml").read_text()
    assert 'Camera.type: "KannalaBrandt8"\n' in (wide / "camera.yaml").read_text()


def table(folder: Path) -> list[list[str]]:
    with (folder / "data.csv").open(newline="") as stream:
        return [row for row in csv.reader(stream) if not row[0].startswith("#")]


def about(folder: Path) -> dict:
    return yaml.safe_load((folder / "sensor.yaml").read_text().removeprefix("%YAML:1.0\n"))


def transform(keys: dict) -> np.ndarray:
    return np.array(keys["T_BS"]["data"]).reshape(4, 4)


def robot_from_imu() -> np.ndarray:
    pose = Pose(0.02, 0.0, math.pi / 2)
    matrix = Pose3.from_planar(pose).matrix()
    matrix[2, 3] = 0.1
    return matrix


def test_evo_reads_where_the_body_of_euroc_truly_was(euroc: Path, run: Recording):
    truth = euroc / "state_groundtruth_estimate0"
    read = file_interface.read_euroc_csv_trajectory(truth / "data.csv")
    np.testing.assert_allclose(read.timestamps, run.time, atol=1e-9)
    for pose, row in zip(read.poses_se3, run.robots[ROBOT].truth_pose.tolist(), strict=True):
        np.testing.assert_allclose(pose, Pose3(*row).matrix() @ robot_from_imu(), atol=1e-9)
    rows = np.array(table(truth), dtype=float)
    assert rows.shape == (len(run.time), 17)
    middle = (rows[2:, 1:4] - rows[:-2, 1:4]) / 0.08
    np.testing.assert_allclose(rows[1:-1, 8:11], middle, atol=1e-12)
    np.testing.assert_array_equal(transform(about(truth)), np.eye(4))


def test_inertial_readings_of_euroc_are_exact_to_the_nanosecond(euroc: Path, run: Recording):
    given = [each for seen in run.observations(ROBOT) for each in seen.imu]
    rows = table(euroc / "imu0")
    assert [int(row[0]) for row in rows] == [round(each.stamp * 1e9) for each in given]
    expected = [[*each.turn.tolist(), *each.acceleration.tolist()] for each in given]
    assert [[float(each) for each in row[1:]] for row in rows] == expected
    keys = about(euroc / "imu0")
    assert (keys["sensor_type"], keys["rate_hz"]) == ("imu", 125)
    assert keys["gyroscope_noise_density"] == pytest.approx(0.002 / math.sqrt(125))
    np.testing.assert_allclose(transform(keys), np.eye(4), atol=1e-15)


def test_pictures_of_euroc_are_the_recorded_files_with_their_calibration(euroc: Path, run: Recording):
    for number, camera in enumerate(("eye", "wide")):
        recorded = list(run.pictures(ROBOT, camera))
        rows = table(euroc / f"cam{number}")
        assert [int(stamp) for stamp, _ in rows] == [round(stamp * 1e9) for stamp, _, _ in recorded]
        for (stamp, name), (_, data, _) in zip(rows, recorded, strict=True):
            assert name == f"{int(stamp):019d}.jpg"
            assert (euroc / f"cam{number}" / "data" / name).read_bytes() == data
    eye, wide = about(euroc / "cam0"), about(euroc / "cam1")
    np.testing.assert_allclose(transform(eye), np.linalg.inv(robot_from_imu()) @ robot_from_eye(), atol=1e-12)
    focal = 32 / math.tan(math.radians(30))
    assert eye["intrinsics"] == pytest.approx([focal, focal, 31.5, 23.5])
    assert (eye["resolution"], eye["rate_hz"], eye["distortion_model"]) == ([64, 48], 12.5, "radial-tangential")
    assert (wide["distortion_model"], wide["distortion_coefficients"]) == ("equidistant", [0.01, 0.0, 0.0, 0.0])


@pytest.fixture(scope="module")
def carmen(run: Recording, tmp_path_factory: pytest.TempPathFactory) -> Path:
    files = export_carmen(run, tmp_path_factory.mktemp("carmen") / "run.log")
    assert [file.name for file in files] == [f"run_{ROBOT}.log", "run_bare.log"]
    return files[0]


def test_a_log_of_carmen_reads_as_its_format_says(carmen: Path, run: Recording):
    text = carmen.read_text().splitlines()
    assert text[0] == "# CARMEN Logfile"
    lines = [line.split() for line in text if not line.startswith("#")]
    # Every message, parameters too, ends in the time of sending, the host, and the time of logging.
    assert all(float(line[-3]) == float(line[-1]) >= 0.0 and line[-2] == "mjsim" for line in lines)
    assert {line[0] for line in lines} == {"PARAM", "ODOM", "TRUEPOS", "ROBOTLASER1", "ROBOTLASER2"}
    track, seen = run.robots[ROBOT], list(run.observations(ROBOT))
    odometry = [[float(each) for each in line[1:7]] for line in lines if line[0] == "ODOM"]
    np.testing.assert_array_equal([row[:3] for row in odometry], track.odometry)
    assert [row[3] for row in odometry] == [each.odometry.forward / each.dt for each in seen]
    truth = np.array([line[1:7] for line in lines if line[0] == "TRUEPOS"], dtype=float)
    np.testing.assert_allclose(truth[:, :3], track.truth, atol=1e-12)
    np.testing.assert_array_equal(truth[:, 3:], track.odometry)
    assert [float(line[-1]) for line in lines if line[0] == "ODOM"] == run.time.tolist()
    lasers = [line for line in lines if line[0] == "ROBOTLASER1"]
    scans = [each.scans["scan"] for each in seen if "scan" in each.scans]
    for line, scan in zip(lasers, scans, strict=True):
        first, fov, step, farthest = (float(each) for each in line[2:6])
        assert (first, step, farthest) == (scan.angle_min, scan.angle_increment, scan.range_max)
        assert fov == pytest.approx(math.radians(240))
        assert line[8] == "61"
        ranges = [float(each) for each in line[9:70]]
        assert ranges == np.where(np.isinf(scan.ranges), np.where(scan.ranges > 0, 3.0, 0.0), scan.ranges).tolist()
        assert [float(each) for each in line[71:132]] == scan.intensities.tolist()
        laser, robot = Pose(*map(float, line[132:135])), Pose(*map(float, line[135:138]))
        mounted = robot.inverse() @ laser
        assert mounted.as_array() == pytest.approx([0.15, 0.02, math.radians(30)], abs=1e-9)
        assert float(line[-1]) == scan.stamp


def test_a_log_of_carmen_comes_in_again(carmen: Path, run: Recording, tmp_path: Path):
    again = imported(carmen, record=tmp_path / "again.mcap")
    (robot,) = again.robots
    track = again.robots[robot]
    np.testing.assert_allclose(track.truth, run.robots[ROBOT].truth, atol=1e-9)
    scans = [seen.scans["front"] for seen in again.observations(robot) if "front" in seen.scans]
    given = [seen.scans["scan"] for seen in run.observations(ROBOT) if "scan" in seen.scans]
    assert len(scans) == len(given)
    for scan, original in zip(scans, given, strict=True):
        np.testing.assert_allclose(scan.ranges, original.ranges, atol=1e-12)
        assert scan.angle_min == original.angle_min
    claimed, told = (
        np.sum([np.diag(seen.odometry.covariance) for seen in each], axis=0)[[0, 2]]
        for each in (again.observations(robot), run.observations(ROBOT))
    )
    np.testing.assert_allclose(claimed, told, rtol=0.05)


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """Return a run of the first robot alone."""
    world = mjsim.parse_world(WORLD.replace("  - {name: bare, at: [4, 4]}\n", ""))
    with mjsim.Simulation(world) as sim:
        return mjsim.run(sim, seconds=0.4, record=tmp_path_factory.mktemp("alone") / "run.mcap")


@pytest.mark.slow
def test_a_bag_comes_in_again_and_goes_out_the_same(alone: Recording, tmp_path: Path):
    again = imported(export_rosbag2(alone, tmp_path / "bag"), record=tmp_path / "again.mcap")
    (robot,) = again.robots
    track, given = again.robots[robot], alone.robots[ROBOT]
    np.testing.assert_allclose(track.time, given.time, atol=1e-9)
    np.testing.assert_allclose(track.truth, given.truth, atol=1e-9)
    np.testing.assert_allclose(track.odometry, given.odometry, atol=1e-9)
    before, after = list(alone.observations(ROBOT)), list(again.observations(robot))
    for old, new in zip(before, after, strict=True):
        # A log's inertial readings are told in the robot's frame; the sensor was turned by a right angle.
        felt = [[-each.acceleration[1], each.acceleration[0], each.acceleration[2]] for each in old.imu]
        np.testing.assert_allclose([each.acceleration for each in new.imu], felt or np.zeros((0,)), atol=1e-12)
        if "scan" in old.scans:
            np.testing.assert_array_equal(np.float32(new.scans["scan"].ranges), np.float32(old.scans["scan"].ranges))
    assert [data for _, data, _ in again.pictures(robot, "eye")] == [
        data for _, data, _ in alone.pictures(ROBOT, "eye")
    ]
    folder, _ = export_tum_rgbd(again, tmp_path / "tum")
    read = file_interface.read_tum_trajectory_file(folder / "groundtruth.txt")
    for pose, row in zip(read.poses_se3, given.truth_pose.tolist(), strict=True):
        np.testing.assert_allclose(pose, Pose3(*row).matrix() @ robot_from_eye(), atol=1e-8)


@pytest.mark.slow
def test_depth_of_tum_comes_in_again_and_goes_out_the_same(alone: Recording, tmp_path: Path):
    first, _ = export_tum_rgbd(alone, tmp_path / "first", redraw=True)
    (second,) = export_tum_rgbd(imported(first, record=tmp_path / "again.mcap"), tmp_path / "second")
    for (_, old), (_, new) in zip(listed(first / "depth.txt"), listed(second / "depth.txt"), strict=True):
        before, after = (cv2.imread(str(path), cv2.IMREAD_UNCHANGED) for path in (first / old, second / new))
        np.testing.assert_array_equal(before, after)


def test_euroc_comes_in_again(euroc: Path, run: Recording, tmp_path: Path):
    again = imported(euroc.parent, record=tmp_path / "again.mcap")
    (robot,) = again.robots
    for number, camera in enumerate(("eye", "wide")):
        before, after = run.pictures(ROBOT, camera), again.pictures(robot, f"cam{number}")
        assert [data for _, data, _ in after] == [data for _, data, _ in before]
    told, given = (
        [reading for seen in each.observations(name) for reading in seen.imu]
        for each, name in ((again, robot), (run, ROBOT))
    )
    for new, old in zip(told, given, strict=True):
        np.testing.assert_array_equal([new.turn, new.acceleration], [old.turn, old.acceleration])
    eye = LoggedPictures(again, robot).cameras["cam0"]
    np.testing.assert_allclose(eye.robot_from_camera, np.linalg.inv(robot_from_imu()) @ robot_from_eye(), atol=1e-9)
    np.testing.assert_allclose(eye.intrinsics.matrix()[:2, 2], [31.5, 23.5])
    # A tick with a picture is of the moment of that; the body is the inertial sensor.
    then = np.searchsorted(run.time, [stamp - 1e-6 for stamp, _, _ in run.pictures(ROBOT, "eye")])
    here = np.searchsorted(again.time, [stamp - 1e-6 for stamp, _, _ in again.pictures(robot, "cam0")])
    for new, old in zip(again.robots[robot].truth_pose[here], run.robots[ROBOT].truth_pose[then], strict=True):
        np.testing.assert_allclose(Pose3(*new).matrix(), Pose3(*old).matrix() @ robot_from_imu(), atol=1e-8)


BOMB = "x0: &x0 [1]\n" + "".join(f"x{k}: &x{k} [{', '.join([f'*x{k - 1}'] * 10)}]\n" for k in range(1, 9))
"""Aliases that stand for a hundred million numbers."""


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("resolution: [", "resolution: ]", "(of a calibration in YAML)"),
        ("intrinsics: [", f"{BOMB}intrinsics: *x8 #", "the text holds more than 250000 values, with aliases expanded"),
        ("T_BS:", "T_CB:", "T_BS is not a pose; its data are 16 numbers of a rigid transform"),
        ("intrinsics: [", "intrinsics: [0, ", "they must be fu, fv, cu, cv in pixels"),
        ("equidistant", "omni", "a lens of model 'omni'; radial-tangential,"),
    ],
)
def test_an_invalid_euroc_calibration_is_a_one_line_error(old, new, said, euroc: Path, tmp_path: Path):
    shutil.copytree(euroc / "cam1", tmp_path / "cam1")
    sheet = tmp_path / "cam1" / "sensor.yaml"
    sheet.write_text(sheet.read_text().replace(old, new))
    with pytest.raises(UsageError, match=re.escape(said)) as caught:
        imported(tmp_path)
    assert "\n" not in str(caught.value)


def test_data_sets_that_exist_are_kept_unless_asked(tum: Path, euroc: Path, carmen: Path, run: Recording):
    with pytest.raises(UsageError, match="exists; name another folder, or add --overwrite"):
        export_tum_rgbd(run, tum.parent)
    with pytest.raises(UsageError, match="exists; name another folder, or add --overwrite"):
        export_euroc(run, euroc.parent.parent)
    with pytest.raises(UsageError, match="exists; name another file, or add --overwrite"):
        export_carmen(run, carmen.with_name("run.log"))
    (euroc / "notes.txt").write_text("mine")
    export_euroc(run, euroc.parent.parent, overwrite=True)
    assert (euroc / "notes.txt").read_text() == "mine"


@pytest.mark.slow
def test_a_run_without_pictures_says_that_they_can_be_drawn_again(run: Recording, tmp_path: Path):
    with mjsim.Simulation(run.world) as sim:
        bare = mjsim.run(sim, seconds=0.2, record=tmp_path / "bare.mcap", pictures=False)
    for export in (export_tum_rgbd, export_euroc, export_rosbag2):
        with pytest.raises(UsageError, match=r"holds no picture of .* at 0 s; render them again: --redraw"):
            export(bare, tmp_path / "set")
    assert [each.name for each in tmp_path.iterdir()] == ["bare.mcap"]


@pytest.mark.slow
def test_what_no_robot_has_is_one_line(tmp_path: Path):
    with mjsim.Simulation(mjsim.parse_world("mjsim: 1\nrobots: [{name: a, at: [0, 0]}]\nrun: {seconds: 0.2}\n")) as sim:
        plain = mjsim.run(sim, record=tmp_path / "plain.mcap")
    with pytest.raises(UsageError, match="has no camera; a TUM RGB-D data set consists of pictures"):
        export_tum_rgbd(plain, tmp_path / "tum")
    with pytest.raises(UsageError, match="has no camera and no inertial sensor"):
        export_euroc(plain, tmp_path / "euroc")
    export_rosbag2(plain, tmp_path / "bag")
    with mjsim.Simulation(mjsim.load_world("fourbar")) as sim:
        export_rosbag2(
            mjsim.run(sim, seconds=0.2, record=tmp_path / "plain.mcap", overwrite=True),
            tmp_path / "bag",
            overwrite=True,
        )
    assert {each.name for each in tmp_path.iterdir()} == {"plain.mcap", "bag"}


@pytest.mark.slow
def test_sensors_that_arms_carry_are_left_out_of_euroc_and_named(tmp_path: Path, capsys):
    arm = (
        "mjsim: 1\nrobots:\n"
        "  - {name: up6, base: fixed, at: [2, 1], arms: [{name: arm, preset: puma560}],\n"
        "     sensors: [{camera: hand, on: arm/tool, width: 32, height: 24},"
        " {camera: eye, at: [0, 0.5, 1], width: 32, height: 24}]}\n"
        "run: {seconds: 0.2}\n"
    )
    for name, text in (
        ("both", arm),
        ("hand", arm.replace(", {camera: eye, at: [0, 0.5, 1], width: 32, height: 24}", "")),
    ):
        with mjsim.Simulation(mjsim.parse_world(text)) as sim:
            mjsim.run(sim, record=tmp_path / f"{name}.mcap")
    (place,) = export_euroc(mjsim.read_recording(tmp_path / "both.mcap"), tmp_path / "euroc")
    assert {each.name for each in (place / "mav0").iterdir()} == {"cam0", "state_groundtruth_estimate0", "body.yaml"}
    assert "up6/eye" in (place / "mav0" / "cam0" / "sensor.yaml").read_text()
    assert "'hand' of robot 'up6' moves with an arm" in capsys.readouterr().err
    with pytest.raises(UsageError, match="'hand' of robot 'up6' moves with an arm; EuRoC supports only fixed sensors"):
        export_euroc(mjsim.read_recording(tmp_path / "hand.mcap"), tmp_path / "none")


class _Repeated:
    """A recording whose only tick comes again and again."""

    def __init__(self, run: Recording, count: int) -> None:
        with RecordedRobots(run, redraw=False) as recorded:
            self.infos, (_, self.tick, *_) = recorded.infos, recorded.ticks(ROBOT)
        self.recording, self.count = run, count

    def on_arms(self, robot: str) -> set[str]:
        return set()

    def ticks(self, robot: str) -> Iterator[RecordedTick]:
        return itertools.repeat(self.tick, self.count)


@pytest.mark.slow
def test_inertial_readings_are_written_as_the_recording_is_read(run: Recording, tmp_path: Path):
    repeated = _Repeated(run, 1000)
    tracemalloc.start()
    (file,) = tables_of(repeated, ROBOT, ["imu"], tmp_path).values()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert file.stat().st_size > 100_000
    assert peak < 50_000
