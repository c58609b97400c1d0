"""People on the page: their outlines, and their posture after a hand is dragged or a joint is rotated."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from mjsim.errors import did_you_mean
from mjsim.geometry import Array
from mjsim.people import SIDES
from mjsim.sentences import Sentence
from mjsim.web.worlds.viewpoints import KeyChange
from mjsim.world import Person

Json = dict[str, Any]
SEATED = "the seat and its targets define the posture of a seated person; change those"
MIN_TURN_DEG = 0.05
"""Smaller changes of joints are not written [deg]."""
ARRIVAL_DISTANCE = 0.002
"""A hand within this distance of its target has reached it [m]."""


def hands(person: Person) -> dict[str, Array]:
    """Return the grip positions of both hands by side, world frame, shape (3,) each [m]."""
    from mjsim.posture import LED

    spots = person.figure.spots(person.poses())
    return {side: spots[f"{side}_{LED}"] for side in SIDES}


def sliders(person: Person) -> Iterator[Json]:
    """Yield each joint: name, value, low, high, unit, and whether it can be rotated."""
    for (name, joint), value in zip(person.figure.joints.items(), person.posture().tolist(), strict=True):
        low, high, shown = (round(math.degrees(each), 2) for each in (joint.low, joint.high, value))
        yield {"name": name, "value": shown, "low": low, "high": high, "unit": "°", "free": person.seat is None}


def turned(person: Person, values: Mapping[str, float]) -> tuple[Person, list[KeyChange]]:
    """Return a person with other joint angles [deg], within range, and the changes of its text, as relative paths.

    Raises:
        ValueError: The joint does not exist, or the person is seated.
    """
    if person.seat is not None:
        raise ValueError(SEATED)
    joints = person.figure.joints
    for name in values:
        if name not in joints:
            raise ValueError(Sentence("no joint '{name}'{meant}", name, did_you_mean(name, joints)))
    within = {
        name: round(min(max(value, math.degrees(joints[name].low)), math.degrees(joints[name].high)), 2) + 0.0
        for name, value in values.items()
    }
    plain = person.model_dump(exclude_unset=True)
    posed = Person.model_validate({**plain, "joints_deg": {**person.joints_deg, **within}})
    posed.stand_among(person.floors)
    return posed, [(("joints_deg", name), value) for name, value in within.items()]


def led(person: Person, targets: Mapping[str, Array]) -> tuple[Person, list[KeyChange], str]:
    """Return a person with hands moved, the changes of its text, and which hand misses its target by how much.

    Args:
        person: The person in the world.
        targets: Target positions of grips by side, world frame, shape (3,) each [m].

    Raises:
        ValueError: The person is seated.
    """
    if person.seat is not None:
        raise ValueError(SEATED)
    from mjsim.posture import lead_hands

    before, root = person.posture(), person.poses()["pelvis"]
    found = lead_hands(person.figure, before, root, targets)
    degrees = np.degrees(found.values)
    changed = np.abs(degrees - np.degrees(before)) > MIN_TURN_DEG
    names = np.array(list(person.figure.joints))[changed]
    posed, changes = turned(person, dict(zip(names.tolist(), degrees[changed].tolist(), strict=True)))
    short = [
        Sentence("the {side} hand does not reach: {far:.2f} m away", side, far)
        for side, far in found.short.items()
        if far > ARRIVAL_DISTANCE
    ]
    return posed, changes, "; ".join(short)
