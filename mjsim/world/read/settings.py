"""Loads worlds, and changes single values of them by their path, as `--set KEY=VALUE` does."""

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path as FilePath
from typing import Any

from mjsim.errors import UsageError, WorldError, did_you_mean
from mjsim.sentences import Sentence
from mjsim.world.check import check_world
from mjsim.world.files import Source, world_path
from mjsim.world.items import World, with_parts
from mjsim.world.read.world_reader import parse_world, read_file
from mjsim.world.yaml import read_value

_VARIABLES = "variables"
Settings = Iterable[str] | Mapping[str, Any]
"""Texts 'KEY=VALUE' as of `--set`, or values by key."""


def with_settings(world: World, settings: Settings) -> World:
    """Return the world with values changed.

    Args:
        world: Not modified.
        settings: Such as 'robots.scout.odometry.noise.turn=0.02', or a mapping {'run.seconds': 5}: keys by name, items
            of a list by name (for a sensor, the value of its kind) or by index from 0; the value is YAML.
            'variables.width=4' changes a variable of the text, and all that is computed from it.

    Raises:
        WorldError: With the changed variables, the text is not a valid world.
        UsageError: The key does not exist, or the value is invalid or implausible, such as a position in a wall.
    """
    settings = setting_texts(settings) if isinstance(settings, Mapping) else tuple(settings)
    given = [_parts(setting) for setting in settings]
    world = _with_variables(world, [part for part in given if part[0][0] == _VARIABLES])
    changed = with_parts(
        world, [part for part in given if part[0][0] != _VARIABLES], Sentence("--set {setting}", ", ".join(settings))
    )
    if problems := check_world(changed):
        known = {problem.message for problem in check_world(world)}
        for problem in problems:
            if problem.message not in known:
                raise UsageError(Sentence("--set {settings}: {message}", ", ".join(settings), problem.message))
    return changed


def setting_texts(values: Mapping[str, Any]) -> tuple[str, ...]:
    """Return values by key as texts of `with_settings`; JSON is valid YAML.

    Raises:
        UsageError: A world file cannot hold one of the values.
    """
    texts = []
    for key, value in values.items():
        try:
            texts.append(f"{key}={json.dumps(value)}")
        except (TypeError, ValueError):
            raise UsageError(
                Sentence("--set {key}: a value of type {type} cannot be in a world file", key, type(value).__name__)
            ) from None
    return tuple(texts)


def load_world(path: str | FilePath, *, settings: Settings = ()) -> World:
    """Return the world of a file; pictures and modules are looked up beside it.

    Args:
        path: The file, or the name of a shipped world.
        settings: Values to change, as for `with_settings`: {"run.seconds": 5}.

    Raises:
        UsageError: The file, or the shipped world, does not exist, or a setting is invalid.
        WorldError: The text is invalid; every error is reported.
    """
    path = world_path(path)
    world = parse_world(read_file(path), source=Source(file=str(path), folder=path.parent.absolute()))
    return with_settings(world, settings) if settings else world


def load_checked(path: str | FilePath, *, settings: Settings = ()) -> World:
    """Return the world of a file, as by `load_world`, after checking it with `check_world`.

    Raises:
        UsageError: The file, or the shipped world, does not exist, or a setting is invalid.
        WorldError: The text is invalid or a value implausible; every error is reported.
    """
    world = load_world(path, settings=settings)
    if problems := check_world(world):
        raise WorldError(problems)
    return world


def _parts(setting: str) -> tuple[list[str], Any, str]:
    """Return the path of a setting, its value, and the setting itself."""
    key, equals, text = setting.partition("=")
    if not equals or not key:
        raise UsageError(Sentence("--set {setting}: write it as KEY=VALUE, such as run.seconds=20", setting))
    try:
        return key.split("."), read_value(text), Sentence("--set {setting}", setting)
    except ValueError:
        raise UsageError(Sentence("--set {setting}: '{text}' is not a YAML value", setting, text)) from None


def _with_variables(world: World, given: Sequence[tuple[list[str], Any, str]]) -> World:
    """Return the world described by its text with changed variables."""
    known, source = world.source.variables, world.source
    for path, value, setting in given:
        name = ".".join(path[1:])
        if name not in known:
            raise UsageError(
                Sentence("{setting}: no variable '{name}'{meant}", setting, name, did_you_mean(name, known))
            )
        if not isinstance(value, (bool, int, float, str)):
            raise UsageError(
                Sentence(
                    "{setting}: variable '{name}' needs a single value, such as {known}", setting, name, known[name]
                )
            )
    if not given or source.text is None:
        return world
    if parse_world(source.text, source=source) != world:
        raise UsageError(
            Sentence("{setting}: this world was changed after it was read; change its values in Python", given[0][2])
        )
    return parse_world(source.text, source=source, variables={path[1]: value for path, value, _ in given})
