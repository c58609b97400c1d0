"""Where people of a world are: those who stand as they say, those who sit as their seats and targets let them."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mjsim.geometry import Array
from mjsim.posture.sitting import Goals, Seated, Seating, Sitter
from mjsim.world import GripTarget, Person, PlacedTarget, World, item_names, placed_targets, world_from_seat


@dataclass(frozen=True, slots=True, eq=False)
class Workstation:
    """A person's seat, and what the world gives hands, feet and eyes to meet."""

    seating: Seating
    goals: Goals
    targets: Mapping[str, PlacedTarget]
    """All targets of the world by `THING.TARGET`."""

    @classmethod
    def of(cls, world: World, person: Person) -> "Workstation":
        """Return the workplace of a person who sits."""
        things = dict(zip(item_names(world.obstacles), world.obstacles, strict=True))
        thing, targets = things[str(person.seat)], {each.name: each for each in placed_targets(world)}
        assert thing.seat is not None, "the world has been checked"
        back = None if thing.seat.back_deg is None else math.radians(thing.seat.back_deg)
        along, up = thing.seat.travel
        seating = Seating(world_from_seat=world_from_seat(thing), back=back, travel=(along, up))
        hands = {side: _held(targets[name]) for side, name in _sides(person.hands).items()}
        feet = {side: _point(targets[name]) for side, name in _sides(person.feet).items()}
        gaze = None if person.gaze is None else _point(targets[person.gaze])
        return cls(seating, Goals(hands=hands, feet=feet, gaze=gaze), targets)


def seated(world: World, person: Person) -> Seated:
    """Return how a person sits."""
    place = Workstation.of(world, person)
    return Sitter(person.figure, place.seating).sit(place.goals)


def poses_of(world: World, person: Person) -> dict[str, Array]:
    """Return world from segment of a person by the segment's name, shape (4, 4) each [m]."""
    if person.seat is None:
        return person.poses()
    found = seated(world, person)
    return person.figure.poses(found.values, found.world_from_pelvis)


def _sides(pair: object) -> dict[str, str]:
    """Return what the left and the right have, of those that have something."""
    named = {side: getattr(pair, side) for side in ("left", "right")}
    return {side: name for side, name in named.items() if name is not None}


def _point(placed: PlacedTarget) -> Array:
    return np.array(placed.world_from_target[:3, 3])


def _held(placed: PlacedTarget) -> tuple[str, Array]:
    assert isinstance(placed.target, GripTarget), "the world has been checked"
    return placed.target.touch, _point(placed)
