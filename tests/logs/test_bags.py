"""Bags of ROS: a run of mjsim is written by another program, and comes back field by field."""

import itertools
from pathlib import Path

import numpy as np
import pytest

import mjsim
from mjsim.algorithms.ekf_slam.ekf_slam import EkfSlam
from mjsim.geometry import Pose, Pose3
from mjsim.logs import Wishes
from mjsim.logs.bags.bag_file import Bag as RosBag
from mjsim.logs.bags.bag_file import BagMessages
from mjsim.run import drivers_of
from mjsim.video.views import scene_pictures
from tests.bags import FORMS, START, Bag, new_bag
from tests.real_logs import imported, run_command

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


@pytest.mark.slow
@pytest.mark.parametrize("form", ["bag-lz4", "mcap-storage"])
def test_a_run_that_another_program_wrote_as_a_bag_comes_back_field_by_field(form, driven, tmp_path):
    path = tmp_path / ("run.bag" if form.startswith("bag") else "run")
    write_run(path, form, driven)
    run, info = driven
    log = imported(path, wishes=Wishes(rate_hz=25.0))
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
    return imported(folder / "run", wishes=Wishes(rate_hz=25.0), record=folder / "log.mcap")


@pytest.mark.slow
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


@pytest.mark.slow
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


TURNED = np.array([[0.0, 0.0, 1.0, 0.2], [0.0, 1.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.9], [0.0, 0.0, 0.0, 1.0]])
"""base_link_from_lidar of a lidar that looks down [m]."""


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
    run = imported(tmp_path / "run")
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
