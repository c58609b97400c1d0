"""Poses of a car from GPS fixes of its antenna, with the heading from odometry."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array, wrap_angles
from mjsim.interface import Odometry

FIT_SECONDS = 20.0
"""The heading at a fix is fitted to the fixes within this time before and after it [s]."""
SCATTER = 0.5
"""Scale of the Cauchy weights: fixes farther than this from the fitted path count less [m]."""
MAX_SCALES = 4.0
"""A fix farther than this many scales from the fitted path is left out as a jump of the receiver [1]."""
MIN_SPREAD = 2.0
"""Fixes all closer than this to their centre give no heading [m]."""
MAX_ITERATIONS = 8
"""Number of iterations of the reweighted fit."""


@dataclass(frozen=True, slots=True, eq=False)
class CarPoses:
    """Poses of a car derived from GPS fixes."""

    rows: Array
    """Time [s], x, y [m] of the robot's origin and heading [rad], shape (N, 4)."""
    jumped: int
    """Number of fixes left out because they disagree with their neighbours."""


def car_poses(
    fixes: Array, steps: Sequence[Odometry], antenna: tuple[float, float], *, scatter: float = SCATTER
) -> CarPoses:
    """Return the poses of a car at fixes of its antenna.

    The path of the antenna by odometry is fitted to the fixes around each one. So the heading is also right when the
    car stands, turns, or drives backwards; the position is that of the fix itself.

    Args:
        fixes: Rows of time [s], x and y [m].
        steps: Odometry of the robot's origin from each fix to the next.
        antenna: Position of the antenna, ahead of the robot's origin and to its left [m].
        scatter: Scale of the Cauchy weights; of the order of the fixes' standard deviation [m].

    References:
        Holland, Welsch, Robust regression using iteratively reweighted least squares, Communications in Statistics
        6(9), 1977: the weights.
    """
    times, seen = fixes[:, 0], fixes[:, 1] + 1j * fixes[:, 2]
    heading = np.concatenate([[0.0], np.cumsum([step.turn for step in steps])])
    ahead = np.array([complex(step.forward, step.left) for step in steps]) * np.exp(1j * heading[:-1])
    arm = complex(*antenna)
    by_odometry = np.concatenate([[0.0], np.cumsum(ahead)]) + arm * np.exp(1j * heading)
    first = np.searchsorted(times, times - FIT_SECONDS)
    last = np.searchsorted(times, times + FIT_SECONDS, side="right")
    fits = [
        _fitted_rotation(by_odometry[a:b], seen[a:b], row - a, scatter)
        for row, (a, b) in enumerate(zip(first, last, strict=True))
    ]
    turn, residuals = np.array(fits).reshape(-1, 2).T
    heading = wrap_angles(heading + turn)
    origin = seen - arm * np.exp(1j * heading)
    good = residuals <= MAX_SCALES * scatter
    rows = np.column_stack([times, origin.real, origin.imag, heading])[good]
    return CarPoses(rows, int(np.count_nonzero(residuals > MAX_SCALES * scatter)))


def _fitted_rotation(
    by_odometry: NDArray[np.complex128], by_gps: NDArray[np.complex128], row: int, scatter: float
) -> tuple[float, float]:
    """Return the rotation that fits places by odometry to those seen [rad], and the residual of one.

    Args:
        by_odometry: Places by odometry, shape (n,), x + iy [m].
        by_gps: Places by GPS, shape (n,), x + iy [m].
        row: Index of the one.
        scatter: Scale of the weights [m].

    Returns:
        Angle and distance; NaN if the places are too close together.
    """
    weight, turn, residuals = np.ones(len(by_odometry)), 0.0, np.zeros(len(by_odometry))
    for _ in range(MAX_ITERATIONS):
        weight = weight / weight.sum()
        a, b = by_odometry - weight @ by_odometry, by_gps - weight @ by_gps
        turn = float(np.angle((weight * np.conj(a)) @ b))
        residuals = np.abs(np.exp(1j * turn) * a - b)
        weight = 1.0 / (1.0 + (residuals / scatter) ** 2)
    clear = np.abs(by_odometry - by_odometry.mean()).max() >= MIN_SPREAD
    return (turn, float(residuals[row])) if clear else (np.nan, np.nan)
