"""Small logs of every format that `mjsim import-log` reads, as bytes by the names of their files."""

import tempfile
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

Files = dict[str, bytes]
"""Path in a folder -> content."""
CLOUD = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("intensity", "<f4"), ("time", "<f4")])
EYE, GREY = np.eye(3).ravel(), np.arange(48, dtype=np.uint8).reshape(6, 8)
START = 1_700_000_000
"""[s]"""
TABLES = """log: tables
odometry: {file: odometry.csv, time: t, x: x, y: y, heading: yaw}
scans: [{file: scan.csv, time: t, ranges: r_, from_deg: -90, step_deg: 90, range: [0.05, 20]}]
truth: {file: truth.csv, time: t, x: x, y: y, heading_deg: yaw}
"""


def _made(store: Typestore, kind: str, **fields: Any) -> Any:
    """Return a message of a type, 'sensor_msgs/msg/Imu': some fields as given, all others zero or empty."""
    _, known = store.fielddefs[kind]
    return store.types[kind](**{name: fields.get(name, _nothing(store, *node)) for name, node in known})


def _nothing(store: Typestore, node: Nodetype, content: Any) -> Any:
    """Return the zero of a field."""
    if node == Nodetype.NAME:
        return _made(store, content)
    if node == Nodetype.BASE:
        return {"string": "", "bool": False}.get(content[0], 0)
    (inner, of), count = content
    if inner == Nodetype.BASE and of[0] != "string":
        return np.zeros(count, dtype={"octet": "u1", "byte": "u1", "char": "u1"}.get(of[0], of[0]))
    return [_nothing(store, inner, of) for _ in range(count)]


def _bag(folder: Path, form: str, *, pictures: bool) -> None:
    """Write odometry and inertial readings, with scans and fixes, or with pictures, depth and clouds."""
    storage, _, packed = form.partition("-")
    is_old = storage == "bag"
    store = get_typestore(Stores.ROS1_NOETIC if is_old else Stores.LATEST)
    writer: Any = Writer1(folder / "run.bag") if is_old else _writer2(folder / "run", storage, packed)
    if is_old and packed:
        writer.set_compression(Writer1.CompressionFormat[packed.upper()])
    with writer:
        channels: dict[str, Any] = {}
        for k in range(6):
            for topic, kind, fields in _PICTURES if pictures else _SCANS:
                name = f"{kind.partition('/')[0]}/msg/{kind.partition('/')[2]}"
                if topic not in channels:
                    channels[topic] = writer.add_connection(topic, name, typestore=store)
                when = store.types["builtin_interfaces/msg/Time"](sec=START, nanosec=k * 100_000_000)
                head = _made(store, "std_msgs/msg/Header", stamp=when, frame_id="base_link")
                message = _made(store, name, header=head, **fields(partial(_made, store), k))
                pack = store.serialize_ros1 if is_old else store.serialize_cdr
                writer.write(channels[topic], START * 10**9 + k * 10**8, pack(message, name))


def _writer2(place: Path, storage: str, packed: str) -> Writer2:
    writer = Writer2(place, version=9, storage_plugin=StoragePlugin[storage.upper()])
    if packed:
        writer.set_compression(CompressionMode[packed.upper()], CompressionFormat.ZSTD)
    return writer


