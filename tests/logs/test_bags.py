"""Bags of ROS: a run of mjsim is written by another program, and comes back field by field."""

import itertools
import math
import re
import struct
from pathlib import Path

import cv2
import numpy as np
import pytest

import mjsim
from mjsim.algorithms.ekf_slam import EkfSlam
from mjsim.errors import UsageError
from mjsim.geometry import Pose, Pose3
from mjsim.interface import Intrinsics
from mjsim.logs import Wishes
from mjsim.logs.bag_file import Bag as RosBag
from mjsim.logs.bag_file import BagMessages
from mjsim.logs.bag_pictures import depth_of, frame_of
from mjsim.record import filed_frame
from mjsim.record.logged_frame import decode_picture
from mjsim.run import drivers_of
from mjsim.video.views import scene_pictures
from tests.bags import FORMS, Bag, new_bag
from tests.real_logs import run_command

START = 1_700_000_000.25
"""Time of the robot's clock when the run begins [s]."""
WORLD = """mjsim: 1
name: room
walls: [{points: [[0, 0], [5, 0], [5, 4], [0, 4]], closed: true}]
robots:
  - name: scout
    preset: pioneer3dx
    at: [1, 1]
    sensors:
      - {lidar: scan, at: [0.1, 0.05, 0.3], yaw_deg: 20, beams: 31, fov_deg: 180, range: [0.05, 3], rate_hz: 12.5}
      - {camera: front, at: [0.15, 0, 0.35], pitch_deg: -10, width: 64, height: 48, rate_hz: 6.25, depth: true}
      - {imu: gyro, at: [0, 0.1, 0.2], yaw_deg: 90, rate_hz: 50}
run:
  seconds: 1.2
  rate_hz: 25
  drivers:
    scout: {navigator: {use: "mjsim.algorithms.waypoints:Waypoints", points: [[3, 1], [3, 3]]}}
"""


@pytest.fixture(scope="module")
def driven():
    """Return the ticks of a run, and what the robot is told of itself."""
    world = mjsim.parse_world(WORLD)
    with mjsim.Simulation(world, seed=3) as sim:
        return list(itertools.islice(mjsim.ticks(sim, drivers_of(world)), 30)), sim.robots["scout"]


def write_run(path: Path, form: str, driven, *, space: str = "") -> None:
    """Write the ticks of a run as a robot of ROS would."""
    run, info = driven
    with new_bag(path, form) as bag:
        write_frames(bag, info)
        camera = info.sensors["front"].intrinsics
        for tick in run:
            seen, order, at = tick.seen["scout"], tick.orders["scout"], START + tick.time
            late = at + 0.003
            pose = Pose3.from_planar(order.dead_reckoning)
            told = bag.odometry(bag.header(at, "odom"), "base_link", pose, order.command.forward, order.command.turn)
            bag.put(f"{space}/odom", late, told)
            truth = bag.make(
                "geometry_msgs/PoseStamped", header=bag.header(at, "map"), pose=bag.pose(tick.poses["scout"])
            )
            bag.put(f"{space}/ground_truth/pose", late, truth)
            for reading in seen.imu:
                header = bag.header(START + reading.stamp, "/gyro")
                bag.put(f"{space}/imu/data", late, bag.imu(header, reading.acceleration, reading.turn))
            for scan in seen.scans.values():
                header = bag.header(at, "laser")
                limits = scan.range_min, scan.range_max
                bag.put(
                    f"{space}/scan", late, bag.scan(header, scan.ranges, scan.angle_min, scan.angle_increment, limits)
                )
            for frame in seen.cameras.values():
                header = bag.header(at, "front_optical")
                bag.put(f"{space}/front/image_raw", late, bag.image(header, "rgb8", frame.image, padding=4))
                far = frame.depth.astype(np.float32)
                bag.put(f"{space}/front/depth/image_raw", late, bag.image(header, "32FC1", far))
                info_message = bag.camera_info(header, 64, 48, camera.matrix(), np.zeros(5))
                bag.put(f"{space}/front/camera_info", late, info_message)


def write_frames(bag: Bag, info) -> None:
    names = {"laser": "scan", "front_optical": "front", "gyro": "gyro"}
    fixed = [
        bag.transform(bag.header(START, "base_link"), frame, info.sensors[sensor].robot_from_sensor)
        for frame, sensor in names.items()
    ]
    bag.put("/tf_static", START, bag.make("tf2_msgs/TFMessage", transforms=fixed))


