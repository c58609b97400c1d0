"""Adds the subclass markers (group 100) that some programs leave out of DXF files, and that ezdxf requires."""

from collections.abc import Iterator, Mapping, Sequence

SUBCLASSES: Mapping[bytes, bytes] = {
    b"LWPOLYLINE": b"AcDbPolyline",
    b"SPLINE": b"AcDbSpline",
    b"ELLIPSE": b"AcDbEllipse",
    b"HATCH": b"AcDbHatch",
    b"MLINE": b"AcDbMline",
    b"MESH": b"AcDbSubDMesh",
    b"MTEXT": b"AcDbMText",
    b"LEADER": b"AcDbLeader",
    b"MULTILEADER": b"AcDbMLeader",
}
"""Types of entities since R13, and the marker before their own groups."""
MARKER = b"100"
HANDLES = {b"5", b"330"}
COMMON = {b"6", b"8", b"48", b"60", b"62", b"67", b"347", b"370", b"410", b"420", b"430", b"440"}
"""Groups of all entities, which stand before and after their common marker."""

Tag = tuple[bytes, bytes]
"""Group code and value, as written."""
VERSION = b"$ACADVER"
HEADER: Sequence[Tag] = (
    *((b"0", b"SECTION"), (b"2", b"HEADER")),
    *((b"9", VERSION), (b"1", b"AC1015")),
    (b"0", b"ENDSEC"),
)
"""Header for a file without one: it would be read as R12, which lacks these entities."""


def with_subclasses(data: bytes) -> bytes:
    """Return a DXF file in text form, with the markers that its entities lack, and a version that has them."""
    lines = data.splitlines()
    tags = [(lines[k].strip(), lines[k + 1]) for k in range(0, len(lines) - 1, 2)]
    starts = [k for k, (code, _) in enumerate(tags) if code == b"0"]
    marked = tags[: starts[0]] if starts else tags
    if not any(value.strip() == VERSION for _, value in tags):
        marked = [*marked, *HEADER]
    for begin, end in zip(starts, [*starts[1:], len(tags)], strict=True):
        marked += _marked(tags[begin:end])
    return b"\n".join(part for tag in marked for part in tag) + b"\n"


def _marked(entity: Sequence[Tag]) -> Sequence[Tag]:
    """Return the tags of an entity, with the marker of its type."""
    marker = SUBCLASSES.get(entity[0][1].strip())
    if marker is None or any(code == MARKER and value.strip() == marker for code, value in entity):
        return entity
    return [*_sorted_tags(entity, marker)]


def _sorted_tags(entity: Sequence[Tag], marker: bytes) -> Iterator[Tag]:
    rest = [tag for tag in entity[1:] if tag[0] != MARKER]
    yield entity[0]
    yield from (tag for tag in rest if tag[0] in HANDLES)
    yield MARKER, b"AcDbEntity"
    yield from (tag for tag in rest if tag[0] in COMMON)
    yield MARKER, marker
    yield from (tag for tag in rest if tag[0] not in COMMON | HANDLES)
