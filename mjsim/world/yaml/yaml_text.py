"""Parses YAML 1.2 text into values that know their positions.

The events of a text are composed here, so that every key and value keeps its line and column, only the core schema of
YAML 1.2 applies (`no` and `12:30` stay text), and hostile texts are cheap to reject.
"""

import itertools
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from mjsim.errors import Problem
from mjsim.sentences import Sentence
from mjsim.world.yaml.scan import ALIAS, DOCUMENT, END, MAP, SCALAR, UnsureError, YamlEvent, exact_events, fast_events

if TYPE_CHECKING:
    from ruamel.yaml.error import MarkedYAMLError

MAX_BYTES = 5_000_000
MAX_NODES = 250_000
"""Maximum number of keys and values of a text, including those that aliases repeat."""
MAX_DEPTH = 50

_WORDS = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL")),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
}
_INT = re.compile(r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_NOT_FINITE = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
_CONTROL = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f\ud800-\udfff\ufffe\uffff]")
_SEPARATORS = re.compile(r"""\"(?:[^\"\\]|\\.)*\"|'(?:[^']|'')*'|#[^\n]*|([,\[{]|- )""", re.DOTALL)
"""Separators of values in brackets, and of list items, one per line; quoted texts and comments are excluded."""
_TAG = "tag:yaml.org,2002:"
_MAX_DIGITS = 30


@dataclass(frozen=True, slots=True)
class Origin:
    """Origin of a value that is not written in the text itself, or is written more than once."""

    file: str | None = None
    """The included file, by its name in messages."""
    how: str = ""
    """How it was reached: 'included by room.yaml:3:5'."""
    repetition: tuple[int, ...] = ()
    """Index of the repetition in each repeat, from 0."""
    copies: int = 1
    """Number of repetitions."""


@dataclass(frozen=True, slots=True, eq=False)
class Node:
    """A value of a text and its start; lines and columns are counted from 1."""

    value: Any
    """None, bool, int, float, str, list or dict."""
    line: int
    column: int
    items: Mapping[str | int, "Node"] = field(default_factory=dict)
    """Children: of a mapping by key, of a list by index."""
    keys: Mapping[str, tuple[int, int]] = field(default_factory=dict)
    """Line and column of each key of a mapping."""
    size: int = 1
    """Number of nodes in it, counting an alias each time it is used."""
    origin: Origin | None = None
    """None if the same as that of the enclosing value."""


class _BrokenTextError(Exception):
    """The rest of the text cannot be read; holds line, column and message."""

    def __init__(self, line: int, column: int, message: str) -> None:
        super().__init__(message)
        self.line, self.column, self.message = line, column, message


class _TooManyError(_BrokenTextError):
    """The text has more values than allowed; it need not be read again by the exact parser."""

    def __init__(self, line: int, column: int) -> None:
        super().__init__(
            line,
            column,
            Sentence(
                "the text holds more than {max_nodes} values, with aliases expanded; use fewer aliases, or split it",
                MAX_NODES,
            ),
        )


def read_text(text: str, *, file: str) -> tuple[Node | None, list[Problem]]:
    """Return the value of a text, None if nothing is usable, and the problems found."""
    control = _CONTROL.search(text)
    if control:
        line, column = line_and_column(text, control.start())
        code = f"U+{ord(control.group()):04X}"
        return None, [
            Problem(file, line, column, Sentence("character {code} is not text; write the file as UTF-8 text", code))
        ]
    if len(text) > MAX_BYTES:
        return None, [Problem(file, 1, 1, too_large(len(text)))]
    try:
        _check_size(text)
        node = _read_fast(text, file=file)
    except _TooManyError as many:
        return None, [Problem(file, many.line, many.column, many.message)]
    return (node, []) if node is not None else _read_exactly(text, file=file)


def read_value(text: str) -> Any:
    """Return the value of a text such as `[1, 2]`; None if it is empty.

    Raises:
        ValueError: It is not YAML.
    """
    if not text.strip():
        return None
    node, problems = read_text(text, file="")
    if node is None or problems:
        raise ValueError(problems[0].message)
    return node.value


