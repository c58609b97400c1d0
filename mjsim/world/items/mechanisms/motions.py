"""Coordinates on which the actuators of a mechanism act, and the prescribed motions of its joints."""

from collections.abc import Callable, Sequence

import numpy as np

from mjsim.mechanics import BodyPoint
from mjsim.sentences import Sentence
from mjsim.world.ground import fault
from mjsim.world.items.mechanisms.actuators import MOTIONS, DistanceActuator, actuator_kind
from mjsim.world.items.mechanisms.assembly import Assembly, Motion
from mjsim.world.items.mechanisms.mechanism_items import MechanismParts
from mjsim.world.items.mechanisms.points import End, place_of
from mjsim.world.items.mechanisms.tree import Points

Read = Callable[[str], bytes]


def motions_of(mechanism: MechanismParts, found: Assembly, points: Points, read: Read) -> tuple[Motion, ...]:
    """Return the prescribed motions of joints and distances; every actuator is checked."""
    drives = list[Motion]()
    taken = dict[str, int]()
    for number, actuator in enumerate(mechanism.actuators):
        kind, column, ends = actuator_kind(actuator), -1, None
        if kind in MOTIONS and isinstance(actuator, DistanceActuator):
            ends = spots_of(actuator.distance, found, points, ("actuators", number, kind))
        else:
            column = _actuated(mechanism, found, number, kind, points)
        if actuator.target in taken:
            raise fault(
                Sentence(
                    "'{target}' has an actuator already, actuators[{taken}]", actuator.target, taken[actuator.target]
                ),
                "actuators",
                number,
                kind,
            )
        taken[actuator.target] = number
        angle = kind in MOTIONS and column >= 0 and not found.slides[column]
        if actuator.signal is None:
            _check_found(mechanism, found, number, kind, column)
            continue
        if (wrong := actuator.signal.misfit(angle=angle)) is not None:
            raise fault(wrong[0], "actuators", number, "signal", *wrong[1])
        if kind in MOTIONS:
            rng = np.random.default_rng(0) if actuator.signal.kind == "random" else None
            made = actuator.signal.made(read, rng, angle=angle)
            drives.append(Motion(number=number, kind=kind, column=column, ends=ends, signal=made, name=actuator.target))
    return tuple(drives)


def _check_found(mechanism: MechanismParts, found: Assembly, number: int, kind: str, column: int) -> None:
    """Check an actuator whose value is found by trimming or set by a controller."""
    actuator = mechanism.actuators[number]
    if getattr(actuator, "controller", None) is not None:
        if mechanism.mode != "forward":
            raise fault("a controller is for mode: forward; leave it out", "actuators", number, "controller")
        if column < 0 or actuator.target not in found.names:
            raise fault(
                Sentence("a controller is for a {kind} on a joint; give a signal", kind),
                "actuators",
                number,
                "controller",
            )
        goal = getattr(actuator, "goal", None)
        if goal is not None and (wrong := goal.misfit(angle=not found.slides[column])) is not None:
            raise fault(wrong[0], "actuators", number, "goal", *wrong[1])
        return
    if mechanism.mode != "trim":
        raise fault("find is for mode: trim; give a signal", "actuators", number, "find")
    if column < 0:
        raise fault(Sentence("find is for a {kind} on a joint; give a signal", kind), "actuators", number, "find")


def _actuated(
    mechanism: MechanismParts,
    found: Assembly,
    number: int,
    kind: str,
    points: Points,
) -> int:
    """Return the column that an actuator acts on, -1 for a body."""
    actuator, path = mechanism.actuators[number], ("actuators", number, kind)
    target = actuator.target
    on_body = kind in ("torque", "force") and target.partition(".")[0] in points
    if on_body:
        try:
            place_of(target, points)
        except ValueError as error:
            raise fault(str(error), *path) from None
        if getattr(actuator, "axis", None) is None:
            raise fault(Sentence("a {kind} on a body needs its direction; add axis: [x, y, z]", kind), *path)
        return -1
    try:
        column = found.moved_column(target)
    except ValueError as error:
        raise fault(str(error), *path) from None
    if getattr(actuator, "axis", None) is not None:
        raise fault(
            Sentence("a {kind} on a joint acts along the joint's own axis; leave out axis", kind),
            "actuators",
            number,
            "axis",
        )
    slides, needs_slide = found.slides[column], {"angle": False, "torque": False, "position": True, "force": True}
    if kind in needs_slide and needs_slide[kind] != slides:
        right = {"angle": "position", "torque": "force", "position": "angle", "force": "torque"}[kind]
        raise fault(
            Sentence(
                "joint '{target}' {moves}; write {right}: {target}", target, "slides" if slides else "turns", right
            ),
            *path,
        )
    return column


def spots_of(
    ends: Sequence[End],
    found: Assembly,
    points: Points,
    path: tuple[str | int, ...],
) -> tuple[BodyPoint, BodyPoint]:
    """Return points of two different bodies.

    Args:
        ends: Ends as written.
        found: The mechanism.
        points: Named points by body.
        path: Their path in the file, for errors.
    """
    spots = []
    for which, end in enumerate(ends):
        try:
            place = place_of(end, points)
        except ValueError as error:
            raise fault(str(error), *path, which) from None
        spots.append(BodyPoint(found.number(place.body), np.array(place.at)))
    if spots[0].body == spots[1].body:
        raise fault("both points are on one body, and cannot move apart; name points of two bodies", *path)
    return spots[0], spots[1]
