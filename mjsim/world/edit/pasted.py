"""Parses items from a fragment of text, such as one copied from another world."""

from collections.abc import Iterator
from typing import Any

from mjsim.errors import UsageError, did_you_mean
from mjsim.sentences import Sentence
from mjsim.world.ground import models_at
from mjsim.world.items import World
from mjsim.world.yaml import MAX_BYTES, read_text, too_large

LISTS: dict[str, tuple[str, ...]] = {
    **{name: (name,) for name in ("walls", "obstacles", "beacons", "robots", "lamps", "mechanisms", "people")},
    "floor": ("floor", "patches"),
}
"""Lists of items with a position, and their paths in a world."""
_NONE = (
    "this text contains no item of a world; copy items such as '- {box: [1, 1, 1], at: [2, 3]}', or a world with some"
)


def items_in(text: str) -> list[tuple[str, dict[str, Any]]]:
    """Return the items of a text as written, each with its key in `LISTS`.

    Args:
        text: YAML: keys of a world with their lists, other keys being ignored; or only items, as a list or a single
            one, whose kind follows from their keys.

    Raises:
        UsageError: It contains no items, or one that is invalid in any world; the message says which.
    """
    if len(text) > MAX_BYTES:
        raise UsageError(too_large(len(text)))
    node, problems = read_text(text, file="")
    if node is None or problems:
        raise UsageError(_NONE)
    value = node.value
    if isinstance(value, dict) and not value.keys().isdisjoint(LISTS):
        found = list(_listed(value))
    else:
        items = value if isinstance(value, list) else [value]
        found = [(_list_of(item), item) for item in items]
    if not found:
        raise UsageError(_NONE)
    return found


def _listed(world: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the items in the lists of a world."""
    for name, path in LISTS.items():
        items: Any = world
        for key in path:
            items = items.get(key) if isinstance(items, dict) else None
        for number, item in enumerate(items if isinstance(items, list) else []):
            if not isinstance(item, dict) or not _fits(item, name):
                raise UsageError(
                    Sentence(
                        "{path}[{number}] is not an item of a world{hint}", ".".join(path), number, _hint(item, name)
                    )
                )
            yield name, item


def _list_of(item: Any) -> str:
    """Return the list to which an item belongs: the first whose items can have all of its keys."""
    found = next((name for name in LISTS if isinstance(item, dict) and _fits(item, name)), None)
    if found is None:
        raise UsageError(_NONE)
    return found


def _fits(item: dict[str, Any], name: str) -> bool:
    """Return whether a kind of item in a list has all keys of an item, and requires no others."""
    keys = item.keys() - {"repeat"}
    kinds = models_at(World, LISTS[name])
    needed = [{key for key, field in kind.model_fields.items() if field.is_required()} for kind in kinds]
    return any(need <= keys <= kind.model_fields.keys() for need, kind in zip(needed, kinds, strict=True))


def _hint(item: Any, name: str) -> str:
    """Return a hint which key of an item is unknown; '' if all are known, but not in this combination."""
    if not isinstance(item, dict):
        return ""
    known = {"repeat"}.union(*(kind.model_fields for kind in models_at(World, LISTS[name])))
    wrong = next((str(key) for key in item if key not in known), None)
    return "" if wrong is None else Sentence(": unknown key '{wrong:.40}'{meant}", wrong, did_you_mean(wrong, known))
