"""Checks for implausible values: robots in walls, hidden beacons, misfitting openings, lamps that light nothing."""

import itertools
import math
from collections.abc import Iterator
from functools import partial

import numpy as np

from mjsim.errors import Problem, UsageError
from mjsim.sentences import Sentence
from mjsim.world.check.lead_checks import misled_joints
from mjsim.world.check.mover_checks import misled
from mjsim.world.check.overlaps import MAX_OVERLAP, Finding, Solids, called, disc, pair
from mjsim.world.check.reach_checks import beyond_reach
from mjsim.world.items import NoiseEvent, Robot, Wall, World, name_of, sensors, with_noise
from mjsim.world.plan import Hung, hung
from mjsim.world.yaml import problems_at

MAX_BEACON, MAX_SPAN, MAX_MOUNT = 20.0, 1000.0, 20.0
"""Largest beacon, extent of walls, and coordinate of a sensor on its robot, for which the unit is not doubted [m]."""
MAX_SOFT_OVERLAP = 0.02
"""Depth to which objects and people may overlap a person, whose body is soft [m]."""
IN_FRONT = 0.05
"""A picture is hidden if something is closer than this in front of its centre [m]."""


def check_world(world: World) -> list[Problem]:
    """Return the implausible values of a valid world, sorted by position; no user code is run."""
    findings = itertools.chain(
        *(_openings(world), _crowded(world), _deaf_tags(world), beyond_reach(world), _noise_of_nothing(world)),
        *(misled_joints(world), _diverging(world), hidden_lamps(world), _gigantic(world)),
    )
    source = world.source
    faults = ((path, partial(str, message)) for message, path in findings)
    return sorted(problems_at(source.written, source.file, faults))


def _gigantic(world: World) -> Iterator[Finding]:
    """Yield values that were perhaps written in millimetres."""
    for index, beacon in enumerate(world.beacons):
        if beacon.has_face and beacon.width > MAX_BEACON:
            sentence = Sentence("beacon '{name}' is {width:g} m wide; lengths are in metres", beacon.name, beacon.width)
            yield sentence, ("beacons", index, "width")
    corners = np.array([point for wall in world.walls for point in wall.points]).reshape(-1, 2)
    span = float(np.ptp(corners, axis=0).max()) if len(corners) else 0.0
    if span > MAX_SPAN:
        yield Sentence("the walls span {span:g} m; lengths are in metres", span), ("walls",)
    for index, robot in enumerate(world.robots):
        for number, sensor in enumerate(robot.sensors):
            if (away := max(map(abs, getattr(sensor, "at", (0.0,))))) > MAX_MOUNT:
                sentence = Sentence(
                    "sensor '{name}' is {away:g} m away from its robot; lengths are in metres", name_of(sensor), away
                )
                yield sentence, ("robots", index, "sensors", number, "at")


def _diverging(world: World) -> Iterator[Finding]:
    if world.mechanisms:  # Most worlds have none, and need not load the code for them.
        from mjsim.world.check.springs import diverging_springs

        yield from diverging_springs(world)


def _noise_of_nothing(world: World) -> Iterator[Finding]:
    for index, event in enumerate(world.run.events):
        if isinstance(event, NoiseEvent):
            try:
                with_noise(world, event.noise, event.value)
            except UsageError as error:
                yield str(error), ("run", "events", index, "noise")


def _openings(world: World) -> Iterator[Finding]:
    for number, wall in enumerate(world.walls):
        if wall.openings:
            for message, path in _openings_of(wall):
                yield message, ("walls", number, "openings", *path)


def _openings_of(wall: Wall) -> Iterator[Finding]:
    segments = wall.segments()
    for index, opening in enumerate(wall.openings):
        length = math.dist(*segments[opening.segment])
        end = opening.at + opening.width
        if end > length + MAX_OVERLAP:
            yield (
                Sentence(
                    "this opening goes from {at:g} to {end:g} m; segment {segment} is {length:g} m long,"
                    " keep it within",
                    *(opening.at, end, opening.segment, length),
                ),
                (index, "at" if opening.at >= length else "width"),
            )
        # A door cuts a low wall over its full height; only an explicitly written height is a mistake.
        if opening.head > wall.height + MAX_OVERLAP and "head" in opening.model_fields_set:
            yield (
                Sentence("head is {head:g} m; the wall is {height:g} m high, keep it below", opening.head, wall.height),
                (index, "head"),
            )
        if opening.sill >= wall.height:
            yield (
                Sentence("sill is {sill:g} m; the wall is {height:g} m high, keep it below", opening.sill, wall.height),
                (index, "sill"),
            )
        for other_index, other in enumerate(wall.openings[:index]):
            beside = other.segment != opening.segment or opening.at >= other.at + other.width - MAX_OVERLAP
            above = opening.sill >= other.head or other.sill >= opening.head
            if not (beside or above or other.at >= end - MAX_OVERLAP):
                yield (
                    Sentence(
                        "this opening overlaps openings[{other_index}] of its wall; move or narrow it", other_index
                    ),
                    (index,),
                )


def _crowded(world: World) -> Iterator[Finding]:
    if not (world.robots or world.beacons or world.people or any(item.path is not None for item in world.obstacles)):
        return
    solids = Solids(world)
    yield from misled(world, solids)
    yield from _robots_in_things(world, solids)
    yield from _people_in_things(world, solids)
    for index, item in enumerate(hung(world)):
        for message in (*_hidden(item, solids), *_hidden_in_robot(item)):
            yield message, ("beacons", index, "at")


