"""Where beacons hang at the start: in the room, on things, on robots."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from mjsim.geometry import Pose
from mjsim.world.items import Beacon, Obstacle, Robot, World
from mjsim.world.plan.outlines import stays


@dataclass(frozen=True, slots=True)
class Hung:
    """A beacon at its place."""

    beacon: Beacon
    carrier: Obstacle | Robot | None
    """What it hangs on; None for the room."""
    place: Pose
    """World frame, facing along its heading."""
    center: float
    """Height of its middle above the floor [m]."""

    @property
    def fixed(self) -> bool:
        """Whether it hangs there as long as the world stands: in the room, or on a thing that stays."""
        return self.carrier is None or (not isinstance(self.carrier, Robot) and stays(self.carrier))


def hung(world: World) -> Iterator[Hung]:
    """Yield where each beacon hangs at the start, in the order of the world."""
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
