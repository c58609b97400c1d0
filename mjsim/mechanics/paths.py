"""Smooth paths of joints and of tools over given times.

References:
    Corke, Robotics, Vision and Control (2017), sections 3.3 and 7.3; Lynch and Park (2017), section 9.2.
"""

import numpy as np
from numpy.typing import ArrayLike

from mjsim.geometry import Array
from mjsim.mechanics.transforms import is_rigid, rotation_of, rotation_vector
from mjsim.sentences import Sentence


def jtraj(
    q0: ArrayLike, q1: ArrayLike, t: ArrayLike, *, qd0: ArrayLike = 0.0, qd1: ArrayLike = 0.0
) -> tuple[Array, Array, Array]:
    """Return values, rates and accelerations along quintics from one posture to another.

    Accelerations are 0 at both ends, rates as given. The path starts at the first of the times and ends at the last.

    Args:
        q0: Start, shape (..., n) [rad, m].
        q1: End, the same shape.
        t: Increasing times, shape (k,) [s]; an integer k of at least 2 stands for k times from 0 to 1.
        qd0: Rates at the start, shape (n,) or one number [rad/s, m/s].
        qd1: Rates at the end, likewise.

    Returns:
        q, qd, qdd: Shape (..., k, n) each [rad, m], [rad/s, m/s], [rad/s^2, m/s^2].

    Raises:
        ValueError: The times do not increase, or shapes do not match.
    """
    times = _times(t)
    length = times[-1] - times[0]
    s = ((times - times[0]) / length)[:, None]
    first, last = (np.asarray(q, dtype=float)[..., None, :] for q in (q0, q1))
    v0, v1 = (np.asarray(qd, dtype=float) * length for qd in (qd0, qd1))
    displacement = last - first
    a, b, c = (
        6 * displacement - 3 * (v1 + v0),
        -15 * displacement + 8 * v0 + 7 * v1,
        10 * displacement - 6 * v0 - 4 * v1,
    )
    q = ((((a * s + b) * s + c) * s * s) + v0) * s + first
    qd = ((((5 * a * s + 4 * b) * s + 3 * c) * s * s) + v0) / length
    qdd = ((20 * a * s + 12 * b) * s + 6 * c) * s / length**2
    return q, qd, qdd


def ctraj(T0: ArrayLike, T1: ArrayLike, t: ArrayLike) -> Array:
    """Return poses of a tool along a straight line, turning about one axis, both with a quintic's speed.

    Args:
        T0: Start, outer_from_tool, shape (4, 4) [m].
        T1: End, in the same frame, shape (4, 4).
        t: As for `jtraj`, k times [s].

    Returns:
        Poses in the same frame, shape (k, 4, 4). The tool turns the shorter way.

    Raises:
        ValueError: The times do not increase, or a matrix is not a pose.
    """
    first, last = (np.asarray(pose, dtype=float) for pose in (T0, T1))
    for name, pose in (("T0", first), ("T1", last)):
        if pose.shape != (4, 4) or not is_rigid(pose):
            raise ValueError(Sentence("{name} is not a pose; give a homogeneous transform of shape (4, 4)", name))
    share, _, _ = jtraj([0.0], [1.0], t)
    turn = rotation_vector(first[:3, :3].T @ last[:3, :3])
    poses = np.zeros((len(share), 4, 4))
    poses[:, :3, :3] = first[:3, :3] @ rotation_of(share * turn)
    poses[:, :3, 3] = first[:3, 3] + share * (last[:3, 3] - first[:3, 3])
    poses[:, 3, 3] = 1.0
    return poses


def _times(t: ArrayLike) -> Array:
    times = np.asarray(t, dtype=float)
    if times.ndim == 0:
        times = np.linspace(0.0, 1.0, max(int(times), 0))
    if times.ndim != 1 or times.size < 2 or not np.isfinite(times).all() or not (np.diff(times) > 0.0).all():
        raise ValueError("t must hold at least two finite times [s], each later than the one before")
    return times
