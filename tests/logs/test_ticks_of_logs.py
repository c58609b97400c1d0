"""Logs in memory become worlds and ticks: each number held to where it comes from, without a file of a log."""

import math
from contextlib import ExitStack

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mjsim.errors import UsageError
from mjsim.geometry import Pose, Pose3
from mjsim.interface import ImuReading, Intrinsics, PointCloud, Scan, Sighting
from mjsim.logs.bags.bag_to_logs import read_bag
from mjsim.logs.resampling import Bias, Log, MotionNoise, Mount, RobotLog, Wishes, kept, recorded
from mjsim.logs.resampling.log import record_logs, world_of
from mjsim.record import LoggedCamera, LoggedFrame
from mjsim.world import Camera, Lidar, name_of, sensors
from tests.bags import START, new_bag

NOISE = MotionNoise(distance=0.03, turn=0.05, veer=0.02)


def scan(stamp: float, count: int = 5, step: float = 0.1, first: float = -0.2) -> Scan:
    return Scan(stamp, np.full(count, 1.0 + stamp), first, step, 0.05, 12.0)


def run_of(log: Log | list[Log], **wishes: object):
    logs = log if isinstance(log, list) else [log]
    from pathlib import Path

    return recorded(
        lambda output: record_logs(logs, Path("log"), Wishes(**wishes), output),
        record=None,
        overwrite=False,
        progress=None,
    )


SEEN = [Sighting(0.3, "a", 2.0, 0.5, np.eye(2)), Sighting(0.9, "b", 4.0, -0.5, np.eye(2))]
CAMERA = Intrinsics(64, 48, 60.0, 61.0, 31.5, 23.5)


def world(log: Log, **keys: object):
    span = {"span": (0.0, 1.0), "rate_hz": 10.0, "wishes": Wishes(), "source": "it"}
    return world_of([log], "w", **{**span, **keys})


def test_sensors_of_the_world_are_those_of_the_log():
    # A camera that looks to the left and 30 degrees up.
    turned = Rotation.from_euler("ZY", [90, -30], degrees=True).as_matrix() @ np.array(
        [[0, 0, 1], [-1, 0, 0], [0, -1, 0]]
    )
    place = np.eye(4)
    place[:3, :3], place[:3, 3] = turned, [0.1, 0.2, 0.9]
    cloud = PointCloud(
        0.1, np.zeros((2, 3), np.float32), np.zeros(2, np.float32), np.zeros(2, np.float32), np.array([0, 6], np.uint16)
    )
    robot = RobotLog(
        scans={"fan": kept([scan(0.1)]), "round": kept([scan(0.1, 400, math.radians(1))])},
        cameras={"eye": kept([LoggedFrame(0.1, np.zeros((48, 64, 3), np.uint8), CAMERA)])},
        clouds={"top": kept([cloud])},
        sightings=SEEN,
        imu=[ImuReading(0.1, np.zeros(3), np.zeros(3), "imu")],
        truth=np.array([[0.0, 1.0, 2.0, 3.0], [1.0, 3.0, 2.0, -3.0]]),
    )
    log = Log(
        kind="test",
        robot=robot,
        name="r",
        mounts={"fan": Mount(at=(0.3, 0.1, 0.2), yaw=0.5), "imu": Mount(at=(0.0, 0.1, 0.0), yaw=-0.5)},
        cameras={"eye": LoggedCamera(CAMERA, place)},
        landmarks={"a": (2.0, 1.0)},
        sighting=(0.2, 0.1),
    )
    made = world(log, span=(0.5, 3.5))
    (item,) = made.robots
    found = {name_of(each): each for each in item.sensors}
    fan, whole, eye, top, eyes, imu = (found[name] for name in ("fan", "round", "eye", "top", "eyes", "imu"))
    assert isinstance(fan, Lidar)
    assert (fan.beams, fan.at, fan.yaw_deg) == (5, (0.3, 0.1, 0.2), pytest.approx(math.degrees(0.5)))
    assert fan.fov_deg == pytest.approx(math.degrees(0.4))
    assert fan.range == (0.05, 12.0)
    assert (whole.beams, whole.fov_deg, whole.at) == (400, 360.0, (0.0, 0.0, 0.3))
    assert isinstance(eye, Camera)
    assert (eye.yaw_deg, eye.pitch_deg) == (pytest.approx(90.0), pytest.approx(30.0))
    assert eye.at == pytest.approx((0.1, 0.2, 0.9))
    assert eye.fov_deg == pytest.approx(2 * math.degrees(math.atan(32.0 / 60.0)))
    assert isinstance(top, sensors.Lidar3d)
    assert top.rings == 7
    assert (eyes.noise.range, eyes.noise.bearing_deg) == (0.2, pytest.approx(math.degrees(0.1)))
    assert (eyes.range[1], eyes.anonymous) == (pytest.approx(4.4), False)
    assert imu.yaw_deg == pytest.approx(math.degrees(-0.5))
    # It starts where the truth is at the first tick, turned the short way.
    assert item.at == pytest.approx((2.0, 2.0))
    assert math.remainder(item.heading_deg - 180.0, 360.0) == pytest.approx(0.0, abs=1e-9)
    assert [(each.name, each.at) for each in made.beacons] == [("a", (2.0, 1.0))]
    assert (made.run.seconds, made.run.map) == (3.0, "unknown")
    assert world(log, wishes=Wishes(known_map=True)).run.map == "known"


