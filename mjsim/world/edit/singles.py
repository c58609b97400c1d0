"""Writes repeated or included items into the text as separate items; the world stays the same."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from mjsim.world.edit.edited_text import EditedText, same
from mjsim.world.edit.snippet import literal
from mjsim.world.edit.text_place import Path, UnwritableError
from mjsim.world.language import OPEN, Value, expand, names_in
from mjsim.world.yaml import Node


def make_single(draft: EditedText, path: Path) -> None:
    """Write an item of the world as a separate item, if it is not one.

    A repeated item becomes as many items as it expands to: the first keeps its place, comments and expressions. For an
    included item, the whole file that contains it, and the files included after it, are written in place of their
    `include`; the files themselves stay unchanged.

    Args:
        draft: The text.
        path: Path of the item, or of something in it.

    Raises:
        UnwritableError: Nothing is at the path, or the world would change.
    """
    draft.settle()
    before = draft.nodes
    item = None if before is None else foreign(before[1], path)
    if before is None or item is None:
        draft.place(path)  # raises an error if nothing is there
        return
    raw, written = before
    node = node_at(written, item)
    if node.origin is not None and node.origin.file is not None:
        _bring_in(draft, raw, item)
    else:
        _unroll(draft, raw, node_at(written, item[:-1]), item)
    draft.settle()
    after = draft.plain if draft.nodes is None else draft.nodes[1].value
    if not same(after, written.value):
        raise UnwritableError(item, "cannot be made single without changing the world; change it in the text")


def _unroll(draft: EditedText, raw: Node, siblings: Node, path: Path) -> None:
    """Write all repetitions of an item one after another."""
    place = draft.place(path[:-1])
    start = siblings.items[path[-1]].line, siblings.items[path[-1]].column
    own = own_index(node_at(raw, place.own), siblings.items[path[-1]])
    copies = [index for index, item in siblings.items.items() if (item.line, item.column) == start]
    values = [siblings.items[index].value for index in copies]
    draft.take_out(draft.below(place, own, "repeat"))
    first = draft.place((*path[:-1], copies[0]))
    plain, expanded = first.span.plain, first.value
    rewrite(draft, (*path[:-1], copies[0]), as_written(plain, expanded, values[0]))
    if values[1:]:
        draft.settle()
        more = [as_written(plain, expanded, value) for value in values[1:]]
        draft.insert(draft.place(path[:-1]), own + 1, more)


def as_written(plain: Any, expanded: Any, required: Any) -> Any:
    """Return the form in which to write a value: as in the text where that gives the same value, otherwise literally.

    Args:
        plain: The value as written in the text.
        expanded: The value that this expands to.
        required: The value that it must expand to.
    """
    if same(expanded, required):
        return plain
    if isinstance(plain, dict) and isinstance(required, dict):
        return {key: as_written(plain.get(key), expanded.get(key), value) for key, value in required.items()}
    if isinstance(plain, list) and isinstance(required, list) and len(plain) == len(expanded) == len(required):
        return [as_written(*each) for each in zip(plain, expanded, required, strict=True)]
    return literal(required)


def rewrite(draft: EditedText, path: Path, required: Any) -> None:
    """Replace a value, leaving equal parts unchanged."""
    place = draft.place(path)
    if place.rest:
        draft.insert_key(place, required)
        return
    plain = place.span.plain
    if isinstance(plain, dict) and isinstance(required, dict):
        for key in [key for key in required if key not in plain or not same(plain[key], required[key])]:
            rewrite(draft, (*path, key), required[key])
    elif isinstance(plain, list) and isinstance(required, list) and len(plain) == place.count == len(required):
        for index in range(len(required)):
            rewrite(draft, (*path, index), required[index])
    elif not same(plain, required):
        draft.replace(place, required)


def _bring_in(draft: EditedText, raw: Node, path: Path) -> None:
    """Write the included file that contains an item, and those included after it, in place of their `include`."""
    names = expand(raw, draft.fresh_source).variables
    include = raw.items["include"]

    def part(first: int, last: int) -> Node:
        entries = [include.items[index] for index in range(first, last)]
        listed = replace(include, items=dict(enumerate(entries)), value=[entry.value for entry in entries])
        only = replace(raw, items={"include": listed}, value={"include": listed.value})
        return expand(only, draft.fresh_source, variables=names).node

    count = len(include.items)
    first = next(k for k in range(count) if _count(part(0, k + 1), path[:-1]) > int(path[-1]))
    brought = part(first, count).value
    for index in reversed(range(first, count)) if first else ():
        draft.take_out(draft.place(("include", index)))
    if not first:
        draft.take_out(draft.place(("include",)))
    _put_below(draft, brought, ())
    _keep_variables(draft, names)


def _put_below(draft: EditedText, brought: Mapping[str, Any], at: Path) -> None:
    """Write the values of included files where the text has none, and their items before those of the text."""
    for key, value in brought.items():
        place = draft.place((*at, key))
        if place.rest:
            draft.insert_key(place, literal(value))
        elif (*at, key) in OPEN and isinstance(value, dict):
            _put_below(draft, value, (*at, key))
        elif isinstance(value, list) and value:
            draft.insert(place, 0, literal(value))


def _keep_variables(draft: EditedText, names: Mapping[str, Value]) -> None:
    """Write the variables of included files that the text uses."""
    own = draft.plain.get("variables") or {}
    used = {name for text in _texts(draft.plain) for name in names_in(text)}
    for name in sorted(used & names.keys() - own.keys()):
        draft.insert_key(draft.place(("variables", name)), literal(names[name]))


def foreign(node: Node, path: Path) -> Path | None:
    """Return the outermost item on a path that is not written in the text, or written more than once; None if none."""
    for number, step in enumerate(path):
        inner = node.items.get(step)
        if inner is None:
            return None
        if isinstance(step, int) and inner.origin is not None:
            return path[: number + 1]
        node = inner
    return None


def own_index(written: Node, item: Node) -> int:
    """Return the index in the text's list of the item from which an item of the world comes."""
    start = item.line, item.column
    return next(int(number) for number, each in written.items.items() if (each.line, each.column) == start)


def node_at(node: Node, path: Sequence[str | int]) -> Node:
    """Return the node at a path below a node."""
    for step in path:
        node = node.items[step]
    return node


def _count(node: Node, path: Path) -> int:
    """Return the number of items in a list; 0 if it does not exist."""
    for step in path:
        inner = node.items.get(step)
        if inner is None:
            return 0
        node = inner
    return len(node.items)


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        for item in value:
            yield from _texts(item)
    elif isinstance(value, str):
        yield value
