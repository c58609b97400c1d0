"""Localisation error over time: the transient, and the recovery after a robot was lifted (kidnapped)."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from mjsim.geometry import Array

RUN_PARTS = 10
"""Number of parts of a run."""
MAX_RECOVERED_ERROR = 0.5
"""A lifted robot is localised again when its position error stays below this [m]."""


def transient_errors(time: Array, position: Array, heading: Array) -> dict[str, list[float]]:
    """Return the mean errors in each tenth of a run; a run with fewer ticks has fewer parts.

    Args:
        time: Time of each tick, shape (N,) [s].
        position: Position errors, shape (N,) [m].
        heading: Absolute heading errors, shape (N,) [deg].

    Returns:
        `until_s`, the end of each part, `position_error_m` and `heading_error_deg`, its mean errors.
    """
    parts = np.array_split(np.arange(len(time)), min(RUN_PARTS, len(time)))
    return {
        "until_s": [float(time[rows[-1]]) for rows in parts],
        "position_error_m": [float(position[rows].mean()) for rows in parts],
        "heading_error_deg": [float(heading[rows].mean()) for rows in parts],
    }


def recoveries(time: Array, position: Array, lifted: Sequence[float]) -> list[dict[str, Any]]:
    """Return the time that the estimate took to recover after each lift.

    Args:
        time: Time of each tick, shape (N,) [s].
        position: Position errors, shape (N,) [m].
        lifted: Times of the lifts [s].

    Returns:
        One for each lift: `time_s`, and `after_s`, the time from the lift after which the error stayed below 0.5 m
        until the next lift or the end; None if it never did.
    """
    found = []
    for start, end in zip(lifted, [*lifted, np.inf][1:], strict=True):
        rows = (time >= start) & (time < end)
        times, lost = time[rows], np.flatnonzero(position[rows] > MAX_RECOVERED_ERROR)
        first = int(lost[-1]) + 1 if len(lost) else 0
        found.append({"time_s": start, "after_s": float(times[first]) - start if first < len(times) else None})
    return found
