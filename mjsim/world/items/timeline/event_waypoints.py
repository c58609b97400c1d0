"""Events that move something through several targets: their single targets, and how they are joined into one."""

import itertools
from collections.abc import Iterable

from mjsim.world.items.timeline.events import MAX_TARGETS, LeadEvent, ReachEvent, WorldEvent

DIGITS = 4
"""Decimals of times."""
LOOKED_BACK = 20
"""Number of events that may have begun after a motion that continues."""
PAUSE = 1.0
"""Targets that follow each other within this time belong to one motion in a list of what happened [s]."""


def single_targets(event: WorldEvent) -> tuple[WorldEvent, ...]:
    """Return an event as one event for each of its targets, in order of time."""
    if not isinstance(event, ReachEvent | LeadEvent) or event.then is None:
        return (event,)
    key, first = _goal_key(event), event.model_copy(update={"then": None})
    later = (
        first.model_copy(update={"time": event.time + row[0], key: row[1] if key == "to_deg" else row[1:]})
        for row in event.then
    )
    return (first, *later)


def with_target(event: WorldEvent, target: WorldEvent) -> WorldEvent | None:
    """Return an event with a later target as its last row; None if the target belongs to another motion.

    A target at the time of the last one replaces it.
    """
    if not isinstance(event, ReachEvent | LeadEvent) or not isinstance(target, ReachEvent | LeadEvent):
        return None
    key, seconds = _goal_key(event), round(target.time - event.time, DIGITS)
    if key != _goal_key(target) or target.then or not _same_motion(event, target, but={"time", "then", key}):
        return None
    if event.then is None and seconds == 0.0:
        return target
    rows = tuple(row for row in event.then or () if row[0] < seconds)
    if seconds <= 0.0 or len(rows) == MAX_TARGETS or len(event.then or ()) > len(rows) + 1:
        return None
    goal = getattr(target, key)
    row = (seconds, *(goal if isinstance(goal, tuple) else (goal,)))
    whole = event.model_copy(update={"then": (*rows, row)})
    return whole.stays_away(target.short) if isinstance(whole, ReachEvent) and isinstance(target, ReachEvent) else whole


def last_time(event: WorldEvent) -> float:
    """Return the time of the last target of an event; its own time if it has only one [s]."""
    rows = event.then if isinstance(event, ReachEvent | LeadEvent) else None
    return event.time if rows is None else event.time + rows[-1][0]


def as_motions(events: Iterable[WorldEvent]) -> list[WorldEvent]:
    """Return events with successive targets of a motion joined into one event, for display."""
    found: dict[int, WorldEvent] = {}
    for number, event in enumerate(events):
        before, whole = extend_motion(found, event)
        found[number if before is None else before] = whole
    return list(found.values())


def extend_motion(motions: dict[int, WorldEvent], event: WorldEvent) -> tuple[int | None, WorldEvent]:
    """Return the number of the motion that an event continues, None for none, and the motion with it.

    Args:
        motions: Events in order of time, by number; the later ones are tried first.
        event: The next event.
    """
    for number in itertools.islice(reversed(motions), LOOKED_BACK):
        near = event.time - last_time(motions[number]) <= PAUSE
        if near and (whole := with_target(motions[number], event)) is not None:
            return number, whole
    return None, event


def _goal_key(event: ReachEvent | LeadEvent) -> str:
    """Return the key of the target."""
    keys = ("to_deg", "rotation_deg") if isinstance(event, LeadEvent) else ("joints_deg", "tool", "to")
    return next(key for key in keys if getattr(event, key) is not None)


def _same_motion(event: ReachEvent | LeadEvent, other: ReachEvent | LeadEvent, *, but: set[str]) -> bool:
    """Return whether two events are equal except in some keys."""
    names = type(event).model_fields.keys() - but
    return type(event) is type(other) and all(getattr(event, name) == getattr(other, name) for name in names)
