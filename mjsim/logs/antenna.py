"""Poses of a car from GPS fixes of its antenna, with the heading from odometry."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array, wrap_angles
from mjsim.interface import Odometry

AROUND = 20.0
"""Fixes so long before and after one tell, with the way by odometry, how the car was turned [s]."""
SCATTER = 0.5
"""A fix farther from that way than this counts less, as of a Cauchy distribution [m]."""
FARTHEST = 2.0
"""A fix farther from it than this is left out: the receiver has jumped [m]."""
SHORTEST = 2.0
"""Fixes that all lie nearer to their middle than this tell no heading [m]."""
ROUNDS = 8
"""So often the way is laid on the fixes, each time with the weights that the last one gives."""


@dataclass(frozen=True, slots=True, eq=False)
class CarPoses:
    """What fixes tell of a car."""

    rows: Array
    """Time [s], x, y [m] of the robot's origin and heading [rad], shape (N, 4)."""
    jumped: int
    """Fixes that were left out because they are far from where the fixes around them have the car."""


def car_poses(fixes: Array, steps: Sequence[Odometry], antenna: tuple[float, float]) -> CarPoses:
    """Return where a car was, and how it was turned, at fixes of its antenna.

    The way of the antenna by odometry is laid on the fixes around each one. So a car that stands, turns, or goes
    backwards has the right heading too; the place is that of the fix itself.

    Args:
        fixes: Rows of time [s], x and y [m].
        steps: By odometry of the robot's origin from each fix to the next.
        antenna: Ahead of the robot's origin and to its left [m].

    References:
        Holland, Welsch, Robust regression using iteratively reweighted least squares, Communications in Statistics
        6(9), 1977: the weights.
    """
    times, seen = fixes[:, 0], fixes[:, 1] + 1j * fixes[:, 2]
    heading = np.concatenate([[0.0], np.cumsum([step.turn for step in steps])])
    ahead = np.array([complex(step.forward, step.left) for step in steps]) * np.exp(1j * heading[:-1])
    arm = complex(*antenna)
    told = np.concatenate([[0.0], np.cumsum(ahead)]) + arm * np.exp(1j * heading)
    first = np.searchsorted(times, times - AROUND)
    last = np.searchsorted(times, times + AROUND, side="right")
    laid = [_laid(told[a:b], seen[a:b], row - a) for row, (a, b) in enumerate(zip(first, last, strict=True))]
    turn, off = np.array(laid).reshape(-1, 2).T
    heading = wrap_angles(heading + turn)
    origin = seen - arm * np.exp(1j * heading)
    good = off <= FARTHEST
    rows = np.column_stack([times, origin.real, origin.imag, heading])[good]
    return CarPoses(rows, int(np.count_nonzero(off > FARTHEST)))


def _laid(told: NDArray[np.complex128], seen: NDArray[np.complex128], row: int) -> tuple[float, float]:
    """Return by how much places that odometry tells must be turned to lie on those seen [rad], and how far one is off.

    Args:
        told: Shape (n,), x + iy [m].
        seen: Shape (n,), x + iy [m].
        row: Number of the one.

    Returns:
        Angle and distance; NaN where the places lie too near to each other to tell.
    """
    weight, turn, off = np.ones(len(told)), 0.0, np.zeros(len(told))
    for _ in range(ROUNDS):
        weight = weight / weight.sum()
        a, b = told - weight @ told, seen - weight @ seen
        turn = float(np.angle((weight * np.conj(a)) @ b))
        off = np.abs(np.exp(1j * turn) * a - b)
        weight = 1.0 / (1.0 + (off / SCATTER) ** 2)
    clear = np.abs(told - told.mean()).max() >= SHORTEST
    return (turn, float(off[row])) if clear else (np.nan, np.nan)
