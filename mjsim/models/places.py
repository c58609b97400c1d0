"""Where an element of XML begins in its file, for errors that MuJoCo gives by a line of the text that it was handed."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple
from xml.etree import ElementTree
from xml.parsers import expat

from mjsim.models.files import Element

_LINE = re.compile(r"(?:Element '(?P<tag>[\w.:-]+)',? )?line (?P<line>\d+)")
_NAMED = re.compile(r"(?:Element name|name) '(?P<name>[^']+)'")


class ElementStart(NamedTuple):
    """Where an element begins."""

    tag: str
    line: int
    """From 1."""
    column: int
    """From 1."""


@dataclass(frozen=True, slots=True, eq=False)
class ElementOrigin:
    """Where an element comes from."""

    path: str
    """Of the file."""
    number: int
    """In the order in which the elements of the file begin."""


class PlacedError(ValueError):
    """What is wrong in a file, with its place."""

    def __init__(self, path: str, start: ElementStart, what: str) -> None:
        """Note a place.

        Args:
            path: Of the file.
            start: Of the element.
            what: Is wrong, in a sentence without the place.
        """
        super().__init__(f"'{path}':{start.line}:{start.column}: {what}")
        self.path, self.start, self.what = path, start, what


def starts(data: bytes) -> list[ElementStart]:
    """Return where the elements of an XML file begin, in their order; as many as can be read."""
    found: list[ElementStart] = []
    parser = expat.ParserCreate()

    def begin(tag: str, _: dict[str, str]) -> None:
        found.append(ElementStart(tag, parser.CurrentLineNumber, parser.CurrentColumnNumber + 1))

    parser.StartElementHandler = begin
    try:
        parser.Parse(data, True)
    except expat.ExpatError:
        return found
    return found


def element_of(error: str, root: Element) -> Element | None:
    """Return the element of a tree of which MuJoCo complains; None where it does not say.

    Args:
        error: Its sentence.
        root: The tree, whose text it was handed.
    """
    elements = list(root.iter())
    said = _LINE.search(error)
    if said is not None:
        begun = starts(ElementTree.tostring(root))
        on_line = [number for number, start in enumerate(begun) if start.line == int(said["line"])]
        same = [number for number in on_line if said["tag"] in (None, begun[number].tag)]
        return elements[same[0]] if len(same) == 1 and len(begun) == len(elements) else None
    named = _NAMED.search(error)
    return None if named is None else next((item for item in elements if item.get("name") == named["name"]), None)


def plainly(error: str, element: Element) -> str:
    """Return what MuJoCo says of an element without its own words about the place."""
    what = " ".join(error.split())
    what = re.sub(r"^(?:XML Error|Error):? *", "", what)
    what = re.sub(r",? *Element (?:name )?'[^']*'.*$", "", what).rstrip(" .,")
    name = element.get("name")
    return f"<{element.tag}>{f' {name!r}' if name else ''}: {what}"


def numbered(root: Element, path: str) -> dict[Element, ElementOrigin]:
    """Return where the elements of a file that was just read come from."""
    return {element: ElementOrigin(path, number) for number, element in enumerate(root.iter())}


def line_of(name: str, data: bytes) -> ElementStart | None:
    """Return where an element of a name begins in a file; None where there is none, or more than one kind of thing."""
    match = re.search(rb"""<([\w.:-]+)(?=[^<>]*\sname\s*=\s*["']%s["'])""" % re.escape(name.encode()), data)
    if match is None:
        return None
    return ElementStart(match[1].decode(), *line_and_column(match.start(), data))


def line_and_column(offset: int, data: bytes) -> tuple[int, int]:
    """Return where a byte of a file stands, both from 1."""
    return data.count(b"\n", 0, offset) + 1, offset - data.rfind(b"\n", 0, offset)


def names_in(text: str) -> Sequence[str]:
    """Return what stands in quotes in a sentence."""
    return re.findall(r"'([^'\s]{1,200})'", text)