@pytest.mark.parametrize("form", ["bag-lz4", "mcap-storage"])
def test_a_run_that_another_program_wrote_as_a_bag_comes_back_field_by_field(form, driven, tmp_path):
    path = tmp_path / ("run.bag" if form.startswith("bag") else "run")
    write_run(path, form, driven)
    run, info = driven
    log = mjsim.import_log(path, wishes=Wishes(rate_hz=25.0))
    assert log.metadata["log"] == ("bag of ROS 1" if form.startswith("bag") else "bag of ROS 2")
    # Stamps of ROS are in nanoseconds; doubles since 1970 hold 0.2 us.
    assert float(log.metadata["log start"]) == pytest.approx(START, abs=1e-6)
    assert list(log.robots) == ["robot"]
    track, told = log.robots["robot"], list(log.observations("robot"))
    assert len(told) == len(run)
    for row, (tick, seen) in enumerate(zip(run, told, strict=True)):
        given, order = tick.seen["scout"], tick.orders["scout"]
        np.testing.assert_allclose(track.truth_pose[row], tick.poses["scout"].as_array(), atol=2e-6)
        first, here = run[0].orders["scout"].dead_reckoning, order.dead_reckoning
        moved = Pose.from_array(track.truth[0]) @ (first.inverse() @ here)
        np.testing.assert_allclose(track.odometry[row], moved.as_array(), atol=2e-6)
        assert set(seen.scans) == set(given.scans)
        for name, scan in seen.scans.items():
            # A message holds ranges and angles as floats of 32 bits.
            np.testing.assert_array_equal(scan.ranges, given.scans[name].ranges.astype(np.float32))
            np.testing.assert_allclose(scan.angles(), given.scans[name].angles(), atol=1e-6)
    readings = [reading for seen in told for reading in seen.imu]
    expected = [reading for tick in run for reading in tick.seen["scout"].imu]
    # One before the first tick belongs to it; the gyroscope's axes were turned into those of the robot.
    turned = info.sensors["gyro"].robot_from_sensor[:3, :3]
    for reading, other in zip(readings[::-1], expected[::-1], strict=False):
        assert reading.stamp == pytest.approx(other.stamp, abs=1e-6)
        np.testing.assert_allclose(reading.acceleration, turned @ other.acceleration, atol=1e-12)
        np.testing.assert_allclose(reading.turn, turned @ other.turn, atol=1e-12)
    assert len(readings) >= len(expected) - 2


class Looker:
    """An observer that keeps what it sees."""

    def __init__(self) -> None:
        self.frames, self.info = [], None

    def start(self, robot, catalogue, rng) -> None:
        self.info = robot

    def observe(self, seen):
        self.frames += seen.cameras.values()
        return ()


@pytest.fixture(scope="module")
def logged(driven, tmp_path_factory):
    """Return a recording of a bag."""
    folder = tmp_path_factory.mktemp("bag")
    write_run(folder / "run", "mcap", driven)
    return mjsim.import_log(folder / "run", wishes=Wishes(rate_hz=25.0), record=folder / "log.mcap")


def test_modules_are_given_the_pictures_depth_and_calibration_of_the_log(logged, driven, tmp_path):
    run, info = driven
    looker = Looker()
    again = mjsim.replay(logged, robot="robot", estimator=EkfSlam(), observer=looker)
    given = [frame for tick in run for frame in tick.seen["scout"].cameras.values()]
    assert len(looker.frames) == len(given) > 5
    for frame, other in zip(looker.frames, given, strict=True):
        np.testing.assert_array_equal(frame.image, other.image)
        np.testing.assert_array_equal(frame.depth, other.depth.astype(np.float32))
        assert frame.stamp == pytest.approx(other.stamp, abs=1e-6)
        assert frame.intrinsics == other.intrinsics or frame.intrinsics.matrix() == pytest.approx(
            other.intrinsics.matrix()
        )
    for mine, its in (("scan", "scan"), ("front", "front")):
        told = looker.info.sensors[mine].robot_from_sensor
        np.testing.assert_allclose(told, info.sensors[its].robot_from_sensor, atol=1e-9)
    # A replay of a replay sees them too, and the film of a camera shows them.
    second = Looker()
    mjsim.replay(again, robot="robot", estimator=EkfSlam(), observer=second)
    np.testing.assert_array_equal(second.frames[-1].image, given[-1].image)
    film = list(scene_pictures(again, range(len(again.time)), "robot/front"))
    np.testing.assert_array_equal(film[-1], given[-1].image)


