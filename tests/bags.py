"""Bags of ROS as other programs write them: with the writer of rosbags, which mjsim does not use."""

import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from mjsim.geometry import Array, Pose3

if sys.version_info >= (3, 14):
    from compression import zstd as zstd
else:
    from backports import zstd as zstd

START = 1_700_000_000.25
"""Time of the robot's clock when a log begins [s]."""
FORMS = ("bag", "bag-bz2", "bag-lz4", "sqlite", "sqlite-file", "mcap", "mcap-message", "mcap-storage")
MODES = {
    "file": CompressionMode.FILE,
    "message": CompressionMode.MESSAGE,
    "storage": CompressionMode.STORAGE,
}


class Bag:
    """A bag being written: `put` takes a topic, a time and a message made with `make`."""

    def __init__(self, writer: Any, store: Any, *, ros1: bool) -> None:
        self._writer, self._store, self._ros1 = writer, store, ros1
        self._connections: dict[str, Any] = {}

    def make(self, name: str, /, **fields: Any) -> Any:
        """Return a message by the short name of its type, 'sensor_msgs/LaserScan'."""
        package, kind = name.split("/")
        return self._store.types[f"{package}/msg/{kind}"](**fields)

    def header(self, stamp: float, frame: str) -> Any:
        """Return a header."""
        seconds, nanoseconds = divmod(round(stamp * 1e9), 1_000_000_000)
        time = self._store.types["builtin_interfaces/msg/Time"](sec=seconds, nanosec=nanoseconds)
        sequence = {"seq": 0} if self._ros1 else {}
        return self.make("std_msgs/Header", **sequence, stamp=time, frame_id=frame)

    def put(self, topic: str, recorded: float, message: Any) -> None:
        """Write a message, recorded at a time [s]."""
        kind = message.__msgtype__
        if topic not in self._connections:
            self._connections[topic] = self._writer.add_connection(topic, kind, typestore=self._store)
        pack = self._store.serialize_ros1 if self._ros1 else self._store.serialize_cdr
        self._writer.write(self._connections[topic], round(recorded * 1e9), pack(message, kind))

    def xyz(self, x: float, y: float, z: float, *, kind: str = "Vector3") -> Any:
        return self.make(f"geometry_msgs/{kind}", x=float(x), y=float(y), z=float(z))

    def quaternion(self, x: float, y: float, z: float, w: float) -> Any:
        return self.make("geometry_msgs/Quaternion", x=float(x), y=float(y), z=float(z), w=float(w))

    def pose(self, pose: Pose3) -> Any:
        place = self.xyz(pose.x, pose.y, pose.z, kind="Point")
        turned = self.quaternion(pose.qx, pose.qy, pose.qz, pose.qw)
        return self.make("geometry_msgs/Pose", position=place, orientation=turned)

    def transform(self, header: Any, child: str, matrix: Array) -> Any:
        pose = Pose3.from_matrix(matrix)
        told = self.make(
            "geometry_msgs/Transform",
            translation=self.xyz(pose.x, pose.y, pose.z),
            rotation=self.quaternion(pose.qx, pose.qy, pose.qz, pose.qw),
        )
        return self.make("geometry_msgs/TransformStamped", header=header, child_frame_id=child, transform=told)

    def transforms(self, topic: str, stamp: float, poses: Iterable[tuple[str, str, Array]]) -> None:
        """Write where frames are in others: (outer, inner, outer_from_inner) of each."""
        told = [self.transform(self.header(stamp, outer), inner, matrix) for outer, inner, matrix in poses]
        self.put(topic, stamp, self.make("tf2_msgs/TFMessage", transforms=told))

    def odometry(self, header: Any, child: str, pose: Pose3, forward: float = 0.0, turn: float = 0.0) -> Any:
        twist = self.make("geometry_msgs/Twist", linear=self.xyz(forward, 0, 0), angular=self.xyz(0, 0, turn))
        return self.make(
            "nav_msgs/Odometry",
            header=header,
            child_frame_id=child,
            pose=self.make("geometry_msgs/PoseWithCovariance", pose=self.pose(pose), covariance=np.zeros(36)),
            twist=self.make("geometry_msgs/TwistWithCovariance", twist=twist, covariance=np.zeros(36)),
        )

    def scan(self, header: Any, ranges: Array, first: float, step: float, limits: tuple[float, float]) -> Any:
        return self.make(
            "sensor_msgs/LaserScan",
            header=header,
            angle_min=first,
            angle_max=first + step * (len(ranges) - 1),
            angle_increment=step,
            time_increment=0.0,
            scan_time=0.1,
            range_min=limits[0],
            range_max=limits[1],
            ranges=np.asarray(ranges, dtype=np.float32),
            intensities=np.zeros(0, dtype=np.float32),
        )

    def cloud(self, header: Any, points: Any, *, padding: int = 0) -> Any:
        """Return a cloud of records, shape (height, width), with fields of their names."""
        kinds = {"i1": 1, "u1": 2, "i2": 3, "u2": 4, "i4": 5, "u4": 6, "f4": 7, "f8": 8}
        fields = [
            self.make("sensor_msgs/PointField", name=name, offset=offset, datatype=kinds[kind.str[1:]], count=1)
            for name, (kind, offset, *_) in points.dtype.fields.items()
        ]
        height, width = points.shape
        rows = np.ascontiguousarray(points).view(np.uint8).reshape(height, -1)
        rows = np.hstack([rows, np.zeros((height, padding), dtype=np.uint8)])
        return self.make(
            "sensor_msgs/PointCloud2",
            header=header,
            height=height,
            width=width,
            fields=fields,
            is_bigendian=points.dtype["x"].str[0] == ">",
            point_step=points.itemsize,
            row_step=rows.shape[1],
            data=rows.ravel(),
            is_dense=False,
        )

    def image(self, header: Any, encoding: str, pixels: Any, *, padding: int = 0) -> Any:
        """Return a picture of an array, shape (height, width) or (height, width, channels)."""
        height, width = pixels.shape[:2]
        rows = np.ascontiguousarray(pixels).view(np.uint8).reshape(height, -1)
        rows = np.hstack([rows, np.zeros((height, padding), dtype=np.uint8)])
        return self.make(
            "sensor_msgs/Image",
            header=header,
            height=height,
            width=width,
            encoding=encoding,
            is_bigendian=0,
            step=rows.shape[1],
            data=rows.ravel(),
        )

    def compressed(self, header: Any, form: str, data: bytes) -> Any:
        return self.make(
            "sensor_msgs/CompressedImage", header=header, format=form, data=np.frombuffer(data, dtype=np.uint8)
        )

    def camera_info(self, header: Any, width: int, height: int, K: Array, D: Array, model: str = "plumb_bob") -> Any:
        region = self.make("sensor_msgs/RegionOfInterest", x_offset=0, y_offset=0, height=0, width=0, do_rectify=False)
        matrices = {
            "K": np.asarray(K, dtype=float).ravel(),
            "D": np.asarray(D, dtype=float),
            "R": np.eye(3).ravel(),
            "P": np.hstack([np.reshape(K, (3, 3)), np.zeros((3, 1))]).ravel(),
        }
        named = matrices if self._ros1 else {name.lower(): value for name, value in matrices.items()}
        return self.make(
            "sensor_msgs/CameraInfo",
            header=header,
            height=height,
            width=width,
            distortion_model=model,
            **named,
            binning_x=0,
            binning_y=0,
            roi=region,
        )

    def imu(self, header: Any, acceleration: Array, turn: Array) -> Any:
        nothing = np.zeros(9)
        return self.make(
            "sensor_msgs/Imu",
            header=header,
            orientation=self.quaternion(0, 0, 0, 1),
            orientation_covariance=nothing,
            angular_velocity=self.xyz(*turn),
            angular_velocity_covariance=nothing,
            linear_acceleration=self.xyz(*acceleration),
            linear_acceleration_covariance=nothing,
        )

    def fix(self, header: Any, place: tuple[float, float, float], *, status: int = 0, deviation: float | None) -> Any:
        """Return the fix of a receiver: latitude, longitude [deg] and altitude [m]; -1 is no fix."""
        told = self.make("sensor_msgs/NavSatStatus", status=status, service=1)
        return self.make(
            "sensor_msgs/NavSatFix",
            header=header,
            status=told,
            latitude=place[0],
            longitude=place[1],
            altitude=place[2],
            position_covariance=(np.eye(3) * (deviation or 0.0) ** 2).ravel(),
            position_covariance_type=0 if deviation is None else 2,
        )


