"""What Foxglove draws: the map, the frames, and the pictures, as its own messages."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from foxglove.messages import (
    CameraCalibration,
    Color,
    CompressedImage,
    CubePrimitive,
    FrameTransform,
    FrameTransforms,
    LaserScan,
    Point3,
    Quaternion,
    SceneEntity,
    SceneUpdate,
    TextPrimitive,
    Timestamp,
    TriangleListPrimitive,
    Vector3,
)
from foxglove.messages import Pose as Pose3
from numpy.typing import NDArray

from mjsim.geometry import Array, Pose
from mjsim.interface import CameraFrame, Intrinsics, Scan
from mjsim.record.messages import nanoseconds
from mjsim.world import World
from mjsim.world.hung import Hung, hung
from mjsim.world.plan import footprint, top, wall_pieces
from mjsim.world.things import Beacon

JPEG_QUALITY = 90
_BEACON_THICKNESS = 0.02
"""As drawn in the map [m]."""
_BEACON_COLOR = "#2f6fd0"


def stamp(time: float) -> Timestamp:
    """Return a simulated time as Foxglove's messages hold it."""
    return Timestamp(*divmod(nanoseconds(time), 1_000_000_000))


def _color(text: str) -> Color:
    r, g, b = (int(text[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return Color(r=r, g=g, b=b, a=1.0)


def _turned(heading: float) -> Quaternion:
    return Quaternion(z=math.sin(heading / 2), w=math.cos(heading / 2))


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
        pose=Pose3(position=Vector3(), orientation=Quaternion(w=1.0)),
        start_angle=scan.angle_min,
        end_angle=scan.angle_min + scan.angle_increment * (len(scan.ranges) - 1),
        ranges=scan.ranges.tolist(),
        intensities=None if scan.intensities is None else scan.intensities.tolist(),
    )


def calibration_message(intrinsics: Intrinsics, frame_id: str) -> CameraCalibration:
    """Return a camera's calibration, without distortion."""
    K = intrinsics.matrix()
    return CameraCalibration(
        timestamp=stamp(0.0),
        frame_id=frame_id,
        width=intrinsics.width,
        height=intrinsics.height,
        distortion_model="plumb_bob",
        D=[0.0] * 5,
        K=K.ravel().tolist(),
        R=np.eye(3).ravel().tolist(),
        P=np.hstack([K, np.zeros((3, 1))]).ravel().tolist(),
    )


@dataclass(frozen=True, slots=True, eq=False)
class Mount:
    """A frame that is fixed in another."""

    outer: str
    inner: str
    translation: Vector3
    """[m]"""
    rotation: Quaternion


def mount(outer: str, inner: str, outer_from_inner: Array) -> Mount:
    """Return the mount of a homogeneous transform, shape (4, 4) [m]."""
    x, y, z = outer_from_inner[:3, 3].tolist()
    qx, qy, qz, qw = quaternion(outer_from_inner[:3, :3]).tolist()
    return Mount(outer, inner, Vector3(x=x, y=y, z=z), Quaternion(x=qx, y=qy, z=qz, w=qw))


def frames_message(time: float, poses: Mapping[str, Pose], mounts: Sequence[Mount]) -> FrameTransforms:
    """Return all frames at a simulated time [s]: those with a pose in the world, and those fixed in them."""
    now = stamp(time)
    moving = [
        FrameTransform(
            timestamp=now,
            parent_frame_id="world",
            child_frame_id=name,
            translation=Vector3(x=float(pose.x), y=float(pose.y)),
            rotation=_turned(pose.heading),
        )
        for name, pose in poses.items()
    ]
    fixed = [
        FrameTransform(
            timestamp=now,
            parent_frame_id=item.outer,
            child_frame_id=item.inner,
            translation=item.translation,
            rotation=item.rotation,
        )
        for item in mounts
    ]
    return FrameTransforms(transforms=moving + fixed)


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


def map_update(world: World, files: Mapping[str, bytes]) -> SceneUpdate:
    """Return walls, obstacles and the beacons that stay as a scene at the start.

    Args:
        world: Of the recording.
        files: The pictures that it names.
    """
    walls = [
        _prism(piece.outline, piece.low, piece.high, wall.color) for wall in world.walls for piece in wall_pieces(wall)
    ]
    obstacles = [_prism(footprint(item), item.elevation, top(item), item.color) for item in world.obstacles]
    return SceneUpdate(
        entities=[
            SceneEntity(timestamp=stamp(0.0), frame_id="world", id="walls", triangles=walls),
            SceneEntity(timestamp=stamp(0.0), frame_id="world", id="obstacles", triangles=obstacles),
            SceneEntity(
                timestamp=stamp(0.0),
                frame_id="world",
                id="beacons",
                cubes=[
                    CubePrimitive(
                        pose=_pose_of(item),
                        size=Vector3(x=_BEACON_THICKNESS, y=item.beacon.width, z=_height(item.beacon, files)),
                        color=_color(_BEACON_COLOR),
                    )
                    for item in hung(world)
                    if item.fixed
                ],
                texts=[
                    TextPrimitive(
                        pose=_pose_of(item),
                        billboard=True,
                        font_size=12.0,
                        scale_invariant=True,
                        color=_color("#000000"),
                        text=item.beacon.name,
                    )
                    for item in hung(world)
                    if item.fixed
                ],
            ),
        ]
    )


def _height(beacon: Beacon, files: Mapping[str, bytes]) -> float:
    """Return the height of a beacon as drawn in the map [m], of its picture read at an eighth of its size."""
    data = files.get(beacon.image) if beacon.image is not None else None
    small = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), cv2.IMREAD_REDUCED_GRAYSCALE_8) if data else None
    return beacon.width if small is None else float(beacon.width * small.shape[0] / small.shape[1])


def _pose_of(item: Hung) -> Pose3:
    """Return where a beacon hangs: x to where it faces, z up."""
    turn, tilt = item.place.heading / 2, -math.radians(item.beacon.tilt_deg) / 2
    c, s, cos_tilt, sin_tilt = math.cos(turn), math.sin(turn), math.cos(tilt), math.sin(tilt)
    return Pose3(
        position=Vector3(x=float(item.place.x), y=float(item.place.y), z=item.center),
        orientation=Quaternion(x=-s * sin_tilt, y=c * sin_tilt, z=s * cos_tilt, w=c * cos_tilt),
    )


def _prism(outline: Array, low: float, high: float, color: str) -> TriangleListPrimitive:
    corners, triangles = prism(outline, low, high)
    return TriangleListPrimitive(
        points=[Point3(x=x, y=y, z=z) for x, y, z in corners.tolist()],
        color=_color(color),
        indices=triangles.ravel().tolist(),
    )


def prism(outline: Array, low: float, high: float) -> tuple[Array, NDArray[np.int64]]:
    """Return the mesh of an upright prism.

    Args:
        outline: Convex, counter-clockwise, shape (n, 2) [m].
        low: Height of its lower face [m].
        high: Of its upper face [m].

    Returns:
        corners: Shape (2 n, 3) [m], the lower ones first.
        triangles: Indices of corners, counter-clockwise from outside, shape (4 n - 4, 3).
    """
    n = len(outline)
    corners = np.vstack([np.column_stack([outline, np.full(n, z)]) for z in (low, high)])
    faces = []
    for i in range(n):
        j = (i + 1) % n
        faces += [(i, j, n + j), (i, n + j, n + i)]
    for i in range(1, n - 1):
        faces += [(n, n + i, n + i + 1), (0, i + 1, i)]
    return corners, np.array(faces)
