"""Items that are repeated or included, written into the text as items of their own; the world stays as it is."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from mjsim.world.edit.edited_text import EditedText, same
from mjsim.world.edit.layout import escaped
from mjsim.world.edit.text_place import Path, UnwritableError
from mjsim.world.language import OPEN, Value, expand, names_in
from mjsim.world.yaml import Node


def make_single(draft: EditedText, path: Path) -> None:
    """Write an item of the world as one of its own, if it is not.

    A repeated item becomes as many items as it comes to: the first keeps its place, its comments and its expressions.
    Of an included item the whole file that holds it is written in place of its `include`, with those that are included
    behind it; the file itself stays as it is.

    Args:
        draft: The text.
        path: Of the item, or of something in it.

    Raises:
        UnwritableError: Nothing is there, or the world would not stay as it is.
    """
    draft.settle()
    before = draft.nodes
    item = None if before is None else foreign(before[1], path)
    if before is None or item is None:
        draft.place(path)  # which says so when nothing is there
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
    """Write all repetitions of an item below each other."""
    place = draft.place(path[:-1])
    start = siblings.items[path[-1]].line, siblings.items[path[-1]].column
    own = own_index(node_at(raw, place.own), siblings.items[path[-1]])
    copies = [index for index, item in siblings.items.items() if (item.line, item.column) == start]
    values = [siblings.items[index].value for index in copies]
    draft.take_out(draft.below(place, own, "repeat"))
    first = draft.place((*path[:-1], copies[0]))
    plain, says = first.span.plain, first.value
    rewrite(draft, (*path[:-1], copies[0]), as_written(plain, says, values[0]))
    if values[1:]:
        draft.settle()
        more = [as_written(plain, says, value) for value in values[1:]]
        draft.insert(draft.place(path[:-1]), own + 1, more)


def as_written(plain: Any, says: Any, wanted: Any) -> Any:
    """Return how to write a value: as it stands in the text where that says the same, else as it is.

    Args:
        plain: What stands in the text.
        says: What that comes to.
        wanted: What it is to come to.
    """
    if same(says, wanted):
        return plain
    if isinstance(plain, dict) and isinstance(wanted, dict):
        return {key: as_written(plain.get(key), says.get(key), value) for key, value in wanted.items()}
    if isinstance(plain, list) and isinstance(wanted, list) and len(plain) == len(says) == len(wanted):
        return [as_written(*each) for each in zip(plain, says, wanted, strict=True)]
    return _literal(wanted)


def rewrite(draft: EditedText, path: Path, wanted: Any) -> None:
    """Write a value over another one, all that is the same left as it is."""
    place = draft.place(path)
    if place.rest:
        draft.insert_key(place, wanted)
        return
    plain = place.span.plain
    if isinstance(plain, dict) and isinstance(wanted, dict):
        for key in [key for key in wanted if key not in plain or not same(plain[key], wanted[key])]:
            rewrite(draft, (*path, key), wanted[key])
    elif isinstance(plain, list) and isinstance(wanted, list) and len(plain) == place.count == len(wanted):
        for index in range(len(wanted)):
            rewrite(draft, (*path, index), wanted[index])
    elif not same(plain, wanted):
        draft.replace(place, wanted)


def _bring_in(draft: EditedText, raw: Node, path: Path) -> None:
    """Write the included file that holds an item, and those included behind it, in place of their `include`."""
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
    """Write the values of included files where the text says nothing else, their items before those of the text."""
    for key, value in brought.items():
        place = draft.place((*at, key))
        if place.rest:
            draft.insert_key(place, _literal(value))
        elif (*at, key) in OPEN and isinstance(value, dict):
            _put_below(draft, value, (*at, key))
        elif isinstance(value, list) and value:
            draft.insert(place, 0, _literal(value))


def _keep_variables(draft: EditedText, names: Mapping[str, Value]) -> None:
    """Write the variables of included files that the text uses."""
    own = draft.plain.get("variables") or {}
    used = {name for text in _texts(draft.plain) for name in names_in(text)}
    for name in sorted(used & names.keys() - own.keys()):
        draft.insert_key(draft.place(("variables", name)), _literal(names[name]))


def foreign(node: Node, path: Path) -> Path | None:
    """Return the outermost item along a path that is not written in the text, or not once; None without one."""
    for number, step in enumerate(path):
        inner = node.items.get(step)
        if inner is None:
            return None
        if isinstance(step, int) and inner.origin is not None:
            return path[: number + 1]
        node = inner
    return None


def own_index(written: Node, item: Node) -> int:
    """Return which item of a list as it stands in the text an item of the world comes from."""
    start = item.line, item.column
    return next(int(number) for number, each in written.items.items() if (each.line, each.column) == start)


def node_at(node: Node, path: Sequence[str | int]) -> Node:
    """Return what a path of a node leads to."""
    for step in path:
        node = node.items[step]
    return node


def _count(node: Node, path: Path) -> int:
    """Return how many items a list has; none where it is not there."""
    for step in path:
        inner = node.items.get(step)
        if inner is None:
            return 0
        node = inner
    return len(node.items)


def _literal(value: Any) -> Any:
    """Return what is to be written for a value: signs of expressions in it stand for themselves."""
    if isinstance(value, dict):
        return {key: _literal(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_literal(item) for item in value]
    return escaped(value) if isinstance(value, str) else value


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        for item in value:
            yield from _texts(item)
    elif isinstance(value, str):
        yield value