def _check_size(text: str) -> None:
    """Raise at once for a text whose brackets, commas and dashes show that it has too many values."""
    if sum(map(text.count, (",", "[", "{", "- "))) > MAX_NODES:
        opened = (match for match in _SEPARATORS.finditer(text) if match.group(1))
        if (last := next(itertools.islice(opened, MAX_NODES, None), None)) is not None:
            raise _TooManyError(*line_and_column(text, last.start()))


def _read_fast(text: str, *, file: str) -> Node | None:
    """Return the value of a valid text; None if it has an error, or if only the exact parser can decide."""
    composer = _Composer(file, fast_events(text))
    try:
        node = composer.document()
    except _TooManyError:
        raise
    except (UnsureError, _BrokenTextError):
        return None
    return None if composer.problems else node


def _read_exactly(text: str, *, file: str) -> tuple[Node | None, list[Problem]]:
    from ruamel.yaml.error import MarkedYAMLError, YAMLError

    composer = _Composer(file, exact_events(text))
    try:
        node = composer.document()
    except _BrokenTextError as broken:
        return None, [*composer.problems, Problem(file, broken.line, broken.column, broken.message)]
    except MarkedYAMLError as error:
        return None, [*composer.problems, _syntax(error, file, composer.brackets, text)]
    except YAMLError as error:
        reason = str(error).partition("\n")[0]
        return None, [
            *composer.problems,
            Problem(file, *composer.place, Sentence("this is not YAML: {reason}", reason)),
        ]
    # The arithmetic of ruamel.yaml fails at an escape beyond Unicode such as "\UFFFFFFFF".
    except (ValueError, OverflowError):
        message = "this is not YAML: the value that follows has an escape that stands for no character"
        return None, [*composer.problems, Problem(file, *composer.place, message)]
    return node, composer.problems


def too_large(size: int) -> str:
    """Return the message for a file with too many bytes."""
    return Sentence(
        "the file has {size:.0f} MB; a world file has at most {max_bytes:.0f} MB", size / 1e6, MAX_BYTES / 1e6
    )


def line_and_column(text: str, offset: int) -> tuple[int, int]:
    """Return the position of a character of a text, line and column counted from 1."""
    return text.count("\n", 0, offset) + 1, offset - text.rfind("\n", 0, offset)


def plain_value(text: str) -> Any:
    """Return the value of an unquoted scalar, by the core schema of YAML 1.2 (chapter 10.3).

    Raises:
        ValueError: It is an integer with too many digits.
    """
    if text in _WORDS:
        return _WORDS[text]
    if text[0] not in "+-.0123456789":
        return text
    if _INT.fullmatch(text):
        if len(text) > _MAX_DIGITS:
            raise ValueError(Sentence("a number of {count} digits; write at most {max_digits}", len(text), _MAX_DIGITS))
        base = {"0o": 8, "0x": 16}.get(text[:2], 10)
        return int(text, base)
    if _FLOAT.fullmatch(text):
        return float(text)
    return float(text.replace(".", "")) if _NOT_FINITE.fullmatch(text) else text


