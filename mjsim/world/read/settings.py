"""Changes single values of a world by their path, as `--set KEY=VALUE` does."""

from collections.abc import Iterable, Sequence
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

from mjsim.errors import UsageError, did_you_mean
from mjsim.world.check import check_world
from mjsim.world.items import World, with_parts
from mjsim.world.read.reader import parse_world

_VARIABLES = "variables"


def with_settings(world: World, settings: Iterable[str]) -> World:
    """Return the world with values changed.

    Args:
        world: Not modified.
        settings: Such as 'robots.scout.odometry.noise.turn=0.02': keys by name, items of a list by name (for a sensor,
            the value of its kind) or by index from 0; the value is YAML. 'variables.width=4' changes a variable of the
            text, and all that is computed from it.

    Raises:
        WorldError: With the changed variables, the text is not a valid world.
        UsageError: The key does not exist, or the value is invalid or implausible, such as a position in a wall.
    """
    given = [_parts(setting) for setting in settings]
    world = _with_variables(world, [part for part in given if part[0][0] == _VARIABLES])
    changed = with_parts(world, [part for part in given if part[0][0] != _VARIABLES], f"--set {', '.join(settings)}")
    known = {problem.message for problem in check_world(world)}
    for problem in check_world(changed):
        if problem.message not in known:
            raise UsageError(f"--set {', '.join(settings)}: {problem.message}")
    return changed


def _parts(setting: str) -> tuple[list[str], Any, str]:
    """Return the path of a setting, its value, and the setting itself."""
    key, equals, text = setting.partition("=")
    if not equals or not key:
        raise UsageError(f"--set {setting}: write it as KEY=VALUE, such as run.seconds=20")
    try:
        return key.split("."), YAML(typ="safe", pure=True).load(text), f"--set {setting}"
    except YAMLError:
        raise UsageError(f"--set {setting}: '{text}' is not a YAML value") from None


def _with_variables(world: World, given: Sequence[tuple[list[str], Any, str]]) -> World:
    """Return the world described by its text with changed variables."""
    known, source = world.source.variables, world.source
    for path, value, setting in given:
        name = ".".join(path[1:])
        if name not in known:
            raise UsageError(f"{setting}: no variable '{name}'{did_you_mean(name, known)}")
        if not isinstance(value, (bool, int, float, str)):
            raise UsageError(f"{setting}: variable '{name}' needs a single value, such as {known[name]}")
    if not given or source.text is None:
        return world
    if parse_world(source.text, source=source) != world:
        raise UsageError(f"{given[0][2]}: this world is no longer what its text says; set its values themselves")
    return parse_world(source.text, source=source, variables={path[1]: value for path, value, _ in given})
