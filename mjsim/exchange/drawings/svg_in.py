"""Reads floor plans from SVG files; nothing that the file refers to is ever opened."""

import math
import re
import warnings
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, ElementTree, ParseError, fromstring

import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.bounded_file import read_bounded
from mjsim.exchange.drawings.drawing import MAX_BOW, MAX_BYTES, MAX_COORDINATE, MAX_CORNERS, Drawing, Line, require_near
from mjsim.exchange.drawings.layer_roles import Role, role_of
from mjsim.exchange.drawings.paint import darkness_of, opacity_of, share_of
from mjsim.exchange.drawings.svg_tree import METRES_PER_UNIT, SHAPE_TAGS, length_of, made_plain, tag_of
from mjsim.exchange.drawings.tried import tried
from mjsim.geometry import Array
from mjsim.inventory import Fate, FileItem
from mjsim.models import RefusedXmlError, checked_xml
from mjsim.sentences import number_of

CURVE_STEPS = 48
"""Number of straight segments per curve, before nearly straight ones are merged."""
LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"
UNIT = "data-metres-per-unit"
"""Attribute of files written by mjsim: metres per user unit."""
BUILDING_SIZES = (2.0, 500.0)
"""Sizes at which a drawing with a stated paper size is assumed to be at scale 1 : 1 [m]."""
MAX_PAGES = 100.0
"""Distance from the page, in page sizes, beyond which shapes are ignored: drawing programs leave some there."""
MIN_BACKGROUND_SHARE = 0.98
"""A rectangle that covers at least this fraction of the drawing is its background."""
MAX_PALE_DIFFERENCE, MIN_OPACITY = 0.06, 0.9
"""Maximum difference from the background colour, and minimum opacity, of what hides the lines beneath it [0 to 1]."""
MAX_HEAD, MAX_REFERENCES = 20_000, 1_000
"""Length of the start of a file in which entities are declared [bytes], and maximum number of their uses."""
_ADDRESS = re.compile(rb"""<!ENTITY\s+([A-Za-z_]\w{0,63})\s+["'](https?://[\w./:-]{1,200})["']\s*>""")
_REFERENCE = re.compile(rb"&([A-Za-z_]\w{0,63});")
_IMPERIAL = re.compile(
    r"""(?<!\d)(\d{1,4})(?:/(\d{1,4}))?\s*(?:"|\u2033|in\b)\s*=\s*"""
    r"""(\d{1,4})\s*(?:'|\u2032|ft\b)(?:\s*-?\s*(\d{1,4})\s*(?:"|\u2033|in\b))?"""
)
_RATIO = re.compile(r"\b1\s*:\s*(\d{1,4})\b")


@dataclass(frozen=True, slots=True, eq=False)
class _Tree:
    """A parsed SVG file."""

    path: Path
    root: Element
    parents: dict[Element, Element]
    chosen: set[Element] | None
    """The groups that contain walls; None if the user names none."""
    numbers: dict[Element, int]
    """Numbers of the elements, in document order."""
    paper: float
    """Darkness of the background, 0 to 1."""


def read_svg(path: str | Path, *, layers: Sequence[str] = ()) -> Drawing:
    """Return the visible lines of an SVG file, y up, with clones and style sheets applied; without text and images.

    Args:
        path: The file.
        layers: Ids or Inkscape labels of the groups that contain walls; by default those whose names say so, or all.

    Raises:
        UsageError: The file does not exist, is too large, is not SVG, or lacks such a layer.
    """
    path = Path(path)
    root = _root_of(read_bounded(path, limit=MAX_BYTES, kind="a drawing"), path)
    odd = made_plain(root, str(path))
    document = _document(root)
    root = document.root
    parents = {child: parent for parent in root.iter() for child in parent}
    numbers = {element: number for number, element in enumerate(root.iter())}
    tree = _Tree(path, root, parents, _layers(root, layers, path), numbers, _paper(root))
    lines: list[Line] = []
    corners, far, box = 0, 0, _box(root)
    # Values in a transform that are not numbers, or too large, are reported with the corners that they produce.
    with warnings.catch_warnings(action="ignore"), np.errstate(all="ignore"):
        paths, broken = _paths(document)
        for drawn in paths:
            if _hidden(drawn.element, parents):
                continue
            found = tried(_lines, drawn, tree)
            if found is None:
                broken += 1
                continue
            if _is_far(found, box):
                far += 1
                continue
            lines += found
            corners += sum(len(line.points) for line in found)
            if corners > 2 * MAX_CORNERS:
                raise UsageError(f"'{path}' has too many lines to be walls; select those of walls with --layer")
    counts = Counter(tag_of(element) for element in root.iter())
    left = [f"{counts[tag]} <{tag}>" for tag in ("use", "image", "text") if counts[tag]]
    for number, what in ((odd, "in percent"), (broken, "that cannot be read"), (far, "far from the page")):
        left += [number_of(number, f"shape {what}")] if number else []
    items = [FileItem(Fate.LEFT_OUT, ", ".join(left))] if left else []
    return Drawing(str(path), lines, _unit(root), bool(layers), items)


