"""Bags, read back field by field by rosbags: what each message must hold is computed here from the recording."""

import math
import resource
from pathlib import Path

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

import mjsim
from mjsim.datasets import export_rosbag2
from mjsim.datasets.recorded_robots import RecordedRobots
from mjsim.errors import UsageError
from mjsim.geometry import Pose, Pose3
from mjsim.record import Recording, read_recording
from tests.strangers import as_stranger

SCOUT = "x7_tip_top"
"""The robot '7.tip-top' as ROS allows it."""


class Bag:
    """All messages of a bag by topic: (time in the bag [ns], message)."""

    def __init__(self, folder: Path) -> None:
        self.messages: dict[str, list] = {}
        with AnyReader([folder]) as reader:
            self.types = {each.topic: each.msgtype for each in reader.connections}
            self.profiles = {each.topic: each.ext.offered_qos_profiles[0] for each in reader.connections}
            for connection, time, raw in reader.messages():
                message = reader.deserialize(raw, connection.msgtype)
                self.messages.setdefault(connection.topic, []).append((time, message))


@pytest.fixture(scope="module")
def bag(run: Recording, tmp_path_factory: pytest.TempPathFactory) -> Bag:
    return Bag(export_rosbag2(run, tmp_path_factory.mktemp("bags") / "bag"))


def nanoseconds(header) -> int:
    return header.stamp.sec * 1_000_000_000 + header.stamp.nanosec


def pose_of(pose) -> list[float]:
    return [pose.position.x, pose.position.y, pose.position.z, *rotation_of(pose.orientation)]


def rotation_of(q) -> list[float]:
    return [q.x, q.y, q.z, q.w]


def planar(pose: Pose) -> list[float]:
    return Pose3.from_planar(pose).as_array().tolist()


def in_space(covariance: np.ndarray) -> list[float]:
    whole = np.diag([1e-9, 1e-9, 1e-6, 1e-6, 1e-6, 1e-9])
    for i, a in enumerate((0, 1, 5)):
        for j, b in enumerate((0, 1, 5)):
            whole[a, b] += covariance[i, j]
    return whole.ravel().tolist()


def test_all_topics_are_there_with_their_types(bag: Bag):
    robot = f"/{SCOUT}"
    assert bag.types == {
        "/clock": "rosgraph_msgs/msg/Clock",
        "/map": "nav_msgs/msg/OccupancyGrid",
        "/tf": "tf2_msgs/msg/TFMessage",
        "/tf_static": "tf2_msgs/msg/TFMessage",
        f"{robot}/truth": "geometry_msgs/msg/PoseStamped",
        f"{robot}/odom": "nav_msgs/msg/Odometry",
        f"{robot}/estimate": "geometry_msgs/msg/PoseWithCovarianceStamped",
        f"{robot}/scan": "sensor_msgs/msg/LaserScan",
        f"{robot}/rear/scan": "sensor_msgs/msg/LaserScan",
        f"{robot}/imu": "sensor_msgs/msg/Imu",
        f"{robot}/proximity": "sensor_msgs/msg/Range",
        f"{robot}/eye/image_raw/compressed": "sensor_msgs/msg/CompressedImage",
        f"{robot}/eye/depth/image_raw": "sensor_msgs/msg/Image",
        f"{robot}/eye/camera_info": "sensor_msgs/msg/CameraInfo",
        f"{robot}/wide/image_raw/compressed": "sensor_msgs/msg/CompressedImage",
        f"{robot}/wide/camera_info": "sensor_msgs/msg/CameraInfo",
        "/bare/truth": "geometry_msgs/msg/PoseStamped",
        "/bare/odom": "nav_msgs/msg/Odometry",
        "/bare/proximity": "sensor_msgs/msg/Range",
    }


def test_late_readers_get_what_stands_once_and_sensors_are_best_effort(bag: Bag):
    kinds = {name: (each.durability.name, each.reliability.name) for name, each in bag.profiles.items()}
    assert {kinds["/tf_static"], kinds["/map"]} == {("TRANSIENT_LOCAL", "RELIABLE")}
    assert {kinds[f"/{SCOUT}/{name}"] for name in ("scan", "imu", "eye/camera_info")} == {("VOLATILE", "BEST_EFFORT")}
    assert {kinds[name] for name in ("/clock", "/tf", f"/{SCOUT}/odom")} == {("VOLATILE", "RELIABLE")}


