"""Initial positions of beacons: in the room, on objects, on robots."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from mjsim.geometry import Pose
from mjsim.world.items import Beacon, Obstacle, Robot, World
from mjsim.world.plan.outlines import stays


@dataclass(frozen=True, slots=True)
class Hung:
    """A beacon with its position."""

    beacon: Beacon
    carrier: Obstacle | Robot | None
    """What carries it; None for the room."""
    place: Pose
    """World frame; the heading is the direction that it faces [m, m, rad]."""
    center: float
    """Height of its centre above the floor [m]."""

    @property
    def fixed(self) -> bool:
        """Whether it never moves: in the room, or on a static object."""
        return self.carrier is None or (not isinstance(self.carrier, Robot) and stays(self.carrier))


def hung(world: World) -> Iterator[Hung]:
    """Yield the initial position of each beacon, in the order of the world."""
    carriers: dict[str | None, Obstacle | Robot] = {}
    if any(beacon.on is not None for beacon in world.beacons):
        carriers = {item.name: item for item in (*world.obstacles, *world.robots) if item.name is not None}
    for beacon in world.beacons:
        place = Pose(beacon.at[0], beacon.at[1], math.radians(beacon.heading_deg))
        carrier = carriers[beacon.on] if beacon.on is not None else None
        center = beacon.center
        if carrier is not None:
            place = Pose(carrier.at[0], carrier.at[1], math.radians(carrier.heading_deg)) @ place
        if carrier is not None and not isinstance(carrier, Robot):
            center += carrier.elevation
        yield Hung(beacon, carrier, place, center)
