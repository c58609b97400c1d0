"""Attaches every comment of a text, and every single empty line, to the value that it describes."""

import itertools
import json
import re
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from mjsim.world.yaml.spans import Comment, Entry, Span, UnknownTextError, read_spans

_COMMENT = re.compile(r"(?<!\S)#[^\n]*")
_PREFIX = re.compile(r"(?:[&!]\S*\s+)+")
_NOT_PLAIN = re.compile("[\x7f-\x9f\u2028\u2029\ufeff\ud800-\udfff]")
_ODD = "it is written in a form that cannot be formatted"


@dataclass(slots=True, eq=False)
class _Item:
    """An entry, and where it is."""

    entry: Entry
    parent: "_Item | None"
    """The item that contains it."""
    around: tuple[Span, ...]
    """The values that contain it, outermost first."""
    start: int
    line: int
    end_line: int


def read_commented(text: str) -> tuple[Span, list[str]]:
    """Return the value of a valid YAML text, a mapping, with its comments attached; and all comments, sorted.

    Raises:
        UnknownTextError: The text uses features of YAML that no world file needs.
    """
    root = read_spans(text)
    if root.kind != "map" or not root.entries:
        raise UnknownTextError(_ODD)
    lines = _Lines(text)
    items = list(_items(lines, root, None, (root,)))
    comments = list(_comments(lines, root))
    _place(lines, items, root, comments)
    return root, sorted(comment.text for comment in comments)


def quoted(value: str) -> str:
    """Return a text in double quotes, on one line."""
    return _NOT_PLAIN.sub(lambda found: f"\\u{ord(found.group()):04x}", json.dumps(value, ensure_ascii=False))


class _Lines:
    """A text and its lines."""

    def __init__(self, text: str) -> None:
        self.text, self.lines = text, text.split("\n")
        self._starts = list(itertools.accumulate((len(line) + 1 for line in self.lines), initial=0))

    def place(self, index: int) -> tuple[int, int]:
        """Return line and column of a character, from 0."""
        line = bisect_right(self._starts, index) - 1
        return line, index - self._starts[line]

    def is_empty(self, number: int) -> bool:
        """Return whether a line is there and holds nothing."""
        return number >= 0 and not self.lines[number].strip()


def _items(lines: _Lines, span: Span, parent: _Item | None, around: tuple[Span, ...]) -> Iterator[_Item]:
    """Yield the items of a value in the order of the text, and keep how each value is written."""
    _keep_written(lines.text, span)
    for entry in span.entries:
        if entry.key is not None:
            _keep_written(lines.text, entry.key)
            if entry.key.written[:1] in ("", "*", "&", "!"):
                raise UnknownTextError(_ODD)
        start = (entry.key or entry.value).start
        item = _Item(entry, parent, around, start, lines.place(start)[0], lines.place(entry.end)[0])
        yield item
        yield from _items(lines, entry.value, item, (*around, entry.value))


def _keep_written(text: str, span: Span) -> None:
    if span.kind != "scalar":
        found = _PREFIX.match(text, span.start)
        span.written = " ".join(found.group().split()) if found else ""
        return
    span.written = text[span.start : span.end]
    if "\n" in span.written or span.is_block:
        if span.shared:
            raise UnknownTextError(_ODD)
        span.written = quoted(span.text)


def _comments(lines: _Lines, root: Span) -> Iterator[Comment]:
    """Yield the comments: between scalars, and beside the indicator of a block scalar."""
    end = 0
    for span in _scalars(root):
        yield from _comments_in(lines, end, lines.text.find("\n", span.start) if span.is_block else span.start)
        end = span.end
    yield from _comments_in(lines, end, len(lines.text))


def _scalars(span: Span) -> Iterator[Span]:
    if span.kind == "scalar":
        yield span
    for entry in span.entries:
        yield from () if entry.key is None else (entry.key,)
        yield from _scalars(entry.value)


def _comments_in(lines: _Lines, start: int, end: int) -> Iterator[Comment]:
    for match in _COMMENT.finditer(lines.text, start, end):
        line, column = lines.place(match.start())
        own = not lines.lines[line][:column].strip()
        yield Comment(match.group().rstrip(), match.start(), line, column, own)


def _place(lines: _Lines, items: Sequence[_Item], root: Span, comments: Sequence[Comment]) -> None:
    """Attach every comment, and every preserved empty line, to what it describes."""
    starts = [item.start for item in items]
    own: dict[int, list[Comment]] = {}
    for comment in comments:
        number = bisect_right(starts, comment.index)
        if comment.own_line or not _put_beside(items[number - 1] if number else None, comment):
            own.setdefault(number, []).append(comment)
    for number, item in enumerate([*items, None]):
        _put_above(lines, root, own.get(number, []), items[number - 1] if number else None, item)
        if item is not None and not item.around[-1].flow and lines.is_empty(item.line - 1):
            item.entry.before += ("",)


def _put_beside(last: _Item | None, comment: Comment) -> bool:
    """Attach a comment to what precedes it on its line; return whether there is something."""
    ended: Entry | None = None
    item = last
    while item is not None:
        # Of those with the same end, the innermost: its text is there.
        if item.entry.end <= comment.index and item.end_line == comment.line:
            ended = item.entry if ended is None or item.entry.end > ended.end else ended
        item = item.parent
    if ended is not None and ended.after is None:
        ended.after = comment
        return True
    if last is not None and last.line == comment.line and last.entry.end > comment.index and last.entry.head is None:
        last.entry.head = comment
        return True
    return False


def _put_above(lines: _Lines, root: Span, found: list[Comment], last: _Item | None, item: _Item | None) -> None:
    """Attach comment lines to the item below, or to what they are indented with."""
    limit: tuple[Span, ...] = () if last is None else last.around
    for comment in found:
        if limit:
            holder = _holder(comment, limit, item)
            limit = () if holder is None else limit[: limit.index(holder) + 1]
        added = ("", comment.text) if lines.is_empty(comment.line - 1) else (comment.text,)
        if limit:
            limit[-1].tail += added
        elif item is not None:
            item.entry.before += added
        else:
            root.tail += added


def _holder(comment: Comment, spans: tuple[Span, ...], item: _Item | None) -> Span | None:
    """Return the innermost value that ends before an item and has the indentation of a comment."""
    for span in reversed(spans):
        if item is not None and span in item.around:
            return None
        if span.flow:
            if comment.index < span.end:
                return span
        elif span.column <= comment.column and (item is None or comment.column > item.around[-1].column):
            return span
    return None