def test_statistics_and_pictures_of_a_bag_that_was_replayed(logged, tmp_path):
    again = mjsim.replay(logged, robot="robot", estimator=EkfSlam(), record=tmp_path / "again.mcap")
    assert mjsim.statistics(again)["robot"]["position_error_m"]["max"] < 0.05
    assert run_command("export", again.path, "--images", tmp_path / "pictures") == 0
    files = sorted((tmp_path / "pictures").rglob("*.png"))
    assert len(files) == len(list(again.pictures("robot", "front")))


@pytest.mark.parametrize("form", FORMS)
def test_every_form_of_a_bag_gives_its_messages_in_order_and_by_number(form, tmp_path):
    path = tmp_path / ("run.bag" if form.startswith("bag") else "run")
    with new_bag(path, form) as bag:
        for k in range(40):
            header = bag.header(START + 0.1 * k, "laser")
            ranges = np.random.default_rng(k).uniform(1.0, 2.0, 500)
            bag.put("/scan", START + 0.1 * k + 0.01, bag.scan(header, ranges, 0.0, 0.01, (0.1, 9.0)))
    with RosBag(path) as bag:
        assert bag.types == {"/scan": "sensor_msgs/msg/LaserScan"}
        found = list(bag.messages(["/scan"]))
        assert [bag.stamp(each) for each in found] == pytest.approx([START + 0.1 * k for k in range(40)], abs=1e-6)
        np.testing.assert_array_equal(
            bag.decode(found[7]).ranges, np.random.default_rng(7).uniform(1.0, 2.0, 500).astype(np.float32)
        )
        later = list(bag.messages(["/scan"], start=found[30].time))
        assert [each.data for each in later] == [each.data for each in found[30:]]
        # By number, in any order.
        messages = BagMessages(bag, {"/scan": np.array([each.time for each in found])})
        for number in (3, 4, 20, 2, 39):
            assert messages.take("/scan", number).data == found[number].data
        assert not bag.cut


def write_scans(path: Path, form: str = "mcap", *, first: float = -0.3, step: float = 0.1) -> None:
    """Write a second of scans, and odometry that stands still."""
    with new_bag(path, form) as bag:
        for k in range(10):
            at = START + 0.1 * k
            ranges = np.array([np.nan, 0.0, 0.05, 1.0, 3.0, 9.0, np.inf])
            told = bag.scan(bag.header(at, "laser"), ranges, first, step, (0.1, 5.0))
            bag.put("/scan", at, told)
            bag.put("/odom", at, bag.odometry(bag.header(at, "odom"), "base_link", Pose3(0, 0, 0, 0, 0, 0, 1)))


def test_ranges_that_are_no_numbers_and_scans_from_left_to_right_are_told_as_ours(tmp_path):
    write_scans(tmp_path / "plain")
    write_scans(tmp_path / "reversed", first=0.3, step=-0.1)
    inf = math.inf
    for name, ranges in (("plain", [-inf, -inf, -inf, 1.0, 3.0, inf, inf]), ("reversed", None)):
        run = mjsim.import_log(tmp_path / name, wishes=Wishes(seconds=0.3))
        scan = next(seen.scans["scan"] for seen in run.observations("robot") if seen.scans)
        np.testing.assert_array_equal(scan.ranges, ranges or [inf, inf, 3.0, 1.0, -inf, -inf, -inf])
        assert scan.angle_increment > 0.0
        np.testing.assert_allclose(scan.angles(), np.linspace(-0.3, 0.3, 7), atol=1e-6)


def test_a_lidar_that_hangs_sees_its_left_on_the_robots_right(tmp_path):
    with new_bag(tmp_path / "run.bag", "bag") as bag:
        hung = np.diag([1.0, -1.0, -1.0, 1.0])
        fixed = bag.transform(bag.header(START, "/base_link"), "/laser", hung)
        bag.put("/tf", START, bag.make("tf2_msgs/TFMessage", transforms=[fixed]))
        for k in range(12):
            header = bag.header(START + 0.1 * k, "/laser")
            bag.put("/scan", START + 0.1 * k, bag.scan(header, np.array([1.0, 2.0, 3.0]), 0.0, 0.5, (0.1, 5.0)))
    run = mjsim.import_log(tmp_path / "run.bag")
    scan = next(seen.scans["scan"] for seen in run.observations("robot") if seen.scans)
    np.testing.assert_allclose(scan.angles(), [-1.0, -0.5, 0.0], atol=1e-6)
    np.testing.assert_array_equal(scan.ranges, [3.0, 2.0, 1.0])


