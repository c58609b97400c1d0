"""Formats the text of a world file: every value and comment stays, only spaces and lines change."""

import json
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from mjsim.errors import Problem, UsageError, WorldError
from mjsim.world.edit.layout import FIRST, WIDTH
from mjsim.world.files import world_path, write_whole
from mjsim.world.ground import models_at
from mjsim.world.items import World
from mjsim.world.language import Repeat
from mjsim.world.read import read_file
from mjsim.world.yaml import (
    Comment,
    TreeItem,
    TreeNode,
    UnformattableError,
    one_line,
    plain_value,
    read_text,
    read_tree,
)

_STEP = 2
"""Spaces by which what is inside stands further right."""
_GAP = 2
"""Spaces before a comment, at least."""
_MOST_LINES = 3
"""Of an item in brackets; a longer one gets a line for each key."""
_MOST_ROUNDS = 8
_UNORDERED = ((), ("variables",), ("run", "drivers"))
"""Paths of mappings whose keys stay in their order."""

Steps = tuple[str | int, ...]


def format_text(text: str, *, file: str) -> str:
    """Return a text laid out for people, the same values and comments in it.

    What stands on one line stays there if it fits, else each key gets a line of its own; lists of numbers fill
    lines. Keys of items come in the order in which people look for them. Comments keep their column where they can.

    Raises:
        WorldError: It is not YAML, or uses it in a way that cannot be laid out without loss.
    """
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    node, problems = read_text(text, file=file)
    if node is None or problems:
        raise WorldError(problems)
    refused = WorldError([Problem(file, 1, 1, "this text cannot be laid out without loss; lay it out by hand")])
    laid, before, found = text, "", []
    try:
        # Once more when a comment has left brackets, which may close then.
        for _ in range(_MOST_ROUNDS):
            root, comments = read_tree(laid)
            found.append(comments)
            before, laid = laid, _Formatter(ordered="&" not in text).whole(root)
            if laid == before:
                break
    except UnformattableError:
        raise refused from None
    again, _ = read_text(laid, file=file)
    # Nothing may be lost, however odd the text.
    if laid != before or again is None or _canonical(again.value) != _canonical(node.value) or found[0] != found[-1]:
        raise refused
    return laid


def format_file(path: str | Path, *, write: bool) -> bool:
    """Format a world file; return whether it changes.

    Args:
        path: The file.
        write: Whether it is written; else it stays as it is.

    Raises:
        UsageError: The file does not exist, or it cannot be written.
        WorldError: As `format_text` raises it.
    """
    path = world_path(path)
    text = read_file(path)
    laid = format_text(text, file=str(path))
    if laid == text or not write:
        return laid != text
    try:
        write_whole(path.resolve(), laid.encode("utf-8"))
    except OSError as error:
        raise UsageError(f"cannot write '{path}': {error.strerror}") from None
    return True


def _canonical(value: Any) -> str:
    return json.dumps(value, sort_keys=True)


class _Formatter:
    """Writes the parts of one text."""

    def __init__(self, *, ordered: bool) -> None:
        """Take whether keys may change places: what an alias stands for must come before it."""
        self._ordered = ordered

    def whole(self, root: TreeNode) -> str:
        self._sort(root, ())
        return "\n".join(_without_empty_ends([*self._map(root, 0), *root.tail])) + "\n"

    def _sort(self, part: TreeNode, path: Steps) -> None:
        """Put the keys of all mappings in their order."""
        if part.kind == "map" and self._ordered and path not in _UNORDERED:
            ranks = key_ranks([item.key.value for item in part.items if item.key is not None], path)
            part.items.sort(key=lambda item: ranks[item.key.value] if item.key is not None else 0)
        for number, item in enumerate(part.items):
            self._sort(item.part, (*path, number if item.key is None else item.key.value))

    def _map(self, part: TreeNode, indent: int) -> list[str]:
        lines: list[str] = []
        space = " " * indent
        for item in part.items:
            assert item.key is not None
            key = _key(item.key)
            above, said = _indented(item.before, space), f"{space}{key}:"
            value = self._inline(item.part, len(said) + 1)
            if value is not None:
                more, after = _beside(item)
                first, *rest = value
                lines += [*above, *_indented(more, space)]
                lines += [f"{said} {first}".rstrip(), *rest] if first else [said]
                lines[-1] = _with_comment(lines[-1], after)
                continue
            head = item.head or item.after
            more = [item.after.text] if item.head is not None and item.after is not None else []
            lines += [*above, *_indented(more, space)]
            opening = f"{said} {_opening(item.part)}".rstrip()
            lines += [_with_comment(opening, head), *self._below(item.part, indent + _STEP)]
        return lines

    def _list(self, part: TreeNode, indent: int) -> list[str]:
        lines: list[str] = []
        space = " " * indent
        for item in part.items:
            value = self._inline(item.part, indent + _STEP)
            beside = [comment for comment in (item.head, item.after) if comment is not None]
            after = beside.pop() if value is not None and beside else None
            lines += _indented([*item.before, *(comment.text for comment in beside)], space)
            if value is not None:
                first, *rest = value
                lines += [f"{space}- {first}".rstrip(), *rest]
                lines[-1] = _with_comment(lines[-1], after)
                continue
            below = self._below(item.part, indent + _STEP)
            if item.part.prefix or item.part.kind == "scalar":
                lines += [f"{space}- {_opening(item.part)}".rstrip(), *below]
                continue
            while not below[0] or below[0].lstrip().startswith(
                "#"
            ):  # what is about its first key stands above its dash
                lines += _indented([below.pop(0).lstrip()], space)
            lines += [f"{space}- {below[0].lstrip()}", *below[1:]]
        return lines

    def _below(self, part: TreeNode, indent: int) -> list[str]:
        """Return the lines below a key or a dash."""
        space = " " * indent
        if part.kind == "scalar":
            return [space + line if line else "" for line in part.value.rstrip("\n").split("\n")]
        inside = self._map(part, indent) if part.kind == "map" else self._list(part, indent)
        return _without_empty_ends([*inside, *_indented(part.tail, space)])

    def _inline(self, part: TreeNode, column: int) -> list[str] | None:
        """Return the lines of a value that goes on behind its key; None when it has to stand below.

        Args:
            part: The value.
            column: Where it would begin.
        """
        if part.kind == "scalar":
            return None if part.block and _is_block_text(part.value) else [part.text]
        if _has_comments(part):
            return None
        flat = _is_flat(part)
        if part.block and part.items and not flat:
            return None
        line = _flow(part)
        if column + len(line) <= WIDTH or not part.items:
            return [line]
        lines = _filled(part, column)
        fits = len(lines) <= _MOST_LINES and all(len(line) <= WIDTH for line in [" " * column + lines[0], *lines[1:]])
        return lines if flat or fits else None


