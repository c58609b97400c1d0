"""What events make of the looks of a world: its light, and what is no longer there."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from mjsim.world.ground import item_names
from mjsim.world.items.events import LampEvent, LightEvent, ReachEvent, RemoveEvent, RestoreEvent, WorldEvent
from mjsim.world.items.world import World


@dataclass(frozen=True, slots=True)
class Looks:
    """How a world looks at an instant, but for where things stand."""

    light: float
    """General light."""
    lamps: Mapping[str, float]
    """Brightness of each lamp by its name."""
    removed: frozenset[str] = frozenset()
    """Names of obstacles and beacons that were taken away, with what they carried."""
    reached: Mapping[str, tuple[tuple[str, tuple[float, float, float]], ...]] = field(default_factory=dict)
    """Of each person whose hands have moved, in turn: which hand, and where its grip was to be, world frame [m]."""

    def after(self, event: WorldEvent, world: World) -> "Looks":
        """Return how the world looks after an event."""
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
                before = self.reached.get(event.reach, ())
                return replace(self, reached={**self.reached, event.reach: (*before, (hand, (x, y, z)))})
            case _:
                return self


def first_looks(world: World) -> Looks:
    """Return how a world looks before any event."""
    brightness = (lamp.brightness for lamp in world.lamps)
    return Looks(world.light, dict(zip(item_names(world.lamps), brightness, strict=True)))


def looks_after(world: World, events: Iterable[WorldEvent]) -> Looks:
    """Return how a world looks after events, in their order."""
    looks = first_looks(world)
    for event in events:
        looks = looks.after(event, world)
    return looks
