"""Manual touches of a running world: events applied at the next tick."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from mjsim.errors import UsageError
from mjsim.sentences import Sentence
from mjsim.world import (
    Change,
    NoiseEvent,
    ReleaseEvent,
    Source,
    World,
    WorldEvent,
    arm_of_event,
    edit_text,
    event_from,
    noise_figures,
    rounded,
    with_target,
)

if TYPE_CHECKING:
    from mjsim.sim import Simulation

DIGITS = 4
"""Decimals of a time in a world file."""


def touch_of(keys: Mapping[str, Any]) -> WorldEvent:
    """Return an event from keys as in a world file, except its time, with numbers rounded as there.

    Raises:
        UsageError: A key is unknown or missing, or a value does not fit.
    """
    if "time" in keys:
        raise UsageError("a touch has no time of its own; it happens at the next tick")
    event = event_from({"time": 0.0, **keys})
    return event_from(rounded(event.model_dump(exclude_unset=True)))


def joints_keys(world: World, robot: str, arm: str, positions: Sequence[float] | None) -> dict[str, Any]:
    """Return the keys of the event that moves the joints of an arm [rad, m], or for None releases it.

    Raises:
        UsageError: The arm does not exist, or has a different number of joints.
    """
    try:
        item = arm_of_event(world, ReleaseEvent(time=0.0, release=robot, arm=arm))
    except ValueError as error:
        raise UsageError(str(error)) from None
    if positions is None:
        return {"release": robot, "arm": arm}
    links = item.arm.links
    if len(positions) != len(links) or not all(map(math.isfinite, positions)):
        raise UsageError(Sentence("arm '{arm}' has {count} joints; give as many finite numbers", arm, len(links)))
    values = [value if link.slide else math.degrees(value) for link, value in zip(links, positions, strict=True)]
    return {"reach": robot, "arm": arm, "joints_deg": values}


class Touches:
    """Touches of a run until now, as events of the world file."""

    def __init__(self, events: Iterable[WorldEvent] = ()) -> None:
        """Start with initial events."""
        self.events = tuple(events)
        """Each with the time of its tick."""
        self._time = -1.0
        self._pending: dict[int, WorldEvent] = {}
        """Touches of the next tick, which is at that time [s], by the index of their event."""

    def take(self, sim: "Simulation", event: WorldEvent, *, follows: bool) -> WorldEvent:
        """Schedule an event for the next tick, and return it.

        If noise or a target that follows is changed more than once before a tick, only the last value counts.

        Args:
            sim: The run.
            event: The event.
            follows: Whether it is a later target of the motion of an earlier touch; then it becomes a part of it.

        Raises:
            UsageError: The event names something that does not exist, or places something where there is no space, or
                outside the world; then nothing changes.
        """
        touch = event.model_copy(update={"time": _written_time((sim.tick + 1) * sim.dt)})
        if touch.time != self._time:
            self._time, self._pending = touch.time, {}
        continued = self._continued(touch) if follows else None
        if continued is None:
            return self._take_new(sim, touch)
        place, whole = continued
        # In the file, simultaneous events are in the order in which their motions began.
        later = next((self._pending[each] for each in sorted(self._pending) if each > place), None)
        touch = sim.schedule(touch, instead_of=self._pending.get(place), before=later)
        self._pending[place] = touch
        self.events = (*self.events[:place], whole, *self.events[place + 1 :])
        return touch

    def _take_new(self, sim: "Simulation", touch: WorldEvent) -> WorldEvent:
        """Schedule a touch that begins a new event."""
        same = next((place for place, each in self._pending.items() if _is_overruled(each, touch)), None)
        touch = sim.schedule(touch, instead_of=None if same is None else self._pending[same])
        if same is not None:
            self.events = (*self.events[:same], *self.events[same + 1 :])
            del self._pending[same]
            self._pending = {place - (place > same): each for place, each in self._pending.items()}
        self._pending[len(self.events)] = touch
        self.events = (*self.events, touch)
        return touch

    def _continued(self, touch: WorldEvent) -> tuple[int, WorldEvent] | None:
        """Return the index of the event that a target continues, and the extended event; None if there is none."""
        for place in reversed(range(len(self.events))):
            if (whole := with_target(self.events[place], touch)) is not None:
                return place, whole
        return None


def noise_kept(touched: Iterable[WorldEvent], world: World) -> tuple[NoiseEvent, ...]:
    """Return manually changed noise as events at the start, where it differs from the world."""
    last = {event.noise: event for event in touched if isinstance(event, NoiseEvent)}
    initial = {figure.key: figure.value for figure in noise_figures(world)}
    changed = (event for event in last.values() if initial.get(event.noise) != event.value)
    return tuple(event.model_copy(update={"time": 0.0}) for event in changed)


def keep_events(text: str, events: Sequence[WorldEvent], *, source: Source | None = None) -> str:
    """Return the text of a world with events added, so that a run of it repeats them.

    Args:
        text: Text of the world whose run was touched.
        events: Touches, from `Session.touched`.
        source: Origin of the text, for the files that it includes.
    """
    changes = [Change("add", ("run", "events"), event_keys(event)) for event in events]
    return edit_text(text, changes) if source is None else edit_text(text, changes, source=source)


def event_keys(event: WorldEvent) -> dict[str, Any]:
    """Return the keys of an event as in a world file, without default values."""
    return event.model_dump(mode="json", exclude_defaults=True)


def _is_overruled(before: WorldEvent, touch: WorldEvent) -> bool:
    """Return whether an earlier touch has no effect: noise changed again before its tick."""
    if not isinstance(before, NoiseEvent) or not isinstance(touch, NoiseEvent):
        return False
    return (before.time, before.noise) == (touch.time, touch.noise)


def _written_time(time: float) -> float:
    """Return a short number not after a time [s] that means the same tick."""
    rounded = round(time, DIGITS)
    return rounded if rounded <= time + 1e-9 else round(math.floor(time * 10**DIGITS) / 10**DIGITS, DIGITS)
