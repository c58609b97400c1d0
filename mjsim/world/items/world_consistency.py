"""Inconsistencies of a world: duplicate names, missing objects, invalid rates, seats and targets of people."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from mjsim.errors import did_you_mean
from mjsim.sentences import Sentence
from mjsim.world.ground import KEY, TakenNames
from mjsim.world.items.arms import RobotArm
from mjsim.world.items.drives import KINDS
from mjsim.world.items.running import Control, Run, nearest_divisor, step_misfit, whole_steps
from mjsim.world.items.sensing import SENSOR_KINDS
from mjsim.world.items.structure import Door
from mjsim.world.items.targets import TARGET_KINDS
from mjsim.world.items.timeline import OpenEvent

NAMED = ("walls", "obstacles", "beacons", "lamps", "robots", "mechanisms", "people", "plants")
"""Lists of items that may have a name."""
MAX_DOOR_ANGLE = 170
"""Upper bound of the angle of any door [deg]."""
Misfit = tuple[str, tuple[str | int, ...]]
"""A message, and the path of the value."""


def misfits(keys: Mapping[str, Any]) -> Iterator[Misfit]:
    """Yield inconsistencies in the keys of a world, each as a message and the path of the value.

    Values may be of any type: the models report values that are wrong by themselves.
    """
    yield from _names_taken(keys)
    yield from _sensors_taken(keys)
    yield from _carried_by_nothing(keys)
    yield from _plants_of_nothing(keys)
    yield from sitting_misfits(keys)
    run = keys.get("run", {})
    if isinstance(run, dict):
        yield from _drivers_without_robot(run, keys)
        yield from _rates_between_ticks(run, keys)
        yield from _controllers(run, keys)
        yield from _events_without_target(run, keys)


def _items(keys: Mapping[str, Any], kind: str) -> Iterator[tuple[int, dict[str, Any]]]:
    items = keys.get(kind)
    if isinstance(items, (list, tuple)):
        yield from ((index, item) for index, item in enumerate(items) if isinstance(item, dict))


def _names(items: Iterable[tuple[int, dict[str, Any]]]) -> set[str]:
    return {item["name"] for _, item in items if isinstance(item.get("name"), str)}


def _named_items(keys: Mapping[str, Any]) -> Iterator[tuple[str, tuple[str | int, ...], dict[str, Any]]]:
    """Yield each item that may have a name: its name in errors, its path and its keys."""
    for kind in NAMED:
        for index, item in _items(keys, kind):
            yield f"{kind}[{index}]", (kind, index), item
            if kind == "walls" and "openings" in item:
                for number, opening in _items(item, "openings"):
                    yield f"{kind}[{index}].openings[{number}]", (kind, index, "openings", number), opening


def _names_taken(keys: Mapping[str, Any]) -> Iterator[Misfit]:
    taken = TakenNames()
    for place, path, item in _named_items(keys):
        name = item.get("name")
        if isinstance(name, str) and (message := taken.fault(name, place, each="each item")):
            yield message, (*path, "name")


def _sensors(robot: Mapping[str, Any]) -> Iterator[tuple[int, str, dict[str, Any]]]:
    """Yield path, kind and keys of each sensor of a known kind."""
    for number, sensor in _items(robot, "sensors"):
        kind = next((kind for kind in SENSOR_KINDS if kind in sensor), None)
        if kind is not None:
            yield number, kind, sensor


def _sensors_taken(keys: Mapping[str, Any]) -> Iterator[Misfit]:
    for index, robot in _items(keys, "robots"):
        taken = TakenNames()
        for number, kind, sensor in _sensors(robot):
            name = sensor[kind]
            if isinstance(name, str) and (message := taken.fault(name, "another sensor of this robot")):
                yield message, ("robots", index, "sensors", number, kind)


def _carried_by_nothing(keys: Mapping[str, Any]) -> Iterator[Misfit]:
    carried = [(index, item["on"]) for index, item in _items(keys, "beacons") if isinstance(item.get("on"), str)]
    carriers = _names(_items(keys, "obstacles")) | _names(_items(keys, "robots")) if carried else set()
    for index, name in carried:
        if name not in carriers:
            yield (
                Sentence("no obstacle or robot '{name}' in this world{meant}", name, did_you_mean(name, carriers)),
                ("beacons", index, "on"),
            )


def _plants_of_nothing(keys: Mapping[str, Any]) -> Iterator[Misfit]:
    robots, mechanisms = _names(_items(keys, "robots")), _names(_items(keys, "mechanisms"))
    for index, plant in _items(keys, "plants"):
        of = plant.get("of")
        if isinstance(of, str) and of.partition("/")[0] not in robots | mechanisms:
            yield (
                Sentence(
                    "no robot or mechanism '{of}' in this world{meant}", of, did_you_mean(of, robots | mechanisms)
                ),
                ("plants", index, "of"),
            )


def _drivers_without_robot(run: Mapping[str, Any], keys: Mapping[str, Any]) -> Iterator[Misfit]:
    drivers = run.get("drivers")
    robots = _names(_items(keys, "robots"))
    for name in drivers if isinstance(drivers, dict) else ():
        if name not in robots:
            yield (
                Sentence("no robot '{name}' in this world{meant}", name, did_you_mean(name, robots)),
                ("run", "drivers", name, KEY),
            )


def _rates_between_ticks(run: Mapping[str, Any], keys: Mapping[str, Any]) -> Iterator[Misfit]:
    tick, step = run.get("rate_hz", Run().rate_hz), run.get("step_ms", Run().step_ms)
    if not _is_rate(tick) or not _is_rate(step) or not whole_steps(tick, step / 1000):
        return
    for index, robot in _items(keys, "robots"):
        for number, kind, sensor in _sensors(robot):
            rate = sensor.get("rate_hz", SENSOR_KINDS[kind].model_fields["rate_hz"].default)
            if not _is_rate(rate):
                continue
            between = SENSOR_KINDS[kind].between_ticks
            wrong = step_misfit("a period", rate, step / 1000) if between else _tick_misfit(rate, tick)
            if wrong is not None:
                yield wrong, ("robots", index, "sensors", number, "rate_hz")


def _controllers(run: Mapping[str, Any], keys: Mapping[str, Any]) -> Iterator[Misfit]:
    """Yield controllers of parts that cannot have one, and rates that are not a whole number of physics steps."""
    drivers, step = run.get("drivers"), run.get("step_ms", Run().step_ms)
    robots = {item["name"]: item for _, item in _items(keys, "robots") if isinstance(item.get("name"), str)}
    for name, modules in drivers.items() if isinstance(drivers, Mapping) else ():
        loops = modules.get("controllers") if isinstance(modules, Mapping) else None
        for part, loop in loops.items() if isinstance(loops, Mapping) and name in robots else ():
            path = ("run", "drivers", name, "controllers", part)
            parts = _controlled(robots[name])
            if parts is not None and part not in parts:
                yield _no_part(name, part, parts), (*path, KEY)
            rate = loop.get("rate_hz", Control.model_fields["rate_hz"].default) if isinstance(loop, Mapping) else None
            if rate is not None and _is_rate(rate) and _is_rate(step):
                wrong = step_misfit("a period", rate, step / 1000)
                if wrong is not None:
                    yield wrong, (*path, "rate_hz")


def _controlled(robot: Mapping[str, Any]) -> list[str] | None:
    """Return the parts of a robot that controllers can drive; None if that depends on a preset."""
    drive = robot.get("drive")
    kind = drive.get("type") if isinstance(drive, Mapping) else None
    if kind is None and isinstance(robot.get("preset"), str):
        return None
    arms = [str(arm.get("name", RobotArm.model_fields["name"].default)) for _, arm in _items(robot, "arms")]
    controlled = isinstance(kind, str) and kind in KINDS and KINDS[kind].controller is not None
    return ["drive", *arms] if controlled else arms


def _no_part(robot: str, part: object, parts: list[str]) -> str:
    if not parts:
        return Sentence("robot '{robot}' has no part that a controller drives; balancing bases and arms have", robot)
    return Sentence(
        "no part '{part}' of robot '{robot}' for a controller{meant}", part, robot, did_you_mean(str(part), parts)
    )


def _tick_misfit(rate: float, tick: float) -> str | None:
    if abs(tick / rate - round(tick / rate)) < 1e-9:
        return None
    nearest = nearest_divisor(tick, rate)
    return Sentence(
        "rate_hz is {rate:g} Hz; it must divide the {tick:g} Hz of the tick, the nearest is {nearest:g} Hz",
        *(rate, tick, nearest),
    )


def _is_rate(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and 0 < value <= 1000


def _events_without_target(run: Mapping[str, Any], keys: Mapping[str, Any]) -> Iterator[Misfit]:
    events = list(_items(run, "events"))
    if not events:
        return
    targets, people = _event_targets(keys), _names(_items(keys, "people"))
    mechanisms = _names(_items(keys, "mechanisms"))
    for index, event in events:
        for key, (kind, names) in targets.items():
            name = event.get(key)
            if not isinstance(name, str):
                continue
            if key in ("reach", "release") and (event.get("hand") is not None or name in people):
                kind, names = "person", people
            elif key == "release" and (event.get("joint") is not None or name in mechanisms):
                kind, names = "mechanism", mechanisms
            if name not in names:
                yield (
                    Sentence("no {kind} '{name}' in this world{meant}", kind, name, did_you_mean(name, names)),
                    ("run", "events", index, key),
                )
    yield from _opened_too_far(events, keys)
    movable = targets["move"][1]
    for index, event in events:
        name = event.get("restore")
        if event.get("to") is not None and name in targets["restore"][1] - movable:
            yield Sentence("'{name}' is not movable; leave out 'to'", name), ("run", "events", index, "to")


def _opened_too_far(events: list[tuple[int, dict[str, Any]]], keys: Mapping[str, Any]) -> Iterator[Misfit]:
    limits = {item["name"]: _limit(item["door"]) for _, _, item in _named_items(keys) if _has_door(item)}
    for index, event in events:
        name, angle = event.get("open"), event.get("angle_deg", OpenEvent.model_fields["angle_deg"].default)
        limit = limits.get(name) if isinstance(name, str) else None
        if limit is not None and isinstance(angle, (int, float)) and limit < abs(angle) <= MAX_DOOR_ANGLE:
            message = Sentence("angle_deg is {angle:g}; door '{name}' swings to {limit:g} at most", angle, name, limit)
            yield message, ("run", "events", index, "angle_deg" if "angle_deg" in event else "open")


def _has_door(item: Mapping[str, Any]) -> bool:
    return item.get("door") is not None and isinstance(item.get("name"), str)


def _limit(door: object) -> float | None:
    limit = door.get("limit_deg", Door.model_fields["limit_deg"].default) if isinstance(door, dict) else None
    return limit if isinstance(limit, (int, float)) and 0 < limit <= MAX_DOOR_ANGLE else None


def _event_targets(keys: Mapping[str, Any]) -> dict[str, tuple[str, set[str]]]:
    """Return, by the key of an event, the objects that it may name: a word for them, and their names."""
    obstacles = list(_items(keys, "obstacles"))
    rolling = [(index, item) for index, item in _items(keys, "robots") if item.get("base") != "fixed"]
    movable = [(index, item) for index, item in obstacles if item.get("movable") is True]
    doors = {item["name"] for _, _, item in _named_items(keys) if _has_door(item)}
    armed = _names((index, item) for index, item in _items(keys, "robots") if item.get("arms"))
    return {
        "move": ("robot or movable obstacle", _names(rolling) | _names(movable)),
        "shove": ("robot or movable obstacle", _names(rolling) | _names(movable)),
        "push": ("robot or movable obstacle", _names(rolling) | _names(movable)),
        "open": ("opening with a door", doors),
        "close": ("opening with a door", doors),
        "lamp": ("lamp", _names(_items(keys, "lamps"))),
        "restore": ("beacon or obstacle", _names(_items(keys, "beacons")) | _names(obstacles)),
        "reach": ("robot with an arm", armed),
        "release": ("robot with an arm", armed),
        "goal": ("robot that drives", _names(rolling)),
        "remove": ("beacon or obstacle", _names(_items(keys, "beacons")) | _names(obstacles)),
    }


SIDES = ("left", "right")
GAZE_TARGETS = ("sight", "display", "grip", "pedal")
"""Kinds of targets for the gaze: all."""


def sitting_misfits(keys: Mapping[str, Any]) -> Iterator[Misfit]:
    """Yield seats and targets that are missing, of the wrong kind, or taken, each as a message and its path."""
    taken: dict[str, str] = {}
    things = {item["name"]: item for _, item in _items(keys, "obstacles") if isinstance(item.get("name"), str)}
    for index, person in _items(keys, "people"):
        seat = person.get("seat")
        if isinstance(seat, str):
            yield from ((sentence, ("people", index, "seat")) for sentence in _wrong_seat(seat, things, taken))
            taken[seat] = str(person.get("name"))
        for path, kinds, name in _named(person):
            wrong = _wrong_target(name, kinds, things)
            if wrong is not None:
                yield wrong, ("people", index, *path)


def _wrong_seat(seat: str, things: Mapping[str, Mapping[str, Any]], taken: Mapping[str, str]) -> Iterator[str]:
    seats = [name for name, item in things.items() if item.get("seat") is not None]
    if seat not in things:
        yield Sentence("no thing '{thing}' in this world{meant}", seat, did_you_mean(seat, seats))
    elif seat not in seats:
        yield Sentence("'{name}' is not a seat; give it seat: {{at: [x, y, z]}}", seat)
    elif seat in taken:
        yield Sentence("'{taken}' sits on '{seat}' already; name another seat", taken[seat], seat)


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
        return (
            Sentence("no thing '{thing}' in this world{meant}", thing, did_you_mean(thing, things)) if thing else None
        )
    targets = things[thing].get("targets")
    items = [item for item in targets if isinstance(item, Mapping)] if isinstance(targets, (list, tuple)) else []
    found = {str(item[kind]): kind for item in items for kind in TARGET_KINDS if kind in item}
    if own not in found:
        return Sentence("no target '{own}' on '{thing}'{meant}", own, thing, did_you_mean(own, found))
    if found[own] not in kinds:
        return Sentence("'{name}' is a {found}; it must be a {kinds}", name, found[own], " or a ".join(kinds))
    return None
