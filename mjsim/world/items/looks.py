"""Appearance of a world after events: its light, and removed objects."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from mjsim.world.ground import item_names
from mjsim.world.items.events import (
    LampEvent,
    LightEvent,
    ReachEvent,
    ReleaseEvent,
    RemoveEvent,
    RestoreEvent,
    WorldEvent,
)
from mjsim.world.items.world import World


@dataclass(frozen=True, slots=True)
class HandLed:
    """A hand of a person is led somewhere, or given back."""

    time: float
    """When it sets out [s]."""
    hand: str
    """left or right."""
    to: tuple[float, float, float] | None
    """Where its grip is to be, world frame [m]; None for where it was at the start."""


@dataclass(frozen=True, slots=True)
class Looks:
    """Appearance of a world at an instant, without positions of objects."""

    light: float
    """General light."""
    lamps: Mapping[str, float]
    """Brightness of each lamp by its name."""
    removed: frozenset[str] = frozenset()
    """Names of obstacles and beacons that were taken away, with what they carried."""
    reached: Mapping[str, tuple[HandLed, ...]] = field(default_factory=dict)
    """Of each person whose hands were led: how, in turn."""
    time: float = math.inf
    """The instant, as far as hands are still on their way; they have arrived unless told [s]."""

    def after(self, event: WorldEvent, world: World) -> "Looks":
        """Return the appearance after an event."""
        match event:
            case LightEvent():
                return replace(self, light=event.light)
            case LampEvent():
                return replace(self, lamps={**self.lamps, event.lamp: event.brightness})
            case RemoveEvent():
                carried = {beacon.name for beacon in world.beacons if beacon.on == event.remove}
                return replace(self, removed=self.removed | {event.remove} | carried)
            case RestoreEvent():
                lost = any(item.name == event.restore and item.on in self.removed for item in world.beacons)
                return self if lost else replace(self, removed=self.removed - {event.restore})
            case ReachEvent(hand=str(hand), to=(x, y, z)):
                return self._led(event.reach, HandLed(event.time, hand, (x, y, z)))
            case ReleaseEvent(hand=str(hand)):
                return self._led(event.release, HandLed(event.time, hand, None))
            case _:
                return self

    def _led(self, person: str, led: HandLed) -> "Looks":
        return replace(self, reached={**self.reached, person: (*self.reached.get(person, ()), led)})


def first_looks(world: World) -> Looks:
    """Return the appearance of a world before any event."""
    brightness = (lamp.brightness for lamp in world.lamps)
    return Looks(world.light, dict(zip(item_names(world.lamps), brightness, strict=True)))


def looks_after(world: World, events: Iterable[WorldEvent], *, time: float = math.inf) -> Looks:
    """Return the appearance of a world after events, in their order.

    Args:
        world: As it was written.
        events: What has happened.
        time: The instant, for hands that are still on their way; they have arrived unless given [s].
    """
    looks = replace(first_looks(world), time=time)
    for event in events:
        looks = looks.after(event, world)
    return looks
