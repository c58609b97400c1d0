"""Checks the goals and options of a navigator."""

import math
from collections.abc import Sequence

import numpy as np

from mjsim.geometry import Array


def checked_goals(goals: Sequence[Sequence[float]]) -> Array:
    """Return goals as rows of x, y [m] and heading [rad], NaN for any, shape (n, 3)."""
    try:
        rows = [np.atleast_1d(np.asarray(goal, dtype=float)) for goal in goals]
        rows = [np.concatenate(rows)] if rows and all(row.shape == (1,) for row in rows) else rows
    except (TypeError, ValueError):
        rows = []
    if not rows or not all(row.shape in ((2,), (3,)) for row in rows):
        raise ValueError(f"goals is {goals!r:.80}; give at least one [x, y], or [x, y, heading]")
    if not all(np.isfinite(row).all() for row in rows):
        raise ValueError(f"goals is {[row.tolist() for row in rows]}; give finite numbers [m, deg]")
    return np.array([[*row[:2], math.radians(row[2]) if len(row) == 3 else math.nan] for row in rows])


def check_options(clearance: float, **positive: float | None) -> None:
    """Raise ValueError if an option of a navigator is not above 0, or a clearance is below [m]."""
    for key, value in positive.items():
        if value is not None and not value > 0:
            raise ValueError(f"{key} is {value}; it must be above 0")
    if not clearance >= 0:
        raise ValueError(f"clearance is {clearance}; it must not be below 0")
