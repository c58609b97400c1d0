"""Programs of others on what mjsim writes: each client that is installed computes something that mjsim computes too.

    python scripts/measure/clients.py

A line a client: what it did, its figure, ours. Those that are not installed are named with the package to install.
"""

import ctypes
import importlib.util
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

import mjsim
from mjsim.datasets import export_rosbag2, export_tum_rgbd
from mjsim.record import export_csv, export_mat, export_tum

WORLD = """mjsim: 1
name: clients
walls: [{points: [[0, 0], [7, 0], [7, 5], [0, 5]], closed: true}]
obstacles: [{box: [0.6, 0.9, 1.2], at: [3.5, 3.6], heading_deg: 20}, {box: [0.5, 0.5, 1.2], at: [2.0, 0.8]}]
beacons:
  - {name: tag, marker: {dictionary: apriltag_36h11, id: 7}, at: [6.93, 2.5], heading_deg: 180, width: 0.4, center: 0.6}
  - {name: left, at: [3.0, 4.9], heading_deg: -90}
robots:
  - name: scout
    preset: pioneer3dx
    at: [1, 2.5]
    odometry: {noise: {distance: 0.05, turn: 0.1}}
    sensors:
      - {lidar: scan, beams: 361, fov_deg: 270, rate_hz: 12.5}
      - {camera: front, at: [0.15, 0, 0.6], width: 640, height: 480, rate_hz: 2.5, depth: true}
      - {beacons: ring, rate_hz: 5}
run:
  seconds: 6
  rate_hz: 25
  drivers:
    scout:
      estimator: {use: "mjsim.algorithms.ekf_slam:EkfSlam"}
      navigator: {use: "mjsim.algorithms.constant:ConstantCommand", forward: 0.4, turn: 0.05}
"""
GALLERY, EVERY = 8.0, 8
"""How long the drive through the gallery is [s], and of how many of its pictures COLMAP gets one."""
Client = Callable[[mjsim.Recording, Path], str]


def evo(run: mjsim.Recording, folder: Path) -> str:
    """Return the error of the estimate as evo finds it in TUM files."""
    from evo.core import metrics
    from evo.tools import file_interface

    export_tum(run, folder)
    both = [file_interface.read_tum_trajectory_file(folder / f"scout_{kind}.tum") for kind in ("truth", "estimate")]
    error = metrics.APE(metrics.PoseRelation.translation_part)
    error.process_data(tuple(both))
    return f"position RMSE {error.get_statistic(metrics.StatisticsType.rmse):.9f} m; {ours(run)}"


def pandas(run: mjsim.Recording, folder: Path) -> str:
    """Return the same from the table."""
    import pandas as pd

    export_csv(run, folder)
    table = pd.read_csv(folder / "scout_track.csv")
    squares = (table.estimate_x - table.truth_x) ** 2 + (table.estimate_y - table.truth_y) ** 2
    return f"position RMSE {squares.mean() ** 0.5:.9f} m; {ours(run)}"


def octave(run: mjsim.Recording, folder: Path) -> str:
    """Return the same from the MATLAB file."""
    export_mat(run, folder / "run.mat")
    code = "load run.mat; r = robots.scout; d = r.estimate(:, 1:2) - r.truth(:, 1:2);"
    code += "printf('%.9f', sqrt(mean(sum(d.^2, 2))))"
    done = subprocess.run(["octave-cli", "--eval", code], cwd=folder, capture_output=True, text=True, check=True)
    return f"position RMSE {done.stdout} m; {ours(run)}"


def rosbags(run: mjsim.Recording, folder: Path) -> str:
    """Return how many messages it reads in a bag."""
    from rosbags.highlevel import AnyReader

    with AnyReader([export_rosbag2(run, folder / "bag")]) as reader:
        read = [reader.deserialize(raw, connection.msgtype) for connection, _, raw in reader.messages()]
        return f"{len(read)} messages of {len(reader.connections)} topics read; the bag says {reader.message_count}"