def _robots_in_things(world: World, solids: Solids) -> Iterator[Finding]:
    for index, robot in enumerate(world.robots):
        radius = robot.body.radius
        found = solids.reached(disc(robot.at, radius - MAX_OVERLAP), depth=0.0, low=0.0, high=robot.body.height)
        for other in world.robots[:index]:
            if math.dist(robot.at, other.at) < radius + other.body.radius - MAX_OVERLAP:
                found = found or Sentence("robot '{name}'", other.name)
        if found:
            yield (
                Sentence(
                    "robot '{name}' at {pair} starts inside {found}; its body needs {radius:g} m free all around",
                    *(robot.name, pair(robot.at), found, radius),
                ),
                ("robots", index, "at"),
            )


def _people_in_things(world: World, solids: Solids) -> Iterator[Finding]:
    for index, person in enumerate(world.people):
        if person.seat is not None:
            continue  # on a seat and among its controls; `mjsim ergonomics` reports the clearances
        below = person.floors if person.elevation is None else ()
        stood_on = (called(thing, number) for number, thing in enumerate(world.obstacles) if thing in below)
        own = Sentence("person '{name}'", person.name), *stood_on
        inside = (
            solids.reached(outline, depth=MAX_SOFT_OVERLAP, low=low + MAX_SOFT_OVERLAP, high=high, but=own)
            for outline, low, high in person.prisms.values()
        )
        found = next(filter(None, inside), None)
        if found:
            yield (
                Sentence(
                    "person '{name}' at {pair} stands inside {found}; move one of them",
                    *(person.name, pair(person.at), found),
                ),
                ("people", index, "at"),
            )


def _deaf_tags(world: World) -> Iterator[Finding]:
    """Yield the radio tags without an anchor in range; anchors on a tag's own robot do not count."""
    for index, robot in enumerate(world.robots):
        if any(beacon.anchor and beacon.on != robot.name for beacon in world.beacons):
            continue
        for place, sensor in enumerate(robot.sensors):
            if isinstance(sensor, sensors.Uwb):
                yield (
                    Sentence(
                        "tag '{uwb}' of robot '{name}' has no anchors to measure in this world; add beacons"
                        " with anchor: true",
                        sensor.uwb,
                        robot.name,
                    ),
                    ("robots", index, "sensors", place, "uwb"),
                )


def _hidden(item: Hung, solids: Solids) -> Iterator[str]:
    beacon, (x, y) = item.beacon, (item.place.x, item.place.y)
    tilt = math.radians(beacon.tilt_deg)
    ahead, up = IN_FRONT * math.cos(tilt), IN_FRONT * math.sin(tilt)
    c, s = math.cos(item.place.heading), math.sin(item.place.heading)
    probes = (((x, y), item.center, "hangs inside"), ((x + ahead * c, y + ahead * s), item.center + up, ""))
    for probe, level, word in probes:
        if not word and not beacon.has_face:
            return  # others have no side to face
        found = solids.reached(np.array([probe]), depth=MAX_OVERLAP, low=level - MAX_OVERLAP, high=level + MAX_OVERLAP)
        if found:
            right = "move it to a face" if word else "turn it around or move it"
            host = Sentence(" on '{on}'", beacon.on) if beacon.on is not None else ""
            yield Sentence(
                "beacon '{name}' at {place}{host} {how} {found}, where it cannot be seen; {right}",
                *(beacon.name, pair(beacon.at), host, word or "faces into", found, right),
            )
            return


def _hidden_in_robot(item: Hung) -> Iterator[str]:
    beacon, robot = item.beacon, item.carrier
    if isinstance(robot, Robot) and item.center < robot.body.height - MAX_OVERLAP:
        from shapely import Point, Polygon

        inner = Polygon(robot.body.outline()).buffer(-MAX_OVERLAP)
        if inner.intersects(Point(beacon.at)):
            yield (
                Sentence(
                    "beacon '{name}' at {pair} on '{robot}' hangs inside this robot, whose body is"
                    " {height:g} m high; move it out or above",
                    *(beacon.name, pair(beacon.at), robot.name, robot.body.height),
                )
            )


def hidden_lamps(world: World) -> Iterator[Finding]:
    """Yield the lamps that light nothing; in plain light there are no shadows, and all lamps shine."""
    if world.shading == "plain" or not world.lamps:
        return
    solids, ceiling = Solids(world), _ceiling(world)
    for index, lamp in enumerate(world.lamps):
        level = lamp.height - MAX_OVERLAP
        found = solids.reached(np.array([lamp.at]), depth=MAX_OVERLAP, low=level, high=lamp.height)
        name = Sentence("lamp '{name}'", lamp.name) if lamp.name else f"lamps[{index}]"
        if found:
            yield (
                Sentence(
                    "{name} at {pair} is inside {found} and lights nothing; move it out", name, pair(lamp.at), found
                ),
                ("lamps", index, "at"),
            )
        elif ceiling is not None and level > ceiling:
            yield (
                Sentence(
                    "{name} is {height:g} m high, above the ceiling at {ceiling:g} m, and lights nothing; lower it",
                    *(name, lamp.height, ceiling),
                ),
                ("lamps", index, "height" if "height" in lamp.model_fields_set else "at"),
            )


def _ceiling(world: World) -> float | None:
    """Return the height of the ceiling [m]; None if there is none, or objects alone determine it."""
    if world.ceiling is None:
        return None
    if world.ceiling.height is not None:
        return world.ceiling.height
    return max((wall.height for wall in world.walls), default=None)
