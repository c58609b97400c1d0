"""Programs of others find where the robot was: from clouds of a 3-D lidar, and from pictures of a data set."""

import json
import sys
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import mjsim
from mjsim.datasets import export_tum_rgbd
from mjsim.geometry import Array
from tests.children import completed

WORLD = """mjsim: 1
name: slam-clients
walls: [{points: [[0, 0], [8, 0], [8, 6], [0, 6]], closed: true, height: 4}]
obstacles:
  - {box: [0.8, 0.5, 1.1], at: [6, 4.8], heading_deg: 30}
  - {cylinder: [0.25, 2.0], at: [5, 1.2]}
  - {box: [0.6, 1.2, 0.7], at: [1.5, 1.2], heading_deg: 10}
beacons:
  - {name: tag, marker: {dictionary: apriltag_36h11, id: 7}, at: [4.2, 5.93], heading_deg: -90, width: 0.3, center: 0.5}
  - {name: lion, image: posters/lion.jpg, at: [3.3, 5.93], heading_deg: -90, width: 0.6}
  - {name: owl, image: posters/owl.jpg, at: [4.1, 5.3], heading_deg: -90, width: 0.6}
  - {name: whale, image: posters/whale.jpg, at: [4.9, 5.93], heading_deg: -90, width: 0.8}
  - {name: rocket, image: posters/rocket.jpg, at: [5.6, 5.6], heading_deg: -110, width: 0.6}
robots:
  - name: scout
    preset: pioneer3dx
    at: [3.2, 3.2]
    heading_deg: -8
    sensors: [SENSOR]
run:
  rate_hz: 25
  drivers: {scout: {navigator: {use: "mjsim.algorithms.constant:ConstantCommand", forward: 0.4, turn: TURN}}}
"""
CORRIDOR = """mjsim: 1
name: corridor
walls:
  - points: [[0, 0], [18, 0], [18, 2.4], [0, 2.4]]
    closed: true
    height: 2.5
    openings:
      - {at: 2, width: 0.95, repeat: {times: 4, offset: 3.6}}
      - {segment: 2, at: 3, width: 0.95, repeat: {times: 4, offset: 3.6}}
  - {points: [[-1, -4], [19, -4], [19, 6.4], [-1, 6.4]], closed: true, height: 2.5}
  - {points: [[4, -4], [4, 0]], height: 2.5, repeat: {times: 4, offset: [3.6, 0]}}
  - {points: [[5, 2.4], [5, 6.4]], height: 2.5, repeat: {times: 4, offset: [3.6, 0]}}
ceiling: {color: "#eeeeee"}
robots:
  - name: scout
    preset: pioneer3dx
    at: [1.2, 1.2]
    sensors: [{lidar3d: top, preset: ouster-os0-128, columns: 256, at: [0, 0, 1.2]}]
run:
  rate_hz: 25
  drivers: {scout: {navigator: {use: "mjsim.algorithms.constant:ConstantCommand", forward: 0.6}}}
"""
LIDAR = "{lidar3d: top, preset: velodyne-vlp16, at: [0, 0, 1.2], noise: {range: 0.01}}"
CAMERA = "{camera: side, at: [0, 0.1, 1.0], yaw_deg: 90, width: 400, height: 300, rate_hz: 2.5, depth: true}"
MAP = """
import json, sys
from pathlib import Path
import pycolmap
folder, place, names, camera = *map(Path, sys.argv[1:3]), *map(json.loads, sys.argv[3:])
pycolmap.logging.minloglevel = pycolmap.logging.ERROR
reader, features = pycolmap.ImageReaderOptions(), pycolmap.FeatureExtractionOptions()
reader.camera_model, reader.camera_params = "PINHOLE", ",".join(map(str, camera))
features.num_threads = 1
single, processor = pycolmap.CameraMode.SINGLE, pycolmap.Device.cpu
pycolmap.extract_features(folder / "all.db", place, names, single, reader, features, processor)
pycolmap.match_exhaustive(folder / "all.db", device=processor)
options = pycolmap.IncrementalPipelineOptions()
options.ba_refine_focal_length = options.ba_refine_extra_params = False
(found,) = pycolmap.incremental_mapping(folder / "all.db", place, folder, options=options).values()
poses = {each.name: each.cam_from_world().inverse().matrix().tolist() for each in found.images.values()}
print(json.dumps(poses))
"""
LOOK = """
import json, os, sys
from pathlib import Path
import cv2, numpy as np, pupil_apriltags
place, names, camera = Path(sys.argv[1]), *map(json.loads, sys.argv[2:])
detector = pupil_apriltags.Detector("tag36h11")
found = {}
for name in names:
    tags = detector.detect(cv2.imread(str(place / name), cv2.IMREAD_GRAYSCALE), True, camera, 0.3)
    if tags:
        found[name] = [(tag.tag_id, float(np.linalg.norm(tag.pose_t))) for tag in tags]
print(json.dumps(found), flush=True)
os._exit(0)  # The detector of 1.0.4 corrupts the heap when it is deleted.
"""
ALIGN = """
import ctypes, importlib.util, json, sys
from pathlib import Path
import numpy as np
found = importlib.util.find_spec("libusb_package")
for usb in Path(found.origin).parent.glob("libusb-1.0*") if found else ():
    ctypes.CDLL(str(usb), mode=ctypes.RTLD_GLOBAL)  # Open3D's wheel wants that of the system, which may lack it.
try:
    import open3d
except (ImportError, OSError) as error:
    sys.exit(print(json.dumps(f"{error}")))
clouds = [open3d.geometry.PointCloud(open3d.utility.Vector3dVector(each)) for each in np.load(sys.argv[1]).values()]
clouds = [cloud.voxel_down_sample(0.1) for cloud in clouds]
found = open3d.pipelines.registration.registration_generalized_icp(*clouds, 0.5)
print(json.dumps(found.transformation.tolist()))
"""
pytestmark = pytest.mark.slow  # Each starts a large program.


