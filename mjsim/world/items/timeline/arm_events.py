"""Events that move arms: the requested joint values."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from mjsim.errors import OutOfReachError, UsageError
from mjsim.geometry import Array
from mjsim.sentences import Sentence
from mjsim.world.items.arms import RobotArm
from mjsim.world.items.timeline.events import ReachEvent

MISS = 1e-3
"""A pose counts as reached below this error [m, rad]."""
WHOLE, PLACE = (1.0,) * 6, (1.0, 1.0, 1.0, 0.0, 0.0, 0.0)
"""Components of a pose that count: for an arm with fewer than six joints, only the position."""
ROUNDED = 1e-5
"""Joint values may exceed their limits by this much, because a world file rounds them [rad, m]."""


def reached_joints(item: RobotArm, event: ReachEvent, start: ArrayLike) -> tuple[Array, UsageError | None]:
    """Return the joint values requested by an event, and the error that says what is wrong with them, or None.

    Args:
        item: The arm.
        event: Its joint values, or the pose of its tool; if out of reach, the nearest one is used.
        start: Initial guess for inverse kinematics, shape (n,) [rad, m].

    Returns:
        Values within the limits, or those of `start` if they do not suit the arm, shape (n,) [rad, m]; and an error,
        an `OutOfReachError` if the tool does not reach.
    """
    if event.joints_deg is not None:
        return _joints(item, event.joints_deg, np.asarray(start, dtype=float))
    return _inverse(item, event, np.asarray(start, dtype=float))


def _joints(item: RobotArm, given: Sequence[float], start: Array) -> tuple[Array, UsageError | None]:
    arm = item.arm
    if len(given) != arm.n:
        return start, UsageError(
            Sentence("joints_deg holds {given} values; arm '{name}' has {joints} joints", len(given), item.name, arm.n)
        )
    scales = np.array([1.0 if link.slide else math.pi / 180.0 for link in arm.links])
    values, (lower, upper) = np.array(given) * scales, arm.limits
    within = np.clip(values, lower, upper)
    beyond = np.flatnonzero(np.abs(values - within) > ROUNDED)
    if not beyond.size:
        return within, None
    k = int(beyond[0])
    low, high = (float(bound[k] / scales[k]) for bound in (lower, upper))
    message = Sentence(
        "joint {k} of arm '{name}' cannot go to {given:g}; its range is {low:g} to {high:g}",
        *(k + 1, item.name, given[k], low, high),
    )
    return start, UsageError(message)


def _inverse(item: RobotArm, event: ReachEvent, start: Array) -> tuple[Array, UsageError | None]:
    from mjsim.mechanics import placed, rpy_of

    assert event.tool is not None, "an event has joints or a tool"
    arm = item.arm
    turned = event.rpy_deg is not None and arm.n >= len(WHOLE)
    rpy = rpy_of(arm.fkine(start)) if event.rpy_deg is None else np.radians(event.rpy_deg)
    reached = arm.ikine(placed(event.tool, rpy), start, mask=WHOLE if turned else PLACE)
    values = np.asarray(reached.q, dtype=float)
    if max(float(reached.distance), float(reached.angle) if turned else 0.0) <= MISS:
        return values, None
    angle = Sentence(" and {degrees:.3g} degrees", float(np.degrees(reached.angle))) if turned else ""
    short, how = float(reached.distance), " turned so" if turned else ""
    missed = Sentence(
        "the tool of '{arm}' does not reach {x:g}, {y:g}, {z:g} m{how}; it misses by {short:.3g} m{angle}",
        *(item.name, *event.tool, how, short, angle),
    )
    x_near, y_near, z_near = arm.fkine(values)[:3, 3].tolist()
    return values, OutOfReachError(missed, short=short, nearest=(x_near, y_near, z_near))
