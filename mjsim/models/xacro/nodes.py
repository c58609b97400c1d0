"""Elements of xacro files with their positions, and their text; names of elements keep their prefixes."""

import re
from dataclasses import dataclass, field
from xml.parsers import expat
from xml.sax.saxutils import escape, quoteattr

from mjsim.models.xacro.budget import XacroBudget, XacroError
from mjsim.sentences import Sentence

NAME = re.compile(r"[^\W\d][\w.-]*(?::[^\W\d][\w.-]*)?")
"""Names of elements and attributes."""
SPACE = "xacro"
"""Part of all namespaces that files give xacro's elements, such as http://ros.org/wiki/xacro."""
STEPS_PER_ELEMENT = 15
"""Steps that an element costs."""


class Verbatim(str):
    """Text of a CDATA section, in which xacro evaluates nothing."""

    __slots__ = ()


@dataclass(slots=True)
class XacroNode:
    """An element, as written or as expanded so far."""

    tag: str
    attributes: dict[str, str]
    file: str = ""
    """The file in which it is written, as messages name it."""
    line: int = 0
    """Line, counted from 1."""
    column: int = 0
    """Column, counted from 1."""
    word: str | None = None
    """Name of the element among those of xacro, such as `if` or that of a macro; None for other elements."""
    children: list["XacroNode | str"] = field(default_factory=list)

    @property
    def elements(self) -> list["XacroNode"]:
        """The children that are elements."""
        return [child for child in self.children if isinstance(child, XacroNode)]

    def required(self, name: str) -> str:
        """Return an attribute.

        Raises:
            XacroError: It is missing.
        """
        if name not in self.attributes:
            raise XacroError(Sentence("<{tag}> has no '{name}'; add it", self.tag, name))
        return self.attributes[name]


class _Reader:
    """Builds the nodes of a text."""

    def __init__(self, file: str, budget: XacroBudget) -> None:
        self._file, self._budget = file, budget
        self._open: list[XacroNode] = []
        self._prefixes = {SPACE}
        self._verbatim = False
        self.root: XacroNode | None = None
        self.parser = expat.ParserCreate("utf-8")
        self.parser.buffer_text = True
        self.parser.StartElementHandler, self.parser.EndElementHandler = self._start, self._end
        self.parser.CharacterDataHandler = self._text
        self.parser.StartCdataSectionHandler, self.parser.EndCdataSectionHandler = self._cdata, self._cdata_end

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self._budget.spend(STEPS_PER_ELEMENT)
        declared = {name: value for name, value in attributes.items() if name.startswith("xmlns:")}
        self._prefixes |= {name[6:] for name, value in declared.items() if SPACE in value.lower()}
        kept = {
            name: value for name, value in attributes.items() if name[6:] not in self._prefixes or name not in declared
        }
        line, column = self.parser.CurrentLineNumber, self.parser.CurrentColumnNumber + 1
        node = XacroNode(tag, kept, self._file, line, column)
        prefix, colon, word = tag.partition(":")
        node.word = word if colon and prefix in self._prefixes else None
        if self._open:
            self._open[-1].children.append(node)
        self.root = self.root or node
        self._open.append(node)

    def _end(self, _: str) -> None:
        self._open.pop()

    def _text(self, text: str) -> None:
        self._open[-1].children.append(Verbatim(text) if self._verbatim else text)

    def _cdata(self) -> None:
        self._verbatim = True

    def _cdata_end(self) -> None:
        self._verbatim = False


def nodes_of(text: str, file: str, budget: XacroBudget) -> XacroNode:
    """Return the root of a checked text.

    Args:
        text: XML that has been checked and parsed before.
        file: Its name in messages.
        budget: Counts elements.
    """
    reader = _Reader(file, budget)
    try:
        reader.parser.Parse(text.encode(), True)
    except expat.ExpatError as error:
        raise XacroError(
            Sentence("{file}:{lineno}:{offset}: this is not XML; correct it", file, error.lineno, error.offset + 1)
        ) from None
    assert reader.root is not None
    return reader.root


def written(node: XacroNode) -> str:
    """Return the text of an expanded element."""
    parts: list[str] = []
    _write(node, parts)
    return "".join(parts)


def _write(node: XacroNode, parts: list[str]) -> None:
    attributes = "".join(
        f" {name}={quoteattr(value, {chr(10): '&#10;', chr(9): '&#9;', chr(13): '&#13;'})}"
        for name, value in node.attributes.items()
    )
    parts.append(f"<{node.tag}{attributes}>")
    for child in node.children:
        if isinstance(child, XacroNode):
            _write(child, parts)
        else:
            parts.append(escape(child))
    parts.append(f"</{node.tag}>")
