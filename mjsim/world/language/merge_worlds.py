"""Merges world files: lists are concatenated; for other values, the including file takes precedence."""

from collections.abc import Collection, Iterator
from dataclasses import replace

from mjsim.world.yaml import Node, Origin

OPEN = {(), ("floor",), ("ceiling",), ("run",), ("run", "drivers")}
"""Paths of mappings that are merged key by key; deeper values are replaced as a whole."""

Path = tuple[str | int, ...]


def merged(below: Node, above: Node, path: Path = ()) -> Node:
    """Return a value merged over the value of an included file.

    The top-level mapping, `floor`, `ceiling`, `run` and its drivers are merged key by key; lists in them are
    concatenated, included items first; any other value replaces the included one.
    """
    if path in OPEN and isinstance(below.value, dict) and isinstance(above.value, dict):
        items = dict(below.items)
        for key, node in above.items.items():
            items[key] = merged(items[key], node, (*path, str(key))) if key in items else node
        return _mapping(above, items, {**below.keys, **above.keys})
    if path[:-1] in OPEN and isinstance(below.value, list) and isinstance(above.value, list):
        nodes = [*below.items.values(), *above.items.values()]
        size = below.size + above.size - 1
        return replace(above, value=below.value + above.value, items=dict(enumerate(nodes)), size=size)
    return above


def marked(node: Node, origin: Origin, path: Path = ()) -> Node:
    """Return the value of an included file, marking the origin of all that may end up beside other files' values."""
    if path in OPEN and isinstance(node.value, dict):
        items = {key: marked(item, origin, (*path, str(key))) for key, item in node.items.items()}
    elif path and path[:-1] in OPEN and isinstance(node.value, list):
        items = {index: _with_origin(item, origin) for index, item in node.items.items()}
    else:
        return _with_origin(node, origin)
    return replace(_with_origin(node, origin), items=items)


def mergeable(node: Node, path: Path = ()) -> Iterator[Node]:
    """Yield the mappings and lists of a file that may be merged with those of others."""
    yield node
    if path in OPEN and isinstance(node.value, dict):
        for key, item in node.items.items():
            if isinstance(item.value, (dict, list)) and ((*path, str(key)) in OPEN or isinstance(item.value, list)):
                yield from mergeable(item, (*path, str(key)))


def without(node: Node, names: Collection[str]) -> Node:
    """Return a mapping without some keys."""
    if not any(name in node.items for name in names):
        return node
    items = {key: item for key, item in node.items.items() if key not in names}
    return _mapping(node, items, {key: place for key, place in node.keys.items() if key not in names})


def _mapping(node: Node, items: dict[str | int, Node], keys: dict[str, tuple[int, int]]) -> Node:
    size = 1 + len(items) + sum(item.size for item in items.values())
    value = {key: item.value for key, item in items.items()}
    return replace(node, value=value, items=items, keys=keys, size=size)


def _with_origin(node: Node, origin: Origin) -> Node:
    old = node.origin
    if old is None:
        return replace(node, origin=origin)
    return node if old.file is not None else replace(node, origin=replace(old, file=origin.file, how=origin.how))
