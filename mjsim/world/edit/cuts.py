"""Removes entries from a text and inserts new ones, preserving comments, spaces and empty lines around them."""

import re
from collections.abc import Sequence
from itertools import pairwise

from mjsim.world.edit.snippet import WIDTH, folded
from mjsim.world.yaml import Entry, Span

Cut = tuple[int, int, str]
"""Start, end, and the replacement text."""

_BLANK = re.compile(r"(?:\s|#[^\n]*)*")
_REST = re.compile(r"[ \t]*(?:#[^\n]*)?(?=\r?\n|\Z)")
"""The end of a line that contains only a comment."""
_COMMENT_LINE = re.compile(r"([ \t]*)#[^\n]*(?:\n|\Z)")
_MAX_BREAK_COLUMN = WIDTH // 2
"""Column beyond which no new lines are started: they would be too short."""
_CONTINUATION_INDENT = 6
"""Indentation of continuation lines relative to the line with the opening bracket [columns]."""
_EMPTY_LINE = re.compile(r"\n[ \t]*\r?\n")


def applied(text: str, cuts: Sequence[Cut]) -> str:
    """Return a text after non-overlapping replacements."""
    parts, at = [], 0
    for start, end, new in sorted(cuts, key=lambda cut: cut[:2]):
        assert start >= at, "pieces that are replaced do not overlap"
        parts += [text[at:start], new]
        at = end
    return "".join([*parts, text[at:]])


def taken_out(text: str, parent: Span, index: int, holder: Entry | None) -> list[Cut]:
    """Return the cuts that remove an entry from a list or a mapping.

    Comments beside and in the entry are removed with it; comment lines above it stay.

    Args:
        text: The text.
        parent: The list or mapping.
        index: Index of the entry.
        holder: The entry whose value is the parent; None for the whole text.
    """
    if parent.flow:
        return _out_of_brackets(text, parent, index)
    entry = parent.entries[index]
    if len(parent.entries) > 1:
        return _out_of_lines(text, parent, index)
    assert holder is not None, "a world without keys is none"
    empty = "[]" if parent.kind == "list" else "{}"
    if "\n" not in text[holder.mark : entry.start]:
        return [(entry.start, entry.end, empty)]
    return [(holder.mark, holder.mark, f" {empty}"), _lines_of(text, entry, parent.column)]


def put_in(text: str, parent: Span, index: int, *, line: str, lines: Sequence[str]) -> list[Cut]:
    """Return the cuts that insert an entry into a list or a mapping.

    Args:
        text: The text.
        parent: The list or mapping.
        index: Index of the entry before which to insert; the number of entries to append.
        line: The new entry in flow style.
        lines: The new entry in block style, indented like the other entries.
    """
    return _into_brackets(text, parent, index, line) if parent.flow else _into_lines(text, parent, index, lines)


def line_start(text: str, at: int) -> int:
    """Return the start of the line that contains a position."""
    return text.rfind("\n", 0, at) + 1


def line_rest(text: str, at: int) -> int:
    """Return the end of the line that contains a position, before its line break."""
    end = text.find("\n", at)
    end = len(text) if end < 0 else end
    return end - 1 if text[end - 1 : end] == "\r" else end


def new_line(text: str) -> str:
    """Return the line break used in a text."""
    return "\r\n" if "\r\n" in text else "\n"


def _line_end(text: str, at: int) -> int:
    """Return the start of the next line, or the end of the text."""
    found = text.find("\n", at)
    return len(text) if found < 0 else found + 1


def _leads(text: str, at: int) -> bool:
    """Return whether a position is preceded only by spaces on its line."""
    return not text[line_start(text, at) : at].strip()


def _comma(text: str, at: int) -> int | None:
    """Return the position of the comma after an entry in brackets; None if there is none."""
    found = _BLANK.match(text, at)
    assert found is not None, "it matches nothing too"
    return found.end() if text[found.end() : found.end() + 1] == "," else None


def _behind(text: str, entry: Entry, column: int) -> int:
    """Return the start of the line after an entry, without the more deeply indented comments below it."""
    at = _line_end(text, entry.end)
    while (comment := _COMMENT_LINE.match(text, at)) and len(comment.group(1)) > column and comment.end() > at:
        at = comment.end()
    return at


def _lines_of(text: str, entry: Entry, column: int) -> Cut:
    """Return a cut of the lines of an entry, and of one of two empty lines that would remain around it."""
    start, end = line_start(text, entry.start), _behind(text, entry, column)
    before = line_start(text, start - 1) if start else 0
    followed = end < len(text) and text[end : _line_end(text, end)].strip()
    if start and not text[before:start].strip() and not followed:
        start = before
    if end == len(text) and not text.endswith("\n") and start:
        start -= len(new_line(text))
    return start, end, ""


def _out_of_lines(text: str, parent: Span, index: int) -> list[Cut]:
    entry = parent.entries[index]
    if _leads(text, entry.start):
        return [_lines_of(text, entry, parent.column)]
    # Its line begins with a dash that belongs to the whole item.
    following = parent.entries[index + 1]
    if "#" not in text[_line_end(text, entry.end) : following.start]:
        return [(entry.start, following.start, "")]
    rest = _REST.match(text, entry.end)
    return [(entry.start, entry.end if rest is None else rest.end(), "")]


