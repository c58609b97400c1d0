"""Times of a log's sensors, none of which are those of ticks: in observations, the recording and every export."""

import csv
from pathlib import Path

import cv2
import numpy as np
import pytest
from evo.tools import file_interface
from rosbags.highlevel import AnyReader

import mjsim
from mjsim.datasets import export_carmen, export_euroc, export_rosbag2, export_tum_rgbd
from mjsim.geometry import Pose3
from mjsim.record import Recording, export_csv, export_npz
from tests.bags import START, new_bag
from tests.real_logs import imported
from tests.record.test_panels import messages

pytestmark = pytest.mark.slow  # Imports and exports a bag.
COUNT, SPEED = 20, 0.5
LATE = {"laser": 0.003, "rear": 0.031, "eye": 0.047, "depth": 0.058, "top": 0.072}
"""When a sensor measures after the beginning of each tenth of a second [s]."""
EYE = np.array([[0, 0, 1, 0.1], [-1, 0, 0, 0], [0, -1, 0, 0.5], [0, 0, 0, 1.0]])
"""robot_from_camera."""
CLOSE = 2e-6
"""Doubles of times since 1970 have 2.4e-7 s [s]; at SPEED that is less than a micrometre."""


def taken(sensor: str) -> np.ndarray:
    """Return the times of a sensor by the clock of the log [s]."""
    return START + 0.1 * np.arange(COUNT) + LATE[sensor]


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """Return the log of a robot that drives straight ahead at a constant speed."""
    folder = tmp_path_factory.mktemp("log")
    with new_bag(folder / "bag") as bag:
        bag.transforms("/tf_static", START, [("base_link", "eye", EYE)])
        for at in (START + 0.01 * np.arange(10 * COUNT + 5)).tolist():
            pose = Pose3(SPEED * (at - START), 0, 0, 0, 0, 0, 1)
            bag.put("/odom", at, bag.odometry(bag.header(at, "odom"), "base_link", pose))
            bag.put("/truth", at, bag.odometry(bag.header(at, "map"), "base_link", pose))
        for k in range(COUNT):
            stamps = {name: float(taken(name)[k]) for name in LATE}
            for name in ("laser", "rear"):
                told = bag.scan(bag.header(stamps[name], name), np.full(9, 1.0 + k), -0.4, 0.1, (0.1, 50.0))
                bag.put(f"/{name}", stamps[name], told)
            picture = cv2.imencode(".png", np.full((32, 32, 3), k, dtype=np.uint8))[1].tobytes()
            told = bag.compressed(bag.header(stamps["eye"], "eye"), "png", picture)
            bag.put("/eye/image_raw/compressed", stamps["eye"], told)
            depth = np.full((32, 32), 1000 + k, dtype=np.uint16)
            bag.put("/eye/depth", stamps["depth"], bag.image(bag.header(stamps["depth"], "eye"), "16UC1", depth))
            points = np.ones((1, 4), dtype=[("x", "<f4"), ("y", "<f4"), ("z", "<f4")])
            bag.put("/top/points", stamps["top"], bag.cloud(bag.header(stamps["top"], "top"), points))
    return imported(folder / "bag", record=folder / "run.mcap")


def since(run: Recording, stamps: object) -> np.ndarray:
    """Return times of the recording by the clock of the log [s]."""
    return np.asarray(stamps, dtype=float) + float(run.metadata["log start"])


class Stamps:
    """An estimator that keeps the times of all readings."""

    def start(self, robot, catalogue, rng):
        self.seen = {name: [] for name in LATE}

    def update(self, seen):
        for readings in (seen.scans, seen.clouds, seen.cameras):
            for name, each in readings.items():
                self.seen[name].append(each.stamp)
        self.seen["depth"] += [frame.depth_stamp for frame in seen.cameras.values()]
        return mjsim.Estimate(mjsim.Pose(0.0, 0.0, 0.0), np.eye(3))


def test_observations_have_the_times_of_the_log(run: Recording):
    estimator = Stamps()
    mjsim.replay(run, robot="robot", estimator=estimator)
    for name, stamps in estimator.seen.items():
        np.testing.assert_allclose(since(run, stamps), taken(name), atol=CLOSE, err_msg=name)


def test_the_recording_has_the_times_of_the_log(run: Recording):
    np.testing.assert_allclose(since(run, [at for at, _ in run.images("robot", "eye")]), taken("eye"), atol=CLOSE)
    np.testing.assert_allclose(since(run, [at for at, _ in run.depths("robot", "eye")]), taken("depth"), atol=CLOSE)
    track = run.robots["robot"]
    stamps = taken("eye") - float(run.metadata["log start"])
    expected = SPEED * (taken("eye") - START)
    np.testing.assert_allclose(track.truth_at(stamps)[:, 0], expected, atol=CLOSE)
    np.testing.assert_allclose(np.diff(track.odometry_at(stamps)[:, 0]), np.diff(expected), atol=CLOSE)
    assert np.isnan(track.truth_at([-1.0, 1e4])).all()


def test_foxglove_gets_readings_and_frames_at_the_times_of_the_log(run: Recording):
    told = messages(run.path)
    topics = {"scan": "laser", "eye/image": "eye", "eye/depth": "depth", "top/points": "top"}
    for topic, name in topics.items():
        stamps = [fox_seconds(message) for _, _, message in told[f"/robot/{topic}"] if frame_of(message) == name]
        np.testing.assert_allclose(since(run, stamps), taken(name), atol=CLOSE, err_msg=topic)
    frames = [each for _, _, message in told["/tf"] for each in message.transforms]
    places = [(fox_seconds(each), each.translation.x) for each in frames if each.child_frame_id == "robot/base"]
    times, xs = np.array(places).T
    np.testing.assert_allclose(xs, SPEED * (since(run, times) - START), atol=CLOSE)
    mounts = [fox_seconds(each) for each in frames if each.child_frame_id == "robot/eye"]
    np.testing.assert_array_equal(mounts, times)


