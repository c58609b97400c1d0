"""Shifts ground truth that is far from the origin, such as in UTM coordinates, close to it."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from mjsim.geometry import Array
from mjsim.logs.resampling.robot_log import RobotLog

MAX_COORDINATE = 1e4
"""Maximum coordinate in a world [m]."""
ORIGIN_STEP = 100.0
"""New origins are multiples of this, so that both coordinates of a place are easily compared [m]."""
Marks = Mapping[str, tuple[float, float]]


def near_origin(
    robots: Sequence[RobotLog], marks: Sequence[Marks]
) -> tuple[list[RobotLog], list[dict[str, tuple[float, float]]], str]:
    """Return logs in a world frame with a near origin.

    Args:
        robots: Logs with a common world frame.
        marks: Positions of landmarks in each [m].

    Returns:
        Logs and landmarks, and a note about the origin; all unchanged and '' if no coordinate is too large.
    """
    known = [place for robot in robots if (place := _places(robot)) is not None]
    known += [np.array(list(each.values())) for each in marks if each]
    places = np.concatenate(known) if known else np.zeros((0, 2))
    places = places[np.isfinite(places).all(axis=1)]
    if not len(places) or np.abs(places).max() <= MAX_COORDINATE:
        return list(robots), [dict(each) for each in marks], ""
    x, y = (math.floor(value / ORIGIN_STEP) * ORIGIN_STEP for value in places[0].tolist())
    away = np.array([x, y])
    moved = [
        replace(
            robot,
            truth=None if robot.truth is None else _moved(robot.truth, away),
            poses=None if robot.poses is None else _moved(robot.poses, away),
        )
        for robot in robots
    ]
    shifted = [{name: (a - x, b - y) for name, (a, b) in each.items()} for each in marks]
    return moved, shifted, f"x {x:.0f}, y {y:.0f} m of the log, whose coordinates are too large for a world"


def _places(robot: RobotLog) -> Array | None:
    rows = robot.poses if robot.poses is not None else robot.truth
    return None if rows is None or not len(rows) else rows[:, 1:3]


def _moved(rows: Array, away: Array) -> Array:
    """Return rows of time, x, y and more, with places relative to another origin."""
    rows = rows.copy()
    rows[:, 1:3] -= away
    return rows
