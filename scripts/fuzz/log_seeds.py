"""Small logs of every format that `mjsim import-log` reads, as bytes by the names of their files."""

import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path

import cv2
import numpy as np

from mjsim.geometry import Pose, Pose3
from tests.bags import START, new_bag
from tests.real_logs import write_mrclam, write_victoria_park

Files = dict[str, bytes]
"""Path in a folder -> content."""
CLOUD = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("intensity", "<f4"), ("time", "<f4")])
STILL = Pose3(0, 0, 0, 0, 0, 0, 1)
TABLES = """log: tables
odometry: {file: odometry.csv, time: t, x: x, y: y, heading: yaw}
scans: [{file: scan.csv, time: t, ranges: r_, from_deg: -90, step_deg: 90, range: [0.05, 20]}]
truth: {file: truth.csv, time: t, x: x, y: y, heading_deg: yaw}
"""


def _bag(folder: Path, form: str, *, pictures: bool) -> None:
    """Write odometry, frames and inertial readings, with scans, or with pictures, depth and clouds."""
    grey, eye = np.arange(48, dtype=np.uint8).reshape(6, 8), np.eye(3)
    png, jpeg = (bytes(cv2.imencode(kind, grey)[1]) for kind in (".png", ".jpg"))
    with new_bag(folder / ("run.bag" if form.startswith("bag") else "run"), form) as bag:
        bag.transforms("/tf_static", START, [("base_link", "laser", np.eye(4))])
        for k in range(6):
            at = START + 0.1 * k
            place = Pose3.from_planar(Pose(0.05 * k, 0.0, 0.01 * k))
            bag.put("/odom", at, bag.odometry(bag.header(at, "odom"), "base_link", place))
            bag.put("/imu", at, bag.imu(bag.header(at, "laser"), np.array([0.0, 0.0, 9.8]), np.zeros(3)))
            bag.put("/fix", at, bag.fix(bag.header(at, "laser"), (47.0 + 1e-6 * k, 8.0, 400.0), deviation=0.5))
            if not pictures:
                bag.put("/scan", at, bag.scan(bag.header(at, "laser"), np.full(5, 2.0), -1.0, 0.5, (0.1, 9.0)))
                continue
            head = bag.header(at, "laser")
            bag.put("/camera/camera_info", at, bag.camera_info(head, 8, 6, eye, np.zeros(5)))
            bag.put("/camera/image_raw", at, bag.image(head, "rgb8", np.dstack([grey] * 3)))
            bag.put("/left/compressed", at, bag.compressed(head, "png", png if k % 2 else jpeg))
            bag.put("/depth/image_raw", at, bag.image(head, "16UC1", grey.astype("<u2")))
            bag.put("/points", at, bag.cloud(head, np.ones((2, 3), dtype=CLOUD)))


def _carmen(folder: Path) -> None:
    lines = ["PARAM robot_frontlaser_offset 0.1 0 h 0"]
    for k in range(8):
        pose, stamp = f"{0.05 * k:.2f} 0.0 0.0", f"{k / 10:.1f} h {k / 10:.1f}"
        lines += [f"ODOM {pose} 0.5 0.0 0.0 {stamp}", f"FLASER 3 1.0 2.0 81.9 {pose} {pose} {stamp}"]
        lines += [f"RAWLASER1 0 -1.5 3.0 1.5 81.0 0.01 0 3 1.0 2.0 3.0 0 {stamp}", f"TRUEPOS {pose} {pose} {stamp}"]
    (folder / "run.log").write_text("\n".join(lines) + "\n")


def _tum(folder: Path) -> None:
    stamps = [f"{1000 + k / 10:.4f}" for k in range(5)]
    for kind, pixels in (("rgb", np.zeros((6, 8, 3), np.uint8)), ("depth", np.full((6, 8), 5000, np.uint16))):
        (folder / kind).mkdir()
        for stamp in stamps:
            cv2.imwrite(str(folder / kind / f"{stamp}.png"), pixels)
        (folder / f"{kind}.txt").write_text("# list\n" + "".join(f"{each} {kind}/{each}.png\n" for each in stamps))
    (folder / "groundtruth.txt").write_text("".join(f"{each} 0 0 0 0 0 0 1\n" for each in stamps))
    (folder / "accelerometer.txt").write_text("".join(f"{each} 0 9.8 0\n" for each in stamps))


def _euroc(folder: Path) -> None:
    stamps = [1_400_000_000_000_000_000 + 100_000_000 * k for k in range(5)]
    camera, imu, truth = (folder / "mav0" / each for each in ("cam0", "imu0", "state_groundtruth_estimate0"))
    for part in (camera / "data", imu, truth):
        part.mkdir(parents=True)
    for stamp in stamps:
        cv2.imwrite(str(camera / "data" / f"{stamp}.png"), np.zeros((6, 8), np.uint8))
    pose = "T_BS:\n  cols: 4\n  rows: 4\n  data: [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]\n"
    lens = "resolution: [8, 6]\nintrinsics: [5, 5, 4, 3]\ndistortion_coefficients: [0, 0, 0, 0]\n"
    (camera / "sensor.yaml").write_text(f"{pose}camera_model: pinhole\ndistortion_model: radial-tangential\n{lens}")
    (imu / "sensor.yaml").write_text(pose)
    (camera / "data.csv").write_text("#t,name\n" + "".join(f"{each},{each}.png\n" for each in stamps))
    (imu / "data.csv").write_text("#t,w,a\n" + "".join(f"{each},0,0,0,0,0,9.8\n" for each in stamps))
    row = ",".join(["0", "0", "0", "1", "0", "0", "0", *["0"] * 9])
    (truth / "data.csv").write_text("#t,p,q,v,b,b\n" + "".join(f"{each},{row}\n" for each in stamps))


def _tables(folder: Path) -> None:
    (folder / "log.yaml").write_text(TABLES)
    poses = "".join(f"{k / 10},{0.05 * k},0,0\n" for k in range(8))
    for name in ("odometry", "truth"):
        (folder / f"{name}.csv").write_text(f"t,x,y,yaw\n{poses}")
    (folder / "scan.csv").write_text("t;r_0;r_1;r_2\n" + "".join(f"{k / 10};1,5;2;inf\n" for k in range(8)))


MAKERS: Mapping[str, Callable[[Path], object]] = {
    "bag of ROS 1": lambda folder: _bag(folder, "bag", pictures=False),
    "bag of ROS 1, bz2": lambda folder: _bag(folder, "bag-bz2", pictures=False),
    "bag of ROS 1, lz4": lambda folder: _bag(folder, "bag-lz4", pictures=False),
    "bag in SQLite": lambda folder: _bag(folder, "sqlite", pictures=False),
    "bag in MCAP": lambda folder: _bag(folder, "mcap", pictures=False),
    "bag in MCAP, zstd": lambda folder: _bag(folder, "mcap-storage", pictures=False),
    "pictures and clouds": lambda folder: _bag(folder, "mcap", pictures=True),
    "CARMEN": _carmen,
    "MRCLAM": lambda folder: write_mrclam(folder, seconds=1.0),
    "Victoria Park": lambda folder: write_victoria_park(folder, seconds=2.0),
    "TUM": _tum,
    "EuRoC": _euroc,
    "tables": _tables,
}
"""Format -> writes a log into a folder."""


def seed_of(name: str) -> Files:
    """Return a log of a format."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        MAKERS[name](folder)
        files = sorted(each for each in folder.rglob("*") if each.is_file())
        return {str(each.relative_to(folder)): each.read_bytes() for each in files}
