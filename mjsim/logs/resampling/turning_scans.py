"""Times of the beams in messages of a lidar that rotates."""

from typing import Any

import numpy as np

from mjsim.geometry import Array

MAX_SCAN_SECONDS, MAX_SCAN_INTERVALS = 1.0, 1.2
"""Maximum duration of a scan, in itself and as a multiple of the interval of scans [s, 1]; other values are wrong."""


def last_beam(message: Any, stamps: Array) -> float:
    """Return when the last beam of a scan was measured, relative to its stamp [s]; 0 if that is impossible.

    Args:
        message: The first `sensor_msgs/LaserScan` of a lidar.
        stamps: Stamps of all of its scans, ascending, shape (N,) [s].
    """
    last = float(beam_times(message, len(message.ranges), reverse=False)[-1])
    longest = (
        min(MAX_SCAN_SECONDS, MAX_SCAN_INTERVALS * float(np.median(np.diff(stamps))))
        if len(stamps) > 1
        else MAX_SCAN_SECONDS
    )
    return last if abs(last) <= longest else 0.0


def beam_times(message: Any, beams: int, *, reverse: bool) -> Array:
    """Return when the beams of a scan were measured, relative to its stamp, shape (beams,) [s].

    Args:
        message: A `sensor_msgs/LaserScan`, whose stamp is that of the first beam.
        beams: Number of beams of the scan; if the message has another number, they are over the same angle.
        reverse: Whether the beams of the scan are in the opposite order.
    """
    increment = float(message.time_increment)
    last = increment * (len(message.ranges) - 1) if np.isfinite(increment) else 0.0
    times = np.linspace(0.0, last, beams)
    return times[::-1] if reverse else times