def world(sensor: str, *, turn: float) -> mjsim.World:
    return mjsim.parse_world(WORLD.replace("SENSOR", sensor).replace("TURN", f"{turn}"))


def clouds_of(world: mjsim.World, seconds: float) -> list[tuple[mjsim.PointCloud, Array]]:
    """Clouds of a drive, and where the sensor was when each was complete, (4, 4) [m]."""
    found = []
    with mjsim.Simulation(world, seed=1) as sim:
        mounted = sim.robots["scout"].sensors["top"].robot_from_sensor

        def keep(tick: mjsim.Tick) -> None:
            found.extend((cloud, sim.pose("scout") @ mounted) for cloud in tick.seen["scout"].clouds.values())

        mjsim.run(sim, seconds=seconds, watch=keep)
    return found


@pytest.fixture(scope="module")
def clouds() -> list[tuple[mjsim.PointCloud, Array]]:
    """Of a drive on a circle."""
    return clouds_of(world(LIDAR, turn=1.5), 1.6)


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("slam-clients")
    with mjsim.Simulation(world(CAMERA, turn=0.1), seed=1) as sim:
        run = mjsim.run(sim, seconds=3.2, record=folder / "run.mcap")
    (place,) = export_tum_rgbd(run, folder / "tum", redraw=True)
    return place


def alone(program: str, *arguments: object) -> Any:
    """What a program prints that runs in a process of its own: libraries of others do not always agree."""
    command = [sys.executable, "-c", program, *map(str, arguments)]
    return json.loads(completed(command).stdout)


def calibration(place: Path) -> list[float]:
    numbers = dict(line.split(": ") for line in (place / "camera.yaml").read_text().splitlines()[1:])
    return [float(numbers[f"Camera.{key}"]) for key in ("fx", "fy", "cx", "cy")]


def stamps(place: Path) -> dict[str, float]:
    """Picture -> its time [s]."""
    lines = (line.split() for line in (place / "rgb.txt").read_text().splitlines()[2:])
    return {name: float(stamp) for stamp, name in lines}


def true_poses(place: Path, times: list[float]) -> tuple[Array, Rotation]:
    """Where the camera was at these times, (n, 3) [m], and how it was turned."""
    truth = np.loadtxt(place / "groundtruth.txt")
    rows = truth[[np.abs(truth[:, 0] - time).argmin() for time in times]]
    return rows[:, 1:4], Rotation.from_quat(rows[:, 4:])


def kiss_icp_error(clouds: list[tuple[mjsim.PointCloud, Array]]) -> tuple[float, float]:
    """How far off KISS-ICP is in the end [m], and turned by how much [rad]."""
    config = pytest.importorskip("kiss_icp.config", reason="KISS-ICP is not installed").KISSConfig()
    from kiss_icp.kiss_icp import KissICP

    config.data.max_range, config.mapping.voxel_size, config.registration.max_num_threads = 20.0, 0.2, 1
    kiss = KissICP(config)
    for cloud, _ in clouds:
        kiss.register_frame(cloud.points.astype(float), cloud.times.astype(float))
    off = np.linalg.inv(clouds[-1][1]) @ clouds[0][1] @ kiss.last_pose
    return float(np.linalg.norm(off[:3, 3])), float(Rotation.from_matrix(off[:3, :3]).magnitude())


def test_kiss_icp_follows_the_robot_and_straightens_clouds_by_the_times_of_their_points(clouds):
    error, turned = kiss_icp_error(clouds)
    assert error < 0.02  # on 0.6 m and 135 degrees
    assert turned < 0.01
    _, turned = kiss_icp_error(
        [(replace(cloud, times=cloud.times.min() - cloud.times), pose) for cloud, pose in clouds]
    )
    assert turned > 0.05  # Times of the wrong sign bend the walls.