def _odometry(made: Any, k: int) -> dict[str, Any]:
    place = made("geometry_msgs/msg/Point", x=0.05 * k, y=0.0, z=0.0)
    turned = made("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0)
    pose = made("geometry_msgs/msg/Pose", position=place, orientation=turned)
    return {"child_frame_id": "base_link", "pose": made("geometry_msgs/msg/PoseWithCovariance", pose=pose)}


def _scan(made: Any, k: int) -> dict[str, Any]:
    limits = {"range_min": 0.1, "range_max": 9.0, "ranges": np.full(5, 2.0 + k, dtype=np.float32)}
    return {"angle_min": -1.0, "angle_max": 1.0, "angle_increment": 0.5, **limits}


def _cloud(made: Any, k: int) -> dict[str, Any]:
    fields = [
        made("sensor_msgs/msg/PointField", name=name, offset=4 * n, datatype=7, count=1)
        for n, name in enumerate(CLOUD.names or ())
    ]
    data = np.ones((2, 3), dtype=CLOUD).view(np.uint8).ravel()
    size = {"height": 2, "width": 3, "point_step": CLOUD.itemsize, "row_step": 3 * CLOUD.itemsize}
    return {"fields": fields, "data": data, **size}


def _image(encoding: str, pixels: Any) -> dict[str, Any]:
    rows = np.ascontiguousarray(pixels).view(np.uint8).reshape(6, -1)
    return {"height": 6, "width": 8, "encoding": encoding, "step": rows.shape[1], "data": rows.ravel()}


def _packed(kind: str) -> dict[str, Any]:
    return {"format": kind, "data": cv2.imencode(f".{kind}", GREY)[1].ravel()}


_MOVES = (
    ("/odom", "nav_msgs/Odometry", _odometry),
    ("/imu", "sensor_msgs/Imu", lambda made, k: {}),
)
_SCANS = (
    *_MOVES,
    ("/scan", "sensor_msgs/LaserScan", _scan),
    ("/fix", "sensor_msgs/NavSatFix", lambda made, k: {"latitude": 47.0 + 1e-6 * k, "longitude": 8.0}),
)
_PICTURES = (
    *_MOVES,
    (
        "/camera/camera_info",
        "sensor_msgs/CameraInfo",
        lambda made, k: {"height": 6, "width": 8, "k": np.eye(3).ravel()},
    ),
    ("/camera/image_raw", "sensor_msgs/Image", lambda made, k: _image("rgb8", np.dstack([GREY] * 3))),
    ("/left/compressed", "sensor_msgs/CompressedImage", lambda made, k: _packed("png" if k % 2 else "jpeg")),
    ("/depth/image_raw", "sensor_msgs/Image", lambda made, k: _image("16UC1", GREY.astype("<u2"))),
    ("/points", "sensor_msgs/PointCloud2", _cloud),
)


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


def _mrclam(folder: Path) -> None:
    (folder / "Barcodes.dat").write_text("# Subject Barcode\n1 5\n6 63\n7 81\n")
    (folder / "Landmark_Groundtruth.dat").write_text("6 4.0 0.5 0.0001 0.0001\n7 3.0 3.5 0.0001 0.0001\n")
    rows = {
        "Groundtruth": [f"{START + k / 10} {0.03 * k} 0.0 0.0" for k in range(12)],
        "Odometry": [f"{START + k / 10} 0.3 0.0" for k in range(12)],
        "Measurement": [f"{START + k / 10} {63 if k % 2 else 81} 3.0 0.1" for k in range(12)],
    }
    for kind, lines in rows.items():
        (folder / f"Robot1_{kind}.dat").write_text("# Time\n" + "\n".join(lines) + "\n")


def _victoria_park(folder: Path) -> None:
    tables = {
        "inputs": [f"{k / 10} 2.0 0.1" for k in range(20)],
        "measurements": [f"{k / 10} 12.0 1.5 0.3" for k in range(20)],
        "gps": [f"{k / 5} {0.4 * k} 0.0" for k in range(10)],
    }
    for name, lines in tables.items():
        (folder / f"{name}.dat").write_text("\n".join(lines) + "\n")


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
    "bag in SQLite": lambda folder: _bag(folder, "sqlite3", pictures=False),
    "bag in MCAP": lambda folder: _bag(folder, "mcap", pictures=False),
    "bag in MCAP, zstd": lambda folder: _bag(folder, "mcap-storage", pictures=False),
    "pictures and clouds": lambda folder: _bag(folder, "mcap", pictures=True),
    "CARMEN": _carmen,
    "MRCLAM": _mrclam,
    "Victoria Park": _victoria_park,
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