def _paths(document: Any) -> tuple[list[Any], int]:
    """Return the paths of all valid shapes, and the number of invalid ones."""
    from svgpathtools import parse_path
    from svgpathtools.document import CONVERSIONS

    if (paths := tried(document.paths)) is not None:
        return paths, 0
    shapes = [element for element in document.root.iter() if tag_of(element) in CONVERSIONS]
    whole = {
        element for element in shapes if tried(lambda shape: parse_path(CONVERSIONS[tag_of(shape)](shape)), element)
    }
    return document.paths(path_filter=lambda element: element in whole), len(shapes) - len(whole)


def _root_of(data: bytes, path: Path) -> Element:
    """Return the root element of a drawing; entities, which can expand or refer to other files, are rejected."""
    try:
        root = fromstring(checked_xml(_with_addresses(data), doctype=True))
    except RefusedXmlError as error:
        raise UsageError(f"'{path}' {error}; save it as plain SVG") from None
    except ParseError as error:
        raise UsageError(f"'{path}' is not XML, and so not an SVG drawing: {error}") from None
    if root.tag != "{http://www.w3.org/2000/svg}svg":
        raise UsageError(f"'{path}' is XML but not an SVG drawing; its first element is '{root.tag[:60]}'")
    return root


def _with_addresses(data: bytes) -> bytes:
    """Return a file in which the entities that Illustrator declares for addresses of namespaces are written out."""
    known = {match[1]: match[2] for match in _ADDRESS.finditer(data[:MAX_HEAD])}
    if not known:
        return data
    plain = _ADDRESS.sub(b"", data, count=len(known))
    return _REFERENCE.sub(lambda match: known.get(match[1], match[0]), plain, count=MAX_REFERENCES)


def _document(root: Element) -> Any:
    from svgpathtools import Document

    document = Document()
    document.tree, document.root = ElementTree(root), root
    return document


def _layers(root: Element, names: Sequence[str], path: Path) -> set[Element] | None:
    """Return the groups that contain walls according to the user; None if the user names none."""
    named = [(name, group) for group in root.iter() for name in (group.get("id"), group.get(LABEL)) if name]
    found = {group for name, group in named if name.lower() in [requested.lower() for requested in names]}
    groups = sorted({name for name, group in named if tag_of(group) == "g"})
    if missing := [name for name in names if name.lower() not in {other.lower() for other, _ in named}]:
        known = f"layers are {', '.join(groups[:20])}" if groups else "it has no layers"
        raise UsageError(f"'{path}' has no layer '{missing[0]:.60}'; {known}")
    return found if names else None


def _upward(element: Element, parents: dict[Element, Element]) -> list[Element]:
    found = [element]
    while (above := parents.get(found[-1])) is not None:
        found.append(above)
    return found