@pytest.mark.parametrize("form", ["bag", "bag-lz4", "mcap", "mcap-storage"])
def test_a_bag_that_was_cut_is_read_up_to_where_it_ends(form, tmp_path):
    path = tmp_path / ("run.bag" if form.startswith("bag") else "run")
    with new_bag(path, form) as bag:
        for k in range(300):
            header = bag.header(START + 0.1 * k, "laser")
            ranges = np.random.default_rng(k).uniform(1.0, 2.0, 3000)
            bag.put("/scan", START + 0.1 * k, bag.scan(header, ranges, 0.0, 0.002, (0.1, 9.0)))
    whole = path if path.is_file() else next(path.glob("*.mcap"))
    cut = tmp_path / f"cut{whole.suffix}"
    cut.write_bytes(whole.read_bytes()[: int(0.7 * whole.stat().st_size)])
    with RosBag(cut) as bag:
        found = list(bag.messages(["/scan"]))
        assert 60 < len(found) < 300
        assert bag.cut
        assert bag.decode(found[-1]).ranges[0] == np.float32(np.random.default_rng(len(found) - 1).uniform(1.0, 2.0))


@pytest.mark.slow
@pytest.mark.parametrize("form", ["bag", "sqlite", "mcap"])
def test_a_bag_of_several_files_is_read_without_its_metadata(form, tmp_path):
    folder = tmp_path / "run"
    folder.mkdir()
    for part in range(3):
        one = tmp_path / f"part{part}.bag"
        with new_bag(one, form) as bag:
            # The recorder changes files at different times of each topic.
            for k in range(10 * part, 10 * part + 12):
                header = bag.header(START + 0.1 * k, "laser")
                bag.put(
                    f"/scan{part % 2}", START + 0.1 * k, bag.scan(header, np.full(5, 1.0 + k), 0.0, 0.1, (0.1, 50.0))
                )
                bag.put("/both", START + 0.1 * k, bag.scan(header, np.full(3, 1.0 + k), 0.0, 0.1, (0.1, 50.0)))
        found = one if form == "bag" else next(file for file in one.iterdir() if file.suffix != ".yaml")
        found.rename(folder / f"run_{part}{found.suffix}")
    with RosBag(folder) as bag:
        found = list(bag.messages(["/both", "/scan0"]))
        times = [each.time for each in found]
        assert times == sorted(times)
        ranges = [bag.decode(each).ranges[0] for each in found if each.topic == "/both"]
        assert sorted(ranges) == sorted(1.0 + k for part in range(3) for k in range(10 * part, 10 * part + 12))
        assert bag.counts == {"/scan0": 24, "/scan1": 12, "/both": 36}
    run = mjsim.import_log(folder)
    assert {name for seen in run.observations("robot") for name in seen.scans} == {"both", "scan0", "scan1"}
    some = next(folder.iterdir())
    some.rename(folder / f"other{some.suffix}")
    with pytest.raises(UsageError, match=r"has no metadata\.yaml and 3 files of bags"):
        RosBag(folder)


