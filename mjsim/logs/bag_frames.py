"""Frames of ROS: where each is in another, as the messages of /tf and /tf_static tell."""

from collections import deque
from collections.abc import Iterable
from typing import Any

import numpy as np

from mjsim.geometry import Array, Pose3

BASES = ("base_footprint", "base_link", "base", "body")
"""What the frame of a robot is called, REP 105 and custom, where odometry does not tell."""

FARTHEST = 1e8
"""Whatever is farther from the origin is no place of a robot, along each axis [m]."""


def frame_name(name: str) -> str:
    """Return the name of a frame without the slash that ROS 1 put before it."""
    return name.lstrip("/")


def matrix_of(position: Any, orientation: Any) -> Array:
    """Return the homogeneous transform of a position [m] and a quaternion of ROS, shape (4, 4).

    Raises:
        ValueError: They are no finite numbers, as far as no robot goes, or the quaternion is not of a rotation.
    """
    values = np.array([orientation.x, orientation.y, orientation.z, orientation.w], dtype=float)
    place = np.array([position.x, position.y, position.z], dtype=float)
    length = float(np.linalg.norm(values))
    # Written so that NaN fails too.
    if not (np.abs(place) < FARTHEST).all() or not 0.5 < length < 2.0:
        raise ValueError(f"a pose of numbers {place.tolist()} and quaternion {values.tolist()}")
    return Pose3(*place.tolist(), *(values / length).tolist()).matrix()


class FrameTree:
    """Frames fixed in each other: of those that move, where they were first."""

    def __init__(self) -> None:
        """Begin without any."""
        self._inner: dict[str, dict[str, Array]] = {}

    def add(self, transforms: Iterable[Any]) -> None:
        """Take `geometry_msgs/TransformStamped`; what is told twice counts as it was first."""
        for each in transforms:
            outer, inner = frame_name(each.header.frame_id), frame_name(each.child_frame_id)
            if inner in self._inner.get(outer, {}):
                continue
            try:
                matrix = matrix_of(each.transform.translation, each.transform.rotation)
            except ValueError:
                continue
            self._inner.setdefault(outer, {})[inner] = matrix
            self._inner.setdefault(inner, {})[outer] = np.asarray(np.linalg.inv(matrix), dtype=float)

    def joined(self, other: "FrameTree") -> "FrameTree":
        """Return a tree of both; what both tell counts as it is here."""
        tree = FrameTree()
        for frame in {**other._inner, **self._inner}:
            tree._inner[frame] = {**other._inner.get(frame, {}), **self._inner.get(frame, {})}
        return tree

    def __contains__(self, frame: str) -> bool:
        """Return whether anything is known of a frame."""
        return frame in self._inner

    def base(self, namespace: str) -> str | None:
        """Return the frame of a robot by its usual names, None if there is none."""
        names = [f"{namespace}/{base}" for base in BASES if namespace] + list(BASES)
        return next((name for name in names if name in self._inner), None)

    def between(self, outer: str, inner: str) -> Array | None:
        """Return outer_from_inner, shape (4, 4) [m]; None where no chain of frames leads there."""
        found: dict[str, Array] = {outer: np.eye(4)}
        waiting = deque([outer])
        while waiting and inner not in found:
            frame = waiting.popleft()
            for following, matrix in self._inner.get(frame, {}).items():
                if following not in found:
                    found[following] = found[frame] @ matrix
                    waiting.append(following)
        return found.get(inner)
