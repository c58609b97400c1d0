"""Checks for implausible motion: movers that pass through walls, and items that events place inside others."""

from collections.abc import Collection, Iterator
from itertools import pairwise

import numpy as np

from mjsim.geometry import Array
from mjsim.sentences import Sentence
from mjsim.world.check.overlaps import MAX_OVERLAP, Finding, Solids, called, disc, pair
from mjsim.world.items import MoveEvent, Obstacle, RemoveEvent, World, placement
from mjsim.world.plan import prisms, stays


def misled(world: World, solids: Solids) -> Iterator[Finding]:
    """Yield the problems of the paths of movers and of the target poses of events."""
    removed = {event.remove for event in world.run.events if isinstance(event, RemoveEvent)}
    numbered = list(enumerate(world.obstacles))
    loose = {called(item, number) for number, item in numbered if not stays(item) or item.name in removed}
    for number, obstacle in numbered:
        if obstacle.path is not None:
            yield from _through_things(obstacle, number, solids, loose)
    yield from _put_into_things(world, solids, loose)


def _through_things(obstacle: Obstacle, number: int, solids: Solids, loose: Collection[str]) -> Iterator[Finding]:
    """Yield the first section of a mover's path on which it hits something static."""
    assert obstacle.path is not None
    stops = [obstacle.at, *obstacle.path.points, *([obstacle.at] if obstacle.path.closed else [])]
    for index, stretch in enumerate(pairwise(stops)):
        for outline, low, high in prisms(obstacle):
            # On a straight path, a convex shape sweeps the convex hull of its start and end positions.
            moved = [outline + np.subtract(place, obstacle.at) for place in stretch]
            found = solids.reached(
                np.concatenate(moved), depth=MAX_OVERLAP, low=low + MAX_OVERLAP, high=high - MAX_OVERLAP, but=loose
            )
            if found:
                point = min(index, len(obstacle.path.points) - 1)
                message = Sentence(
                    "{obstacle} goes through {found} on its way to {pair}",
                    *(called(obstacle, number), found, pair(stretch[1])),
                )
                yield Sentence("{message}; route it around", message), ("obstacles", number, "path", "points", point)
                return


def misplaced(world: World, event: MoveEvent, *, removed: Collection[str] = ()) -> str | None:
    """Return why there is no space at the target of an event, considering static objects; None if there is space.

    Objects of the names in `removed` are not there.

    In a world with walls, a place outside the outermost walls also counts as unavailable, unless part of the world is
    there.
    """
    places = [point for wall in world.walls for point in wall.points]
    places += [item.at[:2] for item in (*world.robots, *world.obstacles)]
    if world.walls and not _within(event.to, np.asarray(places)):
        return Sentence(
            "'{move}' is placed at {pair} outside the world; move it to a free place", event.move, pair(event.to)
        )
    numbered = enumerate(world.obstacles)
    loose = {called(item, number) for number, item in numbered if not stays(item) or item.name in removed}
    return _inside(world, event, Solids(world), loose)


def _within(place: tuple[float, ...], points: Array) -> bool:
    """Return whether a place lies in the bounding box of points, shape (n, 2) [m]."""
    return bool((points.min(axis=0) <= place).all() and (points.max(axis=0) >= place).all())


def _put_into_things(world: World, solids: Solids, loose: Collection[str]) -> Iterator[Finding]:
    """Yield the events that place a robot or an obstacle inside something static."""
    for index, event in enumerate(world.run.events):
        move = placement(event)
        message = None if move is None else _inside(world, move, solids, loose)
        if message is not None:
            yield message, ("run", "events", index, "to")


def _inside(world: World, event: MoveEvent, solids: Solids, loose: Collection[str]) -> str | None:
    """Return the message for an event that places a robot or an obstacle in something static; None if it does not."""
    for shape, low, high in _put_down(world, event):
        found = solids.reached(shape, depth=MAX_OVERLAP, low=low, high=high, but=loose)
        if found:
            return Sentence(
                "'{move}' is placed at {pair} inside {found}; move it to a free place",
                *(event.move, pair(event.to), found),
            )
    return None


def _put_down(world: World, event: MoveEvent) -> list[tuple[Array, float, float]]:
    """Return what an event places: outlines, shape (n, 2), world frame, with lower and upper heights [m]."""
    for robot in world.robots:
        if robot.name == event.move:
            return [(disc(event.to, robot.body.radius), 0.0, robot.body.height)]
    thing = next(item for item in world.obstacles if item.movable and item.name == event.move)
    turned = {} if event.heading_deg is None else {"heading_deg": event.heading_deg}
    moved = thing.model_copy(update={"at": event.to, **turned})
    return [(outline, low + MAX_OVERLAP, high) for outline, low, high in prisms(moved)]