def test_a_folder_whose_metadata_are_wrong_is_read_by_its_files(tmp_path):
    write_scans(tmp_path / "run")
    told = (tmp_path / "run" / "metadata.yaml").read_text()
    for wrong in (told.replace(".mcap", "_9.mcap"), told[: len(told) // 2], "", "[1, 2"):
        (tmp_path / "run" / "metadata.yaml").write_text(wrong)
        with RosBag(tmp_path / "run") as bag:
            assert len(list(bag.messages(["/scan"]))) == 10
            assert bag.cut


def test_messages_out_of_order_and_those_of_a_wrong_clock_do_no_harm(tmp_path):
    order = [0, 2, 1, 3, 4, 6, 5, 7, 8, 9]
    with new_bag(tmp_path / "run") as bag:
        for place, k in enumerate(order):
            header = bag.header(START + 0.1 * k, "laser")
            bag.put("/scan", START + 0.1 * place, bag.scan(header, np.full(3, 1.0 + k), 0.0, 0.5, (0.1, 50.0)))
        early = bag.scan(bag.header(17.0, "laser"), np.ones(3), 0.0, 0.5, (0.1, 50.0))
        bag.put("/scan", START + 1.0, early)
        bag.put("/scan", START + 1.1, bag.scan(bag.header(START + 1.0, "laser"), np.ones(4), 0.0, 0.5, (0.1, 50.0)))
    run = mjsim.import_log(tmp_path / "run")
    told = [seen.scans["scan"].ranges[0] for seen in run.observations("robot") if seen.scans]
    assert told == [1.0 + k for k in range(10)]
    assert run.metadata["/scan messages left out"] == "2"


def test_robots_with_namespaces_of_their_own_are_told_apart(tmp_path):
    with new_bag(tmp_path / "run") as bag:
        for k in range(10):
            at = START + 0.1 * k
            for row, name in enumerate(("anna", "bert")):
                pose = Pose3.from_planar(Pose(0.1 * k, float(row), 0.0))
                bag.put(f"/{name}/odom", at, bag.odometry(bag.header(at, "odom"), f"{name}/base_link", pose))
                bag.put(f"/{name}/scan", at, bag.scan(bag.header(at, "l"), np.full(5, row + 1.0), 0.0, 0.5, (0.1, 9.0)))
    run = mjsim.import_log(tmp_path / "run")
    assert set(run.robots) == {"anna", "bert"}
    for row, name in enumerate(("anna", "bert")):
        assert run.robots[name].odometry[-1, 0] == pytest.approx(0.9, abs=1e-6)
        seen = next(seen for seen in run.observations(name) if seen.scans)
        assert set(seen.scans) == {"scan"}
        assert seen.scans["scan"].ranges[0] == row + 1.0
    only = mjsim.import_log(tmp_path / "run", wishes=Wishes(robots=["bert"]))
    assert set(only.robots) == {"bert"}


@pytest.mark.parametrize(
    ("form", "name"),
    [("bag", "run.mcap"), ("mcap", "run.bag"), ("mcap", "RUN.MCAP"), ("sqlite", "run.mcap"), ("bag", "run")],
)
def test_a_bag_is_known_by_what_it_holds_whatever_its_name(form, name, tmp_path):
    first = tmp_path / "first.bag"
    write_scans(first, form)
    file = first if first.is_file() else next(each for each in first.iterdir() if each.name != "metadata.yaml")
    file.rename(tmp_path / name)
    log = mjsim.import_log(tmp_path / name)
    assert sum(len(seen.scans) for seen in log.observations("robot")) > 3
    assert "bag breaks off" not in log.metadata


def test_a_camera_of_an_unknown_encoding_is_left_out_and_told(tmp_path):
    with new_bag(tmp_path / "seen") as bag:
        for k in range(5):
            header = bag.header(START + 0.1 * k, "eye")
            bag.put("/odom", START + 0.1 * k, bag.odometry(header, "base_link", Pose3(0, 0, 0, 0, 0, 0, 1)))
            bag.put("/eye/image_raw", START + 0.1 * k, bag.image(header, "nv21", np.zeros((16, 16), np.uint8)))
    log = mjsim.import_log(tmp_path / "seen")
    assert log.metadata["/eye/image_raw messages left out"] == "5"
    assert not log.cameras()


def test_a_log_of_one_moment_is_refused(tmp_path):
    with new_bag(tmp_path / "run") as bag:
        bag.put("/scan", START, bag.scan(bag.header(START, "l"), np.ones(9), 0.0, 0.1, (0.1, 9.0)))
    with pytest.raises(UsageError, match="are of one moment; a recording has two ticks at least"):
        mjsim.import_log(tmp_path / "run")


@pytest.mark.slow
def test_what_cannot_be_read_or_is_not_clear_is_one_line(tmp_path):
    write_scans(tmp_path / "run")
    with new_bag(tmp_path / "two") as bag:
        for topic in ("/wheels", "/fused"):
            pose = Pose3(0, 0, 0, 0, 0, 0, 1)
            bag.put(topic, START, bag.odometry(bag.header(START, "odom"), "base_link", pose))
    with new_bag(tmp_path / "words") as bag:
        bag.put("/chatter", START, bag.make("std_msgs/String", data="hello"))
    with new_bag(tmp_path / "beams") as bag:
        bag.put("/scan", START, bag.scan(bag.header(START, "l"), np.ones(20_000), 0.0, 1e-4, (0.1, 9.0)))
    with new_bag(tmp_path / "nothing") as bag:
        bag.put("/scan", START, bag.scan(bag.header(START, "l"), np.ones(1), 0.0, 1e-4, (0.1, 9.0)))
        bag.put("/odom", START, bag.odometry(bag.header(START, "odom"), "base_link", Pose3(0, 0, 0, 0, 0, 0, 0)))
    with new_bag(tmp_path / "days") as bag:
        for at in (START, START + 1e6, START + 2e6):
            bag.put("/odom", at, bag.odometry(bag.header(at, "odom"), "base_link", Pose3(0, 0, 0, 0, 0, 0, 1)))
    (tmp_path / "empty.bag").write_bytes(b"#ROSBAG V2.0\n")
    (tmp_path / "broken.db3").write_bytes(b"SQLite format 3\x00" + b"\x07" * 5000)
    (tmp_path / "text.bag").write_text("hello")
    for name, topics, said in (
        ("two", {}, "several topics hold odometry: /wheels, /fused; name one with --topic odometry=/wheels"),
        ("words", {}, "holds no odometry, scans, clouds, pictures or IMU of ROS; it has std_msgs/msg/String"),
        ("beams", {}, "scans on '/scan' have 20,000 beams; a lidar has at most 10,000"),
        ("nothing", {}, "holds no odometry, scans, clouds, pictures or sightings; there is nothing to record"),
        ("days", {}, "lasts 2000000 s; a recording lasts at most 1000000: choose a part with --begin and --seconds"),
        ("run", {"scan": ["/skan"]}, "no topic '/skan' in this bag; did you mean '/scan'"),
        ("run", {"lidar": ["/scan"]}, "no kind of topic 'lidar'"),
        (
            "run",
            {"odometry": ["/scan"]},
            "topic '/scan' is of sensor_msgs/msg/LaserScan; odometry is read from nav_msgs",
        ),
        ("empty.bag", {}, "is no bag that can be read"),
        ("broken.db3", {}, "is no bag that can be read"),
        ("text.bag", {}, "is no log that is read here"),
    ):
        with pytest.raises(UsageError, match=re.escape(said)) as caught:
            mjsim.import_log(tmp_path / name, wishes=Wishes(topics=topics))
        assert "\n" not in str(caught.value)
    assert run_command("import-log", tmp_path / "run", "-o", tmp_path / "x.mcap", "--topic", "scan") == 2


TURNED = np.array([[0.0, 0.0, 1.0, 0.2], [0.0, 1.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.9], [0.0, 0.0, 0.0, 1.0]])
"""base_link_from_lidar of a lidar that looks down [m]."""


@pytest.mark.slow
def test_clouds_of_several_drivers_come_in_along_the_axes_of_the_robot(tmp_path):
    velodyne = np.dtype(
        [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("intensity", "<f4"), ("ring", "<u2"), ("time", "<f4")]
    )
    ouster = np.dtype(
        [("z", ">f8"), ("x", ">f8"), ("y", ">f8"), ("t", ">u4"), ("reflectivity", ">u2"), ("ring", ">u1")]
    )
    hesai = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("timestamp", "<f8")])
    xyz = np.array([[1, 2, 3], [np.nan, 1, 1], [4, 5, 6], [0, 0, 0], [-1, 0, 2], [1, 1, 1]], dtype=float)
    with new_bag(tmp_path / "run") as bag:
        fixed = bag.transform(bag.header(START, "base_link"), "lidar", TURNED)
        bag.put("/tf_static", START, bag.make("tf2_msgs/TFMessage", transforms=[fixed]))
        for k in range(4):
            at = START + 0.1 * k
            for topic, kind in (("/velodyne_points", velodyne), ("/ouster/points", ouster), ("/hesai", hesai)):
                rows = np.zeros((2, 3), dtype=kind)
                rows["x"], rows["y"], rows["z"] = xyz.T.reshape(3, 2, 3)
                for name, value in (("ring", 3), ("intensity", 40 + k), ("reflectivity", 50)):
                    if name in kind.names:
                        rows[name] = value
                offset = 0.01 * np.arange(6).reshape(2, 3) - (0.05 if kind is velodyne else 0.0)
                if "time" in kind.names:
                    rows["time"] = offset
                elif "t" in kind.names:
                    rows["t"] = np.rint(offset * 1e9)
                else:
                    rows["timestamp"] = at + offset
                bag.put(topic, at, bag.cloud(bag.header(at, "lidar"), rows, padding=5))
    run = mjsim.import_log(tmp_path / "run")
    clouds = [seen.clouds for seen in run.observations("robot") if seen.clouds]
    there = xyz[[0, 2, 4, 5]] @ TURNED[:3, :3].T
    for name, strength, ring in (("velodyne_points", 40.0, 3), ("ouster", 50.0, 3), ("hesai", 0.0, 0)):
        cloud = next(each[name] for each in clouds if name in each)
        np.testing.assert_allclose(cloud.points, there, atol=1e-6)
        np.testing.assert_allclose(cloud.times, [-0.05, -0.03, -0.01, 0.0], atol=1e-6)
        assert set(cloud.intensities.tolist()) == {strength}
        assert set(cloud.rings.tolist()) == {ring}
        assert sum(name in each for each in clouds) == 4
    assert {sensor.at for sensor in run.world.robots[0].sensors} == {(0.2, 0.0, 0.9)}


