"""How the error of localization goes over time: its transient, and how soon it comes back after a robot was lifted."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from mjsim.geometry import Array

PARTS = 10
"""A run is cut in so many."""
RECOVERED = 0.5
"""A lifted robot has found itself again when its position error stays within this [m]."""


def transient_errors(time: Array, position: Array, heading: Array) -> dict[str, list[float]]:
    """Return the mean errors in each tenth of a run; fewer parts of a run that has fewer ticks.

    Args:
        time: Of each tick, shape (N,) [s].
        position: Position errors, shape (N,) [m].
        heading: Sizes of heading errors, shape (N,) [deg].

    Returns:
        `until_s`, when each part ends, `position_error_m` and `heading_error_deg`, its mean errors.
    """
    parts = np.array_split(np.arange(len(time)), min(PARTS, len(time)))
    return {
        "until_s": [float(time[rows[-1]]) for rows in parts],
        "position_error_m": [float(position[rows].mean()) for rows in parts],
        "heading_error_deg": [float(heading[rows].mean()) for rows in parts],
    }


def recoveries(time: Array, position: Array, lifted: Sequence[float]) -> list[dict[str, Any]]:
    """Return how long the estimate took to find the robot again, each time that it was put down elsewhere.

    Args:
        time: Of each tick, shape (N,) [s].
        position: Position errors, shape (N,) [m].
        lifted: When it was put down [s].

    Returns:
        One for each: `time_s`, and `after_s`, from when on the error stayed within 0.5 m until the next lift or the
        end, counted from the lift; None when it never did.
    """
    found = []
    for start, end in zip(lifted, [*lifted, np.inf][1:], strict=True):
        rows = (time >= start) & (time < end)
        times, lost = time[rows], np.flatnonzero(position[rows] > RECOVERED)
        first = int(lost[-1]) + 1 if len(lost) else 0
        found.append({"time_s": start, "after_s": float(times[first]) - start if first < len(times) else None})
    return found
