"""Frames of ROS: their relative poses from the messages of /tf and /tf_static."""

import math
from collections import deque
from collections.abc import Iterable
from typing import Any

import numpy as np

from mjsim.geometry import Array, Pose3
from mjsim.logs.resampling import Mount

BASE_FRAMES = ("base_footprint", "base_link", "base", "body")
"""Usual names of a robot's frame (REP 105 and custom), used if odometry does not name it."""

MAX_COORDINATE = 1e8
"""Maximum distance of a valid position from the origin, along each axis [m]."""


def frame_name(name: str) -> str:
    """Return the name of a frame without the leading slash of ROS 1."""
    return name.lstrip("/")


def is_odometry(outer: str, inner: str) -> bool:
    """Return whether the inner frame's pose may be odometry: the outer one is of odometry, the inner is no map."""
    frame, robot = outer.rpartition("/")[2], inner.rpartition("/")[2]
    return "odom" in frame and not any(word in robot for word in ("odom", "map", "world"))


def is_base(frame: str) -> bool:
    """Return whether a frame has a usual name of a robot's frame."""
    return frame.rpartition("/")[2] in BASE_FRAMES


def matrix_of(position: Any, orientation: Any) -> Array:
    """Return the homogeneous transform of a position [m] and a quaternion of ROS, shape (4, 4).

    Raises:
        ValueError: They are not finite, too far from the origin, or the quaternion is not a rotation.
    """
    values = np.array([orientation.x, orientation.y, orientation.z, orientation.w], dtype=float)
    place = np.array([position.x, position.y, position.z], dtype=float)
    # Written so that NaN fails too; the square of a huge number would overflow.
    length = float(np.linalg.norm(values)) if (np.abs(values) < 2.0).all() else 0.0
    if not (np.abs(place) < MAX_COORDINATE).all() or not 0.5 < length < 2.0:
        raise ValueError(f"a pose of numbers {place.tolist()} and quaternion {values.tolist()}")
    return Pose3(*place.tolist(), *(values / length).tolist()).matrix()


def mount_of(place: Array) -> Mount:
    """Return the mount of a sensor: its position, and the direction of its x axis, from robot_from_sensor [m]."""
    x, y, z = place[:3, 3].tolist()
    return Mount(at=(x, y, z), yaw=math.atan2(place[1, 0], place[0, 0]))


def level_mount(place: Array) -> Mount:
    """Return the mount of a sensor whose readings are rotated to the axes of the robot, from robot_from_sensor [m]."""
    x, y, z = place[:3, 3].tolist()
    return Mount(at=(x, y, z))


class FrameTree:
    """Relative poses of frames; for moving frames the first pose, for fixed ones the last, as in ROS."""

    def __init__(self) -> None:
        """Start without frames."""
        self._inner: dict[str, dict[str, Array]] = {}

    def add(self, transforms: Iterable[Any], *, fixed: bool) -> None:
        """Add each `geometry_msgs/TransformStamped` of a message.

        Args:
            transforms: Transforms of the message.
            fixed: Whether frames do not move, so that a later pose is a correction.
        """
        for each in transforms:
            outer, inner = frame_name(each.header.frame_id), frame_name(each.child_frame_id)
            if inner in self._inner.get(outer, {}) and not fixed:
                continue
            try:
                matrix = matrix_of(each.transform.translation, each.transform.rotation)
            except ValueError:
                continue
            self._inner.setdefault(outer, {})[inner] = matrix
            self._inner.setdefault(inner, {})[outer] = np.asarray(np.linalg.inv(matrix), dtype=float)

    def joined(self, other: "FrameTree") -> "FrameTree":
        """Return a tree of both; this one has priority."""
        tree = FrameTree()
        for frame in {**other._inner, **self._inner}:
            tree._inner[frame] = {**other._inner.get(frame, {}), **self._inner.get(frame, {})}
        return tree

    def __contains__(self, frame: str) -> bool:
        """Return whether a frame is known."""
        return frame in self._inner

    def base(self, namespace: str) -> str | None:
        """Return the frame of a robot by its usual names, None if there is none."""
        names = [f"{namespace}/{base}" for base in BASE_FRAMES if namespace] + list(BASE_FRAMES)
        return next((name for name in names if name in self._inner), None)

    def between(self, outer: str, inner: str) -> Array | None:
        """Return outer_from_inner, shape (4, 4) [m]; None if the frames are not connected."""
        found: dict[str, Array] = {outer: np.eye(4)}
        waiting = deque([outer])
        while waiting and inner not in found:
            frame = waiting.popleft()
            for following, matrix in self._inner.get(frame, {}).items():
                if following not in found:
                    found[following] = found[frame] @ matrix
                    waiting.append(following)
        return found.get(inner)
