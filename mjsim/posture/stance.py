"""Postures of people in a world: standing ones as specified, seated ones from their seats and targets."""

import math
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from mjsim.geometry import Array
from mjsim.posture.goals import Goals, Seating
from mjsim.world import (
    GripTarget,
    Obstacle,
    Person,
    PlacedTarget,
    RampObstacle,
    StepsObstacle,
    World,
    height_under,
    item_names,
    placed_targets,
    world_from_seat,
)

if TYPE_CHECKING:  # imports mink and scipy, which only seated people need
    from mjsim.people import Column, Figure
    from mjsim.posture.seated_figures import Seated

FEET_AHEAD, MIN_BELOW = 0.45, 0.25
"""Position of the feet of a seated person: forward of the hip point, and minimum height below it [m]; assumed."""
CACHE_SIZE = 64
"""Number of cached postures: a command compiles its world several times, a session at each change."""


@dataclass(frozen=True, slots=True, eq=False)
class Workstation:
    """A person's seat, and the targets of hands, feet and eyes in the world."""

    seating: Seating
    goals: Goals
    targets: Mapping[str, PlacedTarget]
    """All targets of the world by `OBJECT.TARGET`."""

    @classmethod
    def of(cls, world: World, person: Person) -> "Workstation":
        """Return the workplace of a seated person."""
        things = dict(zip(item_names(world.obstacles), world.obstacles, strict=True))
        thing, targets = things[str(person.seat)], {each.name: each for each in placed_targets(world)}
        assert thing.seat is not None, "the world has been checked"
        back = None if thing.seat.back_deg is None else math.radians(thing.seat.back_deg)
        along, up = thing.seat.travel
        seating = Seating(world_from_seat=world_from_seat(thing), back=back, travel=(along, up))
        hands = {side: _held(targets[name]) for side, name in _sides(person.hands).items()}
        feet = {side: _point(targets[name]) for side, name in _sides(person.feet).items()}
        gaze = None if person.gaze is None else _point(targets[person.gaze])
        others = [each for each in world.obstacles if each is not thing]
        floor = _floor_before(seating.world_from_seat, others)
        return cls(seating, Goals(hands=hands, feet=feet, gaze=gaze, floor=floor), targets)


@dataclass(frozen=True, slots=True)
class _Key:
    """A person on a seat; equal if body, seat and goals are equal."""

    key: Hashable
    figure: "Figure" = field(compare=False)
    place: Workstation = field(compare=False)

    @classmethod
    def of(cls, figure: "Figure", place: Workstation) -> "_Key":
        body = figure.measures.sex, *figure.measures.values()
        return cls((body, _plain(place.seating), _plain(place.goals)), figure, place)


def _plain(value: object) -> Hashable:
    """Return the parts of seatings and goals as hashable values: arrays as bytes, mappings as pairs."""
    match value:
        case np.ndarray():
            return value.tobytes()
        case Mapping():
            return tuple((name, _plain(each)) for name, each in value.items())
        case tuple():
            return tuple(_plain(each) for each in value)
        case Seating() | Goals():
            return tuple(_plain(getattr(value, each.name)) for each in fields(value))
        case _:
            return value


def seated(world: World, person: Person) -> "Seated":
    """Return the posture of a seated person; solved once while body, seat and goals stay the same."""
    return _solved(_Key.of(person.figure, Workstation.of(world, person)))


@lru_cache(maxsize=CACHE_SIZE)
def _solved(key: _Key) -> "Seated":
    from mjsim.posture.seated_figures import Sitter

    return Sitter(key.figure, key.place.seating).sit(key.place.goals)


def poses_of(world: World, person: Person) -> dict[str, Array]:
    """Return world_from_segment of a person by the segment's name, shape (4, 4) each [m]."""
    if person.seat is None:
        return person.poses()
    found = seated(world, person)
    return person.figure.poses(found.values, found.world_from_pelvis)


def columns_of(world: World, person: Person) -> "Mapping[str, Column]":
    """Return vertical prisms that contain the segments of a person in its posture; see `Person.prisms`."""
    if person.seat is None:
        return person.prisms
    return _seated_columns(_Key.of(person.figure, Workstation.of(world, person)))


@lru_cache(maxsize=CACHE_SIZE)
def _seated_columns(key: _Key) -> "Mapping[str, Column]":
    from mjsim.people import columns, surfaces

    found = _solved(key)
    return columns(surfaces(key.figure), key.figure.poses(found.values, found.world_from_pelvis))


def from_above(world: World, person: Person) -> Iterator[tuple[Array, str]]:
    """Yield outlines of a person's segments, lowest first, each with its colour.

    Outlines are convex, in the world frame, counter-clockwise, shape (n, 2) [m].
    """
    for segment, (outline, _, _) in columns_of(world, person).items():
        yield outline, person.color_of(segment)


def _floor_before(world_from_seat: Array, things: Sequence[Obstacle]) -> float:
    """Return the height on which the feet of a seated person rest [m]: of the floor, or of a platform on it.

    Args:
        world_from_seat: The hip point, x ahead, shape (4, 4) [m].
        things: All objects except the seat.
    """
    spot, max_height = world_from_seat[:2] @ (FEET_AHEAD, 0.0, 0.0, 1.0), world_from_seat[2, 3] - MIN_BELOW
    level = [each for each in things if not isinstance(each, RampObstacle | StepsObstacle)]
    return height_under(level, spot, limit=max_height)


def _sides(pair: object) -> dict[str, str]:
    """Return the values of the left and the right side that are given."""
    named = {side: getattr(pair, side) for side in ("left", "right")}
    return {side: name for side, name in named.items() if name is not None}


def _point(placed: PlacedTarget) -> Array:
    return np.array(placed.world_from_target[:3, 3])


def _held(placed: PlacedTarget) -> tuple[str, Array]:
    assert isinstance(placed.target, GripTarget), "the world has been checked"
    return placed.target.touch, _point(placed)