@pytest.mark.slow
def test_commands_echoes_and_what_is_not_read_are_told(tmp_path):
    with new_bag(tmp_path / "run") as bag:
        for k in range(10):
            at = START + 0.1 * k
            bag.put("/odom", at, bag.odometry(bag.header(at, "odom"), "base_link", Pose3(0.01 * k, 0, 0, 0, 0, 0, 1)))
            told = bag.make("geometry_msgs/Twist", linear=bag.xyz(0.3, 0, 0), angular=bag.xyz(0, 0, -0.2))
            bag.put("/cmd_vel", at, told)
            bag.put("/chatter", at, bag.make("std_msgs/String", data="hello"))
            echoes = [bag.make("sensor_msgs/LaserEcho", echoes=np.float32(each)) for each in ([1.0, 2.0], [], [3.0])]
            plain = bag.scan(bag.header(at, "laser"), np.ones(3), 0.0, 0.5, (0.1, 9.0))
            fields = {name: getattr(plain, name) for name in plain.__dataclass_fields__ if not name.startswith("__")}
            bag.put(
                "/most",
                at,
                bag.make("sensor_msgs/MultiEchoLaserScan", **(fields | {"ranges": echoes, "intensities": []})),
            )
    run = mjsim.import_log(tmp_path / "run")
    np.testing.assert_allclose(run.robots["robot"].command[-1], [0.3, 0.0, -0.2])
    scan = next(seen.scans["most"] for seen in run.observations("robot") if seen.scans)
    np.testing.assert_array_equal(scan.ranges, [1.0, np.inf, 3.0])
    assert run.metadata["/chatter left out"] == "10 messages of std_msgs/msg/String"


