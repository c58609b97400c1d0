"""Parses a text into a tree that preserves the form of each value, and attaches every comment to what it describes."""

import itertools
import json
import re
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.events import AliasEvent, MappingStartEvent, ScalarEvent

_COMMENT = re.compile(r"(?<!\S)#[^\n]*")
_PREFIX = re.compile(r"(?:[&!]\S*\s+)+")
_NOT_PLAIN = re.compile("[\x7f-\x9f\u2028\u2029\ufeff]")


@dataclass(slots=True, eq=False)
class Comment:
    """A comment and its position."""

    text: str
    """From the # on, without trailing spaces."""
    index: int
    line: int
    column: int
    own_line: bool
    """Whether it is alone on its line."""


@dataclass(slots=True, eq=False)
class TreeNode:
    """A value as written."""

    kind: str
    """'scalar', 'list' or 'map'."""
    text: str
    """Text of a scalar, on one line, with anchor and tag."""
    value: str = ""
    """Value of a scalar according to YAML."""
    block: bool = False
    """Whether it is a block scalar, or a list or a mapping without brackets."""
    prefix: str = ""
    """Anchor and tag of a list or a mapping."""
    column: int = 0
    """Column of its items."""
    start: int = 0
    end: int = 0
    items: list["TreeItem"] = field(default_factory=list)
    tail: list[str] = field(default_factory=list)
    """Comments after the last item, and '' for an empty line."""


@dataclass(slots=True, eq=False)
class TreeItem:
    """An item of a list, or a key with its value."""

    key: TreeNode | None
    parent: "TreeItem | None"
    """The item that contains it."""
    around: tuple[TreeNode, ...]
    """The parts that contain it, outermost first."""
    start: int
    line: int
    part: TreeNode = field(default_factory=lambda: TreeNode("scalar", ""))
    end: int = 0
    end_line: int = 0
    before: list[str] = field(default_factory=list)
    """Comments above it, and '' for an empty line."""
    head: Comment | None = None
    """Comment beside its key, if its value is below."""
    after: Comment | None = None
    """Comment beside its end."""


class UnformattableError(Exception):
    """The text is written in a form that cannot be formatted."""


def read_tree(text: str) -> tuple[TreeNode, list[str]]:
    """Return the tree of a valid YAML text, a mapping, and all its comments, sorted.

    Raises:
        UnformattableError: The text uses features of YAML that no world file needs.
    """
    reader = _TreeReader(text)
    root = reader.root()
    comments = list(reader.comments())
    _place_comments(reader, root, comments)
    return root, sorted(comment.text for comment in comments)


def one_line(value: str) -> str:
    """Return a text in double quotes, on one line."""
    return _NOT_PLAIN.sub(lambda found: f"\\u{ord(found.group()):04x}", json.dumps(value, ensure_ascii=False))


