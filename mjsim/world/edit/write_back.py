"""Writes a changed world back into its text: differences are rewritten, everything else stays.

Values in an included file or a repeated item cannot be changed from here; nothing is lost in that case.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from ruamel.yaml.comments import CommentedMap, CommentedSeq

from mjsim.world.edit.yaml_layout import styled
from mjsim.world.items import SENSOR_KINDS
from mjsim.world.language import OPEN
from mjsim.world.yaml import Node

Path = tuple[str | int, ...]


class ForeignError(Exception):
    """A change affects a value that is not written in the text, or written more than once; holds its path."""

    def __init__(self, path: Path, message: str) -> None:
        super().__init__(message)
        self.path, self.message = path, message


def write_changes(
    tree: Any, before: Mapping[str, Any], after: Mapping[str, Any], *, written: Node | None, raw: Node | None
) -> None:
    """Change a text's own tree where the keys before and after differ.

    Args:
        tree: Tree of the text in the form of ruamel.yaml; modified in place.
        before: The text's current keys.
        after: The wanted keys.
        written: The expanded text with the origin of each part; None if nothing is expanded.
        raw: The text as written; None if nothing is expanded.

    Raises:
        ForeignError: Part of a change belongs to another file, or to a repeated item.
    """
    _mapping(tree, before, after, written, raw, ())


def _mapping(
    tree: Any, before: Mapping[str, Any], after: Mapping[str, Any], written: Node | None, raw: Node | None, path: Path
) -> None:
    for key in before.keys() - after.keys():
        removed = tree.pop(key, CommentedSeq())
        if written is not None and isinstance(before[key], list):
            _list(removed, before[key], [], _child(written, key), _child(raw, key), (*path, key))
    for key, value in after.items():
        if key in before and before[key] == value:
            continue
        inner, own = _child(written, key), _child(raw, key)
        inner_path = (*path, key)
        if key not in tree and inner is not None and (isinstance(value, list) or inner_path in OPEN):
            tree[key] = CommentedSeq() if isinstance(value, list) else CommentedMap()
        if key in tree and type(before.get(key)) is type(value) and isinstance(value, (dict, list)):
            _inside(tree[key], before[key], value, inner, own, inner_path)
        else:
            tree[key] = styled(value, depth=2)


def _inside(tree: Any, before: Any, after: Any, written: Node | None, raw: Node | None, path: Path) -> None:
    change = _list if isinstance(after, list) else _mapping
    change(tree, before, after, written, raw, path)


def _list(
    tree: Any, before: Sequence[Any], after: Sequence[Any], written: Node | None, raw: Node | None, path: Path
) -> None:
    own = _own_places(written, raw, len(before))
    remaining = list(range(len(before)))
    removed: list[int] = []
    for index in reversed(range(len(before))):
        if len(remaining) > len(after) and not any(_same(before[index], item) for item in after):
            removed.append(remaining.pop(index))
    removed += remaining[len(after) :]
    for number, value in zip(remaining, after, strict=False):
        if before[number] == value:
            continue
        place = _place(own, number, written, path)
        if isinstance(value, (dict, list)) and type(before[number]) is type(value) and _same(before[number], value):
            inner_path = (*path, number)
            _inside(tree[place], before[number], value, _child(written, number), _child(raw, place), inner_path)
        else:
            tree[place] = styled(value, depth=2)
    for place in sorted((_place(own, number, written, path) for number in removed), reverse=True):
        del tree[place]
    for value in after[len(remaining) :]:
        tree.append(styled(value, depth=2))


def _place(own: Sequence[int | None], number: int, written: Node | None, path: Path) -> int:
    """Return the index in the text of an item of a list."""
    place = own[number]
    if place is None:
        origin = None if written is None else written.items[number].origin
        name = ".".join(str(step) for step in path)
        if origin is not None and origin.repetition:
            message = f"{name}[{number}] is one repetition of this; change this itself, or write it without 'repeat'"
        else:
            message = f"{name}[{number}] stands in this file; change it here"
        raise ForeignError((*path, number), message)
    return place


def _own_places(written: Node | None, raw: Node | None, count: int) -> list[int | None]:
    """Return the index in the text's own list for each item; None for items from elsewhere."""
    if written is None:
        return list(range(count))
    own = {} if raw is None else {(item.line, item.column): int(index) for index, item in raw.items.items()}
    items = [written.items.get(index) for index in range(count)]
    return [None if item is None or item.origin is not None else own.get((item.line, item.column)) for item in items]


def _child(node: Node | None, step: str | int) -> Node | None:
    return None if node is None else node.items.get(step)


def _same(one: Any, other: Any) -> bool:
    """Return whether two items are the same, possibly changed: by name if they have one, otherwise by value."""
    if isinstance(one, dict) and isinstance(other, dict):
        names = [next((item[key] for key in ("name", *SENSOR_KINDS) if key in item), None) for item in (one, other)]
        if names != [None, None]:
            return bool(names[0] == names[1])
        return bool(one == other) or one.keys() == other.keys()
    return bool(one == other)