@pytest.mark.parametrize(
    ("time", "expected"), [(-1.0, (0.0, 0.0)), (0.5, (1.0, 2.0)), (9.0, (2.0, 4.0))], ids=["before", "within", "after"]
)
def test_a_robot_starts_at_its_true_pose_or_the_nearest_in_time(time, expected):
    poses = np.array([[0.0, 0.0, 0.0, 0.3, 0, 0, 0, 1.0], [1.0, 2.0, 4.0, 0.3, 0, 0, 0, 1.0]])
    for truth in ({"poses": poses}, {"truth": poses[:, [0, 1, 2, 4]]}):
        log = Log(kind="t", robot=RobotLog(scans={"s": kept([scan(0.0), scan(1.0)])}, **truth))
        assert world(log, span=(time, time + 1.0)).robots[0].at == pytest.approx(expected)


TRACK = np.column_stack([np.arange(21) * 0.1, np.arange(21) * 0.05, np.zeros(21), np.zeros(21)])


def test_a_tick_has_the_time_of_its_scan_and_what_came_since_the_one_before():
    stamps = [0.02, 0.11, 0.19, 0.33, 0.41]
    imu = [ImuReading(0.01 * k, np.full(3, k), np.zeros(3), "imu") for k in range(60)]
    robot = RobotLog(track=TRACK, scans={"scan": kept([scan(stamp) for stamp in stamps])}, imu=imu, sightings=SEEN)
    run = run_of(Log(kind="t", robot=robot, motion=NOISE), rate_hz=10.0)
    seen, start = list(run.observations("robot")), float(run.metadata["log start"])
    assert start == 0.0
    told = {round(each.time, 6): round(each.scans["scan"].ranges[0] - 1.0, 6) for each in seen if each.scans}
    assert told == {0.1: 0.02, 0.2: 0.11, 0.3: 0.19, 0.4: 0.33, 0.5: 0.41}
    # Odometry ends at the scan of each tick: 0.5 m/s for the time between them.
    np.testing.assert_allclose(
        np.cumsum([each.odometry.forward for each in seen])[:7], 0.5 * np.array([0.0, *stamps, 0.6]), atol=1e-9
    )
    assert [each.odometry.stamp for each in seen[1:6]] == pytest.approx(stamps)
    felt = [reading.acceleration[0] for each in seen for reading in each.imu]
    assert felt == list(range(60))
    for each, last in zip(seen[1:6], stamps, strict=True):
        assert each.imu[-1].stamp <= last + 1e-9
    assert {sighting.name: each.time for each in seen for sighting in each.sightings} == pytest.approx(
        {"a": 0.4, "b": 0.9}
    )
    assert run.metadata["scan scans left out"] == "0"


