"""Reads floor plans from DXF files; external references are never opened."""

import io
import itertools
import logging
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.bounded_file import read_bounded
from mjsim.exchange.drawings.drawing import MAX_BOW, MAX_BYTES, MAX_CORNERS, Drawing, Line, require_near
from mjsim.exchange.drawings.dxf_tags import with_subclasses
from mjsim.exchange.drawings.layer_roles import Role, role_of
from mjsim.exchange.drawings.plan_in import MIN_FILLED_RATIO
from mjsim.exchange.drawings.sorting import length_of_lines
from mjsim.exchange.drawings.tried import tried
from mjsim.geometry import Array
from mjsim.inventory import Fate, FileItem

MAX_ENTITIES = 20_000
"""Maximum number of entities read, including those in blocks."""
LINE_TYPES = ("LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE", "MLINE")
"""Entity types that are lines."""
FILLED_TYPES = ("SOLID", "TRACE", "HATCH", "MPOLYGON")
"""Entity types that are filled shapes."""
BINARY_MAGIC = b"AutoCAD Binary DXF\r\n\x1a\x00"
"""First bytes of a binary DXF file."""
ZERO_RATIO = 1e-9
"""Lengths below this fraction of the drawing's size are zero, as are areas below this fraction of its square."""
BODY_TYPES = ("3DFACE", "MESH")
"""Types of faces of 3-D bodies; many faces make one wall."""


def read_dxf(path: str | Path, *, layers: Sequence[str] = ()) -> Drawing:
    """Return the lines in the model space of a DXF file, including those in blocks.

    Args:
        path: The file, in text or binary form.
        layers: Layers that contain walls; by default those whose names say so, or all that are visible.

    Raises:
        UsageError: The file does not exist, is too large, is not DXF, or lacks such a layer.
    """
    from ezdxf import units
    from ezdxf.enums import InsertUnits

    path = Path(path)
    data = read_bounded(path, limit=MAX_BYTES, kind="a drawing")
    try:
        with _quiet("ezdxf"), np.errstate(all="ignore"):
            document, audit = _document(data, path)
            hidden = _hidden_layers(document, layers, path)
            lines, left = _lines(document, hidden, walls={name.lower() for name in layers}, path=path)
    except RecursionError:
        raise UsageError(f"'{path}' has blocks that contain themselves; explode them") from None
    unit = units.conversion_factor(InsertUnits(document.units), InsertUnits.Meters) if document.units else None
    others = [f"{count} {kind}" for kind, count in sorted(left.items())]
    items = [FileItem(Fate.LEFT_OUT, ", ".join(others))] if others else []
    if audit.has_fixes or audit.has_errors:
        items.append(FileItem(Fate.MENDED, f"{len(audit.fixes) + len(audit.errors)} faults of the file"))
    return Drawing(str(path), lines, unit, bool(layers), items)


def _document(data: bytes, path: Path) -> tuple[Any, Any]:
    """Return the document of a file, and the result of its audit."""
    from ezdxf import recover
    from ezdxf.filemanagement import readfile
    from ezdxf.lldxf.const import DXFStructureError

    if data.startswith(BINARY_MAGIC):
        document = readfile(path)
        return document, document.audit()
    try:
        document, audit = recover.read(io.BytesIO(data))
    except DXFStructureError:
        document, audit = recover.read(io.BytesIO(with_subclasses(data)))
    return document, audit


@contextmanager
def _quiet(name: str) -> Iterator[None]:
    """Suppress the log output of a library."""
    logger = logging.getLogger(name)
    before = logger.disabled
    logger.disabled = True
    try:
        yield
    finally:
        logger.disabled = before


def _hidden_layers(document: Any, names: Sequence[str], path: Path) -> set[str]:
    """Return the names of the layers that are off or frozen, unless the user named them, in lower case.

    Raises:
        UsageError: A layer that the user named does not exist.
    """
    present = {layer.dxf.name.lower(): layer.dxf.name for layer in document.layers}
    # A file may omit layers from its table; the model space is one of the blocks.
    present |= {entity.dxf.layer.lower(): entity.dxf.layer for block in document.blocks for entity in block}
    if missing := [name for name in names if name.lower() not in present]:
        raise UsageError(
            f"'{path}' has no layer '{missing[0]:.60}'; layers are {', '.join(sorted(present.values())[:20])}"
        )
    hidden = {layer.dxf.name.lower() for layer in document.layers if layer.is_off() or layer.is_frozen()}
    return hidden - {name.lower() for name in names}


