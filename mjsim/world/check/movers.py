"""Valid but implausible motion: movers that go through walls, and things that events put inside others."""

from collections.abc import Collection, Iterator
from itertools import pairwise

import numpy as np

from mjsim.world.check.standing import SPARE, Doubt, Solids, called, disc, pair
from mjsim.world.items import MoveEvent, Obstacle, RemoveEvent, World
from mjsim.world.plan import prisms, stays


def misled(world: World, solids: Solids) -> Iterator[Doubt]:
    """Yield what is wrong with the paths of movers and the goals of events."""
    removed = {event.remove for event in world.run.events if isinstance(event, RemoveEvent)}
    numbered = list(enumerate(world.obstacles))
    loose = {called(item, number) for number, item in numbered if not stays(item) or item.name in removed}
    for number, obstacle in numbered:
        if obstacle.path is not None:
            yield from _through_things(obstacle, number, solids, loose)
    yield from _put_into_things(world, solids, loose)


def _through_things(obstacle: Obstacle, number: int, solids: Solids, loose: Collection[str]) -> Iterator[Doubt]:
    """Yield the first stretch of a mover's path on which it meets what stays."""
    assert obstacle.path is not None
    stops = [obstacle.at, *obstacle.path.points, *([obstacle.at] if obstacle.path.closed else [])]
    for index, stretch in enumerate(pairwise(stops)):
        for outline, low, high in prisms(obstacle):
            # What is convex sweeps, on a straight way, the hull of where it begins and where it ends.
            moved = [outline + np.subtract(place, obstacle.at) for place in stretch]
            found = solids.reached(np.concatenate(moved), depth=SPARE, low=low + SPARE, high=high - SPARE, but=loose)
            if found:
                point = min(index, len(obstacle.path.points) - 1)
                message = f"{called(obstacle, number)} goes through {found} on its way to {pair(stretch[1])}"
                yield f"{message}; lead it round", ("obstacles", number, "path", "points", point)
                return


def _put_into_things(world: World, solids: Solids, loose: Collection[str]) -> Iterator[Doubt]:
    """Yield the events that put a robot or an obstacle down inside what stays."""
    radii = {robot.name: (robot.body.radius, robot.body.height) for robot in world.robots}
    things = {item.name: item for item in world.obstacles if item.movable}
    for index, event in enumerate(world.run.events):
        if not isinstance(event, MoveEvent):
            continue
        if event.move in radii:
            radius, height = radii[event.move]
            parts = [(disc(event.to, radius), 0.0, height)]
        else:
            turned = {} if event.heading_deg is None else {"heading_deg": event.heading_deg}
            moved = things[event.move].model_copy(update={"at": event.to, **turned})
            parts = [(outline, low + SPARE, high) for outline, low, high in prisms(moved)]
        for shape, low, high in parts:
            found = solids.reached(shape, depth=SPARE, low=low, high=high, but=loose)
            if found:
                where = pair(event.to)
                message = f"'{event.move}' is put down at {where} inside {found}; move it to where it has room"
                yield message, ("run", "events", index, "to")
                break