def test_bias_is_taken_away_from_each_step_and_sighting():
    bias = Bias(scale=1.25, turn_deg=math.degrees(0.2), range=0.5, bearing_deg=math.degrees(0.25))
    turning = TRACK.copy()
    turning[:, 3] = 0.3 * turning[:, 0]
    robot = RobotLog(track=turning, sightings=SEEN)
    plain, corrected = (run_of(Log(kind="t", robot=robot), rate_hz=10.0, bias=each) for each in (Bias(), bias))
    for before, after in zip(plain.observations("robot"), corrected.observations("robot"), strict=True):
        if before.odometry.forward:
            assert after.odometry.forward == pytest.approx(before.odometry.forward / 1.25)
            assert after.odometry.left == pytest.approx(before.odometry.left / 1.25)
            assert after.odometry.turn == pytest.approx(before.odometry.turn - 0.02)
        for told, true in zip(before.sightings, after.sightings, strict=True):
            assert (true.range, true.bearing) == pytest.approx((told.range - 0.5, told.bearing - 0.25))
    assert "scale 1.25" in corrected.metadata["bias taken away"]
    delayed = run_of(Log(kind="t", robot=robot), rate_hz=10.0, bias=Bias(delay=0.3))
    moved = [each.odometry.forward > 1e-6 for each in delayed.observations("robot")]
    assert moved.index(True) == 4, "it begins to move 0.3 s later"


def test_a_robot_stands_where_it_is_known_to_be_before_that_by_odometry_and_after_that_where_it_was():
    truth = np.array([[time, time + 2.55, 1.0, 0.5] for time in (0.45, 0.55, 0.65, 1.15, 1.25, 1.35)])
    robot = RobotLog(track=TRACK, truth=truth, gap=0.11)
    run = run_of(Log(kind="t", robot=robot), rate_hz=10.0)
    track = run.robots["robot"]
    known = np.isfinite(track.truth[:, 0])
    assert np.flatnonzero(known).tolist() == [5, 6, 12, 13]
    places = run.qpos[:, :2]
    np.testing.assert_allclose(places[known], track.truth[known, :2])
    begin = Pose(3.0, 1.0, 0.5)  # the nearest true pose in time
    for row in range(5):
        expected = begin @ Pose(0.05 * row, 0.0, 0.0)
        np.testing.assert_allclose(places[row], (expected.x, expected.y), atol=1e-9)
    np.testing.assert_allclose(places[7:12], np.broadcast_to(places[6], (5, 2)))
    np.testing.assert_allclose(places[14:], np.broadcast_to(places[13], (len(places) - 14, 2)))
    half = run.qpos[5, [3, 6]]
    assert 2.0 * math.atan2(half[1], half[0]) == pytest.approx(0.5)


def test_a_log_whose_truth_is_of_another_time_says_so_and_long_logs_are_refused():
    far = np.array([[90.0, 0.0, 0.0, 0.0], [91.0, 0.0, 0.0, 0.0]])
    run = run_of(Log(kind="t", robot=RobotLog(track=TRACK, truth=far)), rate_hz=10.0)
    assert run.metadata["truth of robot left out"].startswith("all of it is from 90 to 91 s, readings from 0 to")
    few = np.array([[0.0, 0.0, 0.0, 0.0], [2e6, 1.0, 0.0, 0.0]])
    with pytest.raises(UsageError, match=r"'log' lasts 2000000 s and has 2 readings; a recording of them lasts at"):
        run_of(Log(kind="t", robot=RobotLog(track=few)), rate_hz=10.0)
    with pytest.raises(UsageError, match="have the same time; a recording needs at least two ticks"):
        run_of(Log(kind="t", robot=RobotLog(track=TRACK[:1])), rate_hz=10.0)


