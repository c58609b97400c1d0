"""Converts values of mjsim to ROS 2 messages, with the classes and the serialisation (CDR) of rosbags.

Metres, seconds, radians, right-handed frames with x ahead, y to the left and z up (REP 103); optical frames of cameras
with x right, y down and z ahead. Infinite ranges follow REP 117, infinite depths REP 118.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjsim.errors import UsageError, how_to_install
from mjsim.geometry import Array, Pose, Pose3
from mjsim.interface import (
    CLOUD_FIELDS,
    CompassReading,
    ImuReading,
    Intrinsics,
    JointState,
    Picture,
    PointCloud,
    Scan,
    SensorInfo,
)
from mjsim.ros.simulation_types import ENTITY_STATE, simulation_types

PLANAR = np.ix_((0, 1, 5), (0, 1, 5))
"""Rows and columns of x, y and yaw in the covariance of a 3-D pose."""
FLAT = np.diag([1e-9, 1e-9, 1e-6, 1e-6, 1e-6, 1e-9])
"""Variances of (x, y, z, roll, pitch, yaw) that are added to a planar covariance [m^2, rad^2].

A robot on a floor is certain of z, roll and pitch. Readers invert the whole matrix, though, and some take a variance of
zero for an unknown one. These are the values that robot_localization itself uses: 1e-6 in its `two_d_mode`, and 1e-9 as
the smallest variance of its inputs.
"""
_CALL = "uint64 guid\nint64 number\n"
SERVICE_TYPES = {
    "std_srvs/srv/msg/Trigger_Request": f"{_CALL}uint8 structure_needs_at_least_one_member",
    "std_srvs/srv/msg/Trigger_Response": f"{_CALL}bool success\nstring message",
    "std_srvs/srv/msg/SetBool_Request": f"{_CALL}bool data",
    "std_srvs/srv/msg/SetBool_Response": f"{_CALL}bool success\nstring message",
    **simulation_types(_CALL),
}
"""Requests and responses in the format of rmw_cyclonedds: preceded by the client's id and the number of its request.
rosbags puts `msg` into the names of all types."""
ANY_ANGLE = math.pi**2 / 3
"""Variance of an angle that may have any value in [-pi, pi) [rad^2]."""
OCCUPIED, FREE, UNKNOWN = 100, 0, -1
"""Cells of an occupancy grid."""


@cache
def typestore() -> Any:
    """Return rosbags' types of ROS 2 Jazzy, and those of our services.

    Raises:
        UsageError: rosbags is not installed.
    """
    try:
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore
    except ModuleNotFoundError:
        raise UsageError(
            f"rosbags, which defines ROS messages, is not installed; type: {how_to_install('rosbags')}"
        ) from None
    store = get_typestore(Stores.ROS2_JAZZY)
    for name, text in SERVICE_TYPES.items():
        store.register(get_types_from_msg(text, name))
    return store


def bytes_of(message: Any) -> bytes:
    """Return the CDR of a message, with its header of 4 bytes."""
    return bytes(typestore().serialize_cdr(message, message.__msgtype__))


def message_of(data: bytes, kind: str) -> Any:
    """Return the message of a type in CDR, with its header of 4 bytes."""
    return typestore().deserialize_cdr(data, kind)


def nanoseconds(time: float) -> int:
    """Return a time for ROS messages, rounded [ns]."""
    return round(time * 1e9)


def _of(kind: str) -> Any:
    return typestore().types[kind]


def _time(time: float) -> Any:
    return _of("builtin_interfaces/msg/Time")(*divmod(nanoseconds(time), 1_000_000_000))


def _header(time: float, frame: str) -> Any:
    return _of("std_msgs/msg/Header")(_time(time), frame)


def _vector(values: Iterable[float]) -> Any:
    return _of("geometry_msgs/msg/Vector3")(*map(float, values))


def _pose(pose: Pose3) -> Any:
    return _of("geometry_msgs/msg/Pose")(
        _of("geometry_msgs/msg/Point")(pose.x, pose.y, pose.z),
        _of("geometry_msgs/msg/Quaternion")(pose.qx, pose.qy, pose.qz, pose.qw),
    )


def in_space(covariance: Array) -> Array:
    """Return a covariance of (x, y, heading), shape (3, 3), as one of (x, y, z, roll, pitch, yaw), shape (36,).

    The result is invertible even if the robot's pose is certain; see `FLAT`.
    """
    whole = FLAT.copy()
    whole[PLANAR] += covariance
    return whole.ravel()


def clock(time: float) -> Any:
    """Return the simulated time [s]."""
    return _of("rosgraph_msgs/msg/Clock")(_time(time))


def transforms(time: float, poses: Mapping[tuple[str, str], Pose3]) -> Any:
    """Return poses of frames, outer_from_inner by (outer, inner)."""
    stamped = [
        _of("geometry_msgs/msg/TransformStamped")(
            _header(time, outer),
            inner,
            _of("geometry_msgs/msg/Transform")(
                _vector((pose.x, pose.y, pose.z)),
                _of("geometry_msgs/msg/Quaternion")(pose.qx, pose.qy, pose.qz, pose.qw),
            ),
        )
        for (outer, inner), pose in poses.items()
    ]
    return _of("tf2_msgs/msg/TFMessage")(stamped)


def stamped_pose(time: float, frame: str, pose: Pose3) -> Any:
    """Return a pose in a frame."""
    return _of("geometry_msgs/msg/PoseStamped")(_header(time, frame), _pose(pose))


def entity_state(time: float, frame: str, pose: Pose3, velocity: Array) -> Any:
    """Return a pose in a frame and its planar velocity there, (x, y, turn) [m/s, m/s, rad/s]."""
    x, y, turn = velocity.tolist()
    still = _vector((0.0, 0.0, 0.0))
    return _of(ENTITY_STATE)(
        _header(time, frame),
        _pose(pose),
        _of("geometry_msgs/msg/Twist")(_vector((x, y, 0.0)), _vector((0.0, 0.0, turn))),
        _of("geometry_msgs/msg/Accel")(still, still),
    )


def uncertain_pose(time: float, frame: str, pose: Pose, covariance: Array) -> Any:
    """Return a planar pose with its covariance, shape (3, 3)."""
    with_covariance = _of("geometry_msgs/msg/PoseWithCovariance")(_pose(Pose3.from_planar(pose)), in_space(covariance))
    return _of("geometry_msgs/msg/PoseWithCovarianceStamped")(_header(time, frame), with_covariance)


def odometry(
    time: float, frames: tuple[str, str], pose: Pose, covariance: Array, twist: Array, twist_covariance: Array
) -> Any:
    """Return dead reckoning.

    Args:
        time: [s]
        frames: Frame of the pose, and frame of the robot, in which the twist is given.
        pose: Pose of the robot.
        covariance: Covariance of the pose, shape (3, 3) [m, m, rad].
        twist: (forward, left, turn), shape (3,) [m/s, m/s, rad/s].
        twist_covariance: Covariance of the twist, shape (3, 3).
    """
    forward, left, turn = twist.tolist()
    moving = _of("geometry_msgs/msg/Twist")(_vector((forward, left, 0.0)), _vector((0.0, 0.0, turn)))
    return _of("nav_msgs/msg/Odometry")(
        _header(time, frames[0]),
        frames[1],
        _of("geometry_msgs/msg/PoseWithCovariance")(_pose(Pose3.from_planar(pose)), in_space(covariance)),
        _of("geometry_msgs/msg/TwistWithCovariance")(moving, in_space(twist_covariance)),
    )


def point_cloud(cloud: PointCloud, frame: str, sheet: SensorInfo) -> Any:
    """Return one revolution of a 3-D lidar, with the fields of `CLOUD_FIELDS`."""
    rows = cloud.rows()
    field, numbers = _of("sensor_msgs/msg/PointField"), {"<f4": 7, "<u2": 4}  # FLOAT32 and UINT16 of PointField
    fields = [
        field(name, offset, numbers[CLOUD_FIELDS[name]], 1)
        for name, (_, offset, *_) in (rows.dtype.fields or {}).items()
    ]
    return _of("sensor_msgs/msg/PointCloud2")(
        _header(cloud.stamp, frame),
        height=1,
        width=len(rows),
        fields=fields,
        is_bigendian=False,
        point_step=rows.itemsize,
        row_step=rows.nbytes,
        data=rows.view(np.uint8),
        is_dense=True,
    )


def laser_scan(scan: Scan, frame: str, sheet: SensorInfo) -> Any:
    """Return a scan, with the time of its first beam; unless the lidar rotates, all beams have the same time."""
    strengths = () if scan.intensities is None else scan.intensities
    return _of("sensor_msgs/msg/LaserScan")(
        _header(max(0.0, scan.stamp + float(scan.times()[0])), frame),
        float(scan.angle_min),
        float(scan.angle_min + scan.angle_increment * (len(scan.ranges) - 1)),
        float(scan.angle_increment),
        scan.time_increment or 0.0,
        1.0 / sheet.rate_hz,
        float(scan.range_min),
        float(scan.range_max),
        np.asarray(scan.ranges, dtype=np.float32),
        np.asarray(strengths, dtype=np.float32),
    )


def imu(reading: ImuReading, frame: str, sheet: SensorInfo) -> Any:
    """Return an inertial reading; a first covariance of -1 means that something is not measured, as its orientation."""
    unknown = _unknown()

    def measured(key: str, values: Array) -> tuple[Any, Array]:
        if not np.isfinite(values).all():
            return _vector((0.0, 0.0, 0.0)), unknown
        return _vector(values), (np.eye(3) * sheet.noise.get(key, 0.0) ** 2).ravel()

    return _of("sensor_msgs/msg/Imu")(
        _header(reading.stamp, frame),
        _of("geometry_msgs/msg/Quaternion")(0.0, 0.0, 0.0, 1.0),
        unknown,
        *measured("turn", reading.turn),
        *measured("acceleration", reading.acceleration),
    )


def heading(reading: CompassReading, frame: str, sheet: SensorInfo) -> Any:
    """Return a heading as the orientation of an inertial sensor (REP 145), with unknown roll and pitch."""
    half, nothing = 0.5 * reading.heading, (_vector((0.0, 0.0, 0.0)), _unknown())
    return _of("sensor_msgs/msg/Imu")(
        _header(reading.stamp, frame),
        _of("geometry_msgs/msg/Quaternion")(0.0, 0.0, math.sin(half), math.cos(half)),
        np.diag([ANY_ANGLE, ANY_ANGLE, reading.variance]).ravel(),
        *nothing,
        *nothing,
    )


def _unknown() -> Array:
    """Return the covariance that marks a quantity as not measured by an inertial sensor."""
    return np.array([-1.0, *[0.0] * 8])


@dataclass(frozen=True, slots=True)
class SensorTopic:
    """How the readings of a kind of sensor are sent."""

    word: str
    """Last part of the topic."""
    kind: str
    """Type of the messages."""
    message: Callable[[Any, str, SensorInfo], Any]
    """Reading, name of the sensor's frame and data sheet -> message."""