class _Composer:
    """Composes the events of one text into nodes."""

    def __init__(self, file: str, events: Iterator[YamlEvent]) -> None:
        self.problems: list[Problem] = []
        self.place = (1, 1)
        self.brackets: list[tuple[int, int]] = []
        """Positions of brackets that are not closed yet."""
        self._file = file
        self._events = events
        self._anchors: dict[str, Node] = {}
        self._open: list[str | None] = []
        self._count = 0
        self._depth = 0

    def document(self) -> Node:
        """Return the only document of the text."""
        self._next()
        event = self._next()
        if event.kind != DOCUMENT:
            raise _BrokenTextError(1, 1, "the file is empty; a world begins with 'mjsim: 1'")
        node = self._node(self._next())
        self._next()
        if self._next().kind == DOCUMENT:
            raise _BrokenTextError(*self.place, "a second document begins here; a world file holds one")
        return node

    def _next(self) -> YamlEvent:
        event = next(self._events)
        self.place = (event.line, event.column)
        return event

    def _node(self, event: YamlEvent) -> Node:
        place = self.place
        if event.kind == ALIAS:
            if event.anchor is None or event.anchor not in self._anchors:
                raise _BrokenTextError(*place, self._unresolved(event.anchor))
            node = self._anchors[event.anchor]
            self._grow(node.size)
            return node
        self._grow(1)
        if event.kind == SCALAR:
            node = Node(self._scalar(event), *place)
        else:
            self._depth += 1
            if self._depth > MAX_DEPTH:
                raise _BrokenTextError(
                    *place, Sentence("values are nested more than {max_depth} deep; write them flatter", MAX_DEPTH)
                )
            if event.flow:
                self.brackets.append(place)
            self._open.append(event.anchor)
            node = self._mapping(event) if event.kind == MAP else self._list(event)
            if event.flow:
                self.brackets.pop()
            self._open.pop()
            self._depth -= 1
        if event.anchor is not None:
            self._anchors[event.anchor] = node
        return node

    def _unresolved(self, anchor: str | None) -> str:
        """Return why an alias refers to no value."""
        if anchor in self._open:
            return Sentence("alias '*{anchor}' is inside its own anchor '&{anchor}'; write the value out", anchor)
        return Sentence("alias '*{anchor}' has no anchor '&{anchor}' before it", anchor)

    def _grow(self, size: int) -> None:
        self._count += size
        if self._count > MAX_NODES:
            raise _TooManyError(*self.place)

    def _list(self, start: YamlEvent) -> Node:
        self._check_tag(start, "seq")
        place, items = self.place, []
        while (event := self._next()).kind != END:
            items.append(self._node(event))
        size = 1 + sum(item.size for item in items)
        return Node([item.value for item in items], *place, dict(enumerate(items)), size=size)

    def _mapping(self, start: YamlEvent) -> Node:
        self._check_tag(start, "map")
        place = self.place
        items: dict[str | int, Node] = {}
        keys: dict[str, tuple[int, int]] = {}
        while (event := self._next()).kind != END:
            key_place = self.place
            key = self._node(event).value
            value_event = self._next()
            value = self._node(value_event)
            if value_event.kind == SCALAR and not value_event.value and value_event.plain:
                value = Node(None, *key_place)  # nothing is written; its mark is where the next token starts
            if not isinstance(key, str):
                self._report(key_place, Sentence("key {key!r:.40} is not text; put it in quotes or write a name", key))
            elif key in keys:
                self._report(
                    key_place,
                    Sentence("key '{key}' is written twice, first in line {line}; keep one", key, keys[key][0]),
                )
            else:
                keys[key], items[key] = key_place, value
        size = 1 + len(keys) + sum(item.size for item in items.values())
        return Node({key: item.value for key, item in items.items()}, *place, items, keys, size)

    def _scalar(self, event: YamlEvent) -> Any:
        text = event.value
        if _CONTROL.search(text):
            self._report(self.place, Sentence("{text!r:.40} holds a character that is not text; leave it out", text))
            return ""
        if event.tag not in ("", "!"):
            self._check_tag(event, "str", "int", "float", "bool", "null")
            return text if event.tag == f"{_TAG}str" else plain_value(text)
        if not event.plain:
            return text
        try:
            return plain_value(text)
        except ValueError as error:
            self._report(self.place, str(error))
            return 0

    def _check_tag(self, event: YamlEvent, *known: str) -> None:
        if event.tag not in ("", "!", *(_TAG + name for name in known)):
            self._report(
                self.place,
                Sentence("tag '{tag:.60}' is not allowed; write a plain value", event.tag.replace(_TAG, "!!")),
            )

    def _report(self, place: tuple[int, int], message: str) -> None:
        self.problems.append(Problem(self._file, *place, message))


def _syntax(error: "MarkedYAMLError", file: str, brackets: list[tuple[int, int]], text: str) -> Problem:
    mark = error.problem_mark or error.context_mark
    reason = str(error.problem or error.context)
    if "'\\t'" in reason:
        reason = "a tab is where YAML needs spaces; indent with spaces"
    elif brackets and text[mark.index - 1 : mark.index + 1] == "${":
        reason = 'an expression inside brackets has no quotes; write "${...}"'
    elif brackets:
        reason = Sentence(
            "{reason}; is the bracket opened at {line}:{column} closed?",
            *(reason, brackets[-1][0], brackets[-1][1]),
        )
    return Problem(file, mark.line + 1, mark.column + 1, Sentence("this is not YAML: {reason}", reason))
