"""Messages that Foxglove draws: frames, pictures and scans; for the map see `map`."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import cv2
import numpy as np
from foxglove.messages import (
    CameraCalibration,
    CompressedImage,
    FrameTransform,
    FrameTransforms,
    LaserScan,
    Quaternion,
    Timestamp,
    Vector3,
)
from foxglove.messages import Pose as FoxglovePose

from mjsim.geometry import Array, Pose, Pose3
from mjsim.interface import CameraFrame, Intrinsics, Scan
from mjsim.record.numbers import nanoseconds

JPEG_QUALITY = 90


def stamp(time: float) -> Timestamp:
    """Return a simulated time in Foxglove's format."""
    return Timestamp(*divmod(nanoseconds(time), 1_000_000_000))


def picture_message(frame: CameraFrame, frame_id: str) -> CompressedImage:
    """Return a camera's picture as JPEG."""
    _, data = cv2.imencode(
        ".jpg", cv2.cvtColor(frame.image, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY]
    )
    return CompressedImage(timestamp=stamp(frame.stamp), frame_id=frame_id, data=data.tobytes(), format="jpeg")


def laser_message(scan: Scan, frame_id: str) -> LaserScan:
    """Return a lidar's scan; its frame has x ahead and y to the left."""
    return LaserScan(
        timestamp=stamp(scan.stamp),
        frame_id=frame_id,
        pose=FoxglovePose(position=Vector3(), orientation=Quaternion(w=1.0)),
        start_angle=scan.angle_min,
        end_angle=scan.angle_min + scan.angle_increment * (len(scan.ranges) - 1),
        ranges=scan.ranges.tolist(),
        intensities=None if scan.intensities is None else scan.intensities.tolist(),
    )


def calibration_message(intrinsics: Intrinsics, frame_id: str) -> CameraCalibration:
    """Return a camera's calibration, by which Foxglove rectifies pictures."""
    K, polynomial = intrinsics.matrix(), "rational_polynomial" if intrinsics.is_rational() else "plumb_bob"
    return CameraCalibration(
        timestamp=stamp(0.0),
        frame_id=frame_id,
        width=intrinsics.width,
        height=intrinsics.height,
        distortion_model="kannala_brandt" if intrinsics.lens == "fisheye" else polynomial,
        D=intrinsics.coefficients(),
        K=K.ravel().tolist(),
        R=np.eye(3).ravel().tolist(),
        P=np.hstack([K, np.zeros((3, 1))]).ravel().tolist(),
    )


@dataclass(frozen=True, slots=True, eq=False)
class FixedFrame:
    """A frame that is fixed in another frame."""

    outer: str
    inner: str
    translation: Vector3
    """[m]"""
    rotation: Quaternion


def mount(outer: str, inner: str, outer_from_inner: Array) -> FixedFrame:
    """Return the mount of a homogeneous transform, shape (4, 4) [m]."""
    x, y, z = outer_from_inner[:3, 3].tolist()
    qx, qy, qz, qw = quaternion(outer_from_inner[:3, :3]).tolist()
    return FixedFrame(outer, inner, Vector3(x=x, y=y, z=z), Quaternion(x=qx, y=qy, z=qz, w=qw))


def frames_message(
    time: float,
    poses: Mapping[str, Pose | Pose3],
    mounts: Sequence[FixedFrame],
    *,
    moments: Mapping[str, float] = MappingProxyType({}),
) -> FrameTransforms:
    """Return all frames: those with a pose in the world, and those fixed in them.

    Args:
        time: Time of the poses, simulated [s].
        poses: Poses by the names of frames.
        mounts: Frames fixed in these.
        moments: Time of the frames 'ROBOT/...' by robot, if it is not that of the others [s].
    """
    stamps = {robot: stamp(moment) for robot, moment in moments.items()}
    now = stamp(time)
    moving = [
        FrameTransform(
            timestamp=stamps.get(name.partition("/")[0], now),
            parent_frame_id="world",
            child_frame_id=name,
            translation=_translation(pose),
            rotation=_rotation(pose),
        )
        for name, pose in poses.items()
    ]
    fixed = [
        FrameTransform(
            timestamp=stamps.get(item.outer.partition("/")[0], now),
            parent_frame_id=item.outer,
            child_frame_id=item.inner,
            translation=item.translation,
            rotation=item.rotation,
        )
        for item in mounts
    ]
    return FrameTransforms(transforms=moving + fixed)


def _translation(pose: Pose | Pose3) -> Vector3:
    if isinstance(pose, Pose3):
        return Vector3(x=pose.x, y=pose.y, z=pose.z)
    return Vector3(x=float(pose.x), y=float(pose.y))


def _rotation(pose: Pose | Pose3) -> Quaternion:
    if isinstance(pose, Pose3):
        return Quaternion(x=pose.qx, y=pose.qy, z=pose.qz, w=pose.qw)
    half = pose.heading / 2
    return Quaternion(z=math.sin(half), w=math.cos(half))


def quaternion(rotation: Array) -> Array:
    """Return the unit quaternion (x, y, z, w) of a rotation matrix, shape (3, 3) -> (4,).

    References:
        Bar-Itzhack, J. Guidance 23(6), 2000: the eigenvector of the largest eigenvalue of a symmetric 4 x 4 matrix.
    """
    (a, b, c), (d, e, f), (g, h, i) = rotation.tolist()
    K = np.array(
        [
            [a - e - i, b + d, c + g, h - f],
            [b + d, e - a - i, f + h, c - g],
            [c + g, f + h, i - a - e, d - b],
            [h - f, c - g, d - b, a + e + i],
        ]
    )
    return np.asarray(np.linalg.eigh(K)[1][:, -1])
