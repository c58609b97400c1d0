"""Checks for implausible values: events that lead mechanism joints without a motion, or beyond their range."""

import math
from collections.abc import Iterator

from mjsim.errors import did_you_mean
from mjsim.world.check.standing import Doubt
from mjsim.world.items import LeadEvent, Mechanism, ReleaseEvent, World

ROUNDED = 1e-6
"""Tolerance for values beyond the range, because a world file rounds them [rad, m]."""


def misled_joints(world: World) -> Iterator[Doubt]:
    """Yield the problems of events that lead joints of mechanisms."""
    for index, event in enumerate(world.run.events):
        try:
            if isinstance(event, LeadEvent):
                led_value(world, event)
            elif isinstance(event, ReleaseEvent) and event.joint is not None:
                led_joint(world, event.release, event.joint)
        except ValueError as error:
            yield str(error), ("run", "events", index, "lead" if isinstance(event, LeadEvent) else "release")


def led_value(world: World, event: LeadEvent) -> float:
    """Return the value to which an event leads a joint [rad, m].

    Raises:
        ValueError: The mechanism does not exist, no motion leads this joint, or the value is out of range.
    """
    slides, lower, upper = led_joint(world, event.lead, event.joint)
    scale = 1.0 if slides else math.pi / 180.0
    value = event.to_deg * scale
    if not lower - ROUNDED <= value <= upper + ROUNDED:
        raise ValueError(
            f"joint '{event.joint}' of mechanism '{event.lead}' cannot go to {event.to_deg:g}; its range is"
            f" {lower / scale:g} to {upper / scale:g}"
        )
    return min(max(value, lower), upper)


def led_joint(world: World, name: str, joint: str) -> tuple[bool, float, float]:
    """Return whether a led joint of a mechanism is a sliding joint, and the limits of its range [rad, m].

    Raises:
        ValueError: The mechanism does not exist, or no motion leads this joint.
    """
    mechanisms = {each.name: each for each in world.mechanisms}
    if name not in mechanisms:
        raise ValueError(f"no mechanism '{name}' in this world{did_you_mean(name, mechanisms)}")
    led = led_joints(mechanisms[name])
    if joint not in led:
        known = (
            f"; those that do are {', '.join(led)}" if led else ", nor does any other; add an actuator: {angle: JOINT}"
        )
        raise ValueError(f"joint '{joint}' of mechanism '{name}' follows no motion{known}")
    return led[joint]


def led_joints(mechanism: Mechanism) -> dict[str, tuple[bool, float, float]]:
    """Return the joints that motions lead, by name: whether each is a sliding joint, and its limits [rad, m]."""
    found, led = mechanism.assembly, {}
    columns = {drive.column for drive in found.drives if drive.column >= 0}
    for joint in mechanism.joints:
        for column in found.columns[joint.name]:
            if column in columns:
                slides = found.slides[column]
                degrees = tuple(map(math.radians, joint.range_deg or (-math.inf, math.inf)))
                lower, upper = (joint.range or (-math.inf, math.inf)) if slides else degrees
                led[found.names[column]] = slides, float(lower), float(upper)
    return led
