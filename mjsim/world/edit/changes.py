"""Changes a world in its own text: only what changes is rewritten, every other character stays."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise
from typing import Any, Literal

from mjsim.sentences import Sentence
from mjsim.world.edit.apart import take_apart
from mjsim.world.edit.edited_text import EditedText, same
from mjsim.world.edit.singles import make_single
from mjsim.world.edit.snippet import rounded
from mjsim.world.edit.text_place import Path, TextPlace, UnwritableError, shown_path
from mjsim.world.files import BUILT, Source
from mjsim.world.ground import Model, gc_paused, models_at
from mjsim.world.items import SENSOR_KINDS, World
from mjsim.world.yaml import Node

__all__ = ["Change", "UnwritableError", "edit_text", "edited", "shown_path"]

MAX_DEPTH = 20
"""Maximum nesting of a value to set."""
MAX_INTEGER = 10**18
"""Maximum absolute value of an integer."""


@dataclass(frozen=True, slots=True)
class Change:
    """One change of a value in a world."""

    op: Literal["set", "unset", "add", "remove", "rename", "single", "apart"]
    """Set or unset a key, add or remove an item of a list, rename a key, or write a repeated or included item as a
    separate item: all its repetitions as by `make_single`, or one as by `take_apart`."""
    path: Path
    """Keys and indices as in the world; an added item goes to the end of the named list, or before the named item."""
    value: Any = None
    """The value to set or add, or the new name of a key."""


def edit_text(text: str, changes: Iterable[Change], *, source: Source = BUILT) -> str:
    """Return the text of a world after changes, as by `edited`."""
    return edited(text, changes, source=source)[0]


@gc_paused()
def edited(text: str, changes: Iterable[Change], *, source: Source = BUILT) -> tuple[str, Node]:
    """Return the text of a world after changes, applied in order, and its value.

    A text value may contain an expression, such as `${w / 2}`. Computed numbers are shortened: those with more than six
    decimals are rounded to four. Unsetting a key also removes the comments beside and in it.

    Args:
        text: Valid YAML; it need not be a valid world.
        changes: Changes, with paths in the world that the text describes.
        source: Origin of the text, for finding the files that it includes.

    Raises:
        UnwritableError: A value is not written in this text, is written more than once, or is computed; then nothing is
            changed.
    """
    editor = _Editor(EditedText(text, source))
    for (op, outer), steps in groupby(
        _joined(changes), key=lambda step: (step[0], () if step[0] == "unset" else step[1][:-1])
    ):
        if op == "remove":
            editor.remove([path[-1] for _, path, _ in steps], outer)
        elif op == "unset":
            editor.unset([path for _, path, _ in steps])
        else:
            for _, path, value in steps:
                editor.make(op, path, value)
    return editor.draft.finished()


@gc_paused()
def write_back(text: str, before: dict[str, Any], after: dict[str, Any], *, source: Source) -> str:
    """Return the text of a world with the differences between its keys and others; values are written exactly.

    Raises:
        UnwritableError: See `edited`; but a computed value is replaced.
    """
    editor = _Editor(EditedText(text, source), computed=True)
    for op, path, value in _differences(before, after, ()):
        editor.make(op, path, value)
    return editor.draft.finished()[0]


class _Editor:
    """Applies changes to a draft; `computed`: whether expressions may be replaced by values."""

    def __init__(self, draft: EditedText, *, computed: bool = False) -> None:
        self.draft, self._computed = draft, computed
        self._set_paths: set[Path] = set()
        self._around: set[Path] = set()

    def make(self, op: str, path: Path, value: Any) -> None:
        """Apply one change."""
        # A set value is still pending; it must be applied before the value is read again.
        seen = path in self._around or any(path[:count] in self._set_paths for count in range(1, len(path) + 1))
        if seen or op != "set":
            self._settle()
        if op == "set":
            self._set(path, value)
            self._set_paths.add(path)
            self._around |= {path[:count] for count in range(1, len(path) + 1)}
        elif op == "add":
            self._add(path, value)
        elif op == "rename":
            self._rename(path, value)
        elif op == "single":
            make_single(self.draft, path)
        elif op == "apart":
            take_apart(self.draft, path)
        else:
            self._take_out(path, op)

    def _settle(self) -> None:
        self.draft.settle()
        self._set_paths, self._around = set(), set()

    def remove(self, steps: Sequence[str | int], outer: Path) -> None:
        """Remove items of one list; consecutive items, last first, are read and removed at once."""
        falling = all(isinstance(a, int) and isinstance(b, int) and a > b for a, b in pairwise(steps))
        together = steps[:-1] if falling else []
        if together:
            self._settle()
            places = [self.draft.place((*outer, step)) for step in together]
            if any(each.rest or each.elsewhere is not None or each.chain[-2].flow for each in places):
                together = []
            else:
                self.draft.take_out(*places)
        # The last one may leave the list empty.
        for step in steps[len(together) :]:
            self.make("remove", (*outer, step), None)

    def unset(self, paths: Sequence[Path]) -> None:
        """Unset keys; those of different items are read and removed at once."""
        self._settle()
        places = [self.draft.place(path) for path in paths] if len(paths) > 1 and _are_disjoint(paths) else []
        if places and all(_goes_alone(place) for place in places):
            self.draft.take_out(*places)
            return
        for path in paths:
            self.make("unset", path, None)

    def _set(self, path: Path, value: Any) -> None:
        place = self.draft.place(path)
        if place.rest:
            self.draft.insert_key(place, value)
            return
        before = place.value
        if same(before, value):
            return
        if isinstance(before, list) and isinstance(value, list) and not place.span.shared:
            self._set_items(path, before, value)
        elif isinstance(before, dict) and isinstance(value, dict) and not place.span.shared:
            self._set_keys(path, before, value)
        elif (
            place.span.kind == "scalar"
            and _has_expression(place.span.text)
            and not (self._computed or _has_expression(value))
        ):
            raise UnwritableError(path, Sentence("is computed by {text:.60}; change it in the text", place.span.text))
        else:
            self.draft.replace(place, value)

    def _set_items(self, path: Path, before: Sequence[Any], value: Sequence[Any]) -> None:
        """Replace a list: equal items at both ends stay, those between are written one by one."""
        count = min(len(before), len(value))
        first = last = 0
        if len(before) != len(value):
            first = next((k for k in range(count) if not same(before[k], value[k])), count)
            rest = count - first
            last = next((k for k in range(rest) if not same(before[-1 - k], value[-1 - k])), rest)
        middle = count - last
        for index in range(first, middle):
            self._set((*path, index), value[index])
        for index in reversed(range(middle, len(before) - last)):
            self._take_out((*path, index), "remove")
        if len(value) > len(before):
            self._add((*path, middle), value[middle : len(value) - last])

    def _set_keys(self, path: Path, before: dict[str, Any], value: dict[str, Any]) -> None:
        for key in [key for key in before if key in value]:
            self._set((*path, key), value[key])
        for key in [key for key in value if key not in before]:
            self._set((*path, key), value[key])
        for key in [key for key in before if key not in value]:
            self._take_out((*path, key), "unset")

    def _add(self, path: Path, values: Sequence[Any]) -> None:
        """Add items to a list."""
        index, outer = path[-1], self.draft.place(path[:-1] if isinstance(path[-1], int) else path)
        if outer.rest:
            self.draft.insert_key(outer, list(values))
        elif not isinstance(index, int) or index == outer.count:
            self.draft.insert(outer, len(outer.span.entries), values)
        else:
            own = self.draft.place(path).own[-1]
            assert isinstance(own, int), "an item of a list is meant"
            self.draft.insert(outer, own, values)

    def _take_out(self, path: Path, op: str) -> None:
        place = self.draft.place(path)
        if isinstance(path[-1], int) != (op == "remove"):
            raise UnwritableError(path, "is an item; remove it" if isinstance(path[-1], int) else "is a key; unset it")
        while op == "unset" and not place.rest and _is_default_when_empty(place.path[:-1]):
            outer = self.draft.place(place.path[:-1])
            if outer.count > 1:
                break
            place = outer
        if place.elsewhere is not None:
            raise UnwritableError(path, Sentence("is written in {file}; change it there", place.elsewhere))
        if not place.rest:
            self.draft.take_out(place)

    def _rename(self, path: Path, name: Any) -> None:
        place = self.draft.place(path)
        if place.rest or isinstance(path[-1], int) or not isinstance(name, str) or not name:
            raise UnwritableError(path, "is not a key of this text, or the new name is not a text")
        if name != path[-1]:
            self.draft.rename(place, name)


def _are_disjoint(paths: Sequence[Path]) -> bool:
    """Return whether keys are in different mappings, none of which contains another."""
    outer = {path[:-1] for path in paths}
    within = any(path[:count] in outer for path in outer for count in range(len(path)))
    return len(outer) == len(paths) and not within


def _goes_alone(place: TextPlace) -> bool:
    """Return whether a key is written and has siblings, so that removing it leaves its parent."""
    written = not place.rest and place.elsewhere is None and isinstance(place.path[-1], str)
    return written and len(place.chain[-2].entries) > 1 and not _is_default_when_empty(place.path[:-1])


def _joined(changes: Iterable[Change]) -> list[tuple[str, Path, Any]]:
    """Return changes with shortened values; consecutive additions to one list become one change."""
    joined: list[tuple[str, Path, Any]] = []
    for change in changes:
        if not change.path or not _is_writable(change.value, MAX_DEPTH):
            raise UnwritableError(change.path, "cannot be written; give finite numbers, texts, lists and keys")
        value = rounded(change.value)
        step, behind = ("add", change.path), isinstance(change.path[-1], str)
        if change.op != "add":
            joined.append((change.op, change.path, value))
        elif behind and joined and joined[-1][:2] == step:
            joined[-1][2].append(value)
        else:
            joined.append(("add", change.path, [value]))
    return joined


def _differences(before: Any, after: Any, path: Path) -> Iterator[tuple[str, Path, Any]]:
    """Yield the changes that make a value another; items of a list are matched by name."""
    if isinstance(before, dict) and isinstance(after, dict):
        yield from (("unset", (*path, key), None) for key in before if key not in after)
        for key, value in after.items():
            yield from _differences(before.get(key, ...), value, (*path, key))
    elif (
        isinstance(before, list) and isinstance(after, list) and any(isinstance(each, dict) for each in before + after)
    ):
        kept = list(range(len(before)))
        for index in reversed(range(len(before))):
            if len(kept) > len(after) and not any(_is_same_item(before[index], item) for item in after):
                kept.remove(index)
        kept = kept[: len(after)]
        yield from (("remove", (*path, index), None) for index in reversed(range(len(before))) if index not in kept)
        for place, (index, value) in enumerate(zip(kept, after, strict=False)):
            if _is_same_item(before[index], value):
                yield from _differences(before[index], value, (*path, place))
            else:
                yield "set", (*path, place), value
        if len(after) > len(kept):
            yield "add", path, after[len(kept) :]
    elif before != after:
        yield "set", path, after


def _is_same_item(one: Any, other: Any) -> bool:
    """Return whether two items are the same, possibly changed: by name if they have one, otherwise by keys."""
    if not (isinstance(one, dict) and isinstance(other, dict)):
        return bool(one == other)
    names = [next((item[key] for key in ("name", *SENSOR_KINDS) if key in item), None) for item in (one, other)]
    return bool(names[0] == names[1]) if names != [None, None] else one.keys() == other.keys()


def _is_default_when_empty(path: Path) -> bool:
    """Return whether a key with an empty mapping means the same as no key: true for `noise: {}`, not for `door: {}`."""
    kinds = models_at(World, path[:-1]) if path and isinstance(path[-1], str) else []
    fields = [kind.model_fields[str(path[-1])] for kind in kinds if path[-1] in kind.model_fields]
    return bool(fields) and all(isinstance(field.default, Model) for field in fields)


def _has_expression(value: Any) -> bool:
    return isinstance(value, str) and "${" in value


def _is_writable(value: Any, deepest: int) -> bool:
    """Return whether a value can be written in a world file."""
    if isinstance(value, dict):
        return deepest > 0 and all(isinstance(k, str) and _is_writable(item, deepest - 1) for k, item in value.items())
    if isinstance(value, list):
        return deepest > 0 and all(_is_writable(item, deepest - 1) for item in value)
    if isinstance(value, float):
        return math.isfinite(value)
    if isinstance(value, int):
        return abs(value) < MAX_INTEGER
    return value is None or isinstance(value, str)