def test_small_gicp_finds_how_far_the_robot_drove_between_two_clouds(clouds):
    matcher = pytest.importorskip("small_gicp", reason="small_gicp is not installed")
    (first, world_from_first), (last, world_from_last) = clouds[9], clouds[11]
    found = matcher.align(
        *(each.points.astype(float) for each in (first, last)), registration_type="GICP", downsampling_resolution=0.1
    ).T_target_source
    truly = np.linalg.inv(world_from_first) @ world_from_last
    assert np.linalg.norm(truly[:3, 3]) > 0.05
    np.testing.assert_allclose(found[:3, 3], truly[:3, 3], atol=0.01)  # as is the noise of each point
    assert Rotation.from_matrix(found[:3, :3].T @ truly[:3, :3]).magnitude() < 0.01


@pytest.mark.skipif(find_spec("open3d") is None, reason="Open3D has wheels for Linux and Python up to 3.12")
def test_open3d_finds_how_far_the_robot_drove_between_two_clouds(clouds, tmp_path: Path):
    (first, world_from_first), (last, world_from_last) = clouds[9], clouds[11]
    np.savez(tmp_path / "clouds.npz", last=last.points.astype(float), first=first.points.astype(float))
    answer = alone(ALIGN, tmp_path / "clouds.npz")
    if isinstance(answer, str):
        pytest.skip(f"Open3D needs a library of the system: {answer}")
    found, truly = np.array(answer), np.linalg.inv(world_from_first) @ world_from_last
    np.testing.assert_allclose(found[:2, 3], truly[:2, 3], atol=0.01)  # as is the noise of each point
    assert found[2, 3] == pytest.approx(truly[2, 3], abs=0.02)  # Rings 2 degrees apart bind the height less.
    assert Rotation.from_matrix(found[:3, :3].T @ truly[:3, :3]).magnitude() < 0.01


def test_small_gicp_follows_a_corridor_to_millimetres_and_half_a_turn_behind_in_clouds_that_nobody_straightens():
    matcher = pytest.importorskip("small_gicp", reason="small_gicp is not installed")
    found = clouds_of(mjsim.parse_world(CORRIDOR), 2.6)
    truth = np.array([pose for _, pose in found])
    behind = {}
    for straighten in (True, False):
        near, pose, moved, path = matcher.GaussianVoxelMap(0.5), np.eye(4), np.zeros(3), []
        for cloud, _ in found:
            # It drives straight on: to straighten is to shift.
            shift = np.outer(cloud.times / found[0][0].times.min(), moved) if straighten else 0.0
            thin, _ = matcher.preprocess_points(cloud.points - shift, downsampling_resolution=0.1, num_neighbors=10)
            ahead = pose.copy()
            ahead[:3, 3] += moved
            if path:
                pose = matcher.align(near, thin, ahead, 1.0).T_target_source
                moved = pose[:3, 3] - path[-1][:3, 3]
            near.insert(thin, pose)
            path.append(pose)
        behind[straighten] = truth[:, 0, 3] - (truth[0] @ path)[:, 0, 3]
    way, speed, period = truth[-1, 0, 3] - truth[0, 0, 3], 0.6, 0.08
    assert way > 1.3
    assert np.abs(behind[True][-15:]).max() < 0.005  # a voxel's mean of a hundred points with 15 mm of noise
    assert behind[False][-15:].mean() == pytest.approx(speed * period / 2, abs=0.004)


@pytest.mark.skipif(find_spec("pupil_apriltags") is None, reason="pupil-apriltags is not installed")
def test_pupil_apriltags_finds_how_far_a_tag_is(pictures: Path):
    times = stamps(pictures)
    told = alone(LOOK, pictures, json.dumps(list(times)), json.dumps(calibration(pictures)))
    assert len(told) > 3
    for name, found in told.items():
        truly = np.linalg.norm(true_poses(pictures, [times[name]])[0] - [4.2, 5.93, 0.5])
        assert found == [[7, pytest.approx(truly, rel=0.01)]]


@pytest.mark.skipif(find_spec("pycolmap") is None, reason="pycolmap is not installed")
def test_colmap_finds_where_pictures_were_taken(pictures: Path, tmp_path: Path):
    umeyama_alignment = pytest.importorskip("evo.core.geometry", reason="evo is not installed").umeyama_alignment
    fx, fy, cx, cy = calibration(pictures)
    times, camera = stamps(pictures), [fx, fy, cx + 0.5, cy + 0.5]  # COLMAP counts pixels from their corner.
    told = alone(MAP, tmp_path, pictures, json.dumps(list(times)), json.dumps(camera))
    assert len(told) > 5
    poses = np.array(list(told.values()))
    places, turned = true_poses(pictures, [times[name] for name in told])
    turn, moved, scale = umeyama_alignment(poses[:, :, 3].T, places.T, with_scale=True)
    np.testing.assert_allclose(scale * poses[:, :, 3] @ turn.T + moved, places, atol=0.01)
    assert np.ptp(places[:, 0]) > 1.0
    found = Rotation.from_matrix(poses[:, :, :3])
    first, last = np.argmin(places[:, 0]), np.argmax(places[:, 0])
    off = (turned[first].inv() * turned[last]).inv() * found[first].inv() * found[last]
    assert off.magnitude() < 0.01
    assert (turned[first].inv() * turned[last]).magnitude() > 0.2