SENSOR_TOPICS = {
    "scans": SensorTopic("scan", "sensor_msgs/msg/LaserScan", laser_scan),
    "clouds": SensorTopic("points", "sensor_msgs/msg/PointCloud2", point_cloud),
    "imu": SensorTopic("imu", "sensor_msgs/msg/Imu", imu),
    "compasses": SensorTopic("heading", "sensor_msgs/msg/Imu", heading),
}
"""Field of `Observation` -> topic of each sensor with readings in it; pictures are in several topics."""


def picture(stamp: float, frame: str, image: Picture) -> Any:
    """Return a raw RGB picture."""
    height, width, _ = image.shape
    return _image(stamp, frame, (height, width), "rgb8", image)


def depth_picture(stamp: float, frame: str, depth: NDArray[Any]) -> Any:
    """Return the depth of each pixel along the optical axis, according to REP 118.

    Args:
        stamp: Time of the picture [s].
        frame: Optical frame of the camera.
        depth: Shape (height, width): uint16 [mm], 0 for none; or floats [m], sent in single precision.
    """
    whole = depth.dtype == np.uint16
    pixels = depth.astype("<u2" if whole else "<f4")
    return _image(stamp, frame, (depth.shape[0], depth.shape[1]), "16UC1" if whole else "32FC1", pixels)


