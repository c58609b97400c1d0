"""Worlds with single values changed, selected by path."""

from collections.abc import Mapping, Sequence
from typing import Any

from pydantic import ValidationError

from mjsim.errors import UsageError, did_you_mean
from mjsim.sentences import Sentence
from mjsim.world.ground import composed, path_of, sentence
from mjsim.world.items.sensing import SENSOR_KINDS
from mjsim.world.items.world import World


def with_values(world: World, values: Mapping[str, Any]) -> World:
    """Return the world with values changed, with keys as in `with_settings`; without checks for plausibility.

    Raises:
        UsageError: The key does not exist, or the value is not allowed.
    """
    parts = [(key.split("."), value, key) for key, value in values.items()]
    return with_parts(world, parts, ", ".join(values))


def with_parts(world: World, given: Sequence[tuple[list[str], Any, str]], label: str) -> World:
    """Return the world with values changed.

    Args:
        world: Not modified.
        given: For each value its path, the value, and its name in errors.
        label: The name in errors of all of them.

    Raises:
        UsageError: The key does not exist, or the value is not allowed.
    """
    tree = world.model_dump(exclude_unset=True)
    full = world.model_dump()
    for path, value, setting in given:
        _put(tree, full, list(map(composed, path)), value, setting)
    try:
        changed = World.model_validate(tree, context={"source": world.source})
    except ValidationError as error:
        first = error.errors()[0]
        raise UsageError(Sentence("{label}: {problem}", label, sentence(first, path_of(first), World))) from None
    changed._source = world.source
    return changed


def _put(tree: Any, full: Any, path: list[str], value: Any, setting: str) -> None:
    """Set the value at a path; `full` has every allowed key."""
    head, rest = path[0], path[1:]
    if isinstance(full, (list, tuple)):
        names = [called(item, str(k)) for k, item in enumerate(full)]
        index = int(head) if head.isdigit() and int(head) < len(full) else None
        if head in names:
            index = names.index(head)
        if index is None:
            raise UsageError(Sentence("{setting}: no item '{head}'{meant}", setting, head, did_you_mean(head, names)))
        head_key: Any = index
    else:
        if not isinstance(full, dict) or (head not in full and "use" not in full):
            raise UsageError(
                Sentence(
                    "{setting}: no key '{head}'{meant}",
                    *(setting, head, did_you_mean(head, full if isinstance(full, dict) else ())),
                )
            )
        head_key = head
    if not rest:
        tree[head_key] = value
        return
    if isinstance(tree, dict) and not isinstance(tree.get(head_key), (dict, list)):
        held = full.get(head_key)
        tree[head_key] = list(held) if isinstance(held, (list, tuple)) else dict(held) if isinstance(held, dict) else {}
    _put(tree[head_key], full[head_key] or {}, rest, value, setting)


def called(item: Any, number: str) -> str:
    """Return the name of an item of a list (for a sensor, the value of its kind), or its number."""
    keys = ("name", *SENSOR_KINDS) if isinstance(item, dict) else ()
    return next((item[key] for key in keys if isinstance(item.get(key), str)), number)