def _lines(document: Any, hidden: set[str], *, walls: set[str], path: Path) -> tuple[list[Line], Counter[str]]:
    """Return the lines on visible layers, and the number of skipped entities of each type."""
    found: list[Line] = []
    patterns: list[Line] = []
    left: Counter[str] = Counter()
    faces: dict[_Place, list[Array]] = {}
    corners = 0
    for number, placed in enumerate(_entities(document.modelspace(), _Place(), itertools.count(1))):
        if number >= MAX_ENTITIES or corners > 4 * MAX_CORNERS:
            raise UsageError(f"'{path}' has too many lines to be walls; select those of walls with --layer")
        if placed.layer in hidden:
            left[f"on layer {placed.layer:.60}, which is off or frozen"] += placed.entity.dxftype() != "INSERT"
            continue
        require_near([_numbers(placed.entity)], str(path))
        kind, role = _kind(placed.entity), _role(placed, walls)
        if kind in BODY_TYPES:
            outlines = _faces_of(placed.entity)
            require_near(outlines, str(path))
            faces.setdefault(replace(placed, entity=None), []).extend(outlines)
            corners += sum(map(len, outlines))
            continue
        hatch = kind in ("HATCH", "MPOLYGON")
        if (kind not in LINE_TYPES and kind not in FILLED_TYPES) or (hatch and role not in (None, "wall")):
            left[kind] += kind != "INSERT"
            left["external references"] += kind == "INSERT" and _is_external(placed.entity)
            continue
        group = patterns if hatch and not placed.entity.dxf.solid_fill else found
        drawn = tried(list, _filled(placed.entity) if kind in FILLED_TYPES else _of_entity(placed.entity))
        if drawn is None:
            left[f"{kind} that cannot be read"] += 1
            continue
        for line in drawn:
            group.append(replace(line, role=role, block=placed.block, parts=placed.parts, path=number))
            corners += len(line.points)
    for number, (placed, outlines) in enumerate(faces.items(), start=MAX_ENTITIES):
        for line in _from_above(outlines):
            found.append(replace(line, role=_role(placed, walls), block=placed.block, parts=placed.parts, path=number))
    chosen = _walls_of_patterns(patterns, found)
    left["HATCH"] += len({line.path for line in patterns} - {line.path for line in chosen})
    return [*found, *chosen], +left


def _walls_of_patterns(patterns: Sequence[Line], lines: Sequence[Line]) -> list[Line]:
    """Return the outlines of pattern hatches that are walls: those where no other line draws any.

    Args:
        patterns: Outlines of hatches on wall layers, or on layers with unknown names.
        lines: All other lines.
    """
    if any(line.role == "wall" for line in lines):
        return []
    if named := [line for line in patterns if line.role == "wall"]:
        return named
    others = [line for line in lines if line.role is None]
    return list(patterns) if length_of_lines(patterns) > MIN_FILLED_RATIO * length_of_lines(others) else []


def _numbers(entity: Any) -> Array:
    """Return the numbers among the attributes of an entity, shape (n, 2): points, and other numbers paired with 0."""
    values = entity.dxfattribs().values()
    places = [(value.x, value.y) for value in values if hasattr(value, "xyz")]
    return np.array([*places, *((value, 0.0) for value in values if isinstance(value, float))]).reshape(-1, 2)


def _kind(entity: Any) -> str:
    """Return the type of an entity; a polyline that is a mesh has a type of its own."""
    kind = str(entity.dxftype())
    return "MESH" if kind == "POLYLINE" and not (entity.is_2d_polyline or entity.is_3d_polyline) else kind


def _faces_of(entity: Any) -> list[Array]:
    """Return the corners of the faces of a body from above, shape (n, 2) each [units of the drawing]."""
    from ezdxf.render.mesh import MeshBuilder

    if entity.dxftype() == "3DFACE":
        faces = [entity.wcs_vertices()]
    elif entity.dxftype() == "MESH":
        faces = list(MeshBuilder.from_mesh(entity).faces_as_vertices())
    else:
        faces = [face.wcs_vertices() for face in entity.virtual_entities() if face.dxftype() == "3DFACE"]
    return [np.array([tuple(place)[:2] for place in face]) for face in faces if len(face) > 2]


def _is_external(insert: Any) -> bool:
    """Return whether an insert refers to another file or to a missing block."""
    block = insert.block()
    return block is None or bool(block.block.is_xref or block.block.is_xref_overlay)


@dataclass(frozen=True, slots=True)
class _Place:
    """An entity, or the placement of a block."""

    entity: Any = None
    layer: str | None = None
    block: str = ""
    """Names of the enclosing blocks, innermost last, separated by spaces."""
    parts: tuple[int, ...] = ()
    """Numbers of the enclosing block instances, innermost last."""


