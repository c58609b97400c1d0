"""Checks for implausible values: events that lead joints of mechanisms that cannot be led, or beyond their range."""

import math
from collections.abc import Iterator

from mjsim.errors import did_you_mean
from mjsim.sentences import Sentence
from mjsim.world.check.overlaps import Finding
from mjsim.world.items import LeadEvent, Mechanism, ReleaseEvent, World, single_targets

RANGE_TOLERANCE = 1e-6
"""Tolerance for values beyond the range, because a world file rounds them [rad, m]."""
Led = tuple[bool, float, float]
"""Whether a value that can be led is a length, and the limits of its range [rad, m]."""


def misled_joints(world: World) -> Iterator[Finding]:
    """Yield the problems of events that lead joints of mechanisms."""
    for index, event in enumerate(world.run.events):
        place: tuple[str | int, ...] = ("lead",) if isinstance(event, LeadEvent) else ("release",)
        try:
            for number, target in enumerate(single_targets(event)):
                place = ("then", number - 1) if number else place
                if isinstance(target, LeadEvent):
                    led_goals(world, target)
            if isinstance(event, ReleaseEvent) and event.joint is not None:
                led_values(world, event.release, event.joint)
        except ValueError as error:
            yield str(error), ("run", "events", index, *place)


def led_goals(world: World, event: LeadEvent) -> dict[str, float]:
    """Return the values to which an event leads a joint, by their names [rad, m].

    Raises:
        ValueError: The mechanism does not exist, has no such joint that can be led, or a value is out of its range.
    """
    led = led_values(world, event.lead, event.joint)
    asked = event.rotation_deg if event.to_deg is None else (event.to_deg,)
    assert asked is not None, "one of them is given"
    if len(asked) != len(led):
        key = Sentence("rotation_deg: [rx, ry, rz], or lead one of {led}", ", ".join(led)) if len(led) > 1 else "to_deg"
        raise ValueError(
            Sentence("joint '{joint}' of mechanism '{lead}' is led with {key}", event.joint, event.lead, key)
        )
    goals = {}
    for (name, (slides, lower, upper)), written in zip(led.items(), asked, strict=True):
        scale = 1.0 if slides else math.pi / 180.0
        value = written * scale
        if not lower - RANGE_TOLERANCE <= value <= upper + RANGE_TOLERANCE:
            raise ValueError(
                Sentence(
                    "joint '{name}' of mechanism '{lead}' cannot go to {written:g}; its range is {lower:g}"
                    " to {upper:g}",
                    *(name, event.lead, written, lower / scale, upper / scale),
                )
            )
        goals[name] = min(max(value, lower), upper)
    return goals


def led_values(world: World, name: str, joint: str) -> dict[str, Led]:
    """Return the values of a joint that can be led, by their names: three if it is a ball, otherwise one.

    Raises:
        ValueError: The mechanism does not exist, or has no such joint that can be led.
    """
    mechanisms = {each.name: each for each in world.mechanisms}
    if name not in mechanisms:
        raise ValueError(Sentence("no mechanism '{name}' in this world{meant}", name, did_you_mean(name, mechanisms)))
    mechanism = mechanisms[name]
    led, balls, names = led_joints(mechanism), mechanism.balls, mechanism.assembly.names
    if joint in led:
        return {joint: led[joint]}
    if joint in balls:
        return {value: led[value] for value in balls[joint]}
    if values := [each for each in led if each.startswith(f"{joint}.")]:
        raise ValueError(
            Sentence(
                "joint '{joint}' of mechanism '{name}' has {count} values; lead one of {values}",
                *(joint, name, len(values), ", ".join(values)),
            )
        )
    if joint not in names:
        raise ValueError(
            Sentence(
                "mechanism '{name}' has no joint '{joint}' that can be led{meant}",
                *(name, joint, did_you_mean(joint, [*balls, *led])),
            )
        )
    known = Sentence("those that can are {led}", ", ".join(led)) if led else "nor can any other"
    raise ValueError(
        Sentence(
            "joint '{joint}' of mechanism '{name}' cannot be led, as {why_not}; {known}",
            *(joint, name, _why_not(mechanism, joint), known),
        )
    )


def _why_not(mechanism: Mechanism, joint: str) -> str:
    constraint = joint.partition(".")[0]
    own = [each.called(number) for number, each in enumerate(mechanism.constraints)]
    return (
        Sentence("it is a value of the constraint '{constraint}'", constraint)
        if constraint in own
        else "it does not move"
    )


def led_joints(mechanism: Mechanism) -> dict[str, Led]:
    """Return the single values that can be led, by name: whether each is a length, and its limits [rad, m].

    Those in `mechanism.driven` are led by motions, those in `mechanism.held` by the bounded force of a hand.
    """
    found, led = mechanism.assembly, {}
    movable = mechanism.driven | mechanism.held
    for joint in mechanism.joints:
        for column in found.columns[joint.name]:
            if found.names[column] in movable:
                slides = found.slides[column]
                degrees = tuple(map(math.radians, joint.range_deg or (-math.inf, math.inf)))
                lower, upper = (joint.range or (-math.inf, math.inf)) if slides else degrees
                led[found.names[column]] = slides, float(lower), float(upper)
    for track in found.tracks:
        if track.name in movable:
            curve = track.curve(found.linkage)
            led[track.name] = (True, -math.inf, math.inf) if curve.closed else (True, 0.0, curve.length)
    return led
