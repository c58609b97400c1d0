"""Walls drawn as lines in an SVG file; nothing that the file names elsewhere is ever opened."""

import io
import math
import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, ParseError
from xml.parsers import expat

import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.drawing import BOW, MOST_BYTES, MOST_CORNERS, Drawing, Line
from mjsim.exchange.grid import read_bounded
from mjsim.exchange.shapes import fitted_rectangle
from mjsim.geometry import Array

CURVE_STEPS = 48
"""Straight lines to a curve, before those that hardly bow are joined."""
DEEPEST = 100
"""Elements within elements."""
LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"
UNIT = "data-metres-per-unit"
"""Attribute of files that mjsim wrote: metres to one user unit."""
SHAPES = ("rect", "circle", "ellipse", "line")
LENGTHS = ("x", "y", "width", "height", "cx", "cy", "r", "rx", "ry", "x1", "y1", "x2", "y2")
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_BROKEN = (ArithmeticError, AssertionError, AttributeError, LookupError, TypeError, ValueError)
"""What svgpathtools raises on paths that are none."""


def read_svg(path: str | Path, *, layers: Sequence[str] = ()) -> Drawing:
    """Return the lines of an SVG file, y up.

    Lines, polylines, polygons, rectangles, circles and paths are taken along their middles; a rectangle that is
    filled and has no stroke is a wall of its length and width. What is hidden, text, pictures and clones are not.

    Args:
        path: The file.
        layers: Ids or Inkscape labels of the groups that hold walls; the group `walls` unless given, or all.

    Raises:
        UsageError: It is not there, too large, no SVG, or has no such layer.
    """
    path = Path(path)
    data = read_bounded(path, most=MOST_BYTES, kind="a drawing")
    document = _document(data, path)
    root: Element = document.root
    if root.tag != "{http://www.w3.org/2000/svg}svg":
        raise UsageError(f"'{path}' is XML but no SVG drawing; its first element is '{root.tag[:60]}'")
    odd = _without_units(root)
    parents = {child: parent for parent in root.iter() for child in parent}
    chosen = _layers(root, layers, path)
    lines: list[Line] = []
    try:
        for drawn in document.paths():
            if not _hidden(drawn.element, parents) and _within(drawn.element, chosen, parents):
                lines += _lines(drawn, parents)
                if sum(len(line.points) for line in lines) > 2 * MOST_CORNERS:
                    raise UsageError(f"'{path}' has too many lines to be walls; name their --layer")
    except _BROKEN as error:
        raise UsageError(f"'{path}' has a shape that cannot be read ({error!s:.80}); mend the drawing") from error
    counts = Counter(element.tag.rpartition("}")[2] for element in root.iter() if isinstance(element.tag, str))
    left = [f"{counts[tag]} <{tag}>" for tag in ("use", "image", "text") if counts[tag]]
    left += [f"{odd} shapes in other units than the drawing's"] if odd else []
    notes = [f"left out: {', '.join(left)}"] if left else []
    return Drawing(str(path), lines, _unit(root), notes)


def _document(data: bytes, path: Path) -> Any:
    """Return the parsed drawing; entities, which can swell or reach outside, are refused."""
    from svgpathtools import Document

    parser = expat.ParserCreate()
    depth = 0

    def entity(name: str, *_: object) -> None:
        raise UsageError(f"'{path}' declares the XML entity '{name:.40}'; save it as plain SVG, without entities")

    def deeper(*_: object) -> None:
        nonlocal depth
        depth += 1
        if depth > DEEPEST:
            raise UsageError(f"'{path}' has elements more than {DEEPEST} deep; save it as plain SVG")

    def higher(*_: object) -> None:
        nonlocal depth
        depth -= 1

    parser.EntityDeclHandler = entity
    parser.StartElementHandler, parser.EndElementHandler = deeper, higher
    try:
        parser.Parse(data, True)
        return Document(io.BytesIO(data))
    except (expat.ExpatError, ParseError, ValueError, LookupError) as error:
        raise UsageError(f"'{path}' is not XML, and so no SVG drawing: {error}") from None


def _without_units(root: Element) -> int:
    """Take away shapes whose places or sizes are in percent or millimetres, and return how many they were."""
    count = 0
    for parent in list(root.iter()):
        for shape in list(parent):
            if any(not _plain(shape, key) for key in LENGTHS):
                parent.remove(shape)
                count += isinstance(shape.tag, str) and shape.tag.rpartition("}")[2] in SHAPES
    return count


