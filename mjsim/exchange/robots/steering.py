"""Wheels that steer: those that the user names, and how far they turn."""

import math
from collections.abc import Sequence
from dataclasses import replace

from mjsim.errors import UsageError, did_you_mean
from mjsim.exchange.robots.found_wheels import FoundWheel
from mjsim.models import Anatomy, FileJoint

USUAL_STEERING = math.radians(35.0)
"""Steering limit of a car's inner wheel where the file states none [rad]."""


def steered_as_named(
    chosen: Sequence[FoundWheel],
    others: Sequence[FoundWheel],
    names: Sequence[str],
    anatomy: Anatomy,
    file: str,
) -> tuple[list[FoundWheel], list[FoundWheel]]:
    """Return the wheels that drive or steer, those on the named joints alone as steered, and the passive ones.

    Raises:
        UsageError: A named joint does not exist, or carries no wheel.
    """
    known = {joint.name: joint for joint in anatomy.joints if not joint.slides}
    steered = {wheel.steer.name for wheel in (*chosen, *others) if wheel.steer is not None}
    for name in names:
        if name not in known:
            raise UsageError(f"no hinge '{name}' in {file}{did_you_mean(name, known)}")
        if name not in steered:
            others_that = f"; {listed(sorted(steered))} do" if steered else "; leave out --steering"
            raise UsageError(f"--steering '{name}' of {file} turns no wheel about a vertical axis{others_that}")

    def is_steered(wheel: FoundWheel) -> bool:
        return wheel.steer is not None and wheel.steer.name in names

    kept = [wheel if is_steered(wheel) else replace(wheel, steer=None) for wheel in chosen]
    kept += [wheel for wheel in others if is_steered(wheel)]
    kept = [replace(wheel, swivels=False) if is_steered(wheel) else wheel for wheel in kept]
    return kept, [wheel for wheel in others if not is_steered(wheel)]


def steering_limit(joints: Sequence[FileJoint], *, limit: float = USUAL_STEERING) -> float:
    """Return the steering limit to both sides, `limit` if the file does not state it [rad]."""
    limits = [min(abs(joint.range[0]), abs(joint.range[1])) for joint in joints if joint.range is not None]
    return min([*limits, limit])


def steering_note(joints: Sequence[FileJoint]) -> str:
    """Return a note on a steering range that is guessed; '' if the file states it."""
    if any(joint.range is not None for joint in joints) or not joints:
        return ""
    why = "its limits are 0 to 0" if any(joint.placeholder for joint in joints) else "it has no limits"
    return f"it steers {math.degrees(USUAL_STEERING):.0f} degrees to both sides, as {why}; change it in the preset"


def listed(names: Sequence[str]) -> str:
    """Return names in quotes, at most 12."""
    return ", ".join(f"'{name}'" for name in names[:12]) + (" and more" if len(names) > 12 else "")
