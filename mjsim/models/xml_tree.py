"""The tree of an XML file of a model, of bounded size."""

from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from mjsim.models.xml_text import checked_xml
from mjsim.sentences import Sentence

MAX_ELEMENTS, DEEPEST = 20_000, 64
FOREIGN = "foreign."
"""Prefix for the tags of elements for other programs, so that they are ignored."""


class Builder(ElementTree.TreeBuilder):
    """Builds the tree of a file, and stops if it grows beyond the limits."""

    def __init__(self, path: str, count: int) -> None:
        super().__init__()
        self._path, self._depth, self.count = path, 0, count

    def start(self, tag: str, attrs: dict[str, str]) -> Element:
        """Count an element, and start it."""
        self._depth += 1
        self.count += 1
        if self._depth > DEEPEST:
            raise ValueError(
                Sentence("'{path}' is nested more than {deepest} deep; make it flatter", self._path, DEEPEST)
            )
        if self.count > MAX_ELEMENTS:
            raise ValueError(
                Sentence("'{path}' has more than {max_elements} elements; make it simpler", self._path, MAX_ELEMENTS)
            )
        if tag.startswith("{"):
            tag = self._foreign(*tag[1:].rsplit("}", 1))
        return super().start(tag, {name: value for name, value in attrs.items() if not name.startswith("{")})

    def _foreign(self, space: str, word: str) -> str:
        """Return a tag that is ignored; raise ValueError for xacro, which would change the meaning of the file."""
        if space.endswith("xacro"):
            raise ValueError(Sentence("'{path}' holds <{word}> of {space}; expand it", self._path, word, space))
        return f"{FOREIGN}{word}"

    def end(self, tag: str) -> Element:
        """End an element."""
        self._depth -= 1
        return super().end(tag)


def tree_of(path: str, data: bytes, count: int) -> tuple[Element, int]:
    """Return the root of a file, and the number of elements including those counted before."""
    builder = Builder(path, count)
    parser = ElementTree.XMLParser(target=builder)
    parser.feed(checked_xml(data))
    root: Element = parser.close()
    return root, builder.count