def test_the_clock_ticks_as_the_run(bag: Bag, run: Recording):
    told = [(time, each.clock.sec * 10**9 + each.clock.nanosec) for time, each in bag.messages["/clock"]]
    assert told == [(round(time * 1e9), round(time * 1e9)) for time in run.time.tolist()]


@pytest.mark.parametrize("robot", ["7.tip-top", "bare"])
def test_truth_odometry_and_estimate_are_those_of_the_recording(bag: Bag, run: Recording, robot: str):
    name, track = {"7.tip-top": SCOUT, "bare": "bare"}[robot], run.robots[robot]
    observed = list(run.observations(robot))
    for row, (time, message) in enumerate(bag.messages[f"/{name}/truth"]):
        assert time == nanoseconds(message.header) == round(track.time[row] * 1e9)
        assert message.header.frame_id == "map"
        assert pose_of(message.pose) == track.truth_pose[row].tolist()
    for row, (_, message) in enumerate(bag.messages[f"/{name}/odom"]):
        assert (message.header.frame_id, message.child_frame_id) == (f"{name}/odom", f"{name}/base_link")
        assert pose_of(message.pose.pose) == planar(Pose(*track.odometry[row]))
        assert message.pose.covariance.tolist() == in_space(track.odometry_covariance[row])
        moved, dt = observed[row].odometry, observed[row].dt
        twist = message.twist.twist
        assert [twist.linear.x, twist.linear.y, twist.linear.z] == [moved.forward / dt, moved.left / dt, 0.0]
        assert [twist.angular.x, twist.angular.y, twist.angular.z] == [0.0, 0.0, moved.turn / dt]
        assert message.twist.covariance.tolist() == in_space(moved.covariance / dt**2)
    estimates = bag.messages.get(f"/{name}/estimate", [])
    for row, (_, message) in enumerate(estimates):
        assert message.header.frame_id == "map"
        assert pose_of(message.pose.pose) == planar(Pose(*track.estimate[row]))
        assert message.pose.covariance.tolist() == in_space(track.covariance[row])
    assert len(estimates) == (len(run.time) if run.has_estimator(robot) else 0)
    assert len(observed) == len(bag.messages[f"/{name}/truth"]) == len(run.time)


def test_covariances_of_odometry_can_be_inverted_also_of_a_robot_that_does_not_know_of_any_error(bag: Bag):
    for robot in (SCOUT, "bare"):
        for _, message in bag.messages[f"/{robot}/odom"]:
            for of in (message.pose, message.twist):
                whole = of.covariance.reshape(6, 6)
                assert np.linalg.eigvalsh(whole).min() > 0.9e-9  # What is added is 1e-9, in double precision.
                np.testing.assert_array_equal(np.diag(whole)[2:5], 1e-6)


@pytest.mark.parametrize(("lidar", "topic", "rate"), [("scan", "scan", 12.5), ("rear", "rear/scan", 5.0)])
def test_scans_are_those_of_the_recording(bag: Bag, run: Recording, lidar: str, topic: str, rate: float):
    given = [(seen.time, seen.scans[lidar]) for seen in run.observations("7.tip-top") if lidar in seen.scans]
    told = bag.messages[f"/{SCOUT}/{topic}"]
    assert len(given) == len(told) > 3
    for (time, scan), (logged, message) in zip(given, told, strict=True):
        assert (logged, nanoseconds(message.header)) == (round(time * 1e9), round(scan.stamp * 1e9))
        assert message.header.frame_id == f"{SCOUT}/{lidar}"
        singles = (scan.angle_min, scan.angle_increment, 0.0, 1 / rate, scan.range_min, scan.range_max)
        names = ("angle_min", "angle_increment", "time_increment", "scan_time", "range_min", "range_max")
        assert [getattr(message, name) for name in names] == np.float32(singles).tolist()
        assert message.angle_max == np.float32(scan.angles()[-1])
        np.testing.assert_array_equal(message.ranges, np.float32(scan.ranges))
        np.testing.assert_array_equal(
            message.intensities, np.float32([] if scan.intensities is None else scan.intensities)
        )
    assert np.isinf(told[0][1].ranges).any() or lidar == "rear"


