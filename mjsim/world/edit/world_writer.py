"""Writes a `World` as text; a world that was read keeps its comments and layout."""

import dataclasses
from functools import partial
from typing import Any

from mjsim.errors import Problem, WorldError
from mjsim.world.edit.changes import write_back
from mjsim.world.edit.snippet import below, literal
from mjsim.world.edit.text_place import UnwritableError
from mjsim.world.files import Source
from mjsim.world.ground import Model
from mjsim.world.items import AnySensor, Robot, RobotArm, World, name_of
from mjsim.world.language import needs_expansion
from mjsim.world.read import parse_world
from mjsim.world.yaml import problems_at


def format_world(world: World) -> str:
    """Return a text that `parse_world` reads as an equal world.

    For a world that was read from text, the result is that text; if it was changed since, only differences are
    rewritten and all other comments stay. Default values are omitted.

    Raises:
        WorldError: A change affects an included file or a repeated item; the message says where.
    """
    text = world.source.text
    if text is None:
        return _fresh(world)
    # Included files are those that were read, even if they have changed since.
    source = dataclasses.replace(world.source, attached={**world.source.included, **world.source.attached})
    before = parse_world(text, source=source)
    if before == world:
        return text
    try:
        changed = write_back(text, _keys_of_world(before), _keys_of_world(world), source=source)
        if parse_world(changed, source=source) == world:
            return changed
        message = "this change cannot be written beside 'include', 'variables' and 'repeat'; change the text itself"
        faults = [Problem(source.file, 1, 1, message)]
    # An alias that stands for two values cannot be changed in only one place.
    except WorldError as error:
        faults = list(error.problems)
    except UnwritableError as error:
        faults = list(problems_at(before.source.written, source.file, [(error.path, partial(str, error))]))
    if needs_expansion(text):
        raise WorldError(faults)
    return _fresh(world)


def _fresh(world: World) -> str:
    return "\n".join([*below(_keys_of_world(world), 0), ""])


def _keys_of_world(world: World) -> dict[str, Any]:
    """Return the keys to write: all that differ from the default or the preset."""
    keys = literal(world.model_dump(mode="json", exclude_defaults=True, exclude={"robots"}))
    if world.robots:
        keys["robots"] = [_keys_of_robot(robot, world.source) for robot in world.robots]
    keys = {"mjsim": world.mjsim, "name": world.name, **keys}
    return {key: keys[key] for key in World.model_fields if key in keys}


def _keys_of_robot(robot: Robot, source: Source) -> dict[str, Any]:
    given = {"name": robot.name, "at": robot.at}
    if robot.preset is not None:
        given["preset"] = robot.preset
    if robot.base is not None:
        given["base"] = robot.base
    base = Robot.model_validate(given, context={"source": source})
    found = {**robot.model_dump(mode="json", include=set(given)), **_differing(robot, base)}
    if "noise" in robot.odometry.model_fields_set - base.odometry.model_fields_set:
        # Noise that is the usual one is kept too: a robot that names none has a note.
        found.setdefault("odometry", {}).setdefault("noise", robot.odometry.noise.model_dump(mode="json"))
    if "arms" in found:
        found["arms"] = [_keys_of_arm(arm) for arm in robot.arms]
    if "sensors" in found:
        found["sensors"] = [_keys_of_sensor(sensor) for sensor in robot.sensors]
    keys: dict[str, Any] = literal(found)
    return keys


def _keys_of_arm(arm: RobotArm) -> dict[str, Any]:
    if arm.preset is None:
        return arm.model_dump(mode="json", exclude_defaults=True)
    named = {"name": arm.name, "preset": arm.preset}
    return {**named, **_differing(arm, RobotArm.model_validate(named))}


def _keys_of_sensor(sensor: AnySensor) -> dict[str, Any]:
    preset = getattr(sensor, "preset", None)
    if preset is None:
        return sensor.model_dump(mode="json", exclude_defaults=True)
    named = {sensor.kind: name_of(sensor), "preset": preset}
    return {**named, **_differing(sensor, type(sensor).model_validate(named))}


def _differing(value: Model, base: Model) -> dict[str, Any]:
    """Return the keys of a model whose values differ from those of another model of its kind."""
    found = {}
    for key in type(value).model_fields:
        own, other = getattr(value, key), getattr(base, key)
        if own == other:
            continue
        if isinstance(own, Model) and type(own) is type(other):
            found[key] = _differing(own, other)
        else:
            found[key] = value.model_dump(mode="json", include={key}, exclude_defaults=True).get(key, own)
    return found
