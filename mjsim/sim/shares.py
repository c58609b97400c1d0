"""Contribution of each part of a slip to the odometry covariance, for many drives at once."""

import numpy as np

from mjsim.geometry import Array
from mjsim.sim.odometry import ARC_TIME, SmoothedAcceleration


def slip_shares(increments: Array, *, dt: float) -> Array:
    """Return the variances of (forward, left, turn) that `WheelOdometer` adds for a slip of 1, per part.

    Args:
        increments: Measured distances along the arc and to the left [m], and rotations [rad] of all ticks, shape
            (robots, ticks, 3); robots start from rest and do not move sideways.
        dt: Period of the loop [s].

    Returns:
        Shape (robots, ticks, 6, 3), parts in the order of the fields of `Slip`.
    """
    forward, turn = increments[..., 0], increments[..., 2]
    shares = np.zeros((*forward.shape, 6, 3))
    shares[..., 0, 0] = shares[..., 1, 1] = np.abs(forward)
    shares[..., 2, 2] = np.abs(turn)
    shares[..., 3, 1] = (forward * turn) ** 2 * ARC_TIME / dt**3
    shares[..., 4, 0] = _accelerations(forward, dt) ** 2 * ARC_TIME * dt
    shares[..., 5, 2] = _accelerations(turn, dt) ** 2 * ARC_TIME * dt
    return shares


def _accelerations(distances: Array, dt: float) -> Array:
    """Return smoothed accelerations of drives, shape (robots, ticks)."""
    rows = []
    for drive in distances.tolist():
        smoothed = SmoothedAcceleration(dt)
        rows.append([smoothed.add(distance) for distance in drive])
    return np.array(rows)