@contextmanager
def new_bag(path: Path, form: str = "mcap") -> Iterator[Bag]:
    """Write a bag of one of FORMS; of ROS 2 a folder, of ROS 1 a file."""
    storage, _, packed = form.partition("-")
    if storage == "bag":
        writer = Writer1(path)
        if packed:
            writer.set_compression(Writer1.CompressionFormat[packed.upper()])
        store = get_typestore(Stores.ROS1_NOETIC)
        store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", "tf2_msgs/msg/TFMessage"))
    else:
        writer = Writer2(path, version=9, storage_plugin=StoragePlugin[{"sqlite": "SQLITE3"}.get(storage, "MCAP")])
        if packed:
            writer.set_compression(MODES[packed], CompressionFormat.ZSTD)
        store = get_typestore(Stores.LATEST)
    with writer:
        yield Bag(writer, store, ros1=storage == "bag")


def write_scans(path: Path, form: str = "mcap", *, first: float = -0.3, step: float = 0.1) -> None:
    """Write a second of scans, and odometry that stands still."""
    with new_bag(path, form) as bag:
        for k in range(10):
            at = START + 0.1 * k
            ranges = np.array([np.nan, 0.0, 0.05, 1.0, 3.0, 9.0, np.inf])
            told = bag.scan(bag.header(at, "laser"), ranges, first, step, (0.1, 5.0))
            bag.put("/scan", at, told)
            bag.put("/odom", at, bag.odometry(bag.header(at, "odom"), "base_link", Pose3(0, 0, 0, 0, 0, 0, 1)))