def small_gicp(run: mjsim.Recording, folder: Path) -> str:
    """Return where it finds the robot by matching two scans, as walls 0.5 m high."""
    import small_gicp as matcher

    first, last, expected = two_scans(run)
    found = matcher.align(first, last, registration_type="GICP", downsampling_resolution=0.03).T_target_source
    return f"moved by {found[0, 3]:.3f}, {found[1, 3]:.3f} m; truly {expected[0, 3]:.3f}, {expected[1, 3]:.3f} m"


def open3d(run: mjsim.Recording, folder: Path) -> str:
    """Return the same by its ICP."""
    # Its wheel wants libusb of the system; another wheel brings one where that has none.
    found = importlib.util.find_spec("libusb_package")
    for usb in Path(found.origin or "").parent.glob("libusb-1.0*") if found else ():
        ctypes.CDLL(str(usb), mode=ctypes.RTLD_GLOBAL)
    import open3d as o3d

    first, last, expected = two_scans(run)
    clouds = [o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points)) for points in (last, first)]
    found = o3d.pipelines.registration.registration_icp(*clouds, 0.5).transformation
    return f"moved by {found[0, 3]:.3f}, {found[1, 3]:.3f} m; truly {expected[0, 3]:.3f}, {expected[1, 3]:.3f} m"


def pupil_apriltags(run: mjsim.Recording, folder: Path) -> str:
    """Return how far off its ranges to a tag are, in pictures of a TUM RGB-D data set."""
    import cv2
    from pupil_apriltags import Detector

    (place,) = export_tum_rgbd(run, folder / "tum", redraw=True)
    camera, detector, errors = calibration(place), Detector(families="tag36h11"), []
    truth = np.loadtxt(place / "groundtruth.txt")
    for stamp, name in (line.split() for line in (place / "rgb.txt").read_text().splitlines()[2:]):
        picture = cv2.imread(str(place / name), cv2.IMREAD_GRAYSCALE)
        for found in detector.detect(picture, estimate_tag_pose=True, camera_params=camera, tag_size=0.4):
            at = truth[np.argmin(np.abs(truth[:, 0] - float(stamp))), 1:4]
            truly = np.linalg.norm(at - [6.93, 2.5, 0.6])
            errors.append(abs(np.linalg.norm(found.pose_t) - truly) / truly)
    return f"tag found in {len(errors)} pictures; range off by {100 * np.median(errors):.2f} % (median)"


def colmap(run: mjsim.Recording, folder: Path) -> str:
    """Return how far off the places of pictures are that COLMAP finds in the gallery, after alignment with scale."""
    import pycolmap
    from evo.core.geometry import umeyama_alignment

    with mjsim.Simulation(mjsim.load_world("gallery")) as sim:
        drive = mjsim.run(sim, seconds=GALLERY, record=folder / "gallery.mcap")
    (place,) = export_tum_rgbd(drive, folder / "tum", redraw=True)
    fx, fy, cx, cy = calibration(place)
    names = dict(reversed(line.split()) for line in (place / "rgb.txt").read_text().splitlines()[2::EVERY])
    reader = pycolmap.ImageReaderOptions()
    # COLMAP counts pixels from their corner.
    reader.camera_model, reader.camera_params = "PINHOLE", f"{fx},{fy},{cx + 0.5},{cy + 0.5}"
    database = folder / "colmap.db"
    (folder / "maps").mkdir()
    single, processor = pycolmap.CameraMode.SINGLE, pycolmap.Device.cpu
    pycolmap.extract_features(database, place, list(names), single, reader, device=processor)
    pycolmap.match_exhaustive(database, device=processor)
    maps = pycolmap.incremental_mapping(database, place, folder / "maps").values()
    found = max(maps, key=lambda each: each.num_reg_images()).images.values()
    truth = np.loadtxt(place / "groundtruth.txt")
    stamps = np.array([float(names[each.name]) for each in found])
    true = truth[np.abs(truth[:, :1] - stamps).argmin(axis=0), 1:4].T
    seen = np.array([each.projection_center() for each in found]).T
    turn, moved, scale = umeyama_alignment(seen, true, with_scale=True)
    errors = np.linalg.norm(scale * turn @ seen + moved[:, None] - true, axis=0)
    return (
        f"{len(errors)} of {len(names)} pictures placed; off by {1e3 * np.sqrt(np.mean(errors**2)):.0f} mm (RMSE)"
        f" on a way of {np.linalg.norm(np.diff(truth[:, 1:4], axis=0), axis=1).sum():.1f} m"
    )