def test_inertial_readings_are_those_of_the_recording(bag: Bag, run: Recording):
    given = [each for seen in run.observations("7.tip-top") for each in seen.imu]
    told = [message for _, message in bag.messages[f"/{SCOUT}/imu"]]
    assert len(given) == len(told) > 90
    for reading, message in zip(given, told, strict=True):
        assert nanoseconds(message.header) == round(reading.stamp * 1e9)
        felt, turn = message.linear_acceleration, message.angular_velocity
        assert [felt.x, felt.y, felt.z] == reading.acceleration.tolist()
        assert [turn.x, turn.y, turn.z] == reading.turn.tolist()
        assert message.orientation_covariance[0] == -1.0
        assert message.linear_acceleration_covariance.tolist() == (np.eye(3) * 0.02**2).ravel().tolist()
        assert message.angular_velocity_covariance.tolist() == (np.eye(3) * 0.002**2).ravel().tolist()


def test_depth_is_what_the_recording_holds_in_whole_millimetres(bag: Bag, run: Recording):
    given = list(run.depths("7.tip-top", "eye"))
    told = bag.messages[f"/{SCOUT}/eye/depth/image_raw"]
    assert len(given) == len(told) == len(bag.messages[f"/{SCOUT}/eye/camera_info"]) > 3
    with RecordedRobots(run, redraw=True) as again:
        ticks = [tick for tick in again.ticks("7.tip-top") if "eye" in tick.stamps]
        exact = again.frame("7.tip-top", "eye", ticks[0].stamps["eye"]).depth
    for (stamp, pixels), (time, message) in zip(given, told, strict=True):
        assert time == round((stamp + 0.04) * 1e9)
        assert nanoseconds(message.header) == round(stamp * 1e9)
        assert (message.encoding, message.height, message.width, message.step) == ("16UC1", 48, 64, 128)
        assert message.header.frame_id == f"{SCOUT}/eye_optical_frame"
        np.testing.assert_array_equal(message.data.view("<u2").reshape(48, 64), pixels)
    expected = np.where(np.isfinite(exact), np.rint(1000.0 * np.where(np.isfinite(exact), exact, 0.0)), 0.0)
    np.testing.assert_allclose(given[0][1], expected, atol=1)
    assert expected.max() > 500.0


@pytest.mark.parametrize(("camera", "model", "late"), [("eye", "plumb_bob", 0.04), ("wide", "equidistant", 0.0)])
def test_pictures_are_the_recorded_files_with_the_calibration(
    bag: Bag, run: Recording, camera: str, model: str, late: float
):
    told = bag.messages[f"/{SCOUT}/{camera}/image_raw/compressed"]
    given = list(run.pictures("7.tip-top", camera))
    assert len(given) == len(told) > 3
    infos = bag.messages[f"/{SCOUT}/{camera}/camera_info"]
    for (stamp, data, form), (time, message), (_, info) in zip(given, told, infos, strict=True):
        assert nanoseconds(message.header) == nanoseconds(info.header) == round(stamp * 1e9)
        assert time == round((stamp + late) * 1e9)
        assert (message.format, message.data.tobytes()) == (form, data)
        assert message.header.frame_id == info.header.frame_id == f"{SCOUT}/{camera}_optical_frame"
    width = info.width
    half = (60 if camera == "eye" else 150) / 2
    expected = width / 2 / math.tan(math.radians(half)) if camera == "eye" else info.k[0]
    K = [[expected, 0, (width - 1) / 2], [0, expected, (info.height - 1) / 2], [0, 0, 1]]
    np.testing.assert_allclose(info.k.reshape(3, 3), K, rtol=1e-12)
    np.testing.assert_array_equal(info.p.reshape(3, 4)[:, :3], info.k.reshape(3, 3))
    np.testing.assert_array_equal(info.r.reshape(3, 3), np.eye(3))
    assert (info.distortion_model, len(info.d)) == (model, 5 if model == "plumb_bob" else 4)


def test_the_ring_of_rays_is_sixteen_ranges_a_tick(bag: Bag, run: Recording):
    told = [message for _, message in bag.messages[f"/{SCOUT}/proximity"]]
    given = np.concatenate([seen.proximity for seen in run.observations("7.tip-top")])
    np.testing.assert_array_equal(np.array([message.range for message in told]), np.float32(given))
    assert [message.header.frame_id for message in told[:16]] == [f"{SCOUT}/proximity_{ray}" for ray in range(16)]
    assert {(message.radiation_type, message.min_range, message.max_range) for message in told} == {(1, 0.0, 2.0)}


