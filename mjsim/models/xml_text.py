"""Text of untrusted XML files: decoded once and checked; readers parse this text.

The declaration of the encoding is blanked, so that no parser decodes the text a second time. What a document type
declares could expand to any amount of text, or name other files. URDF parsers ignore namespaces, so files use prefixes
without declaring them.
"""

import codecs
import re
from contextlib import suppress
from xml.parsers import expat

from mjsim.sentences import Sentence

_MARKS = {
    codecs.BOM_UTF8: "utf-8",
    codecs.BOM_UTF32_LE: "utf-32-le",  # Begins with the byte order mark of UTF-16.
    codecs.BOM_UTF32_BE: "utf-32-be",
    codecs.BOM_UTF16_LE: "utf-16-le",
    codecs.BOM_UTF16_BE: "utf-16-be",
}
_UNMARKED = {b"<\0\0\0": "utf-32-le", b"\0\0\0<": "utf-32-be", b"<\0": "utf-16-le", b"\0<": "utf-16-be"}
"""First bytes of files in these encodings without a byte order mark."""
_DECLARATION = re.compile(r"\A\s*<\?xml\s[^>]*\?>")
"""Blank lines before the declaration are invalid, though many programs accept them."""
_OPENED = re.compile(r"<!--|<!\[CDATA\[")
_ENCODING = re.compile(rb"""\A\s*<\?xml\s[^>]*?\sencoding\s*=\s*["']([A-Za-z0-9._-]+)["']""")
_SUPERSETS = re.compile(r"utf-8|ascii|iso8859-\d+|cp125\d|koi8-[ru]")
"""Encodings that a file without a byte order mark may declare; in all, ASCII characters are single bytes."""


class RefusedXmlError(ValueError):
    """A file cannot be decoded, or holds something that is not allowed; the message lacks the path."""


def xml_text(data: bytes) -> str:
    """Return the text of an XML file, with blanks in place of its declaration.

    Raises:
        RefusedXmlError: It is not in the encoding that it declares, or in a rare one.
    """
    encoding, mark = _encoding(data)
    try:
        text = data[len(mark) :].decode(encoding)
    except UnicodeDecodeError:
        raise RefusedXmlError(
            Sentence("cannot be read as XML: it is not in {encoding}; write it as UTF-8", encoding)
        ) from None
    if "\0" in text:
        raise RefusedXmlError("cannot be read as XML: it has null characters; write it as UTF-8")
    return _plain_comments(_DECLARATION.sub(lambda match: re.sub(r"\S", " ", match[0]), text))


def _plain_comments(text: str) -> str:
    """Return a text of the same length without `--` within comments, invalid but tolerated by Gazebo and ROS."""
    pieces, done = [], 0
    for begin in _OPENED.finditer(text):
        if begin.start() < done:
            continue
        end = text.find("-->" if begin[0] == "<!--" else "]]>", begin.end())
        if end < 0:
            break
        within = text[begin.end() : end]
        if begin[0] == "<!--" and ("--" in within or within.endswith("-")):
            within = within.replace("-", " ")
        pieces += [text[done : begin.end()], within]
        done = end
    return "".join([*pieces, text[done:]])


def _encoding(data: bytes) -> tuple[str, bytes]:
    """Return the encoding of a file, and its byte order mark."""
    for mark, encoding in _MARKS.items():
        if data.startswith(mark):
            return encoding, mark
    for start, encoding in _UNMARKED.items():
        if data.startswith(start):
            return encoding, b""
    declared = _ENCODING.match(data[:1000])
    name = declared[1].decode() if declared else "utf-8"
    try:
        encoding = codecs.lookup(name).name
    except LookupError:
        encoding = ""
    if not _SUPERSETS.fullmatch(encoding):
        raise RefusedXmlError(Sentence("cannot be read as XML: its encoding is {name:.40}; write it as UTF-8", name))
    return encoding, b""


def checked_xml(data: bytes, *, doctype: bool = False, deepest: int | None = None) -> str:
    """Return the text of an untrusted XML file, with declarations added for undeclared prefixes.

    Args:
        data: Contents of the file.
        doctype: Whether it may name a document type; it may not declare anything in it.
        deepest: Maximum nesting of elements.

    Raises:
        RefusedXmlError: It cannot be decoded, names or declares a document type, or is nested too deeply.
    """
    text = xml_text(data)
    begins, missing = _Check(doctype=doctype, deepest=deepest).run(text)
    declarations = "".join(f' xmlns:{prefix}="undeclared:{prefix}"' for prefix in missing)
    return text[:begins] + declarations + text[begins:]


class _Check:
    """Scans a text before it is parsed; errors in its syntax are left to the parser."""

    def __init__(self, *, doctype: bool, deepest: int | None) -> None:
        self._parser = expat.ParserCreate("utf-8")
        self._deepest, self._depth, self._begins = deepest, 0, 0
        self._used: set[str] = set()
        # xacro's elements change the meaning of a file: without a declaration they are an error.
        self._known = {"xml", "xmlns", "xacro"}
        self._parser.StartElementHandler, self._parser.EndElementHandler = self._start, self._end
        self._parser.EntityDeclHandler, self._parser.AttlistDeclHandler = self._entity, self._attributes
        if not doctype:
            self._parser.StartDoctypeDeclHandler = self._doctype

    def run(self, text: str) -> tuple[int, list[str]]:
        """Return the position after the name in the root's tag, and the prefixes that are not declared."""
        data = text.encode()
        with suppress(expat.ExpatError):
            self._parser.Parse(data, True)
        return len(data[: self._begins].decode()), sorted(self._used - self._known)

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        if not self._depth and not self._begins:
            self._begins = self._parser.CurrentByteIndex + 1 + len(tag.encode())
        self._depth += 1
        if self._deepest is not None and self._depth > self._deepest:
            raise RefusedXmlError(Sentence("has elements more than {deepest} deep", self._deepest))
        self._used.update(name.partition(":")[0] for name in (tag, *attributes) if ":" in name)
        self._known.update(name.partition(":")[2] for name in attributes if name.startswith("xmlns:"))

    def _end(self, _: str) -> None:
        self._depth -= 1

    def _doctype(self, *_: object) -> None:
        raise RefusedXmlError("declares a document type; leave <!DOCTYPE ...> out")

    def _entity(self, name: str, *_: object) -> None:
        raise RefusedXmlError(Sentence("declares the XML entity '{name:.40}'", name))

    def _attributes(self, element: str, *_: object) -> None:
        raise RefusedXmlError(Sentence("declares attributes of <{element:.40}>", element))