def _out_of_brackets(text: str, parent: Span, index: int) -> list[Cut]:
    entries = parent.entries
    entry, comma = entries[index], _comma(text, entries[index].end)
    tail = entry.end if comma is None else comma + 1
    if len(entries) == 1:
        inner = text[parent.start + 1 : entry.start] + text[tail : parent.end - 1]
        return [(entry.start, tail, "") if inner.strip() else (parent.start + 1, parent.end - 1, "")]
    last, rest = index == len(entries) - 1, _REST.match(text, tail)
    if _leads(text, entry.start) and rest is not None:
        cuts = [(line_start(text, entry.start), _line_end(text, rest.end()), "")]
        return cuts + (_without_comma(text, entries[index - 1]) if last and comma is None else [])
    if not last:
        following = entries[index + 1]
        if "\n" not in text[tail : following.start]:
            return [(entry.start, following.start, "")]
        start = entry.start
        while text[start - 1] == " ":
            start -= 1
        return [(start, tail, "")]
    before = entries[index - 1]
    if "#" not in text[before.end : entry.start]:
        return [(before.end, entry.end, "")]
    return [*_without_comma(text, before), (entry.start, tail, "")]


def _without_comma(text: str, entry: Entry) -> list[Cut]:
    comma = _comma(text, entry.end)
    return [] if comma is None else [(comma, comma + 1, "")]


def _into_brackets(text: str, parent: Span, index: int, line: str) -> list[Cut]:
    entries = parent.entries
    indent = _indent(text, entries[0]) + 2 if entries else 0
    if not entries:
        inner, begin = text[parent.start + 1 : parent.end - 1], line_start(text, parent.start)
        line = _fold(text, line, column=parent.start + 1 - begin, indent=_margin(text, begin) + _CONTINUATION_INDENT)
        return [
            (parent.start + 1, parent.start + 1, f"{line} ")
            if inner.strip()
            else (parent.start + 1, parent.end - 1, line)
        ]
    if index < len(entries):
        following = entries[index]
        gap = _gap(text, following.start, following.start, line, entries[0])
        line = _fold(text, line, column=following.start - line_start(text, following.start), indent=indent)
        return [(following.start, following.start, f"{line},{gap}")]
    last = entries[-1]
    comma = _comma(text, last.end)
    rest = _REST.match(text, last.end if comma is None else comma + 1)
    if rest is not None and _leads(text, last.start):
        margin = text[line_start(text, last.start) : last.start]
        line = _fold(text, line, column=len(margin), indent=len(margin) + 2)
        added = (rest.end(), rest.end(), f"{new_line(text)}{margin}{line}{',' if comma is not None else ''}")
        return [added] if comma is not None else [(last.end, last.end, ","), added]
    gap = _gap(text, last.end, last.start, line, entries[0])
    line = _fold(text, line, column=indent - 2, indent=indent) if gap != " " else line
    if comma is not None:
        return [(comma + 1, comma + 1, f"{gap}{line},")]
    return [(last.end, last.end, f",{gap}{line}")]


def _gap(text: str, at: int, beside: int, line: str, first: Entry) -> str:
    """Return the separator of two entries in brackets: a line break if there was one, or if the line is full."""
    length = len(text[line_start(text, at) : _line_end(text, at)].rstrip())
    if (_leads(text, beside) and beside > first.start) or length + len(line) + 2 > WIDTH:
        return new_line(text) + " " * _indent(text, first)
    return " "


def _indent(text: str, first: Entry) -> int:
    """Return the indentation of entries in brackets on new lines: that of the first, unless it is far to the right."""
    begin = line_start(text, first.start)
    column = first.start - begin
    if column <= _MAX_BREAK_COLUMN:
        return column
    return _margin(text, begin) + _CONTINUATION_INDENT


def _margin(text: str, begin: int) -> int:
    """Return the number of spaces at the start of a line."""
    own = text[begin : line_rest(text, begin)]
    return len(own) - len(own.lstrip())


def _fold(text: str, line: str, *, column: int, indent: int) -> str:
    """Return an entry with the line breaks of the text where it is too long."""
    return folded(line, column=column, indent=indent).replace("\n", new_line(text))


def _into_lines(text: str, parent: Span, index: int, lines: Sequence[str]) -> list[Cut]:
    entries, end = parent.entries, new_line(text)
    first = entries[0]
    if index == 0 and not _leads(text, first.start):
        space = " " * parent.column
        return [(first.start, first.start, end.join(lines).lstrip() + end + space)]
    spaced = _has_blank_lines(text, entries, index)
    if index == 0:
        at = line_start(text, first.start)
        return [(at, at, end.join(lines) + end + (end if spaced else ""))]
    at = _behind(text, entries[index - 1], parent.column)
    written = (end if spaced else "") + end.join(lines)
    return [(at, at, f"{written}{end}" if not at or text[at - 1] == "\n" else f"{end}{written}")]


def _has_blank_lines(text: str, entries: Sequence[Entry], index: int) -> bool:
    """Return whether empty lines separate the entries around an insertion."""
    pairs = list(pairwise(entries))
    if not pairs:
        return False
    before, after = pairs[min(max(index - 1, 0), len(pairs) - 1)]
    return _EMPTY_LINE.search(text, before.end, after.start) is not None