def _role(element: Element, tree: _Tree) -> tuple[Role | None, str, int]:
    """Return the role of a shape from the names of its groups, and the name and number of its item."""
    above = _upward(element, tree.parents)
    if tree.chosen is not None and any(group in tree.chosen for group in above):
        return "wall", "", 0
    found: Role | None = None
    thing: Element | None = None
    for group in above:
        names = [name for key in (LABEL, "id", "class") if (name := group.get(key))]
        role = next((role for name in names if (role := role_of(name)) is not None), None)
        if found is None and role is not None:
            found = role
        # Each group within a furniture group is one item.
        if role == "furniture" and found == "furniture" and tag_of(group) == "g":
            below = above[max(0, above.index(group) - 1)]
            thing = below if tag_of(below) == "g" and below is not group else None
    if tree.chosen is not None and found == "wall":
        found = None
    if thing is None or found != "furniture":
        return found, "", 0
    label = thing.get(LABEL) or thing.get("id") or ""
    return found, label, tree.numbers[thing]


def _own(element: Element, key: str) -> str | None:
    """Return a property of an element: from its style, or from an attribute."""
    for part in reversed(element.get("style", "").split(";")):
        name, _, value = part.partition(":")
        if name.strip() == key:
            return value.strip()
    return element.get(key)


def _paper(root: Element) -> float:
    """Return the darkness of the background: from its style, or from a first rectangle that fills the drawing."""
    for key in ("background-color", "background"):
        if (color := _own(root, key)) is not None:
            return darkness_of(color) * opacity_of(color)
    first = next((element for element in root.iter() if tag_of(element) in (*SHAPE_TAGS, "path")), None)
    if first is None or tag_of(first) != "rect":
        return 0.0
    box = _box(root)
    size = [length_of(first.get(key)) or 0.0 for key in ("width", "height")]
    whole = len(box) == 4 and all(side >= MIN_BACKGROUND_SHARE * page for side, page in zip(size, box[2:], strict=True))
    fill = _own(first, "fill")
    return darkness_of(fill) * opacity_of(fill) if whole and fill not in ("none", "transparent") else 0.0


def _inherited(element: Element, key: str, parents: dict[Element, Element]) -> str | None:
    return next((value for above in _upward(element, parents) if (value := _own(above, key)) is not None), None)


def _hidden(element: Element, parents: dict[Element, Element]) -> bool:
    none = any(_own(above, "display") == "none" for above in _upward(element, parents))
    return none or _inherited(element, "visibility", parents) in ("hidden", "collapse")


def _is_far(lines: Sequence[Line], box: Sequence[float]) -> bool:
    """Return whether lines lie farther from the page than `MAX_PAGES` times its size, where nobody sees them."""
    if len(box) != 4 or not lines or min(box[2:]) <= 0.0:
        return False
    points = np.concatenate([line.points for line in lines]) * (1.0, -1.0)
    if not np.abs(points).max() <= MAX_COORDINATE:
        return False  # Too large: the drawing is refused later.
    apart = np.abs((points - box[:2]) / box[2:] - 0.5).max(axis=1)
    return bool(apart.min() > MAX_PAGES)


def _lines(drawn: Any, tree: _Tree) -> list[Line]:
    """Return the lines of one shape."""
    element: Element = drawn.element
    ink = _ink(element, tree)
    scale = math.sqrt(abs(float(np.linalg.det(np.asarray(drawn.transform, dtype=float)[:2, :2]))))
    role, block, part = _role(element, tree)
    lines = []
    for outline in drawn.continuous_subpaths():
        points, closed = _points(outline, str(tree.path))
        if len(points) < 2:
            continue
        ring = len(points) > 2 and (closed or (ink.bare and ink.filled))
        shaded = ink.dark if ring and (ink.bare or ink.filled) else None
        blank = ink.blank and (ring or not ink.bare)
        lines.append(Line(points, ring, ink.pen * scale, role, block, part, tree.numbers[element], shaded, blank))
    return lines


@dataclass(frozen=True, slots=True)
class _Ink:
    """How a shape is painted."""

    pen: float
    """Stroke width [user units]; 0 for none."""
    filled: bool
    """Whether a fill is specified."""
    dark: float | None
    """Difference of its fill from the background, 0 to 1; None for no fill."""
    blank: bool
    """Whether it has the background colour, and hides what is beneath."""

    @property
    def bare(self) -> bool:
        """Whether it has no stroke."""
        return self.pen == 0.0


