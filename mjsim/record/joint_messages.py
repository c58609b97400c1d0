"""The true motion of joints: messages of each arm, and their rows in a recording."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array, Pose3
from mjsim.mechanics import JointMotion
from mjsim.record.json_messages import pose3_row, truth_message
from mjsim.record.numbers import Message, flat, stamp_json
from mjsim.sentences import Sentence

KEYS = ("positions", "velocities", "accelerations", "torques", "goal")
"""Keys of lists in a message, with one number per joint."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class JointTrack:
    """Recorded motion of the joints of an arm. One row per tick, N in all; NaN where nothing was recorded.

    Angles in rad and torques in N m; m and N for prismatic joints.
    """

    names: tuple[str, ...]
    """Names of n joints."""
    positions: Array
    """Shape (N, n)."""
    velocities: Array
    """Shape (N, n) [1/s]."""
    accelerations: Array
    """Shape (N, n) [1/s^2]."""
    torques: Array
    """Motor torques, on the side of the joint, shape (N, n)."""
    goal: Array
    """Set-points, shape (N, n)."""
    tool: Array
    """Position and unit quaternion (x, y, z, qx, qy, qz, qw) of the tool, world frame, shape (N, 7) [m]; NaN for the
    wheels of a base."""

    def at(self, rows: NDArray[np.intp]) -> "JointTrack":
        """Return the track at some rows."""
        parts = {key: getattr(self, key)[rows] for key in (*KEYS, "tool")}
        return JointTrack(names=self.names, **parts)


def joint_messages(time: float, motions: Mapping[str, JointMotion]) -> list[tuple[str, Message]]:
    """Return the topics and messages of all arms at a tick; motions by `ROBOT/ARM`."""
    messages: list[tuple[str, Message]] = []
    for name, motion in motions.items():
        joints = {"time": time, "names": list(motion.names)} | {key: flat(getattr(motion, key)) for key in KEYS}
        messages.append((f"/{name}/joints", joints))
        if motion.tool is not None:
            pose = Pose3.from_matrix(motion.tool)
            messages.append((f"/{name}/tool", truth_message(time, pose.planar(), pose)))
    return [*messages, *_state_messages(time, motions)]


def _state_messages(time: float, motions: Mapping[str, JointMotion]) -> list[tuple[str, Message]]:
    """Return a topic and a message for each robot or mechanism, with the fields of `foxglove.JointStates`."""
    states: dict[str, list[Message]] = {}
    for name, motion in motions.items():
        owner, _, part = name.partition("/")
        values = (motion.positions, motion.velocities, motion.accelerations, motion.torques)
        for joint, *row in zip(motion.names, *map(flat, values), strict=True):
            values_by_name = dict(zip(("position", "velocity", "acceleration", "effort"), row, strict=True))
            states.setdefault(owner, []).append({"name": f"{part}/{joint}" if part else joint, **values_by_name})
    return [
        (f"/{owner}/joint_states", {"time": time, "timestamp": stamp_json(time), "joints": joints})
        for owner, joints in states.items()
    ]


class JointRows:
    """Collects the rows of one arm while a recording is read."""

    def __init__(self, names: tuple[str, ...]) -> None:
        """Start with no rows.

        Args:
            names: Names of its joints.
        """
        self._names, self._rows = names, list[list[float]]()
        self._nothing = [np.nan] * (len(names) * len(KEYS) + 7)
        self._now: dict[str, list[float]] = {}

    @property
    def width(self) -> int:
        """Numbers in a row."""
        return len(self._nothing)

    def take(self, kind: str, message: Message) -> None:
        """Take a message on 'joints' or 'tool'; raises ValueError if it has other joints."""
        if kind == "tool":
            self._now[kind] = list(pose3_row(message))
            return
        if any(len(message[key]) != len(self._names) for key in KEYS):
            raise ValueError(Sentence("the arm has {count} joints", len(self._names)))
        self._now[kind] = [value for key in KEYS for value in message[key]]

    def end_tick(self) -> None:
        """Add a row; NaN for missing messages."""
        count = len(self._nothing) - 7
        joints, tool = self._now.get("joints", self._nothing[:count]), self._now.get("tool", self._nothing[count:])
        self._rows.append([*joints, *tool])
        self._now = {}

    def track(self) -> JointTrack:
        """Return everything as arrays."""
        rows, count = np.array(self._rows).reshape(-1, self.width), len(self._names)
        parts = {key: rows[:, place * count : (place + 1) * count] for place, key in enumerate(KEYS)}
        return JointTrack(names=self._names, tool=rows[:, -7:], **parts)