class _TreeReader:
    """Builds the tree of a text from its events; comments are attached afterwards."""

    def __init__(self, text: str) -> None:
        self.text, self.lines = text, text.split("\n")
        self._line_starts = list(itertools.accumulate((len(line) + 1 for line in self.lines), initial=0))
        self.items: list[TreeItem] = []
        """All items, in the order of the text."""
        self._events: list[Any] = list(YAML(typ="safe", pure=True).parse(text))
        self._at = 2  # after the starts of the stream and of the document

    def root(self) -> TreeNode:
        root = self._part(None)
        if root.kind != "map" or not root.items:
            raise UnformattableError
        return root

    def comments(self) -> Iterator[Comment]:
        """Yield the comments: between events, and beside the indicator of a block scalar."""
        end = 0
        for event in self._events:
            start, stop = event.start_mark.index, event.end_mark.index
            yield from self._comments_in(end, start)
            if isinstance(event, ScalarEvent):
                yield from self._comments_in(start, self.text.find("\n", start) if event.style in ("|", ">") else start)
            else:
                yield from self._comments_in(max(start, end), stop)
            end = max(end, stop)
        yield from self._comments_in(end, len(self.text))

    def _comments_in(self, start: int, end: int) -> Iterator[Comment]:
        for match in _COMMENT.finditer(self.text, start, end):
            line, column = self._place(match.start())
            own = not self.lines[line][:column].strip()
            yield Comment(match.group().rstrip(), match.start(), line, column, own)

    def _part(self, parent: TreeItem | None) -> TreeNode:
        event = self._events[self._at]
        self._at += 1
        start, end = event.start_mark, event.end_mark
        if isinstance(event, (ScalarEvent, AliasEvent)):
            return self._scalar(event, start.index, end.index)
        flow = bool(event.flow_style)
        found = _PREFIX.match(self.text, start.index)
        prefix = " ".join(found.group().split()) if found else ""
        kind = "map" if isinstance(event, MappingStartEvent) else "list"
        part = TreeNode(kind, "", "", not flow, prefix, start.column, start.index)
        while not type(self._events[self._at]).__name__.endswith("EndEvent"):
            self._item(part, parent)
        close = self._events[self._at].end_mark.index
        self._at += 1
        part.end = close if flow or not part.items else part.items[-1].end
        if part.block and part.items and kind == "map":
            part.column = self._place(part.items[0].start)[1]
        return part

    def _item(self, part: TreeNode, parent: TreeItem | None) -> None:
        mark = self._events[self._at].start_mark
        around = () if parent is None else parent.around
        # Not `mark.line`: YAML has more line breaks than those at which these lines are split.
        item = TreeItem(None, parent, (*around, part), mark.index, self._place(mark.index)[0])
        self.items.append(item)
        part.items.append(item)
        if part.kind == "map":
            item.key = self._part(item)
            if item.key.kind != "scalar" or item.key.block or item.key.text[:1] in ("", "*", "&", "!"):
                raise UnformattableError
        item.part = self._part(item)
        item.end = max(item.part.end, item.key.end if item.key is not None else 0)
        item.end_line = self._place(item.end)[0]

    def _scalar(self, event: Any, start: int, end: int) -> TreeNode:
        written = self.text[start:end].rstrip()
        block = isinstance(event, ScalarEvent) and event.style in ("|", ">")
        value = "" if isinstance(event, AliasEvent) else event.value
        if "\n" in written or block:
            if event.anchor is not None or (event.ctag is not None and str(event.ctag)):
                raise UnformattableError
            return TreeNode("scalar", one_line(value), value, block, start=start, end=start + len(written))
        return TreeNode("scalar", written, value, start=start, end=start + len(written))

    def _place(self, index: int) -> tuple[int, int]:
        line = bisect_right(self._line_starts, index) - 1
        return line, index - self._line_starts[line]


def _place_comments(reader: _TreeReader, root: TreeNode, comments: list[Comment]) -> None:
    """Attach every comment, and every preserved empty line, to what it describes."""
    starts = [item.start for item in reader.items]
    own: dict[int, list[Comment]] = {}
    for comment in comments:
        number = bisect_right(starts, comment.index)
        if comment.own_line or not _put_beside(reader.items[number - 1] if number else None, comment):
            own.setdefault(number, []).append(comment)
    for number, item in enumerate([*reader.items, None]):
        _put_above(reader, root, own.get(number, []), reader.items[number - 1] if number else None, item)
        if item is not None and item.around[-1].block and _is_empty(reader.lines, item.line - 1):
            item.before.append("")


def _put_beside(last: TreeItem | None, comment: Comment) -> bool:
    """Attach a comment to what precedes it on its line; return whether there is something."""
    ended: TreeItem | None = None
    item = last
    while item is not None:
        # Of those with the same end, the innermost: its text is there.
        if item.end <= comment.index and item.end_line == comment.line and (ended is None or item.end > ended.end):
            ended = item
        item = item.parent
    if ended is not None and ended.after is None:
        ended.after = comment
        return True
    if last is not None and last.line == comment.line and last.end > comment.index and last.head is None:
        last.head = comment
        return True
    return False


def _put_above(
    reader: _TreeReader, root: TreeNode, found: list[Comment], last: TreeItem | None, item: TreeItem | None
) -> None:
    """Attach comment lines to the item below, or to what they are indented with."""
    limit: tuple[TreeNode, ...] = () if last is None else last.around
    for comment in found:
        if limit:
            holder = _holder(comment, limit, item)
            limit = () if holder is None else limit[: limit.index(holder) + 1]
        target = item.before if item is not None else root.tail
        if limit:
            target = limit[-1].tail
        if _is_empty(reader.lines, comment.line - 1):
            target.append("")
        target.append(comment.text)


def _holder(comment: Comment, parts: tuple[TreeNode, ...], item: TreeItem | None) -> TreeNode | None:
    """Return the innermost part that ends before an item and has the indentation of a comment."""
    for part in reversed(parts):
        if item is not None and part in item.around:
            return None
        if part.block and part.column <= comment.column and (item is None or comment.column > item.around[-1].column):
            return part
        if not part.block and comment.index < part.end:
            return part
    return None


def _is_empty(lines: list[str], number: int) -> bool:
    return number >= 0 and not lines[number].strip()
