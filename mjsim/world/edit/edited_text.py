"""A text under edit: finds where the values of its world are written, and changes them there."""

import copy
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from mjsim.sentences import Sentence
from mjsim.world.edit.cuts import Cut, applied, line_rest, line_start, new_line, put_in, taken_out
from mjsim.world.edit.formatter import key_ranks
from mjsim.world.edit.snippet import dashed, inline, keyed, scalar
from mjsim.world.edit.text_place import Path, TextPlace, UnwritableError, shown_path
from mjsim.world.files import Source
from mjsim.world.language import OPEN, expand, needs_expansion
from mjsim.world.yaml import MAX_BYTES, Entry, Node, Span, UnknownTextError, read_spans, read_text, too_large

_SHARED = "is written once for several places; change it in the text"
_TWICE = "is written twice; remove one of them in the text"
_ABSENT = "is not there; it may come from a preset, or have been removed"


class EditedText:
    """A text under edit, with the value that it is meant to have."""

    def __init__(self, text: str, source: Source) -> None:
        """Read a text.

        Raises:
            UnwritableError: The text cannot be read.
        """
        self._text, self.source = text, source
        self._cuts: list[Cut] = []
        """Pending replacements of single values; positions remain valid until they are applied."""
        self._read()
        self._stale = False
        """Whether the text has changed since positions were computed; they are recomputed on demand."""
        self._grown: set[Path] = set()
        """Mappings that get a new key by the pending cuts."""
        self._lines: set[int] = set()
        """Starts of the lines in which they get it."""
        self._required = self._root.plain  # created anew at each access

    def finished(self) -> tuple[str, Node]:
        """Return the new text, and its value.

        Raises:
            UnwritableError: The value of the text is not the intended one.
        """
        self._text, self._cuts = applied(self._text, self._cuts), []
        self._check_size()
        node, problems = read_text(self._text, file=self.source.file)
        if problems or node is None or not same(node.value, self._required):
            raise UnwritableError((), "this cannot be changed without touching the rest; change the text itself")
        return self._text, node

    @property
    def nodes(self) -> tuple[Node, Node] | None:
        """The text as written and its expanded form; None if it uses nothing that must be expanded."""
        self._refresh()
        return None if self._raw is None or self._written is None else (self._raw, self._written)

    @property
    def plain(self) -> Any:
        """The text as written, with expressions and repeats unexpanded."""
        self._refresh()
        return self._root.plain

    @property
    def fresh_source(self) -> Source:
        """The source, with the current text."""
        return replace(self.source, text=self._text, included={}, variables={})

    def settle(self) -> None:
        """Apply the pending changes; places found before are no longer valid."""
        if self._cuts:
            self._restructure([])

    def place(self, path: Path) -> TextPlace:
        """Return where a path leads, up to its last written value.

        Raises:
            UnwritableError: The value is in another file, or is written more than once.
        """
        if self._grown and any(path[:count] in self._grown for count in range(len(path) + 1)):
            self.settle()
        self._refresh()
        raw = self._raw
        expanded = None if self._written is None else self._written.value
        place = TextPlace(path, [], [self._root], [], self._written, expanded, [])
        for number, step in enumerate(path):
            prefix, span = path[: number + 1], place.span
            if span.shared:
                raise UnwritableError(path[:number], _SHARED)
            inner = None if place.node is None else place.node.items.get(step)
            own = self._own_index(place, raw, prefix) if isinstance(step, int) else step
            entry = span.entry(own)
            if entry is None:
                _check_free(prefix, path, inner)
                place.rest = list(path[number:])
                return place
            if span.kind == "map" and sum(each.name == own for each in span.entries) > 1:
                raise UnwritableError(prefix, _TWICE)
            raw = None if raw is None else raw.items.get(own)
            place.own.append(own)
            place.entries.append(entry)
            place.chain.append(entry.value)
            # In an item that is not repeated only values are computed; below it, nodes hold what is written.
            place.expanded = None if inner is None else place.expanded[step]
            place.node = inner
        return place

    def below(self, place: TextPlace, *steps: str | int) -> TextPlace:
        """Return a place within a value as written, repeated or not."""
        found = TextPlace(place.path, [*place.own], [*place.chain], [*place.entries], None, None, [])
        for step in steps:
            entry = found.span.entry(step)
            assert entry is not None, "only what is written is asked for"
            found.own.append(step)
            found.entries.append(entry)
            found.chain.append(entry.value)
        return found

    def replace(self, place: TextPlace, value: Any) -> None:
        """Replace a value."""
        if place.span.shared:
            raise UnwritableError(place.path, _SHARED)
        self._at(place.own[:-1])[place.own[-1]] = copy.deepcopy(value)
        span, mark = place.span, place.entries[-1].mark
        long = span.style in ("|", ">")
        if span.kind == "scalar" and not long:
            space = " " if span.start == mark and place.chain[-2].kind != "list" else ""
            self._cuts.append((span.start, span.end, space + _written(value, span)))
            return
        if "\n" not in self._text[mark : span.start]:
            self._cuts.append((span.start, span.end, _written(value, span)))
        else:
            first, last = line_start(self._text, span.start), self._text.find("\n", span.end)
            removal = (first, len(self._text) if last < 0 else last + 1, "")
            self._cuts += [(mark, mark, f" {_written(value, span)}"), removal]
        self.settle()

    def insert(self, place: TextPlace, index: int, values: Sequence[Any]) -> None:
        """Insert items into a list, before one of its own items."""
        self.settle_at(place)
        span = place.span
        if span.shared:
            raise UnwritableError(place.path, _SHARED)
        if place.is_empty:
            self._at(place.own[:-1])[place.own[-1]] = copy.deepcopy(list(values))
            self._lay(place, list(values))
            return
        if span.kind != "list":
            raise UnwritableError(place.path, "is not a list; items can be added only to lists")
        self._at(place.own)[index:index] = copy.deepcopy(list(values))
        if not span.entries:
            self._lay(place, list(values))
            return
        beside = span.entries[max(index - 1, 0)].value
        whole = beside.kind == "map" and not beside.flow
        lines = [line for item in values for line in dashed(item, span.column, whole=whole)]
        line = ", ".join(inline(item) for item in values)
        self._restructure(put_in(self._text, span, index, line=line, lines=lines))

    def insert_key(self, place: TextPlace, value: Any) -> None:
        """Add a missing key, with its missing parents."""
        if any(isinstance(step, int) for step in place.rest):
            absent = "is not there; it may come from a preset, set the whole list"
            here = (
                absent
                if place.elsewhere is None
                else Sentence("is written in {file}; change it there", place.elsewhere)
            )
            raise UnwritableError(place.path, here)
        first, *deeper = map(str, place.rest)
        for key in reversed(deeper):
            value = {key: value}
        if place.is_empty or not place.span.entries:
            self.settle_at(place)
        span, holding = place.span, self._at(place.own)
        if place.is_empty:
            self._at(place.own[:-1])[place.own[-1]] = {first: copy.deepcopy(value)}
            self._lay(place, {first: value})
            return
        if span.kind != "map":
            raise UnwritableError(
                place.path,
                Sentence("cannot be set; {path} has no keys", shown_path(place.path[: len(place.own)])),
            )
        names = [str(entry.name) for entry in span.entries]
        ranks = key_ranks([*names, first], place.path[: len(place.own)])
        index = next((k for k in reversed(range(len(names))) if ranks[names[k]] <= ranks[first]), -1) + 1
        holding[first] = copy.deepcopy(value)
        if not names:
            self._lay(place, {first: value})
            return
        self._put_key(place, index, first, value)

    def _put_key(self, place: TextPlace, index: int, key: str, value: Any) -> None:
        """Add a key to a non-empty mapping; the change is deferred unless its line already has a pending change."""
        line, lines = f"{scalar(key)}: {inline(value)}", keyed(key, value, place.span.column)
        cuts = put_in(self._text, place.span, index, line=line, lines=lines)
        if not self._lines.isdisjoint(self._begins(cuts)):
            # How a line continues depends on what was inserted before.
            self.settle_at(place)
            cuts = put_in(self._text, place.span, index, line=line, lines=lines)
        self._cuts += cuts
        self._grown.add(place.path[: len(place.own)])
        self._lines |= self._begins(cuts)

    def _begins(self, cuts: Sequence[Cut]) -> set[int]:
        return {line_start(self._text, start) for start, _, _ in cuts}

    def take_out(self, *places: TextPlace) -> None:
        """Remove a key or an item, with the comments beside and in it.

        Args:
            places: One place; or several items of a block-style list, last first, if others remain.
        """
        cuts: list[Cut] = []
        for place in places:
            if place.span.shared:
                raise UnwritableError(place.path, _SHARED)
            self.settle_at(place)
            parent = place.chain[-2]
            if len(place.entries) == 1 and len(parent.entries) == 1:
                raise UnwritableError(place.path, "is the only content of the text; it cannot be removed")
            del self._at(place.own[:-1])[place.own[-1]]
            holder = place.entries[-2] if len(place.entries) > 1 else None
            cuts += taken_out(self._text, parent, _index(parent.entries, place.entries[-1]), holder)
        self._restructure(cuts)

    def rename(self, place: TextPlace, name: str) -> None:
        """Rename a key."""
        self.settle_at(place)
        key = place.entries[-1].key
        if key is None or place.chain[-2].entry(name) is not None:
            raise UnwritableError(
                place.path,
                Sentence("cannot be renamed '{name:.40}'; that is not a valid key, or it exists already", name),
            )
        holding = self._at(place.own[:-1])
        renamed = {name if old == place.own[-1] else old: value for old, value in holding.items()}
        holding.clear()
        holding.update(renamed)
        self._restructure([(key.start, key.end, scalar(name, style=key.style))])

    def settle_at(self, place: TextPlace) -> None:
        """Apply pending changes, and find a place again."""
        if self._cuts:
            self.settle()
            again = self.place(place.path)
            place.chain, place.entries, place.node, place.expanded = (
                again.chain,
                again.entries,
                again.node,
                again.expanded,
            )

    def _refresh(self) -> None:
        if self._stale:
            self._read()
            self._stale = False

    def _check_size(self) -> None:
        if len(self._text) > MAX_BYTES:
            raise UnwritableError((), too_large(len(self._text)))

    def _read(self) -> None:
        self._written: Node | None = None
        self._raw: Node | None = None
        self._indices: dict[int, dict[tuple[int, int], int]] = {}
        self._check_size()
        raw: Node | None = None
        expands = needs_expansion(self._text)
        if expands or "*" in self._text:
            # Nested aliases may expand to more than fits in memory.
            raw, problems = read_text(self._text, file=self.source.file)
            if raw is None or problems:
                raise UnwritableError((), Sentence("the text cannot be read, correct it first: {problem}", problems[0]))
        try:
            self._root = read_spans(self._text)
        except UnknownTextError as unknown:
            raise UnwritableError(
                (), Sentence("the text cannot be edited here: {reason}; correct it first", unknown)
            ) from None
        if self._root.kind != "map":
            raise UnwritableError((), "the text is not a world; a world begins with 'mjsim: 1'")
        if expands and raw is not None:
            self._raw, self._written = raw, expand(raw, self.fresh_source).node

    def _restructure(self, cuts: Sequence[Cut]) -> None:
        self._text, self._cuts, self._stale = applied(self._text, [*self._cuts, *cuts]), [], True
        self._grown, self._lines = set(), set()

    def _own_index(self, place: TextPlace, raw: Node | None, path: Path) -> int:
        """Return the index in the text's list of an item of the world."""
        index, span, node = path[-1], place.span, place.node
        assert isinstance(index, int), "an item of a list is meant"
        if span.kind != "list" or not 0 <= index < place.count:
            raise UnwritableError(path, _ABSENT)
        if node is None or raw is None:
            return index
        item = node.items[index]
        if item.origin is not None and item.origin.repetition:
            raise UnwritableError(
                path, Sentence("is one repetition of the item in line {line}; change it in the text", item.line)
            )
        if item.origin is not None:
            raise UnwritableError(path, Sentence("is written in {file}; change it there", item.origin.file))
        if id(raw) not in self._indices:
            self._indices[id(raw)] = {(own.line, own.column): int(number) for number, own in raw.items.items()}
        return self._indices[id(raw)][item.line, item.column]

    def _lay(self, place: TextPlace, value: Any) -> None:
        """Write a list or a mapping for a key whose value is empty or empty brackets."""
        span, entry, outer = place.span, place.entries[-1], place.chain[-2]
        inside = self._text[span.start + 1 : span.end - 1] if span.kind != "scalar" else ""
        if inside.strip():
            text = inline(value)[1:-1]
            self._restructure(put_in(self._text, span, 0, line=text, lines=()))
            return
        start = entry.mark if self._text[entry.mark : span.start].isspace() else span.start
        in_lines = isinstance(value, list) and isinstance(value[0], dict) and outer.kind == "map" and not outer.flow
        if not in_lines:
            self._restructure([(start, span.end, f" {inline(value)}")])
            return
        lines = [line for item in value for line in dashed(item, outer.column + 2)]
        rest = line_rest(self._text, span.end)
        added = "".join(f"{new_line(self._text)}{line}" for line in lines)
        # A comment beside the key stays there.
        self._restructure([(start, span.end, ""), (rest, rest, added)])

    def _at(self, own: Sequence[str | int]) -> Any:
        """Return the intended value at a place of the text."""
        found = self._required
        for step in own:
            found = found[step]
        return found