def _ink(element: Element, tree: _Tree) -> _Ink:
    """Return how a shape is painted; lines have no fill."""

    def value_of(key: str) -> str | None:
        return _inherited(element, key, tree.parents)

    stroke, fill = value_of("stroke"), value_of("fill")
    bare = stroke in (None, "none", "transparent")
    pen = 0.0 if bare else length_of(value_of("stroke-width") or "1") or 0.0
    sheer = math.prod(share_of(_own(above, "opacity")) for above in _upward(element, tree.parents))
    solid = sheer * share_of(value_of("fill-opacity")) * opacity_of(fill)
    none = fill in ("none", "transparent") or tag_of(element) == "line"
    dark = None if none else abs(darkness_of(fill) - tree.paper) * solid
    covers = dark is not None and dark <= MAX_PALE_DIFFERENCE and solid >= MIN_OPACITY
    painted = (
        not bare
        and abs(darkness_of(stroke) - tree.paper) <= MAX_PALE_DIFFERENCE
        and sheer * opacity_of(stroke) >= MIN_OPACITY
    )
    return _Ink(pen, not none and fill is not None, dark, covers if bare else painted and (dark is None or covers))


def _points(part: Any, name: str) -> tuple[Array, bool]:
    """Return the corners of a path without gaps, shape (n, 2), y up, and whether it is closed."""
    from svgpathtools import Line as Straight

    places = [part.start]
    for piece in part:
        places += [piece.end] if isinstance(piece, Straight) else _along(piece, name)
    points = [point for index, point in enumerate(places) if index == 0 or point != places[index - 1]]
    closed = len(points) > 2 and abs(points[0] - points[-1]) <= 1e-9 * (1.0 + abs(points[0]))
    points = points[:-1] if closed else points
    return np.array([(place.real, -place.imag) for place in points], dtype=float).reshape(-1, 2), closed


def _along(curve: Any, name: str) -> list[complex]:
    """Return the corners of the straight segments along a curve, without its start."""
    import shapely

    places = [curve.point(step / CURVE_STEPS) for step in range(CURVE_STEPS + 1)]
    points = np.array([(place.real, place.imag) for place in places])
    require_near([points], name)
    bow = float(np.ptp(points, axis=0).max()) * MAX_BOW
    simplified = shapely.get_coordinates(shapely.simplify(shapely.linestrings(points), bow))
    return [complex(x, y) for x, y in simplified[1:].tolist()]


def _unit(root: Element) -> float | None:
    """Return metres per user unit: as mjsim wrote it, or from the paper size and the scale stated in a text."""
    try:
        unit = float(root.get(UNIT, "nan"))
    except ValueError:
        return None
    if 0.0 < unit < math.inf:
        return unit
    box = _box(root)
    wide = root.get("width", "")
    size = length_of(wide)
    if size is None or re.fullmatch(r"[\d.\s]*(px)?", wide) or len(box) != 4 or box[2] <= 0.0:
        return None
    paper = size * METRES_PER_UNIT / box[2]
    texts = " ".join(
        text
        for element in root.iter()
        if tag_of(element) in ("text", "tspan", "title", "desc")
        for text in " ".join(element.itertext()).split()
    )
    unit = paper * _ratio(texts)
    return unit if BUILDING_SIZES[0] <= unit * box[2] <= BUILDING_SIZES[1] else None


def _ratio(texts: str) -> float:
    """Return the scale denominator stated in texts, such as `1 : 50` or `1/4" = 1'-0"`; 1 if there is none."""
    if found := _RATIO.search(texts):
        return float(found[1])
    if found := _IMPERIAL.search(texts):
        inches, parts, feet, more = (float(number or 0.0) for number in found.groups())
        return (12.0 * feet + more) / (inches / (parts or 1.0)) if inches else 1.0
    return 1.0


def _box(root: Element) -> list[float]:
    """Return the view box: left, top, width, height [user units]."""
    return [float(word) for word in re.findall(r"[-+0-9.eE]+", root.get("viewBox", "")) if _is_number(word)]


def _is_number(word: str) -> bool:
    try:
        return math.isfinite(float(word))
    except ValueError:
        return False