def calibration(place: Path) -> list[float]:
    """Return fx, fy, cx, cy of a TUM RGB-D data set [px]."""
    numbers = dict(line.split(": ") for line in (place / "camera.yaml").read_text().splitlines()[1:])
    return [float(numbers[f"Camera.{key}"]) for key in ("fx", "fy", "cx", "cy")]


def ours(run: mjsim.Recording) -> str:
    """Return what mjsim's own statistics say."""
    return f"mjsim {mjsim.statistics(run)['scout']['position_error_m']['rmse']:.9f} m"


def two_scans(run: mjsim.Recording) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return two scans 1.6 s apart as points, (n, 3) [m], and where the second lidar truly was in the first, (4, 4)."""
    seen = [each for each in run.observations("scout") if "scan" in each.scans]
    clouds, poses = [], []
    for each in (seen[0], seen[20]):
        flat = each.scans["scan"].points()
        clouds.append(np.concatenate([np.column_stack([flat, np.full(len(flat), z)]) for z in np.arange(0, 0.5, 0.05)]))
        row = int(np.argmin(np.abs(run.time - each.time)))
        poses.append(mjsim.Pose(*run.robots["scout"].truth[row]))
    with mjsim.Simulation(run.world) as sim:
        mounted = sim.robots["scout"].sensors["scan"].robot_from_sensor
    moved = poses[0].inverse() @ poses[1]
    planar = np.eye(4)
    planar[:2, :2], planar[:2, 3] = moved.matrix()[:2, :2], moved.matrix()[:2, 2]
    return clouds[0], clouds[1], np.linalg.inv(mounted) @ planar @ mounted


CLIENTS: dict[str, tuple[Client, str]] = {
    "evo": (evo, "evo"),
    "pandas": (pandas, "pandas"),
    "Octave": (octave, "octave-cli"),
    "rosbags": (rosbags, "rosbags"),
    "small_gicp": (small_gicp, "small_gicp"),
    "Open3D": (open3d, "open3d"),
    "pupil-apriltags": (pupil_apriltags, "pupil_apriltags"),
    "COLMAP": (colmap, "pycolmap"),
}
"""Client -> what it does, and the module or program that must be there."""


def main() -> int:
    """Run each client in turn, in a process of its own: libraries of others do not always agree with each other."""
    if len(sys.argv) > 1:
        name, recording, folder = sys.argv[1:]
        print(f"{name}: {CLIENTS[name][0](mjsim.read_recording(recording), Path(folder))}")
        return 0
    failed = False
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        with mjsim.Simulation(mjsim.parse_world(WORLD)) as sim:
            mjsim.run(sim, record=folder / "run.mcap")
        for name, (_, needs) in CLIENTS.items():
            if importlib.util.find_spec(needs) is None and shutil.which(needs) is None:
                print(f"{name}: not installed")
                continue
            own = folder / name
            own.mkdir()
            command = [sys.executable, __file__, name, folder / "run.mcap", own]
            done = subprocess.run(command, stdout=subprocess.PIPE, text=True)
            found = [line for line in done.stdout.splitlines() if line.startswith(f"{name}: ")]
            print(*found or [f"{name}: FAILED, exit code {done.returncode}"], sep="\n", flush=True)
            failed = failed or not found
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
