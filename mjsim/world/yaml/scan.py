"""The events of YAML 1.2 text, each with its place: a C parser where it sees what the exact one would, else that.

libyaml (through PyYAML) is twenty times as fast as the parser of ruamel.yaml, but knows YAML 1.1: what the two may
see differently is left to the latter, and so is every text with a fault, that there be one set of messages.
"""

import re
from collections.abc import Iterator
from typing import Any, NamedTuple

from yaml import YAMLError

try:
    from yaml.cyaml import CParser
except ImportError:  # PyYAML was built without libyaml.
    CParser = None

LIST, MAP, SCALAR, ALIAS, END, DOCUMENT, OTHER = "list", "map", "scalar", "alias", "end", "document", "other"
_KINDS = {
    "SequenceStartEvent": LIST,
    "MappingStartEvent": MAP,
    "ScalarEvent": SCALAR,
    "AliasEvent": ALIAS,
    "SequenceEndEvent": END,
    "MappingEndEvent": END,
    "DocumentStartEvent": DOCUMENT,
}
"""By the names of classes, which both libraries have in common."""


class YamlEvent(NamedTuple):
    """A step through a text."""

    kind: str
    line: int
    """Of its first character, counted from 1."""
    column: int
    """In characters, counted from 1."""
    value: str = ""
    """Of a scalar."""
    plain: bool = True
    """Whether a scalar is written without quotes or tag."""
    anchor: str | None = None
    """Of an alias the name that it stands for."""
    tag: str = ""
    flow: bool = False
    """Whether a list or a mapping is written in brackets."""


class UnsureError(Exception):
    """The fast parser may see something else than YAML 1.2 means."""


def exact_events(text: str) -> Iterator[YamlEvent]:
    """Return the events of a text, one after the other; raises what ruamel.yaml does where it is not YAML."""
    from ruamel.yaml import YAML  # Slow to load, and few texts need it.

    return map(_event, YAML(typ="safe", pure=True).parse(text))


def fast_events(text: str) -> Iterator[YamlEvent]:
    """Return the same events of a text, many times as fast; only where lists and mappings end is not the same place.

    Raises:
        UnsureError: The text is not YAML, or holds what libyaml sees differently; ask `exact_events`.
    """
    return map(_event, sure_events(text))


def sure_events(text: str) -> Iterator[Any]:
    """Yield the events of libyaml itself.

    Raises:
        UnsureError: As `fast_events` does.
    """
    if CParser is None or _DIFFERENT.search(text):
        raise UnsureError
    try:
        parser = CParser(text)
        while (event := parser.get_event()) is not None:
            kind = _KINDS.get(type(event).__name__, OTHER)
            # An empty value is there for both parsers, for each in a place of its own.
            if kind == SCALAR and (event.style in _LONG or (event.implicit[0] and not event.value)):
                raise UnsureError
            if kind == ALIAS or (kind in _VALUES and (event.anchor or event.tag)):
                raise UnsureError
            yield event
    except (YAMLError, ValueError, OverflowError) as error:
        raise UnsureError from error


def _event(event: Any) -> YamlEvent:
    kind, mark = _KINDS.get(type(event).__name__, OTHER), event.start_mark
    line, column = mark.line + 1, mark.column + 1
    if kind == SCALAR:
        return YamlEvent(SCALAR, line, column, event.value, event.implicit[0], event.anchor, _tag(event))
    if kind in (LIST, MAP):
        return YamlEvent(kind, line, column, anchor=event.anchor, tag=_tag(event), flow=bool(event.flow_style))
    return YamlEvent(kind, line, column, anchor=event.anchor if kind == ALIAS else None)


def _tag(event: Any) -> str:
    return "" if event.tag is None else str(event.tag)


_LONG = ("|", ">")
_VALUES = (LIST, MAP, SCALAR)
_DIFFERENT = re.compile(r"[\t\x85\u2028\u2029\ufeff]|^%|^---|^\.\.\.|(?:^|[\s\[\]{},:])\?(?:\s|$)", re.MULTILINE)
"""Tabs, ends of lines of YAML 1.1, byte order marks, directives, more documents, and long keys."""