def same(one: Any, other: Any, *, within: float = 0.0) -> bool:
    """Return whether two values are equal in a world, numbers within a tolerance; 1 equals 1.0, but not true."""
    if isinstance(one, bool) or isinstance(other, bool):
        return one is other
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key], within=within) for key in one)
    if isinstance(one, (list, tuple)) and isinstance(other, (list, tuple)):
        return len(one) == len(other) and all(same(*each, within=within) for each in zip(one, other, strict=True))
    if within and isinstance(one, (int, float)) and isinstance(other, (int, float)):
        return abs(one - other) <= within
    return bool(one == other)


def _check_free(path: Path, whole: Path, inner: Node | None) -> None:
    """Raise UnwritableError if a value missing here is in another file to which nothing can be added from here."""
    if inner is None or inner.origin is None:
        return
    joined = path in OPEN or isinstance(inner.value, list)
    if path[:-1] in OPEN and (path == whole or joined):
        return
    raise UnwritableError(path, Sentence("is written in {file}; change it there", inner.origin.file))


def _written(value: Any, span: Span) -> str:
    return inline(value) if isinstance(value, (dict, list)) else scalar(value, style=span.style)


def _index(entries: Sequence[Entry], entry: Entry) -> int:
    """Return the index of an entry by identity."""
    return next(number for number, each in enumerate(entries) if each is entry)
