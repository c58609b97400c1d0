"""Sorts wheels by axles, and by the sides of a robot."""

import numpy as np

from mjsim.exchange.robots.found_wheels import FoundWheel
from mjsim.exchange.robots.robot_import import RobotOptions
from mjsim.geometry import Array

AXLE_TOLERANCE = 0.5
"""Wheels this close to each other along the robot share an axle, in wheel radii."""
Sides = tuple[list[FoundWheel], list[FoundWheel]]
"""The left and the right wheels of an axle."""


def axles_of(wheels: list[FoundWheel], forward: Array) -> list[list[FoundWheel]]:
    """Return wheels by axles, front axle first."""
    rows: list[list[FoundWheel]] = []
    for wheel in sorted(wheels, key=lambda w: -float(w.middle[:2] @ forward)):
        apart = float((rows[-1][0].middle - wheel.middle)[:2] @ forward) if rows else np.inf
        if abs(apart) < AXLE_TOLERANCE * wheel.radius:
            rows[-1].append(wheel)
        else:
            rows.append([wheel])
    return rows


def by_side(row: list[FoundWheel], left: Array, options: RobotOptions) -> Sides:
    """Return the left and the right wheels of an axle, outer ones first."""
    middle = float(np.mean([wheel.middle[:2] @ left for wheel in row]))
    if len(row) == 1:
        middle = 0.0

    def outward(wheel: FoundWheel) -> float:
        return -abs(float(wheel.middle[:2] @ left) - middle)

    named_left, named_right = set(options.left), set(options.right)

    def is_left(wheel: FoundWheel) -> bool:
        if (wheel.name in named_left) != (wheel.name in named_right):
            return wheel.name in named_left
        return float(wheel.middle[:2] @ left) > middle

    return (
        sorted((w for w in row if is_left(w)), key=outward),
        sorted((w for w in row if not is_left(w)), key=outward),
    )


def across_of(wheel: FoundWheel, left: Array, sides: list[Sides]) -> float:
    """Return the lateral distance of a wheel from the centreline of the robot [m]."""
    all_of = [float(w.middle[:2] @ left) for pair in sides for side in pair for w in side]
    return float(wheel.middle[:2] @ left) - (min(all_of) + max(all_of)) / 2