def test_frames_lead_from_the_map_to_each_sensor(bag: Bag, run: Recording):
    ((_, fixed),) = bag.messages["/tf_static"]
    mounts = {each.child_frame_id: each for each in fixed.transforms}
    assert {each.header.frame_id for each in fixed.transforms} == {f"{SCOUT}/base_link", "bare/base_link"}
    scan = mounts[f"{SCOUT}/scan"].transform
    assert [scan.translation.x, scan.translation.y, scan.translation.z] == pytest.approx([0.15, 0.02, 0.3])
    assert rotation_of(scan.rotation) == pytest.approx([0, 0, math.sin(math.radians(15)), math.cos(math.radians(15))])
    # x right, y down, z ahead, tilted 10 degrees down.
    q = mounts[f"{SCOUT}/eye_optical_frame"].transform.rotation
    ahead = Pose3(0, 0, 0, q.x, q.y, q.z, q.w).matrix()[:3, 2]
    assert ahead == pytest.approx([math.cos(math.radians(10)), 0, -math.sin(math.radians(10))], abs=1e-12)
    ray = mounts[f"{SCOUT}/proximity_4"].transform
    assert ray.translation.y > 0.1
    assert ray.translation.x == pytest.approx(0, abs=1e-12)
    track = run.robots["7.tip-top"]
    for row, (_, message) in enumerate(bag.messages["/tf"]):
        chain = {(each.header.frame_id, each.child_frame_id): each.transform for each in message.transforms}
        assert set(chain) == {
            ("map", f"{SCOUT}/odom"),  # the other robot has no estimator: other programs may publish that frame
            *((f"{name}/odom", f"{name}/base_link") for name in (SCOUT, "bare")),
        }
        map_from_base = matrix(chain["map", f"{SCOUT}/odom"]) @ matrix(chain[f"{SCOUT}/odom", f"{SCOUT}/base_link"])
        expected = Pose3.from_planar(Pose(*track.estimate[row])).matrix()
        np.testing.assert_allclose(map_from_base, expected, atol=1e-12)


def matrix(transform) -> np.ndarray:
    place = transform.translation
    return Pose3(place.x, place.y, place.z, *rotation_of(transform.rotation)).matrix()


def test_the_map_has_walls_where_the_world_has_them(bag: Bag):
    ((_, grid),) = bag.messages["/map"]
    cells = grid.data.reshape(grid.info.height, grid.info.width)
    origin = grid.info.origin.position

    def cell(x: float, y: float) -> int:
        return cells[int((y - origin.y) / grid.info.resolution), int((x - origin.x) / grid.info.resolution)]

    assert (cell(0.01, 2.0), cell(3.5, 2.2), cell(1, 1), cell(-0.5, 2)) == (100, 100, 0, -1)


@pytest.mark.slow
def test_pictures_drawn_again_are_raw_and_hold_depth(run: Recording, tmp_path: Path):
    bag = Bag(export_rosbag2(run, tmp_path / "raw", storage="sqlite3", redraw=True))
    raw, depths = bag.messages[f"/{SCOUT}/eye/image_raw"], bag.messages[f"/{SCOUT}/eye/depth/image_raw"]
    recorded = list(run.images("7.tip-top", "eye"))
    # In the lowest row, seen from 0.5 m above by a camera that looks 10 degrees down.
    tilt, below = math.radians(10), 23.5 / (32 / math.tan(math.radians(30)))
    floor = 0.5 / (math.sin(tilt) + below * math.cos(tilt))
    assert len(raw) == len(depths) == len(recorded)
    for (_, message), (_, depth), (stamp, picture) in zip(raw, depths, recorded, strict=True):
        assert nanoseconds(message.header) == nanoseconds(depth.header) == round(stamp * 1e9)
        assert (message.encoding, message.height, message.width, message.step) == ("rgb8", 48, 64, 192)
        # The recorded one went through JPEG.
        assert np.abs(message.data.reshape(48, 64, 3).astype(int) - picture).mean() < 3.0
        assert (depth.encoding, depth.step, depth.is_bigendian) == ("32FC1", 256, 0)
        metres = depth.data.view(np.float32).reshape(48, 64)
        assert stamp > 0 or metres[-1, 32] == pytest.approx(floor, rel=1e-3)  # later the robot nods
    assert (tmp_path / "raw" / "raw.db3").exists()