def _image(stamp: float, frame: str, size: tuple[int, int], encoding: str, pixels: NDArray[Any]) -> Any:
    data = np.frombuffer(np.ascontiguousarray(pixels).tobytes(), dtype=np.uint8)
    height, width = size
    return _of("sensor_msgs/msg/Image")(_header(stamp, frame), height, width, encoding, 0, len(data) // height, data)


def compressed_picture(stamp: float, frame: str, data: bytes, form: str) -> Any:
    """Return the contents of a picture's file, of format 'jpeg' or 'png'."""
    return _of("sensor_msgs/msg/CompressedImage")(_header(stamp, frame), form, np.frombuffer(data, dtype=np.uint8))


def camera_info(stamp: float, frame: str, intrinsics: Intrinsics) -> Any:
    """Return a camera's calibration: 'plumb_bob' of 5 coefficients, 'rational_polynomial' of 8, 'equidistant' of 4."""
    polynomial = "rational_polynomial" if intrinsics.is_rational() else "plumb_bob"
    K = intrinsics.matrix()
    return _of("sensor_msgs/msg/CameraInfo")(
        _header(stamp, frame),
        intrinsics.height,
        intrinsics.width,
        "equidistant" if intrinsics.lens == "fisheye" else polynomial,
        np.array(intrinsics.coefficients()),
        K.ravel(),
        np.eye(3).ravel(),
        np.hstack([K, np.zeros((3, 1))]).ravel(),
        0,
        0,
        _of("sensor_msgs/msg/RegionOfInterest")(0, 0, 0, 0, False),
    )


def joint_state(names: Sequence[str], state: JointState) -> Any:
    """Return joint states; effort is the torque of the motors [N m], or the force [N]."""
    values = (np.asarray(each, dtype=float) for each in (state.positions, state.velocities, state.torques))
    return _of("sensor_msgs/msg/JointState")(_header(state.stamp, ""), list(names), *values)


def distance(time: float, frame: str, reading: float, *, farthest: float) -> Any:
    """Return the range of a ray along the x axis of a frame [m]; infinite for no return."""
    infrared = _of("sensor_msgs/msg/Range").INFRARED
    return _of("sensor_msgs/msg/Range")(_header(time, frame), infrared, 0.0, 0.0, farthest, float(reading), 0.0)


def grid_map(
    occupied: NDArray[np.bool_], free: NDArray[np.bool_], *, resolution: float, map_from_grid: Pose, frame: str = "map"
) -> Any:
    """Return a map.

    Args:
        occupied: Cells, shape (rows, columns); row 0 is the lowest in y.
        free: The same; cells that are neither are unknown.
        resolution: Side of a cell [m].
        map_from_grid: Corner of the first cell.
        frame: Frame of the map.
    """
    cells = np.where(occupied, OCCUPIED, np.where(free, FREE, UNKNOWN)).astype(np.int8)
    rows, columns = cells.shape
    about = _of("nav_msgs/msg/MapMetaData")(
        _time(0.0), float(resolution), columns, rows, _pose(Pose3.from_planar(map_from_grid))
    )
    return _of("nav_msgs/msg/OccupancyGrid")(_header(0.0, frame), about, cells.ravel())
