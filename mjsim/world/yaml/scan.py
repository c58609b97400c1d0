"""Events of YAML 1.2 text with positions: from a C parser where it agrees with the exact one, otherwise from that.

libyaml (through PyYAML) is twenty times as fast as the parser of ruamel.yaml, but implements YAML 1.1: texts that the
two may interpret differently go to the latter, and so does every invalid text, so that there is one set of messages.
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
"""By the class names common to both libraries."""


class YamlEvent(NamedTuple):
    """A parsing event."""

    kind: str
    line: int
    """Line of its first character, counted from 1."""
    column: int
    """Column in characters, counted from 1."""
    value: str = ""
    """Value of a scalar."""
    plain: bool = True
    """Whether a scalar has neither quotes nor tag."""
    anchor: str | None = None
    """For an alias, the name to which it refers."""
    tag: str = ""
    flow: bool = False
    """Whether a list or a mapping is in brackets."""


class UnsureError(Exception):
    """The fast parser may not interpret the text as YAML 1.2 does."""


def exact_events(text: str) -> Iterator[YamlEvent]:
    """Return the events of a text in order; raises the errors of ruamel.yaml if it is not YAML."""
    return map(_event, ruamel_events(text))


def ruamel_events(text: str) -> Iterator[Any]:
    """Return the events of ruamel.yaml itself."""
    from ruamel.yaml import YAML  # Slow to load, and few texts need it.

    found: Iterator[Any] = YAML(typ="safe", pure=True).parse(text)
    return found


def fast_events(text: str) -> Iterator[YamlEvent]:
    """Return the same events of a text much faster; only the end positions of lists and mappings differ.

    Raises:
        UnsureError: The text is not YAML, or libyaml may interpret it differently; use `exact_events`.
    """
    return map(_event, sure_events(text))


def sure_events(text: str) -> Iterator[Any]:
    """Yield the events of libyaml itself.

    Raises:
        UnsureError: See `fast_events`.
    """
    if CParser is None or _DIFFERENT.search(text):
        raise UnsureError
    try:
        parser = CParser(text)
        while (event := parser.get_event()) is not None:
            kind = _KINDS.get(type(event).__name__, OTHER)
            # The two parsers place an empty value at different positions.
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
"""Tabs, line breaks of YAML 1.1, byte order marks, directives, several documents, and long keys."""