@pytest.mark.slow
def test_the_joints_of_mechanisms_are_those_of_the_recording(tmp_path: Path):
    with mjsim.Simulation(mjsim.load_world("fourbar")) as sim:
        run = mjsim.run(sim, seconds=0.4, record=tmp_path / "run.mcap")
    bag = Bag(export_rosbag2(run, tmp_path / "bag"))
    assert len(run.joints) == 2
    for name, track in run.joints.items():
        messages = bag.messages[f"/{name}/joint_states"]
        assert [time for time, _ in messages] == [round(time * 1e9) for time in run.time.tolist()]
        for row, (time, message) in enumerate(messages):
            assert nanoseconds(message.header) == time
            assert message.name == list(track.names)
            np.testing.assert_array_equal(message.position, track.positions[row])
            np.testing.assert_array_equal(message.velocity, track.velocities[row])
            np.testing.assert_array_equal(message.effort, track.torques[row])
    assert np.ptp(run.joints["fourbar"].positions, axis=0).min() > 0.0


@pytest.mark.slow
def test_a_folder_that_exists_is_replaced_only_when_asked_and_when_it_is_a_bag(run: Recording, tmp_path: Path):
    export_rosbag2(run, tmp_path / "bag")
    with pytest.raises(UsageError, match=r"'.*bag' exists; name another folder, or add --overwrite"):
        export_rosbag2(run, tmp_path / "bag")
    export_rosbag2(run, tmp_path / "bag", storage="sqlite3", overwrite=True)
    assert {each.name for each in (tmp_path / "bag").iterdir()} == {"bag.db3", "metadata.yaml"}
    (tmp_path / "bag" / "notes.txt").write_text("mine")
    export_rosbag2(run, tmp_path / "bag", overwrite=True)
    assert {each.name for each in (tmp_path / "bag").iterdir()} == {"bag.mcap", "metadata.yaml", "notes.txt"}
    assert [each.name for each in tmp_path.iterdir()] == ["bag"]


@pytest.mark.slow
def test_a_bag_never_replaces_recordings_that_lie_in_its_folder(run: Recording, tmp_path: Path):
    folder = tmp_path / "runs"
    folder.mkdir()
    for name in ("run.mcap", "other.mcap", "notes.db3"):
        (folder / name).write_bytes(run.path.read_bytes())
    again = read_recording(folder / "run.mcap")
    for _ in range(2):
        export_rosbag2(again, folder, overwrite=True)
        found = {each.name for each in folder.iterdir()}
        assert found == {"run.mcap", "other.mcap", "notes.db3", "runs.mcap", "metadata.yaml"}
        assert (folder / "run.mcap").read_bytes() == run.path.read_bytes()
    (folder / "run.mcap").rename(folder / "runs.mcap")
    with pytest.raises(UsageError, match="would replace the recording itself; name another folder"):
        export_rosbag2(read_recording(folder / "runs.mcap"), folder, overwrite=True)
    assert (folder / "runs.mcap").read_bytes() == run.path.read_bytes()


def test_a_file_in_the_place_of_the_folder_is_kept(run: Recording, tmp_path: Path):
    (tmp_path / "bag").write_text("mine")
    with pytest.raises(UsageError, match="is not a folder"):
        export_rosbag2(run, tmp_path / "bag", overwrite=True)
    assert (tmp_path / "bag").read_text() == "mine"


def test_an_unknown_storage_is_refused(run: Recording, tmp_path: Path):
    with pytest.raises(UsageError, match="storage is 'zip'; it must be mcap or sqlite3"):
        export_rosbag2(run, tmp_path / "bag", storage="zip")


@pytest.mark.slow
@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_a_disk_that_is_full_is_one_line_and_leaves_nothing(storage: str, run: Recording, tmp_path: Path):
    def export() -> str:
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))
        with pytest.raises(UsageError, match=r"^cannot write '[^']*': .+$") as caught:
            export_rosbag2(run, tmp_path / "bag", storage=storage)  # type: ignore[arg-type]
        return str(caught.value)

    assert len(as_stranger(export, other=False).splitlines()) == 1
    assert not list(tmp_path.iterdir())
