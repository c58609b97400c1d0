"""Undeclared XML prefixes: URDF parsers accept them because they ignore namespaces."""

from contextlib import suppress
from xml.etree.ElementTree import ParseError
from xml.parsers import expat
from xml.parsers.expat.errors import XML_ERROR_UNBOUND_PREFIX, codes


class _DeclaredError(Exception):
    """A file declares a document type, which is rejected elsewhere."""


def is_unbound(error: ParseError) -> bool:
    """Return whether an error is about an undeclared prefix."""
    return error.code == codes[XML_ERROR_UNBOUND_PREFIX]


def with_prefixes(data: bytes) -> bytes:
    """Return XML whose root declares all undeclared prefixes that it uses; each maps to its own name."""
    parser = expat.ParserCreate()
    used: set[str] = set()
    places: list[int] = []

    def begin(tag: str, attributes: dict[str, str]) -> None:
        if not places:
            places.append(parser.CurrentByteIndex + 1 + len(tag.encode()))
        used.update(name.partition(":")[0] for name in (tag, *attributes) if ":" in name)
        known.update(name.partition(":")[2] for name in attributes if name.startswith("xmlns:"))

    def refuse(*_: object) -> None:
        raise _DeclaredError

    # The expansion of xacro elements is unknown here: without a declaration they are an error.
    known = {"xml", "xmlns", "xacro"}
    parser.StartElementHandler, parser.StartDoctypeDeclHandler = begin, refuse
    # Other errors are reported by the parser that runs afterwards.
    with suppress(expat.ExpatError, _DeclaredError, ValueError, LookupError):
        parser.Parse(data, True)
    missing = sorted(used - known)
    # In other encodings, positions are not byte offsets.
    if not missing or not data[places[0] - 1 : places[0]].isascii() or b"\x00" in data[:4]:
        return data
    declarations = "".join(f' xmlns:{prefix}="undeclared:{prefix}"' for prefix in missing)
    return data[: places[0]] + declarations.encode() + data[places[0] :]