def test_robots_that_only_tf_tells_apart_are_not_mixed(tmp_path):
    with new_bag(tmp_path / "run") as bag:
        for k in range(10):
            at = START + 0.1 * k
            moved = []
            for row, name in enumerate(("anna", "bert")):
                place = Pose3(0.1 * k, float(row), 0, 0, 0, 0, 1).matrix()
                moved.append(bag.transform(bag.header(at, f"{name}/odom"), f"{name}/base_link", place))
            bag.put("/tf", at, bag.make("tf2_msgs/TFMessage", transforms=moved))
            bag.put("/scan", at, bag.scan(bag.header(at, "l"), np.ones(5), 0.0, 0.5, (0.1, 9.0)))
    run = mjsim.import_log(tmp_path / "run")
    assert run.metadata["odometry"] == "none; /tf has several frames that move, anna/base_link, bert/base_link"
    assert not run.robots["robot"].odometry[:, :2].any()


class _Image:
    """A `sensor_msgs/Image` of an array."""

    def __init__(self, encoding: str, pixels: np.ndarray, *, big: bool = False) -> None:
        pixels = pixels.astype(pixels.dtype.newbyteorder(">")) if big else pixels
        self.height, self.width = pixels.shape[:2]
        self.encoding, self.is_bigendian = encoding, int(big)
        self.step = pixels.nbytes // self.height + 3
        rows = np.frombuffer(pixels.tobytes(), dtype=np.uint8).reshape(self.height, -1)
        self.data = np.hstack([rows, np.full((self.height, 3), 9, dtype=np.uint8)]).ravel()


