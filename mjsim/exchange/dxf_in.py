"""Walls drawn as lines in a DXF file; external references are never opened."""

import itertools
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.drawing import BOW, MOST_BYTES, MOST_CORNERS, Drawing, Line
from mjsim.exchange.grid import read_bounded

MOST_ENTITIES = 20_000
"""Looked at, those within blocks too."""
WALL_LAYERS = ("walls", "wall", "a-wall")
"""Taken alone when the drawing has one and none is named."""
LINES = ("LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE")
"""Kinds of entities that can be walls."""


def read_dxf(path: str | Path, *, layers: Sequence[str] = ()) -> Drawing:
    """Return the lines of a DXF file's model space, those in blocks too.

    Args:
        path: The file, as text or binary.
        layers: That hold walls; a layer called walls or a-wall unless given, or all that are switched on.

    Raises:
        UsageError: It is not there, too large, no DXF, or has no such layer.
    """
    from ezdxf import recover, units
    from ezdxf.enums import InsertUnits
    from ezdxf.lldxf.const import DXFError

    path = Path(path)
    read_bounded(path, most=MOST_BYTES, kind="a drawing")
    try:
        document, _ = recover.readfile(str(path))
        chosen = _layers(document, layers, path)
        lines, left = _lines(document, chosen, path)
    except (DXFError, ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        raise UsageError(f"'{path}' cannot be read as DXF ({error!s:.80}); save it as DXF R2000 or later") from error
    except RecursionError:
        raise UsageError(f"'{path}' has blocks that contain themselves; explode them") from None
    unit = units.conversion_factor(InsertUnits(document.units), InsertUnits.Meters) if document.units else None
    others = [f"{count} {kind}" for kind, count in sorted(left.items())]
    return Drawing(str(path), lines, unit, [f"left out: {', '.join(others)}"] if others else [])


def _layers(document: Any, names: Sequence[str], path: Path) -> set[str]:
    """Return the names of the layers that hold walls, in lower case."""
    there = {layer.dxf.name.lower(): layer.dxf.name for layer in document.layers}
    there |= {entity.dxf.layer.lower(): entity.dxf.layer for entity in document.modelspace()}
    if missing := [name for name in names if name.lower() not in there]:
        raise UsageError(
            f"'{path}' has no layer '{missing[0]:.60}'; layers are {', '.join(sorted(there.values())[:20])}"
        )
    if names:
        return {name.lower() for name in names}
    off = {layer.dxf.name.lower() for layer in document.layers if layer.is_off() or layer.is_frozen()}
    shown = set(there) - off
    return {name for name in WALL_LAYERS if name in shown} or shown


def _lines(document: Any, layers: set[str], path: Path) -> tuple[list[Line], Counter[str]]:
    """Return the lines on layers, and how many entities of which other kinds are there."""
    found: list[Line] = []
    left: Counter[str] = Counter()
    corners = 0
    for number, (entity, layer) in enumerate(_entities(document.modelspace(), None)):
        if number >= MOST_ENTITIES or corners > 4 * MOST_CORNERS:
            raise UsageError(f"'{path}' has too many lines to be walls; name their --layer")
        if layer not in layers:
            continue
        if entity.dxftype() not in LINES:
            left[entity.dxftype()] += 1
            continue
        for line in _of_entity(entity):
            found.append(line)
            corners += len(line.points)
    return found, left


def _entities(entities: Any, layer: str | None) -> Iterator[tuple[Any, str]]:
    """Yield entities, those of blocks in place, each with its layer: '0' in a block is that of the block."""
    for entity in entities:
        own = entity.dxf.layer.lower()
        own = layer if own == "0" and layer is not None else own
        if entity.dxftype() == "INSERT":
            yield entity, own
            many = entity.multi_insert() if entity.mcount > 1 else (entity,)
            for one in many:
                yield from _entities(one.virtual_entities(), own)
        else:
            yield entity, own


def _of_entity(entity: Any) -> Iterator[Line]:
    """Yield the straight lines along one entity."""
    from ezdxf import path as paths

    drawn = paths.make_path(entity)
    width = float(entity.dxf.get("const_width", 0.0)) if entity.dxftype() == "LWPOLYLINE" else 0.0
    for part in drawn.sub_paths() if drawn.has_sub_paths else (drawn,):
        if not len(part):
            continue
        size = max(np.ptp([tuple(place)[:2] for place in part.control_vertices()], axis=0).tolist())
        places = [
            (place.x, place.y) for place in itertools.islice(part.flattening(max(size * BOW, 1e-9)), MOST_CORNERS)
        ]
        points = np.array([here for here, before in zip(places, [None, *places], strict=False) if here != before])
        closed = len(points) > 3 and bool(np.allclose(points[0], points[-1], rtol=1e-9, atol=1e-9 * size))
        yield Line(points[:-1] if closed else points, closed, width)
