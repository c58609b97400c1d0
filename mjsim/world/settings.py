"""Change single values of a world by their path, as `--set KEY=VALUE` does."""

from collections.abc import Iterable
from typing import Any

from pydantic import ValidationError
from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

from mjsim.errors import UsageError, did_you_mean
from mjsim.world.check import check_world
from mjsim.world.model import World
from mjsim.world.words import path_of, sentence


def with_settings(world: World, settings: Iterable[str]) -> World:
    """Return the world with values changed.

    Args:
        world: Stays as it is.
        settings: 'robots.scout.odometry.noise.turn=0.02' and the like: keys by their names, items of a list by
            their `name` or their number from 0; the value is YAML.

    Raises:
        UsageError: There is no such key, the value does not fit it, or it cannot be meant, such as a place in a wall.
    """
    tree = world.model_dump(exclude_unset=True)
    full = world.model_dump()
    for setting in settings:
        key, equals, text = setting.partition("=")
        if not equals or not key:
            raise UsageError(f"--set {setting}: write it as KEY=VALUE, such as run.seconds=20")
        try:
            value = YAML(typ="safe", pure=True).load(text)
        except YAMLError:
            raise UsageError(f"--set {setting}: '{text}' is not a YAML value") from None
        _put(tree, full, key.split("."), value, setting)
    try:
        changed = World.model_validate(tree)
    except ValidationError as error:
        first = error.errors()[0]
        raise UsageError(f"--set {', '.join(settings)}: {sentence(first, path_of(first), World)}") from None
    changed._source = world.source
    known = {problem.message for problem in check_world(world)}
    for problem in check_world(changed):
        if problem.message not in known:
            raise UsageError(f"--set {', '.join(settings)}: {problem.message}")
    return changed


def _put(tree: Any, full: Any, path: list[str], value: Any, setting: str) -> None:
    """Put a value at its path; `full` holds every key that there may be."""
    head, rest = path[0], path[1:]
    if isinstance(full, (list, tuple)):
        names = [item.get("name") or str(k) if isinstance(item, dict) else str(k) for k, item in enumerate(full)]
        index = int(head) if head.isdigit() and int(head) < len(full) else None
        if head in names:
            index = names.index(head)
        if index is None:
            raise UsageError(f"--set {setting}: no item '{head}'{did_you_mean(head, names)}")
        head_key: Any = index
    else:
        if not isinstance(full, dict) or (head not in full and "use" not in full):
            raise UsageError(
                f"--set {setting}: no key '{head}'{did_you_mean(head, full if isinstance(full, dict) else ())}"
            )
        head_key = head
    if not rest:
        tree[head_key] = value
        return
    if isinstance(tree, dict) and not isinstance(tree.get(head_key), (dict, list)):
        held = full.get(head_key)
        tree[head_key] = list(held) if isinstance(held, (list, tuple)) else dict(held) if isinstance(held, dict) else {}
    _put(tree[head_key], full[head_key] or {}, rest, value, setting)