def fox_seconds(message) -> float:
    return message.timestamp.seconds + 1e-9 * message.timestamp.nanos


def frame_of(message) -> str:
    """Return the sensor of a message; depth is of the camera's frame."""
    name = message.frame_id.partition("/")[2]
    return "depth" if hasattr(message, "step") else name


def test_bags_have_the_times_of_the_log(run: Recording, tmp_path: Path):
    topics = {
        "/robot/scan": "laser",
        "/robot/rear/scan": "rear",
        "/robot/eye/image_raw/compressed": "eye",
        "/robot/eye/camera_info": "eye",
        "/robot/eye/depth/image_raw": "depth",
        "/robot/points": "top",
    }
    stamps, base = {name: [] for name in topics}, []
    with AnyReader([export_rosbag2(run, tmp_path / "bag")]) as reader:
        for connection, _, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            if connection.topic in topics:
                stamps[connection.topic].append(seconds(message.header))
            if connection.topic in ("/robot/truth", "/robot/odom"):
                pose = message.pose.pose if connection.topic.endswith("odom") else message.pose
                base.append((connection.topic, seconds(message.header), pose.position.x))
            if connection.topic == "/tf":
                base += [("/tf", seconds(each.header), each.transform.translation.x) for each in message.transforms]
    for topic, name in topics.items():
        np.testing.assert_allclose(since(run, stamps[topic]), taken(name), atol=CLOSE, err_msg=topic)
    for topic in ("/robot/truth", "/robot/odom", "/tf"):
        times, xs = np.array([row[1:] for row in base if row[0] == topic]).T
        start = float(run.metadata["log start"]) - START if topic == "/robot/truth" else 0.0
        np.testing.assert_allclose(xs, SPEED * (times + start), atol=CLOSE, err_msg=topic)


def seconds(header) -> float:
    return header.stamp.sec + 1e-9 * header.stamp.nanosec


def listed(path: Path) -> list[list[str]]:
    return [line.split() for line in path.read_text().splitlines() if not line.startswith("#")]


def test_tum_rgbd_has_the_times_of_the_log_and_a_pose_beside_each_picture(run: Recording, tmp_path: Path):
    (folder,) = export_tum_rgbd(run, tmp_path / "tum")
    for file, name in (("rgb.txt", "eye"), ("depth.txt", "depth")):
        rows = listed(folder / file)
        np.testing.assert_allclose(since(run, [row[0] for row in rows]), taken(name), atol=CLOSE)
    read = file_interface.read_tum_trajectory_file(folder / "groundtruth.txt")
    times = since(run, read.timestamps)
    np.testing.assert_allclose(read.positions_xyz[:, 0], SPEED * (times - START) + EYE[0, 3], atol=CLOSE)
    assert np.abs(times[:, None] - taken("eye")).min(axis=0).max() < CLOSE


def test_euroc_has_the_times_of_the_log_and_a_pose_beside_each_picture(run: Recording, tmp_path: Path):
    (folder,) = export_euroc(run, tmp_path / "euroc")
    with (folder / "mav0" / "cam0" / "data.csv").open(newline="") as stream:
        stamps = [1e-9 * int(row[0]) for row in csv.reader(stream) if not row[0].startswith("#")]
    np.testing.assert_allclose(since(run, stamps), taken("eye"), atol=CLOSE)
    truth = folder / "mav0" / "state_groundtruth_estimate0" / "data.csv"
    read = file_interface.read_euroc_csv_trajectory(truth)
    times = since(run, read.timestamps)
    np.testing.assert_allclose(read.positions_xyz[:, 0], SPEED * (times - START), atol=CLOSE)
    assert np.abs(times[:, None] - taken("eye")).min(axis=0).max() < CLOSE
    speeds = np.loadtxt(truth, delimiter=",")[:, 8]
    np.testing.assert_allclose(speeds, SPEED, rtol=1e-3)


def test_carmen_has_the_times_of_the_log_and_the_pose_of_each_scan(run: Recording, tmp_path: Path):
    (file,) = export_carmen(run, tmp_path / "run.log")
    lines = [line.split() for line in file.read_text().splitlines() if not line.startswith("#")]
    for word, name in (("ROBOTLASER1", "laser"), ("ROBOTLASER2", "rear")):
        rows = [line for line in lines if line[0] == word]
        times = np.array([line[-1] for line in rows], dtype=float)
        np.testing.assert_allclose(since(run, times), taken(name), atol=CLOSE)
        # Dead reckoning starts with the recording; before its first tick it stands still.
        xs = np.array([line[-11] for line in rows], dtype=float)
        np.testing.assert_allclose(xs, SPEED * times, atol=CLOSE)


def test_tables_have_the_times_of_the_log(run: Recording, tmp_path: Path):
    export_csv(run, tmp_path / "csv")
    rows = np.genfromtxt(tmp_path / "csv" / "robot_track.csv", delimiter=",", names=True)
    np.testing.assert_allclose(rows["truth_x"], SPEED * (since(run, rows["moment"]) - START), atol=CLOSE)
    assert np.abs(rows["moment"] - rows["time"]).max() > 0.01
    for name in ("scan_laser", "scan_rear", "cloud_top"):
        stamps = np.genfromtxt(tmp_path / "csv" / f"robot_{name}.csv", delimiter=",", names=True)["stamp"]
        np.testing.assert_allclose(np.unique(since(run, stamps)), taken(name.partition("_")[2]), atol=CLOSE)
    export_npz(run, tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz") as arrays:
        np.testing.assert_array_equal(arrays["robot/moment"], rows["moment"])
