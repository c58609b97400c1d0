"""Range noise of a scan, estimated from neighbours on straight walls, and smoothing of the scan."""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.interface import Scan

NORMAL = 1.4826
"""Standard deviation of a normal distribution divided by its median absolute deviation."""
FEWEST = 20
"""Minimum number of beams with neighbours that also hit something, for an estimate of the noise."""
MAX_STEP = 0.3
"""Neighbouring beams whose ranges differ by more are assumed to hit different walls [m]."""
FINE = 0.02
"""Ranges are averaged until their noise is at most this [m]."""
WIDEST = 0.2
"""Maximum angle over which ranges are averaged to either side [rad]."""
NEAREST = 1e-3
"""Shorter ranges count as this [m]."""


def range_noise(scan: Scan) -> float:
    """Estimate the standard deviation of the ranges of a scan [m]; 0 if too few beams hit walls.

    On a straight wall the inverse of the range is a cosine of the angle, so the sum of the outer two of three
    neighbours is that of the middle one times twice the cosine of the angle between two beams. The residual is noise;
    its median is robust to corners.
    """
    hit, inverse = np.isfinite(scan.ranges), 1.0 / np.maximum(scan.ranges, NEAREST)
    twice = 2.0 * math.cos(scan.angle_increment)
    known = np.flatnonzero(hit[:-2] & hit[1:-1] & hit[2:])
    if len(known) < FEWEST:
        return 0.0
    left = (inverse[:-2] + inverse[2:] - twice * inverse[1:-1])[known]
    errors = np.abs(left) * scan.ranges[1 + known] ** 2
    return NORMAL * median(errors) / math.sqrt(2.0 + twice**2)


def smoothed(scan: Scan, noise: float) -> Scan:
    """Return a scan with ranges averaged over neighbours on the same wall, over more of them for larger noise.

    The inverse of the range is averaged, which keeps straight walls straight.

    Args:
        scan: The original scan.
        noise: Standard deviation of its ranges [m].
    """
    needed = math.ceil(0.5 * ((noise / FINE) ** 2 - 1.0))
    half = min(needed, int(WIDEST / max(abs(scan.angle_increment), 1e-6)))
    if half < 1:
        return scan
    number, beside = np.arange(len(scan.ranges)), _neighbours(scan.ranges, half, max_step=max(MAX_STEP, 6.0 * noise))
    inverse = np.where(np.isfinite(scan.ranges), 1.0 / np.maximum(scan.ranges, NEAREST), 0.0)
    sums, count = np.concatenate([[0.0], np.cumsum(inverse)]), 2 * beside + 1
    # The mean of a cosine over a symmetric window is its value in the middle times this.
    turn = 0.5 * scan.angle_increment / np.pi
    mean = (sums[number + beside + 1] - sums[number - beside]) / count * np.sinc(turn) / np.sinc(count * turn)
    averaged = beside > 0
    return replace(scan, ranges=np.where(averaged, 1.0 / np.where(averaged, mean, 1.0), scan.ranges))


def median(values: Array) -> float:
    """Return the median of values (n,), at least one; for few values, several times faster than that of NumPy."""
    middle = len(values) // 2
    if len(values) % 2:
        return float(np.partition(values, middle)[middle])
    return float(np.partition(values, (middle - 1, middle))[middle - 1 : middle + 1].mean())


def _neighbours(ranges: Array, limit: int, *, max_step: float) -> NDArray[np.intp]:
    """Return the number of beams on either side of each that hit the same wall, shape (n,).

    The number is the same on both sides, so that averages are not shifted at the end of a wall; at most `limit`.
    """
    far, number = np.where(np.isfinite(ranges), ranges, np.inf), np.arange(len(ranges))
    with np.errstate(invalid="ignore"):
        another = ~(np.abs(np.diff(far)) < max_step)
    wall = np.concatenate([[0], np.cumsum(another)])
    to_right = number - np.searchsorted(wall, wall, side="left")
    to_left = np.searchsorted(wall, wall, side="right") - 1 - number
    return np.asarray(np.minimum(np.minimum(to_right, to_left), limit), dtype=np.intp)