def test_pictures_of_every_encoding_show_the_same():
    size = Intrinsics(16, 16, 10.0, 10.0, 7.5, 7.5)
    rgb = np.zeros((16, 16, 3), dtype=np.uint8)
    rgb[:] = 200, 120, 40
    clear = np.full((16, 16, 1), 255, dtype=np.uint8)
    grey = np.full((16, 16), 77, dtype=np.uint8)
    mosaic = np.empty((16, 16), dtype=np.uint8)
    mosaic[::2, ::2], mosaic[1::2, 1::2] = 200, 40
    mosaic[::2, 1::2] = mosaic[1::2, ::2] = 120
    for encoding, pixels in (
        ("rgb8", rgb),
        ("bgr8", rgb[..., ::-1]),
        ("rgba8", np.concatenate([rgb, clear], axis=2)),
        ("bgra8", np.concatenate([rgb[..., ::-1], clear], axis=2)),
        ("bgr16", rgb[..., ::-1].astype(np.uint16) << 8),
        ("bayer_rggb8", mosaic),
        ("bayer_bggr8", np.roll(mosaic, (1, 1), axis=(0, 1))),
    ):
        frame = frame_of(_Image(encoding, np.ascontiguousarray(pixels)), 1.0, size)
        np.testing.assert_array_equal(frame.image[4:12, 4:12], rgb[4:12, 4:12], err_msg=encoding)
        assert frame.form == "png"
    for encoding, pixels in (("mono8", grey), ("8UC1", grey), ("mono16", grey.astype(np.uint16) << 8)):
        for big in (False, True):
            frame = frame_of(_Image(encoding, pixels, big=big), 1.0, size)
            assert (frame.image == 77).all()
    with pytest.raises(ValueError, match="encoding 'yuv999' are not read"):
        frame_of(_Image("yuv999", grey), 1.0, size)
    metres = np.full((16, 16), 1.25, dtype=np.float32)
    metres[0, :2] = np.nan, 0.0
    assert np.isinf(depth_of(_Image("32FC1", metres), size)[0, :2]).all()
    counts = np.full((16, 16), 1250, dtype=np.uint16)
    counts[0, 0] = 0
    far = depth_of(_Image("16UC1", counts, big=True), size)
    assert far[1, 1] == np.float32(1.25)
    assert far[0, 0] == np.inf


def test_a_jpeg_that_says_it_was_turned_keeps_its_rows():
    pixels = np.zeros((16, 32, 3), dtype=np.uint8)
    pixels[:, :16] = 250
    data = cv2.imencode(".jpg", pixels)[1].tobytes()
    # EXIF with one entry: orientation 6, a quarter turn; behind the mark that a JPEG begins with.
    exif = b"Exif\0\0" + struct.pack("<2sHIHHHIHHI", b"II", 42, 8, 1, 0x0112, 3, 1, 6, 0, 0)
    turned = data[:2] + struct.pack(">2sH", b"\xff\xe1", len(exif) + 2) + exif + data[2:]
    assert cv2.imdecode(np.frombuffer(turned, dtype=np.uint8), cv2.IMREAD_COLOR).shape == (32, 16, 3)
    frame = filed_frame(turned, 0.0, Intrinsics(32, 16, 10.0, 10.0, 15.5, 7.5))
    assert frame.encoded == turned
    np.testing.assert_array_equal(frame.image, decode_picture(data))


def test_a_picture_that_claims_to_be_huge_is_not_decoded():
    plain = cv2.imencode(".png", np.zeros((16, 32), dtype=np.uint8))[1].tobytes()
    size = Intrinsics(32, 16, 10.0, 10.0, 15.5, 7.5)
    assert filed_frame(plain, 0.0, size).image.shape == (16, 32, 3)
    for width, height, said in ((9000, 2, "a picture of 9000 x 2 pixels among others"), (40000, 40000, "megapixels")):
        # Its checksum is wrong too: who decoded it would call it broken.
        with pytest.raises(ValueError, match=said):
            filed_frame(plain[:16] + struct.pack(">II", width, height) + plain[24:], 0.0, size)
