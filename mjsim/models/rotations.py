"""Rotations in MuJoCo's terms."""

import mujoco
import numpy as np

from mjsim.geometry import Array


def quaternion_of(rotation: Array) -> Array:
    """Return the quaternion (w, x, y, z) of a rotation, shape (3, 3) -> (4,)."""
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(rotation).ravel())
    return quaternion


def matrix_of(quaternion: Array) -> Array:
    """Return the rotation of a unit quaternion (w, x, y, z), shape (4,) -> (3, 3)."""
    rotation = np.empty(9)
    mujoco.mju_quat2Mat(rotation, quaternion)
    return rotation.reshape(3, 3)


def pose_keys(pose: Array) -> dict[str, Array]:
    """Return the keys `pos` [m] and `quat` of a body, camera or geom at a pose, shape (4, 4)."""
    return {"pos": pose[:3, 3], "quat": quaternion_of(pose[:3, :3])}


def frame_at(place: Array, turn: Array) -> Array:
    """Return the transform, shape (4, 4), of a place, shape (3,), and the nine numbers of a rotation."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn.reshape(3, 3), place
    return pose