def key_ranks(keys: list[str], path: Steps) -> dict[str, int]:
    """Return the place of each key: those that people look for, then as the models have them, then as they stand."""
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


def _key(key: TreeNode) -> str:
    """Return a key, without quotes where it needs none."""
    return key.value if key.value.isidentifier() and plain_value(key.value) == key.value else key.text


def _key_in_brackets(key: TreeNode) -> str:
    text = _key(key)
    return _in_brackets(key) if text == key.text else text


def _flow(part: TreeNode) -> str:
    """Return a value in brackets, on one line."""
    if part.kind == "scalar":
        return _in_brackets(part)
    text = ", ".join(_pieces(part))
    text = f"{{{text}}}" if part.kind == "map" else f"[{text}]"
    return f"{part.prefix} {text}" if part.prefix else text


def _pieces(part: TreeNode) -> list[str]:
    """Return the items of a list or a mapping, each as it stands inside brackets."""
    return [
        _flow(item.part) if item.key is None else f"{_key_in_brackets(item.key)}: {_flow(item.part)}"
        for item in part.items
    ]


def _in_brackets(part: TreeNode) -> str:
    """Return a scalar as it stands inside brackets, where fewer signs go without quotes."""
    if not part.text:
        return "null"
    plain = part.text[0] not in "'\"&!*"
    return one_line(part.value) if plain and any(sign in part.text for sign in ",[]{}") else part.text


def _filled(part: TreeNode, column: int) -> list[str]:
    """Return a value in brackets on lines that are filled with its items one after the other."""
    opening, closing = ("{", "}") if part.kind == "map" else ("[", "]")
    opening = f"{part.prefix} {opening}".lstrip()
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


def _is_flat(part: TreeNode) -> bool:
    """Return whether a part is a list of single values, or of lists of them."""
    return part.kind == "list" and all(
        (item.part.kind == "scalar" and not item.part.block) or _is_flat(item.part) for item in part.items
    )


def _has_comments(part: TreeNode) -> bool:
    return bool(part.tail) or any(
        item.head is not None
        or item.after is not None
        or any(item.before)
        or (item.part.kind == "scalar" and item.part.block)
        or _has_comments(item.part)
        for item in part.items
    )


def _is_block_text(value: str) -> bool:
    """Return whether a text can stand on lines of its own as it is."""
    lines = value.rstrip("\n").split("\n")
    plain = all(line == line.strip() and (line.isprintable() or not line) for line in lines)
    return plain and bool(lines[0]) and bool(lines[-1]) and not value.endswith("\n\n")


def _opening(part: TreeNode) -> str:
    """Return what stands beside a key whose value is below."""
    if part.kind == "scalar":
        return "|" if part.value.endswith("\n") else "|-"
    return part.prefix


def _beside(item: TreeItem) -> tuple[list[str], Comment | None]:
    """Return the comments above and beside an item that stands on one line."""
    found = [comment for comment in (item.head, item.after) if comment is not None]
    after = found.pop() if found else None
    return [comment.text for comment in found], after


def _with_comment(line: str, comment: Comment | None) -> str:
    """Return a line with a comment, in its column if that is free."""
    if comment is None:
        return line
    return f"{line}{' ' * max(comment.column - len(line), _GAP)}{comment.text}"


def _indented(lines: list[str], space: str) -> list[str]:
    return [space + line if line else "" for line in lines]


def _without_empty_ends(lines: list[str]) -> list[str]:
    """Return lines without empty ones first, last, and two in a row."""
    kept: list[str] = []
    for line in lines:
        if line or (kept and kept[-1]):
            kept.append(line)
    while kept and not kept[-1]:
        kept.pop()
    return kept
