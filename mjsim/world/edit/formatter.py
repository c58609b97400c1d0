"""Formats the text of a world file: all values and comments stay, only spaces and line breaks change."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from mjsim.errors import Problem, UsageError, WorldError
from mjsim.output import write_whole
from mjsim.sentences import Sentence
from mjsim.world.edit.snippet import FIRST, WIDTH
from mjsim.world.files import world_path
from mjsim.world.ground import models_at
from mjsim.world.items import World
from mjsim.world.language import Repeat
from mjsim.world.read import read_file
from mjsim.world.yaml import (
    Comment,
    Entry,
    Span,
    UnknownTextError,
    plain_value,
    quoted,
    read_commented,
    read_text,
)

_STEP = 2
"""Indentation per level [spaces]."""
_GAP = 2
"""Minimum number of spaces before a comment."""
_MAX_LINES = 3
"""Maximum number of lines of an item in brackets; a longer one gets a line per key."""
_MAX_ROUNDS = 8
_UNORDERED = ((), ("variables",), ("run", "drivers"))
"""Paths of mappings whose keys are not reordered."""

Steps = tuple[str | int, ...]


def format_text(text: str, *, file: str) -> str:
    """Return a text in standard layout, with the same values and comments.

    Items on one line stay there if they fit, otherwise each key gets its own line; lists of numbers fill lines. Keys of
    items are put in a standard order. Comments keep their column where possible.

    Raises:
        WorldError: The text is not YAML, or uses YAML features that cannot be reformatted without loss.
    """
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    node, problems = read_text(text, file=file)
    if node is None or problems:
        raise WorldError(problems)
    refused = WorldError([Problem(file, 1, 1, "this text cannot be formatted without loss; format it by hand")])
    formatted, before, found = text, "", []
    try:
        # Repeat if a comment has left brackets, which may then fit on one line.
        for _ in range(_MAX_ROUNDS):
            root, comments = read_commented(formatted)
            found.append(comments)
            before, formatted = formatted, _Formatter(ordered="&" not in text).whole(root)
            if formatted == before:
                break
    except UnknownTextError:
        raise refused from None
    again, _ = read_text(formatted, file=file)
    # Nothing may be lost, however unusual the text.
    if (
        formatted != before
        or again is None
        or _canonical(again.value) != _canonical(node.value)
        or found[0] != found[-1]
    ):
        raise refused
    return formatted


def format_file(path: str | Path, *, write: bool) -> bool:
    """Format a world file; return whether it changes.

    Args:
        path: The file.
        write: Whether to write the file; otherwise it stays unchanged.

    Raises:
        UsageError: The file does not exist, or cannot be written.
        WorldError: The text cannot be formatted; see `format_text`.
    """
    path = world_path(path)
    text = read_file(path)
    formatted = format_text(text, file=str(path))
    if formatted == text or not write:
        return formatted != text
    try:
        write_whole(path.resolve(), formatted.encode("utf-8"))
    except OSError as error:
        raise UsageError(Sentence("cannot write '{path}': {reason}", path, error.strerror)) from None
    return True


def _canonical(value: Any) -> str:
    return json.dumps(value, sort_keys=True)


class _Formatter:
    """Writes the parts of one text."""

    def __init__(self, *, ordered: bool) -> None:
        """Store whether keys may be reordered: an anchor must come before its aliases."""
        self._ordered = ordered

    def whole(self, root: Span) -> str:
        self._sort(root, ())
        return "\n".join(_without_empty_ends([*self._map(root, 0), *root.tail])) + "\n"

    def _sort(self, part: Span, path: Steps) -> None:
        """Sort the keys of all mappings."""
        if part.kind == "map" and self._ordered and path not in _UNORDERED:
            ranks = key_ranks([str(item.name) for item in part.entries], path)
            part.entries.sort(key=lambda item: ranks[str(item.name)])
        for number, item in enumerate(part.entries):
            self._sort(item.value, (*path, number if item.name is None else item.name))

    def _map(self, part: Span, indent: int) -> list[str]:
        lines: list[str] = []
        space = " " * indent
        for item in part.entries:
            assert item.key is not None
            key = _key(item.key)
            above, lead = _indented(item.before, space), f"{space}{key}:"
            value = self._inline(item.value, len(lead) + 1)
            if value is not None:
                more, after = _beside(item)
                first, *rest = value
                lines += [*above, *_indented(more, space)]
                lines += [f"{lead} {first}".rstrip(), *rest] if first else [lead]
                lines[-1] = _with_comment(lines[-1], after)
                continue
            head = item.head or item.after
            more = [item.after.text] if item.head is not None and item.after is not None else []
            lines += [*above, *_indented(more, space)]
            opening = f"{lead} {_opening(item.value)}".rstrip()
            lines += [_with_comment(opening, head), *self._below(item.value, indent + _STEP)]
        return lines

    def _list(self, part: Span, indent: int) -> list[str]:
        lines: list[str] = []
        space = " " * indent
        for item in part.entries:
            value = self._inline(item.value, indent + _STEP)
            beside = [comment for comment in (item.head, item.after) if comment is not None]
            after = beside.pop() if value is not None and beside else None
            lines += _indented([*item.before, *(comment.text for comment in beside)], space)
            if value is not None:
                first, *rest = value
                lines += [f"{space}- {first}".rstrip(), *rest]
                lines[-1] = _with_comment(lines[-1], after)
                continue
            below = self._below(item.value, indent + _STEP)
            if item.value.written or item.value.kind == "scalar":
                lines += [f"{space}- {_opening(item.value)}".rstrip(), *below]
                continue
            while not below[0] or below[0].lstrip().startswith(
                "#"
            ):  # a comment about its first key goes above its dash
                lines += _indented([below.pop(0).lstrip()], space)
            lines += [f"{space}- {below[0].lstrip()}", *below[1:]]
        return lines

    def _below(self, part: Span, indent: int) -> list[str]:
        """Return the lines below a key or a dash."""
        space = " " * indent
        if part.kind == "scalar":
            return [space + line if line else "" for line in part.text.rstrip("\n").split("\n")]
        inside = self._map(part, indent) if part.kind == "map" else self._list(part, indent)
        return _without_empty_ends([*inside, *_indented(part.tail, space)])

    def _inline(self, part: Span, column: int) -> list[str] | None:
        """Return the lines of a value that continues on its key's line; None if it must start below.

        Args:
            part: The value.
            column: Column in which it would start.
        """
        if part.kind == "scalar":
            return None if part.is_block and _is_block_text(part.text) else [part.written]
        if _has_comments(part):
            return None
        flat = _is_flat(part)
        if not part.flow and part.entries and not flat:
            return None
        line = _flow(part)
        if column + len(line) <= WIDTH or not part.entries:
            return [line]
        lines = _filled(part, column)
        fits = len(lines) <= _MAX_LINES and all(len(line) <= WIDTH for line in [" " * column + lines[0], *lines[1:]])
        return lines if flat or fits else None


def key_ranks(keys: list[str], path: Steps) -> dict[str, int]:
    """Return the rank of each key: well-known keys first, then in the order of the models, then as written."""
    if "use" in keys:
        return {key: 0 if key == "use" else 1 for key in keys}
    repeating = [step for step in path if isinstance(step, str)][-1:] == ["repeat"]
    models: list[type[BaseModel]] = [Repeat] if repeating else models_at(World, path)
    best = max(models, key=lambda model: len(model.model_fields.keys() & set(keys)), default=None)
    known = list(best.model_fields) if best is not None else []
    if not known:
        return dict.fromkeys(keys, 0)
    order = [*(key for key in FIRST if key in known), *(key for key in known if key not in FIRST)]
    ranks = {key: order.index(key) if key in order else len(order) for key in keys}
    return {key: len(order) + 1 if key == "repeat" else rank for key, rank in ranks.items()}


def _key(key: Span) -> str:
    """Return a key, quoted only if needed."""
    return key.text if key.text.isidentifier() and plain_value(key.text) == key.text else key.written


def _key_in_brackets(key: Span) -> str:
    text = _key(key)
    return _in_brackets(key) if text == key.written else text


def _flow(part: Span) -> str:
    """Return a value in brackets, on one line."""
    if part.kind == "scalar":
        return _in_brackets(part)
    text = ", ".join(_pieces(part))
    text = f"{{{text}}}" if part.kind == "map" else f"[{text}]"
    return f"{part.written} {text}" if part.written else text


def _pieces(part: Span) -> list[str]:
    """Return the items of a list or a mapping in their form inside brackets."""
    return [
        _flow(item.value) if item.key is None else f"{_key_in_brackets(item.key)}: {_flow(item.value)}"
        for item in part.entries
    ]


def _in_brackets(part: Span) -> str:
    """Return a scalar in its form inside brackets, where fewer characters are allowed without quotes."""
    if not part.written:
        return "null"
    plain = part.written[0] not in "'\"&!*"
    return quoted(part.text) if plain and any(sign in part.written for sign in ",[]{}") else part.written


def _filled(part: Span, column: int) -> list[str]:
    """Return a value in brackets with its items filling lines."""
    opening, closing = ("{", "}") if part.kind == "map" else ("[", "]")
    opening = f"{part.written} {opening}".lstrip()
    lines, space = [opening], " " * (column + len(opening))
    pieces = _pieces(part)
    for number, piece in enumerate(pieces, start=1):
        text = piece + ("," if number < len(pieces) else closing)
        start = column if len(lines) == 1 else 0
        if start + len(lines[-1]) + 1 + len(text) > WIDTH and number > 1:
            lines.append(space + text)
        else:
            lines[-1] += f" {text}" if number > 1 else text
    return lines


def _is_flat(part: Span) -> bool:
    """Return whether a part is a list of scalars, or of lists of scalars."""
    return part.kind == "list" and all(
        (item.value.kind == "scalar" and not item.value.is_block) or _is_flat(item.value) for item in part.entries
    )


def _has_comments(part: Span) -> bool:
    return bool(part.tail) or any(
        item.head is not None
        or item.after is not None
        or any(item.before)
        or item.value.is_block
        or _has_comments(item.value)
        for item in part.entries
    )


def _is_block_text(value: str) -> bool:
    """Return whether a text can be written as a literal block."""
    lines = value.rstrip("\n").split("\n")
    plain = all(line == line.strip() and (line.isprintable() or not line) for line in lines)
    return plain and bool(lines[0]) and bool(lines[-1]) and not value.endswith("\n\n")


def _opening(part: Span) -> str:
    """Return what follows a key on its line if the value is below."""
    if part.kind == "scalar":
        return "|" if part.text.endswith("\n") else "|-"
    return part.written


def _beside(item: Entry) -> tuple[list[str], Comment | None]:
    """Return the comments above and beside an item on one line."""
    found = [comment for comment in (item.head, item.after) if comment is not None]
    after = found.pop() if found else None
    return [comment.text for comment in found], after


def _with_comment(line: str, comment: Comment | None) -> str:
    """Return a line with a comment, in the comment's column if that is free."""
    if comment is None:
        return line
    return f"{line}{' ' * max(comment.column - len(line), _GAP)}{comment.text}"


def _indented(lines: Sequence[str], space: str) -> list[str]:
    return [space + line if line else "" for line in lines]


def _without_empty_ends(lines: list[str]) -> list[str]:
    """Return lines without empty lines at both ends and without consecutive empty lines."""
    trimmed: list[str] = []
    for line in lines:
        if line or (trimmed and trimmed[-1]):
            trimmed.append(line)
    while trimmed and not trimmed[-1]:
        trimmed.pop()
    return trimmed
