"""Positions of XML elements in their file, for MuJoCo errors that refer to lines of another text."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple
from xml.etree import ElementTree
from xml.parsers import expat

from mjsim.models.model_sources import Element
from mjsim.models.xml_text import xml_text

_LINE = re.compile(r"(?:Element '(?P<tag>[\w.:-]+)',? )?line (?P<line>\d+)")
_NAMED = re.compile(r"(?:Element name|name) '(?P<name>[^']+)'")


class ElementStart(NamedTuple):
    """The start of an element."""

    tag: str
    line: int
    """Line, counted from 1."""
    column: int
    """Column, counted from 1."""


@dataclass(frozen=True, slots=True, eq=False)
class ElementOrigin:
    """The origin of an element."""

    path: str
    """Path of the file."""
    number: int
    """Index of the element in its file, in document order."""


class PlacedError(ValueError):
    """An error in a file, with its position."""

    def __init__(self, path: str, start: ElementStart, message: str) -> None:
        """Store a position.

        Args:
            path: Path of the file.
            start: Start of the element.
            message: The message, without the position.
        """
        super().__init__(f"'{path}':{start.line}:{start.column}: {message}")
        self.path, self.start, self.what = path, start, message


def starts(data: bytes) -> list[ElementStart]:
    """Return the starts of the elements of an XML file, in order, as far as the file is valid."""
    found: list[ElementStart] = []
    parser = expat.ParserCreate("utf-8")

    def begin(tag: str, _: dict[str, str]) -> None:
        found.append(ElementStart(tag, parser.CurrentLineNumber, parser.CurrentColumnNumber + 1))

    parser.StartElementHandler = begin
    try:
        parser.Parse(xml_text(data).encode(), True)
    except expat.ExpatError:
        return found
    return found


def element_of(error: str, root: Element) -> Element | None:
    """Return the element of a tree to which a MuJoCo error refers; None if it names none.

    Args:
        error: The message.
        root: The tree whose text MuJoCo was given.
    """
    elements = list(root.iter())
    position = _LINE.search(error)
    if position is not None:
        begun = starts(ElementTree.tostring(root))
        on_line = [number for number, start in enumerate(begun) if start.line == int(position["line"])]
        same = [number for number in on_line if position["tag"] in (None, begun[number].tag)]
        return elements[same[0]] if len(same) == 1 and len(begun) == len(elements) else None
    named = _NAMED.search(error)
    return None if named is None else next((item for item in elements if item.get("name") == named["name"]), None)


def plainly(error: str, element: Element) -> str:
    """Return MuJoCo's message about an element without its own description of the position."""
    text = " ".join(error.split())
    text = re.sub(r"^(?:XML Error|Error):? *", "", text)
    text = re.sub(r",? *Element (?:name )?'[^']*'.*$", "", text).rstrip(" .,")
    name = element.get("name")
    return f"<{element.tag}>{f' {name!r}' if name else ''}: {text}"


def numbered(root: Element, path: str) -> dict[Element, ElementOrigin]:
    """Return the origins of the elements of a newly read file."""
    return {element: ElementOrigin(path, number) for number, element in enumerate(root.iter())}


def line_of(name: str, data: bytes) -> ElementStart | None:
    """Return the start of a named element in a file; None if there is none, or if the name is ambiguous."""
    match = re.search(rb"""<([\w.:-]+)(?=[^<>]*\sname\s*=\s*["']%s["'])""" % re.escape(name.encode()), data)
    if match is None:
        return None
    return ElementStart(match[1].decode(), *line_and_column(match.start(), data))


def line_and_column(offset: int, data: bytes) -> tuple[int, int]:
    """Return line and column, from 1, of a byte in a file."""
    return data.count(b"\n", 0, offset) + 1, offset - data.rfind(b"\n", 0, offset)


def names_in(text: str) -> Sequence[str]:
    """Return the quoted names in a message."""
    return re.findall(r"'([^'\s]{1,200})'", text)
