"""Appearance of a world after events: its light, and removed objects."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from mjsim.world.ground import item_names
from mjsim.world.items.timeline import (
    LampEvent,
    LightEvent,
    ReachEvent,
    ReleaseEvent,
    RemoveEvent,
    RestoreEvent,
    WorldEvent,
)
from mjsim.world.items.world import World

if TYPE_CHECKING:
    from mjsim.geometry import Array


@dataclass(frozen=True, slots=True, eq=False)
class HandMotion:
    """How a figure moves a hand, once it is known."""

    values: "Array"
    """Joint values at its end, shape (n,) [rad]."""
    short: float
    """Remaining distance of the hand from its target [m]."""
    seconds: float
    """Its duration [s]."""


@dataclass(frozen=True, slots=True)
class HandLed:
    """A hand of a person is moved to a target, or released."""

    time: float
    """Start of the motion [s]."""
    hand: str
    """left or right."""
    to: tuple[float, float, float] | None
    """Target of its grip, world frame [m]; None for its start position."""
    motion: HandMotion | None = field(default=None, compare=False, repr=False)
    """How it moves; None if it was not computed yet."""


@dataclass(frozen=True, slots=True)
class Looks:
    """Appearance of a world at an instant, without positions of objects."""

    light: float
    """Ambient light."""
    lamps: Mapping[str, float]
    """Brightness of each lamp by its name."""
    removed: frozenset[str] = frozenset()
    """Names of removed obstacles and beacons, with all that they carried."""
    reached: Mapping[str, tuple[HandLed, ...]] = field(default_factory=dict)
    """For each person whose hands were moved: the motions, in order."""
    time: float = math.inf
    """The instant, for hands that are still moving; by default they have arrived [s]."""

    def after(self, event: WorldEvent, world: World) -> "Looks":
        """Return the appearance after an event."""
        match event:
            case LightEvent():
                return replace(self, light=event.light)
            case LampEvent():
                return replace(self, lamps={**self.lamps, event.lamp: event.brightness})
            case RemoveEvent():
                return replace(self, removed=self.removed | _with_carried(event.remove, world))
            case RestoreEvent():
                lost = any(item.name == event.restore and item.on in self.removed for item in world.beacons)
                return self if lost else replace(self, removed=self.removed - _with_carried(event.restore, world))
            case ReachEvent(hand=str(hand), to=(x, y, z)):
                return self._led(event.reach, HandLed(event.time, hand, (x, y, z)))
            case ReleaseEvent(hand=str(hand)):
                return self._led(event.release, HandLed(event.time, hand, None))
            case _:
                return self

    def _led(self, person: str, led: HandLed) -> "Looks":
        return replace(self, reached={**self.reached, person: (*self.reached.get(person, ()), led)})


def _with_carried(name: str, world: World) -> set[str]:
    """Return the name of something and those of the beacons on it."""
    return {name, *(beacon.name for beacon in world.beacons if beacon.on == name)}


def first_looks(world: World) -> Looks:
    """Return the appearance of a world before any event."""
    brightness = (lamp.brightness for lamp in world.lamps)
    return Looks(world.light, dict(zip(item_names(world.lamps), brightness, strict=True)))


def looks_after(world: World, events: Iterable[WorldEvent], *, time: float = math.inf) -> Looks:
    """Return the appearance of a world after events, in their order.

    Args:
        world: The world as written.
        events: Past events.
        time: The instant, for hands that are still moving; by default they have arrived [s].
    """
    looks = replace(first_looks(world), time=time)
    for event in events:
        looks = looks.after(event, world)
    return looks