def _plain(shape: Element, key: str) -> bool:
    """Say whether a length is a number; one in pixels is made one."""
    value = shape.get(key)
    if value is None or (isinstance(shape.tag, str) and shape.tag.rpartition("}")[2] not in SHAPES):
        return True
    shape.set(key, value.strip().removesuffix("px"))
    return NUMBER.fullmatch(shape.get(key, "")) is not None


def _layers(root: Element, names: Sequence[str], path: Path) -> set[Element] | None:
    """Return the groups that hold walls; None for the whole drawing."""
    named = [(name, group) for group in root.iter() for name in (group.get("id"), group.get(LABEL)) if name]
    wanted = [name.lower() for name in names] or ["walls"]
    found = {group for name, group in named if name.lower() in wanted}
    groups = sorted({name for name, group in named if group.tag.endswith("}g")})
    if missing := [name for name in names if name.lower() not in {other.lower() for other, _ in named}]:
        raise UsageError(
            f"'{path}' has no layer '{missing[0]:.60}'; layers are {', '.join(groups[:20]) or 'not in it'}"
        )
    return found or None


def _within(element: Element, chosen: set[Element] | None, parents: dict[Element, Element]) -> bool:
    return chosen is None or any(above in chosen for above in _upward(element, parents))


def _upward(element: Element, parents: dict[Element, Element]) -> list[Element]:
    found = [element]
    while (above := parents.get(found[-1])) is not None:
        found.append(above)
    return found


def _own(element: Element, key: str) -> str | None:
    """Return a property of an element: from its style, or an attribute."""
    for part in reversed(element.get("style", "").split(";")):
        name, _, value = part.partition(":")
        if name.strip() == key:
            return value.strip()
    return element.get(key)


def _inherited(element: Element, key: str, parents: dict[Element, Element]) -> str | None:
    return next((value for above in _upward(element, parents) if (value := _own(above, key)) is not None), None)


def _hidden(element: Element, parents: dict[Element, Element]) -> bool:
    none = any(_own(above, "display") == "none" for above in _upward(element, parents))
    return none or _inherited(element, "visibility", parents) in ("hidden", "collapse")


def _lines(drawn: Any, parents: dict[Element, Element]) -> list[Line]:
    """Return the lines of one shape."""
    element: Element = drawn.element
    stroke = _inherited(element, "stroke", parents)
    pen = _inherited(element, "stroke-width", parents) or "1"
    number = re.match(r"\s*[0-9.]+(?:e-?[0-9]+)?", pen)
    spread = math.sqrt(abs(float(np.linalg.det(np.asarray(drawn.transform, dtype=float)[:2, :2]))))
    width = float(number[0]) * spread if number and stroke not in (None, "none") else 0.0
    filled = stroke in (None, "none") and _inherited(element, "fill", parents) != "none"
    lines = []
    for part in drawn.continuous_subpaths():
        points, closed = _points(part)
        bar = fitted_rectangle(points) if filled and closed else None
        if bar is not None:
            lines.append(Line(bar.ends, width=bar.width))
        elif len(points) > 1:
            lines.append(Line(points, closed and len(points) > 2, width))
    return lines


def _points(part: Any) -> tuple[Array, bool]:
    """Return the corners of a path without a gap, shape (n, 2), y up, and whether it is closed."""
    from svgpathtools import Line as Straight

    places = [part.start]
    for piece in part:
        places += [piece.end] if isinstance(piece, Straight) else _along(piece)
    kept = [here for index, here in enumerate(places) if index == 0 or here != places[index - 1]]
    closed = len(kept) > 2 and abs(kept[0] - kept[-1]) <= 1e-9 * (1.0 + abs(kept[0]))
    kept = kept[:-1] if closed else kept
    return np.array([(place.real, -place.imag) for place in kept], dtype=float).reshape(-1, 2), closed


def _along(curve: Any) -> list[complex]:
    """Return corners of straight lines along a curve, without its start."""
    import shapely

    places = [curve.point(step / CURVE_STEPS) for step in range(CURVE_STEPS + 1)]
    points = np.array([(place.real, place.imag) for place in places])
    bow = float(np.ptp(points, axis=0).max()) * BOW
    kept = shapely.get_coordinates(shapely.simplify(shapely.linestrings(points), bow))
    return [complex(x, y) for x, y in kept[1:].tolist()]


def _unit(root: Element) -> float | None:
    """Return metres to one user unit, when mjsim wrote the file."""
    try:
        unit = float(root.get(UNIT, "nan"))
    except ValueError:
        return None
    return unit if 0.0 < unit < math.inf else None