@pytest.mark.parametrize(("hertz", "rate"), [(5.0, 10.0), (7.5, 12.5), (9.0, 25.0), (30.0, 50.0), (200.0, 125.0)])
def test_the_rate_is_the_lowest_with_a_tick_and_a_half_for_each_scan(hertz, rate):
    stamps = np.arange(0.0, 2.0, 1.0 / hertz)
    run = run_of(Log(kind="t", robot=RobotLog(scans={"scan": kept([scan(float(each)) for each in stamps])})))
    assert run.world.run.rate_hz == rate


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    """A bag whose commands have no headers, by a recorder 100 s ahead of the robot's clock."""
    path = tmp_path_factory.mktemp("bags") / "bag"
    with new_bag(path) as bag:
        for k in range(20):
            at = START + 0.1 * k
            pose = Pose3.from_planar(Pose(0.1 * k, 0.2, 0.3))
            bag.put("/odom", at + 100.0, bag.odometry(bag.header(at, "odom"), "base_link", pose, 1.0, 0.25))
            bag.put("/imu", at + 100.0, bag.imu(bag.header(at + 0.01, "imu_link"), [1, 2, 9], [4, 5, 6]))
            told = bag.make("geometry_msgs/Twist", linear=bag.xyz(k, 0, 0), angular=bag.xyz(0, 0, 0.5))
            bag.put("/cmd_vel", at + 100.0 + 0.05, told)
            lidar = bag.scan(bag.header(at + 0.02, "laser"), np.full(7, 1.0 + k), -0.3, 0.1, (0.1, 90.0))
            bag.put("/scan", at + 100.03, lidar)
        place = np.eye(4)
        place[:3, :3] = Rotation.from_euler("z", 90, degrees=True).as_matrix()
        place[:3, 3] = [0.2, 0.1, 0.4]
        for stamp in (START, START + 1.0):
            bag.transforms("/tf_static", stamp, [("base_link", "laser", place), ("base_link", "imu_link", place)])
    return path


def test_a_bag_gives_motion_commands_scans_and_inertial_readings_at_the_times_of_the_robot(bag):
    with ExitStack() as stack:
        (log,) = read_bag(bag, Wishes(), stack)
        robot = log.robot
        np.testing.assert_allclose(robot.track[:, 0], START + 0.1 * np.arange(20), atol=1e-6)
        np.testing.assert_allclose(robot.track[:, 1], 0.1 * np.arange(20), atol=1e-9)
        np.testing.assert_allclose(robot.track[:, 2:], np.broadcast_to([0.2, 0.3], (20, 2)), atol=1e-9)
        # Commands have the time of the robot at which they were recorded.
        np.testing.assert_allclose(robot.twists[:, 0], START + 0.1 * np.arange(20) + 0.05, atol=0.051)
        assert np.abs(np.diff(robot.twists[:-2, 0]) - 0.1).max() < 0.04
        np.testing.assert_allclose(robot.twists[:, 1:3], np.column_stack([np.arange(20), np.full(20, 0.5)]))
        (scans,) = robot.scans.values()
        np.testing.assert_allclose(scans.stamps, START + 0.1 * np.arange(20) + 0.02, atol=1e-6)
        assert [scans.take(k).ranges[0] for k in (0, 7, 19)] == [1.0, 8.0, 20.0]
        (reading, *_) = robot.imu
        # Turned by 90 degrees: its x points to the left of the robot.
        np.testing.assert_allclose(reading.stamp, START + 0.01, atol=1e-6)
        mounted = log.mounts[reading.name]
        whole = Rotation.from_euler("z", mounted.yaw)
        np.testing.assert_allclose(whole.apply(reading.acceleration), [-2.0, 1.0, 9.0], atol=1e-9)
        np.testing.assert_allclose(whole.apply(reading.turn), [-5.0, 4.0, 6.0], atol=1e-9)
        assert mounted.at == pytest.approx((0.2, 0.1, 0.4))
        (lidar,) = (mount for name, mount in log.mounts.items() if name in robot.scans)
        assert (lidar.at, lidar.yaw) == (pytest.approx((0.2, 0.1, 0.4)), pytest.approx(math.pi / 2))
    assert log.notes["/cmd_vel messages left out"] == log.notes["/scan messages left out"] == "0"
