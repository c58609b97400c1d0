"""Checks for implausible values: events that lead joints of mechanisms that cannot be led, or beyond their range."""

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
        ValueError: The mechanism does not exist, has no such joint that can be led, or the value is out of its range.
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
    """Return whether a joint that can be led is a sliding joint, and the limits of its range [rad, m].

    Raises:
        ValueError: The mechanism does not exist, or has no such joint that can be led.
    """
    mechanisms = {each.name: each for each in world.mechanisms}
    if name not in mechanisms:
        raise ValueError(f"no mechanism '{name}' in this world{did_you_mean(name, mechanisms)}")
    led, names = led_joints(mechanisms[name]), mechanisms[name].assembly.names
    if joint in led:
        return led[joint]
    if joint not in names:
        raise ValueError(f"mechanism '{name}' has no joint '{joint}' that can be led{did_you_mean(joint, led)}")
    known = f"those that can are {', '.join(led)}" if led else "nor can any other"
    raise ValueError(f"joint '{joint}' of mechanism '{name}' cannot be led, as other joints move it; {known}")


def led_joints(mechanism: Mechanism) -> dict[str, tuple[bool, float, float]]:
    """Return the joints that can be led, by name: whether each is a sliding joint, and its limits [rad, m].

    Joints with a motion are led in place of it, those in `mechanism.held` by the bounded force of a hand.
    """
    found, led = mechanism.assembly, {}
    columns = {drive.column for drive in found.drives if drive.column >= 0}
    for joint in mechanism.joints:
        for column in found.columns[joint.name]:
            if column in columns or found.names[column] in mechanism.held:
                slides = found.slides[column]
                degrees = tuple(map(math.radians, joint.range_deg or (-math.inf, math.inf)))
                lower, upper = (joint.range or (-math.inf, math.inf)) if slides else degrees
                led[found.names[column]] = slides, float(lower), float(upper)
    return led