def _role(placed: _Place, walls: set[str]) -> Role | None:
    """Return the role of an entity from its block and its layer; on a layer named by the user it is a wall."""
    by_block = next((role for name in reversed(placed.block.split()) if (role := role_of(name))), None)
    if walls:
        on_walls = placed.layer in walls and by_block in (None, "wall")
        role = by_block or role_of(placed.layer or "")
        return "wall" if on_walls else None if role == "wall" else role
    return by_block or role_of(placed.layer or "")


def _entities(entities: Any, above: _Place, numbers: Iterator[int]) -> Iterator[_Place]:
    """Yield entities with their layers, block contents in place; layer '0' inside a block is the layer of the block."""
    for entity in entities:
        own = entity.dxf.layer.lower()
        own = above.layer if own == "0" and above.layer is not None else own
        yield replace(above, entity=entity, layer=own)
        if entity.dxftype() == "INSERT":
            block = f"{above.block} {entity.dxf.name.replace(' ', '_')}".strip()
            for one in entity.multi_insert() if entity.mcount > 1 else (entity,):
                inner = _Place(None, own, block, (*above.parts, next(numbers)))
                yield from _entities(one.virtual_entities(), inner, numbers)


def _filled(entity: Any) -> Iterator[Line]:
    """Yield the outlines of a filled shape."""
    if entity.dxftype() in ("HATCH", "MPOLYGON"):
        from ezdxf import path as paths

        for drawn in paths.from_hatch(entity):
            yield from _flattened(drawn, 0.0, dark=1.0)
        return
    places = [(place.x, place.y) for place in entity.wcs_vertices()]
    points = np.array([point for point, before in zip(places, [None, *places], strict=False) if point != before])
    yield Line(points, closed=True, dark=1.0)


def _from_above(faces: Sequence[Array]) -> Iterator[Line]:
    """Yield the view of faces from above: the outlines of their union, or lines if all faces are vertical.

    Args:
        faces: Corners of each face, shape (n, 2) [units of the drawing].
    """
    import shapely

    size = float(np.ptp(np.concatenate(faces), axis=0).max())
    level = [shape for corners in faces if (shape := shapely.Polygon(corners)).area > ZERO_RATIO * size**2]
    if not level:
        edges = [shapely.LineString(corners) for corners in faces]
        yield from (
            Line(shapely.get_coordinates(part)[:, :2], False) for part in shapely.get_parts(shapely.union_all(edges))
        )
        return
    together = shapely.union_all([shapely.make_valid(shape) for shape in level], grid_size=ZERO_RATIO * size)
    for part in shapely.get_parts(together):
        for ring in (part.exterior, *part.interiors) if isinstance(part, shapely.Polygon) else ():
            yield Line(shapely.get_coordinates(ring)[:-1], closed=True, dark=1.0)


def _of_entity(entity: Any) -> Iterator[Line]:
    """Yield the straight lines along one entity."""
    from ezdxf import path as paths

    if entity.dxftype() == "MLINE":
        for part in entity.virtual_entities():
            yield from _of_entity(part)
        return
    yield from _flattened(paths.make_path(entity), _width(entity))


def _width(entity: Any) -> float:
    """Return the line width of a polyline; 0 if it varies."""
    kind = entity.dxftype()
    if kind == "LWPOLYLINE":
        constant = float(entity.dxf.get("const_width", 0.0))
        widths = {float(width) for *_, start, end, _ in entity.get_points() for width in (start, end)}
        single = widths.pop() if len(widths) == 1 else 0.0
        return constant or single
    if kind == "POLYLINE" and entity.is_2d_polyline:
        usual = [float(entity.dxf.get(f"default_{side}_width", 0.0)) for side in ("start", "end")]
        own = [
            float(vertex.dxf.get(f"{side}_width", default))
            for vertex in entity.vertices
            for side, default in zip(("start", "end"), usual, strict=True)
        ]
        return own[0] if own and len(set(own)) == 1 else 0.0
    return 0.0


def _flattened(drawn: Any, width: float, *, dark: float | None = None) -> Iterator[Line]:
    """Yield the straight segments along an ezdxf path."""
    for part in drawn.sub_paths() if drawn.has_sub_paths else (drawn,):
        if not len(part):
            continue
        size = max(np.ptp([tuple(place)[:2] for place in part.control_vertices()], axis=0).tolist())
        places = [
            (place.x, place.y) for place in itertools.islice(part.flattening(max(size * MAX_BOW, 1e-9)), MAX_CORNERS)
        ]
        points = np.array([point for point, before in zip(places, [None, *places], strict=False) if point != before])
        closed = len(points) > 3 and bool(np.allclose(points[0], points[-1], rtol=1e-9, atol=1e-9 * size))
        yield Line(points[:-1] if closed else points, closed, width, dark=dark if closed else None)
