"""Putting free bodies elsewhere."""

import math
from collections.abc import Sequence

import mujoco
import numpy as np

from mjsim.geometry import Array


def put_down(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    joint: str,
    to: Sequence[float],
    *,
    height: float | None,
    heading: float | None,
) -> int:
    """Move a free body elsewhere, with all its parts at rest; its wheels keep their angles.

    Args:
        model: The compiled world.
        data: Its state.
        joint: Name of the free joint.
        to: Where to, x and y [m].
        height: Height of its frame [m]; None for that in the compiled world.
        heading: [rad]; None for the current one.

    Returns:
        The root body of what was moved.
    """
    found = model.joint(joint)
    start = int(found.qposadr[0])
    if heading is None:
        heading = heading_of(_matrix(data.qpos[start + 3 : start + 7]))
    data.qpos[start : start + 2] = to
    data.qpos[start + 2] = model.qpos0[start + 2] if height is None else height
    data.qpos[start + 3 : start + 7] = [math.cos(heading / 2), 0.0, 0.0, math.sin(heading / 2)]
    root = int(model.body_rootid[model.jnt_bodyid[found.id]])
    data.qvel[model.body_rootid[model.dof_bodyid] == root] = 0.0
    return root


def heading_of(matrix: Array) -> float:
    """Return the heading of a body's x axis from above [rad]; its rotation matrix has shape (9,)."""
    return math.atan2(float(matrix[3]), float(matrix[0]))


def _matrix(quaternion: Array) -> Array:
    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, quaternion)
    return matrix
