"""Inconsistencies of the seats and targets of people."""

from collections.abc import Iterator, Mapping
from typing import Any

from mjsim.errors import did_you_mean
from mjsim.world.items.targets import TARGET_KINDS

SIDES = ("left", "right")
GAZE_TARGETS = ("sight", "display", "grip", "pedal")
"""Kinds of targets for the gaze: all."""
Misfit = tuple[str, tuple[str | int, ...]]


def sitting_misfits(keys: Mapping[str, Any]) -> Iterator[Misfit]:
    """Yield seats and targets that are missing, of the wrong kind, or taken, each as a message and its path."""
    people = keys.get("people")
    if not isinstance(people, (list, tuple)):
        return
    things, taken = _things(keys), dict[str, str]()
    for index, person in enumerate(people):
        if not isinstance(person, Mapping):
            continue
        seat = person.get("seat")
        if isinstance(seat, str):
            yield from ((sentence, ("people", index, "seat")) for sentence in _wrong_seat(seat, things, taken))
            taken[seat] = str(person.get("name"))
        for path, kinds, name in _named(person):
            wrong = _wrong_target(name, kinds, things)
            if wrong is not None:
                yield wrong, ("people", index, *path)


def _things(keys: Mapping[str, Any]) -> dict[str, Mapping[str, Any]]:
    obstacles = keys.get("obstacles")
    found = obstacles if isinstance(obstacles, (list, tuple)) else ()
    return {item["name"]: item for item in found if isinstance(item, Mapping) and isinstance(item.get("name"), str)}


def _wrong_seat(seat: str, things: Mapping[str, Mapping[str, Any]], taken: Mapping[str, str]) -> Iterator[str]:
    seats = [name for name, item in things.items() if item.get("seat") is not None]
    if seat not in things:
        yield f"no thing '{seat}' in this world{did_you_mean(seat, seats)}"
    elif seat not in seats:
        yield f"'{seat}' is not a seat; give it seat: {{at: [x, y, z]}}"
    elif seat in taken:
        yield f"'{taken[seat]}' sits on '{seat}' already; name another seat"


def _named(person: Mapping[str, Any]) -> Iterator[tuple[tuple[str, ...], tuple[str, ...], str]]:
    """Yield each target that a person names: its path, the allowed kinds, and its name."""
    for key, kind in (("hands", "grip"), ("feet", "pedal")):
        pair = person.get(key)
        held = pair if isinstance(pair, Mapping) else {}
        yield from (((key, side), (kind,), held[side]) for side in SIDES if isinstance(held.get(side), str))
    if isinstance(person.get("gaze"), str):
        yield ("gaze",), GAZE_TARGETS, person["gaze"]


def _wrong_target(name: str, kinds: tuple[str, ...], things: Mapping[str, Mapping[str, Any]]) -> str | None:
    """Return what is wrong with a target that a person names, or None."""
    thing, _, own = name.rpartition(".")
    if thing not in things:
        return f"no thing '{thing}' in this world{did_you_mean(thing, things)}" if thing else None
    targets = things[thing].get("targets")
    items = [item for item in targets if isinstance(item, Mapping)] if isinstance(targets, (list, tuple)) else []
    found = {str(item[kind]): kind for item in items for kind in TARGET_KINDS if kind in item}
    if own not in found:
        return f"no target '{own}' on '{thing}'{did_you_mean(own, found)}"
    if found[own] not in kinds:
        return f"'{name}' is a {found[own]}; it must be a {' or a '.join(kinds)}"
    return None
