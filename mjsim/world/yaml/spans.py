"""Start and end of each value of a text, so that a value can be changed without touching anything else."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from ruamel.yaml.error import YAMLError

from mjsim.sentences import Sentence
from mjsim.world.yaml.scan import UnsureError, ruamel_events, sure_events
from mjsim.world.yaml.yaml_text import plain_value

_ODD = "it uses YAML features that world files do not allow"
_COLON = re.compile(r"\s*:")


@dataclass(slots=True, eq=False)
class Comment:
    """A comment and its position."""

    text: str
    """Text from the # on, without trailing spaces."""
    index: int
    line: int
    column: int
    own_line: bool
    """Whether it is alone on its line."""


@dataclass(slots=True, eq=False)
class Span:
    """A value in a text, from its first character to just past its last."""

    kind: str
    """'scalar', 'list' or 'map'."""
    start: int
    end: int
    flow: bool = False
    """Whether a list or a mapping is in brackets."""
    style: str = ""
    """Style of a scalar: its quotes, '|' or '>'; empty for a plain one."""
    shared: bool = False
    """Whether it has an anchor, an alias or a tag."""
    text: str = ""
    """Text of a scalar, without its quotes."""
    entries: list["Entry"] = field(default_factory=list)
    column: int = 0
    """Column of the dashes or keys of a list or a mapping without brackets, counted from 0."""
    meant: "Span | None" = None
    """For an alias, the value to which it refers."""
    written: str = ""
    """For layout: a scalar as written, on one line, with anchor and tag; only these for a list or a mapping."""
    tail: tuple[str, ...] = ()
    """For layout: comments after the last entry, and '' for an empty line."""

    @property
    def is_block(self) -> bool:
        """Whether it is a block scalar."""
        return self.style in ("|", ">")

    @property
    def plain(self) -> Any:
        """Its value, with expressions and repeats as written."""
        if self.meant is not None:
            return self.meant.plain
        if self.kind == "list":
            return [entry.value.plain for entry in self.entries]
        if self.kind == "map":
            return {entry.name: entry.value.plain for entry in self.entries}
        return self.text if self.style else plain_value(self.text)

    def entry(self, step: str | int) -> "Entry | None":
        """Return the entry of a key or an index."""
        if self.kind == "map":
            return next((entry for entry in self.entries if entry.name == step), None)
        if self.kind == "list" and isinstance(step, int) and 0 <= step < len(self.entries):
            return self.entries[step]
        return None


@dataclass(slots=True, eq=False)
class Entry:
    """An item of a list, or a key with its value."""

    name: str | None
    """The key."""
    start: int
    """Start of its dash or key, or of its value in brackets."""
    mark: int
    """Just past its dash or colon; for an item in brackets, its start."""
    value: Span
    key: Span | None = None
    before: tuple[str, ...] = ()
    """For layout: comments above it, and '' for an empty line."""
    head: Comment | None = None
    """Comment beside its key, if its value is below."""
    after: Comment | None = None
    """Comment beside its end."""

    @property
    def end(self) -> int:
        """Just past its last character."""
        return max(self.value.end, self.mark)


class UnknownTextError(Exception):
    """The text is not YAML, or written in a form that no world file has; the message says which."""


def read_spans(text: str) -> Span:
    """Return the value of a text.

    Raises:
        UnknownTextError: It is not YAML, or written in a form that no world file has.
    """
    try:
        try:
            return _Reader(text, sure_events(text)).whole()
        except UnsureError:
            return _Reader(text, ruamel_events(text)).whole()
    # The arithmetic of ruamel.yaml fails at an escape beyond Unicode, and recursion fails on hostile nesting.
    except (YAMLError, ValueError, OverflowError, RecursionError, StopIteration) as error:
        raise UnknownTextError(Sentence("it is not YAML ({reason:.80})", str(error).partition(chr(10))[0])) from None


class _Reader:
    """Builds the spans of a text from its events."""

    def __init__(self, text: str, events: Iterator[Any]) -> None:
        self._text, self._events = text, events
        self._anchors: dict[str, Span] = {}

    def whole(self) -> Span:
        next(self._events)
        next(self._events)
        return self._value(next(self._events), 0)

    def _value(self, event: Any, mark: int) -> Span:
        """Return a value; `mark` is the position just past its colon or dash."""
        span = self._written(event, mark)
        if event.anchor and span.meant is None:
            self._anchors[event.anchor] = span
        return span

    def _written(self, event: Any, mark: int) -> Span:
        start, end = event.start_mark.index, event.end_mark.index
        kind = type(event).__name__
        shared = bool(event.anchor or getattr(event, "tag", None))
        if kind.startswith(("Scalar", "Alias")):
            if kind.startswith("Alias"):
                return Span("scalar", start, end, shared=True, meant=self._anchors.get(event.anchor))
            if start == end:
                return Span("scalar", mark, mark)  # nothing is written
            end = start + len(self._text[start:end].rstrip())
            return Span("scalar", start, end, style=event.style or "", shared=shared, text=event.value)
        flow = bool(event.flow_style)
        if kind.startswith("Sequence"):
            span = Span("list", start, end, flow, shared=shared)
            self._list(span)
        else:
            span = Span("map", start, end, flow, shared=shared)
            self._map(span)
        return span

    def _list(self, span: Span) -> None:
        text, behind = self._text, span.start
        pattern: re.Pattern[str] | None = None
        while not _ends(event := next(self._events)):
            at = event.start_mark.index
            if span.flow:
                entry = Entry(None, at, at, self._value(event, at))
            else:
                if pattern is None:
                    dash = text.rfind("-", behind, at) if text[behind : behind + 1] != "-" else behind
                    if dash < 0:
                        raise UnknownTextError(_ODD)
                    span.column = dash - text.rfind("\n", 0, dash) - 1
                    pattern = re.compile(rf"^[ ]{{{span.column}}}-(?=\s|$)", re.MULTILINE)
                else:
                    found = pattern.search(text, behind, len(text))
                    if found is None:
                        raise UnknownTextError(_ODD)
                    dash = found.end() - 1
                entry = Entry(None, dash, dash + 1, self._value(event, dash + 1))
                behind = entry.end
            span.entries.append(entry)
        self._close(span, event)

    def _map(self, span: Span) -> None:
        text = self._text
        while not _ends(event := next(self._events)):
            key = self._value(event, event.start_mark.index)
            colon = _COLON.match(text, key.end)
            if key.kind != "scalar" or key.shared or key.style in ("|", ">") or colon is None:
                raise UnknownTextError(_ODD)
            value = self._value(next(self._events), colon.end())
            span.entries.append(Entry(event.value, key.start, colon.end(), value, key))
        if span.entries and not span.flow:
            first = span.entries[0].start
            span.column = first - text.rfind("\n", 0, first) - 1
        self._close(span, event)

    def _close(self, span: Span, event: Any) -> None:
        if span.flow:
            span.end = event.end_mark.index
        elif span.entries:
            span.end = span.entries[-1].end


def _ends(event: Any) -> bool:
    return type(event).__name__.endswith("EndEvent")
