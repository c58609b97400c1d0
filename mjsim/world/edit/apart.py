"""Writes one repetition of an item as a separate item; those before and after it stay repeated."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from mjsim.world.edit.edited_text import EditedText, same
from mjsim.world.edit.singles import as_written, foreign, make_single, node_at, own_index, rewrite
from mjsim.world.edit.text_place import Path, UnwritableError
from mjsim.world.language import names_in
from mjsim.world.yaml import Node

COUNTERS = "ijk"
"""Names of the indices of a repetition, outermost first."""
TOLERANCE = 1e-8
"""Tolerance for positions rotated about a point, which are rounded to 9 decimals [m, deg]."""


@dataclass(frozen=True, slots=True)
class _Part:
    """Repetitions that one item of the text represents."""

    first: tuple[int, ...]
    """Index of its first repetition in each repeat, from 0."""
    times: tuple[int, ...]
    """Number of repetitions in each repeat."""

    @property
    def repeats(self) -> list[int]:
        """Indices of the repeats that it still has."""
        return [number for number, count in enumerate(self.times) if count > 1]


def take_apart(draft: EditedText, path: Path) -> None:
    """Write one repetition of an item as a separate item, in its place; the others stay repeated.

    The world stays the same, except that positions rotated about a point are rounded again (`TOLERANCE`). An included
    item is first written into the text as by `make_single`.

    Args:
        draft: The text.
        path: Path of the item, or of something in it.

    Raises:
        UnwritableError: Nothing is at the path, or the others cannot be written as repeats of the same items.
    """
    draft.settle()
    before = draft.nodes
    item = None if before is None else foreign(before[1], path)
    origin = None if before is None or item is None else node_at(before[1], item).origin
    if before is None or item is None or origin is None or origin.file is not None or len(origin.repetition) == 0:
        make_single(draft, path)
        return
    raw, written = before
    siblings = node_at(written, item[:-1])
    start = siblings.items[item[-1]].line, siblings.items[item[-1]].column
    copies = [index for index, each in siblings.items.items() if (each.line, each.column) == start]
    parts = list(_parts(_shape([siblings.items[index] for index in copies]), origin.repetition))
    _write(draft, raw, siblings, (item, copies), parts)
    draft.settle()
    after = draft.plain if draft.nodes is None else draft.nodes[1].value
    if not same(after, written.value, within=TOLERANCE):
        raise UnwritableError(item, "cannot be taken out of its repeat alone; make all of them single")


def _parts(shape: Sequence[int], index: Sequence[int]) -> Iterator[_Part]:
    """Yield the parts into which a grid splits when one element is removed, in the order of the repetitions."""
    if not shape:
        yield _Part((), ())
        return
    count, taken, deeper = shape[0], index[0], (0,) * (len(shape) - 1)
    if taken:
        yield _Part((0, *deeper), (taken, *shape[1:]))
    for part in _parts(shape[1:], index[1:]):
        yield _Part((taken, *part.first), (1, *part.times))
    if taken + 1 < count:
        yield _Part((taken + 1, *deeper), (count - taken - 1, *shape[1:]))


def _shape(copies: Sequence[Node]) -> tuple[int, ...]:
    """Return the number of repetitions in each repeat."""
    every = [each.origin.repetition for each in copies if each.origin is not None]
    return tuple(max(column) + 1 for column in zip(*every, strict=True))


def _write(draft: EditedText, raw: Node, siblings: Node, found: tuple[Path, list[Any]], parts: list[_Part]) -> None:
    """Write the parts of a repeated item one after another."""
    item, copies = found
    outer, place = item[:-1], draft.place(item[:-1])
    own = own_index(node_at(raw, place.own), siblings.items[item[-1]])
    values = {_index_of(siblings.items[index]): siblings.items[index].value for index in copies}
    repeated = draft.below(place, own, "repeat")
    steps = repeated.span.plain
    draft.take_out(repeated)
    first = (*outer, copies[0])
    alone = draft.place(first)
    plain, expanded = alone.span.plain, alone.value
    texts = [_text_of(part, plain, expanded, values[part.first], steps) for part in parts]
    again = texts[0].pop("repeat", None)
    rewrite(draft, first, texts[0])
    if again is not None:
        draft.settle()
        rewrite(draft, (*first, "repeat"), again)
    if texts[1:]:
        draft.settle()
        draft.insert(draft.place(outer), own + 1, texts[1:])


def _index_of(node: Node) -> tuple[int, ...]:
    return () if node.origin is None else node.origin.repetition


def _text_of(part: _Part, plain: Any, expanded: Any, required: Any, steps: Any) -> dict[str, Any]:
    """Return the keys of a part as they will be written in the text."""
    counting = {key for key, value in plain.items() if part.repeats and _counts(value)}
    keys = {
        key: _renumbered(plain[key], part) if key in counting else as_written(plain.get(key), expanded.get(key), value)
        for key, value in required.items()
    }
    numbers = "-".join(str(number + 1) for number in part.first)
    for key, value in required.items() if part.repeats else ():
        # The name of a repeated item: 'desk' became 'desk-1', 'desk-2'.
        if isinstance(value, str) and value == f"{plain.get(key)}-{numbers}":
            keys[key] = f"{plain[key]}-" + "-".join(_number(part, number, 1) for number in range(len(part.first)))
    left = [{**_step(steps, number), "times": part.times[number]} for number in part.repeats]
    if left:
        keys["repeat"] = left[0] if len(left) == 1 else left
    return keys


def _step(steps: Any, number: int) -> dict[str, Any]:
    found: dict[str, Any] = steps[number] if isinstance(steps, list) else steps
    return found


def _number(part: _Part, number: int, more: int) -> str:
    """Return the text of a repetition index of the part, with a number added."""
    begin = part.first[number] + more
    if number not in part.repeats:
        return str(begin)
    name = COUNTERS[part.repeats.index(number)]
    return f"${{{name} + {begin}}}" if begin else f"${{{name}}}"


def _counts(plain: Any) -> bool:
    """Return whether a value as written depends on a repetition index."""
    if isinstance(plain, dict):
        return any(map(_counts, plain.values()))
    if isinstance(plain, list):
        return any(map(_counts, plain))
    return isinstance(plain, str) and not names_in(plain).isdisjoint(COUNTERS)


def _renumbered(plain: Any, part: _Part) -> Any:
    """Return a value as written, with the indices of a part instead of those of the whole."""
    if isinstance(plain, dict):
        return {key: _renumbered(value, part) for key, value in plain.items()}
    if isinstance(plain, list):
        return [_renumbered(value, part) for value in plain]
    if not _counts(plain):
        return plain

    def number(found: re.Match[str]) -> str:
        which = COUNTERS.index(found[0])
        if which >= len(part.times):
            return found[0]
        text = _number(part, which, 0).removeprefix("${").removesuffix("}")
        return f"({text})" if " " in text else text

    return re.sub(r"\$\{[^}]*\}", lambda found: re.sub(rf"\b[{COUNTERS}]\b", number, found[0]), plain)
