"""Change single values of a world by their path, as `--set KEY=VALUE` does."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from pydantic import ValidationError
from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

from mjsim.errors import UsageError, did_you_mean
from mjsim.world.check import check_world
from mjsim.world.ground import path_of, sentence
from mjsim.world.items import SENSOR_KINDS, World
from mjsim.world.read.reader import parse_world

_VARIABLES = "variables"


def with_settings(world: World, settings: Iterable[str]) -> World:
    """Return the world with values changed.

    Args:
        world: Stays as it is.
        settings: 'robots.scout.odometry.noise.turn=0.02' and the like: keys by their names, items of a list by
            their name (a sensor's is that of its kind) or their number from 0; the value is YAML. 'variables.width=4'
            changes a variable of the text, and all that is computed from it.

    Raises:
        WorldError: With other variables the text describes no world.
        UsageError: There is no such key, the value does not fit it, or it is implausible, such as a place in a wall.
    """
    given = [_parts(setting) for setting in settings]
    world = _with_variables(world, [part for part in given if part[0][0] == _VARIABLES])
    changed = _with_parts(world, [part for part in given if part[0][0] != _VARIABLES], f"--set {', '.join(settings)}")
    known = {problem.message for problem in check_world(world)}
    for problem in check_world(changed):
        if problem.message not in known:
            raise UsageError(f"--set {', '.join(settings)}: {problem.message}")
    return changed


def with_values(world: World, values: Mapping[str, Any]) -> World:
    """Return the world with values changed, by their keys as `with_settings` has them; without asking what is meant.

    Raises:
        UsageError: There is no such key, or the value does not fit it.
    """
    parts = [(key.split("."), value, key) for key, value in values.items()]
    return _with_parts(world, parts, ", ".join(values))


def _with_parts(world: World, given: Sequence[tuple[list[str], Any, str]], what: str) -> World:
    tree = world.model_dump(exclude_unset=True)
    full = world.model_dump()
    for path, value, setting in given:
        _put(tree, full, path, value, setting)
    try:
        changed = World.model_validate(tree, context={"source": world.source})
    except ValidationError as error:
        first = error.errors()[0]
        raise UsageError(f"{what}: {sentence(first, path_of(first), World)}") from None
    changed._source = world.source
    return changed


def _parts(setting: str) -> tuple[list[str], Any, str]:
    """Return the path of a setting, its value, and itself."""
    key, equals, text = setting.partition("=")
    if not equals or not key:
        raise UsageError(f"--set {setting}: write it as KEY=VALUE, such as run.seconds=20")
    try:
        return key.split("."), YAML(typ="safe", pure=True).load(text), f"--set {setting}"
    except YAMLError:
        raise UsageError(f"--set {setting}: '{text}' is not a YAML value") from None


def _with_variables(world: World, given: Sequence[tuple[list[str], Any, str]]) -> World:
    """Return the world that its text describes with other values of its variables."""
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


def _put(tree: Any, full: Any, path: list[str], value: Any, setting: str) -> None:
    """Put a value at its path; `full` holds every key that there may be."""
    head, rest = path[0], path[1:]
    if isinstance(full, (list, tuple)):
        names = [called(item, str(k)) for k, item in enumerate(full)]
        index = int(head) if head.isdigit() and int(head) < len(full) else None
        if head in names:
            index = names.index(head)
        if index is None:
            raise UsageError(f"{setting}: no item '{head}'{did_you_mean(head, names)}")
        head_key: Any = index
    else:
        if not isinstance(full, dict) or (head not in full and "use" not in full):
            raise UsageError(f"{setting}: no key '{head}'{did_you_mean(head, full if isinstance(full, dict) else ())}")
        head_key = head
    if not rest:
        tree[head_key] = value
        return
    if isinstance(tree, dict) and not isinstance(tree.get(head_key), (dict, list)):
        held = full.get(head_key)
        tree[head_key] = list(held) if isinstance(held, (list, tuple)) else dict(held) if isinstance(held, dict) else {}
    _put(tree[head_key], full[head_key] or {}, rest, value, setting)


def called(item: Any, number: str) -> str:
    """Return the name of an item of a list, a sensor's being that of its kind; else its number."""
    keys = ("name", *SENSOR_KINDS) if isinstance(item, dict) else ()
    return next((item[key] for key in keys if isinstance(item.get(key), str)), number)
