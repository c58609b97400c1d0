"""Range noise of a scan, estimated from neighbours on straight walls, and smoothing of the scan."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.interface import Scan

NORMAL = 1.4826
"""Standard deviation of a normal distribution by its median absolute deviation."""
FEWEST = 20
"""Beams whose neighbours meet something too, without which a scan tells nothing of its noise."""
APART = 0.3
"""Neighbouring beams whose ranges differ by more are taken to meet different walls [m]."""
FINE = 0.02
"""Ranges are averaged until they err by no more than this [m]."""
WIDEST = 0.2
"""But over no more than this to either side [rad]."""
NEAREST = 1e-3
"""Shorter ranges are taken for this one [m]."""


def range_noise(scan: Scan) -> float:
    """Return the standard deviation of the ranges of a scan as it shows it [m]; 0 where too few beams meet walls.

    On a straight wall the inverse of the range is a cosine of the angle, so that of three neighbours the outer ones
    add up to that in the middle times twice the cosine of the angle between two beams. What is left is noise; its
    median is not moved by corners.
    """
    inverse = np.where(np.isfinite(scan.ranges), 1.0 / np.maximum(scan.ranges, NEAREST), np.nan)
    twice = 2.0 * np.cos(scan.angle_increment)
    left = inverse[:-2] + inverse[2:] - twice * inverse[1:-1]
    known = np.flatnonzero(np.isfinite(left))
    if len(known) < FEWEST:
        return 0.0
    errors = left[known] * scan.ranges[1 + known] ** 2 / np.sqrt(2.0 + twice**2)
    return float(NORMAL * np.median(np.abs(errors)))


def smoothed(scan: Scan, noise: float) -> Scan:
    """Return a scan whose ranges are averaged over neighbours on the same wall, over more of them the more they err.

    The inverse of the range is averaged, which keeps straight walls straight.

    Args:
        scan: As it came.
        noise: Standard deviation of its ranges [m].
    """
    wanted = int(np.ceil(0.5 * ((noise / FINE) ** 2 - 1.0)))
    half = min(wanted, int(WIDEST / max(abs(scan.angle_increment), 1e-6)))
    if half < 1:
        return scan
    number, beside = np.arange(len(scan.ranges)), _neighbours(scan.ranges, half, apart=max(APART, 6.0 * noise))
    inverse = np.where(np.isfinite(scan.ranges), 1.0 / np.maximum(scan.ranges, NEAREST), 0.0)
    sums, count = np.concatenate([[0.0], np.cumsum(inverse)]), 2 * beside + 1
    # Of a cosine over an even window the mean is that in the middle, less by this.
    turn = 0.5 * scan.angle_increment / np.pi
    mean = (sums[number + beside + 1] - sums[number - beside]) / count * np.sinc(turn) / np.sinc(count * turn)
    averaged = beside > 0
    return replace(scan, ranges=np.where(averaged, 1.0 / np.where(averaged, mean, 1.0), scan.ranges))


def _neighbours(ranges: Array, most: int, *, apart: float) -> NDArray[np.intp]:
    """Return how many beams on either side of each meet the same wall, shape (n,).

    As many to its right as to its left, so that none is pulled away from the end of its wall; at most `most`.
    """
    far, number = np.where(np.isfinite(ranges), ranges, np.inf), np.arange(len(ranges))
    with np.errstate(invalid="ignore"):
        another = ~(np.abs(np.diff(far)) < apart)
    wall = np.concatenate([[0], np.cumsum(another)])
    to_right = number - np.searchsorted(wall, wall, side="left")
    to_left = np.searchsorted(wall, wall, side="right") - 1 - number
    return np.asarray(np.minimum(np.minimum(to_right, to_left), most), dtype=np.intp)
