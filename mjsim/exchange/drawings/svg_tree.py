"""Simplifies SVG files: clones expanded, style sheets applied, all lengths in user units."""

import copy
import re
from xml.etree.ElementTree import Element

from mjsim.errors import UsageError

SVG = "{http://www.w3.org/2000/svg}"
HREFS = ("href", "{http://www.w3.org/1999/xlink}href")
UNITS = {"": 1.0, "px": 1.0, "pt": 96 / 72, "pc": 16.0, "mm": 96 / 25.4, "cm": 96 / 2.54, "in": 96.0, "m": 96 / 0.0254}
"""User units per unit (CSS Values and Units 3, section 6.2)."""
METRES_PER_UNIT = 0.0254 / 96
"""Metres per user unit of a file that states its paper size."""
SHAPE_TAGS = ("rect", "circle", "ellipse", "line")
LENGTH_ATTRIBUTES = ("x", "y", "width", "height", "cx", "cy", "r", "rx", "ry", "x1", "y1", "x2", "y2")
GROUP_TAGS = ("a", "switch", "svg", "symbol")
"""Container elements that are drawn like groups."""
MAX_ELEMENTS = 50_000
"""Maximum number of elements in a drawing, including clones."""
_LENGTH = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(px|pt|pc|mm|cm|in|m|)\s*")


def tag_of(element: Element) -> str:
    """Return the name of an element without its namespace; '' for comments."""
    return element.tag.rpartition("}")[2] if isinstance(element.tag, str) else ""


def length_of(text: str | None) -> float | None:
    """Return a length in user units; None for a percentage or an invalid length."""
    found = _LENGTH.fullmatch(text or "")
    return float(found[1]) * UNITS[found[2]] if found else None


def made_plain(root: Element, name: str) -> int:
    """Expand clones, apply style sheets, convert lengths to numbers; return the number of shapes that have percentages.

    Raises:
        UsageError: There are too many elements, including clones.
    """
    _expand(root, name)
    _apply_styles(root)
    for element in root.iter():
        if element is not root and tag_of(element) in GROUP_TAGS:
            element.tag = f"{SVG}g"
    return _without_percent(root)


def _expand(root: Element, name: str) -> None:
    """Replace each `use` element by a group with a copy of its target."""
    named = {key: element for element in root.iter() if (key := element.get("id"))}
    waiting = [(root, frozenset[str]())]
    count = 0
    while waiting:
        parent, above = waiting.pop()
        for index, child in enumerate(list(parent)):
            count += 1
            if count > MAX_ELEMENTS:
                raise UsageError(f"'{name}' has more than {MAX_ELEMENTS} elements with its clones; name their --layer")
            inner = above
            if tag_of(child) == "use":
                href = next((value for key in HREFS if (value := child.get(key))), "")
                target = named.get(href[1:]) if href.startswith("#") else None
                if target is None or href in above or len(above) > 20:
                    continue
                parent[index] = child = _cloned(child, target)
                inner = above | {href}
            if tag_of(child) not in ("defs", "clipPath", "mask", "pattern", "marker"):
                waiting.append((child, inner))


def _cloned(use: Element, target: Element) -> Element:
    """Return a group with a copy of a `use` element's target, translated as the element states."""
    group = Element(f"{SVG}g", {key: value for key, value in use.attrib.items() if key not in (*HREFS, "x", "y")})
    x, y = (length_of(use.get(key, "0")) or 0.0 for key in ("x", "y"))
    group.set("transform", f"{use.get('transform', '')} translate({x} {y})".strip())
    inner = copy.deepcopy(target)
    if tag_of(inner) in ("symbol", "svg"):
        inner.tag = f"{SVG}g"
    group.append(inner)
    return group


def _apply_styles(root: Element) -> None:
    """Add the declarations of style sheets to the `style` of elements, before the existing ones."""
    sheet = "".join(element.text or "" for element in root.iter() if tag_of(element) == "style")
    rules = _rules(re.sub(r"/\*.*?(?:\*/|\Z)|<!--|-->", "", sheet, flags=re.DOTALL))
    if not rules:
        return
    for element in root.iter():
        keys = {tag_of(element), f"#{element.get('id')}", *(f".{word}" for word in element.get("class", "").split())}
        keys |= {f"{tag_of(element)}{key}" for key in list(keys) if key[:1] in ".#"}
        styles = [text for _, text in sorted(rule for key in keys for rule in rules.get(key, ()))]
        if styles:
            element.set("style", ";".join([*styles, element.get("style", "")]))


def _rules(sheet: str) -> dict[str, list[tuple[int, str]]]:
    """Return the declarations for each simple selector of a style sheet, with their rank; tags first, ids last."""
    found: list[tuple[str, str]] = []
    for rule in sheet.split("}")[:-1]:
        before, _, body = rule.rpartition("{")
        selectors = before.rpartition("{")[2].split(",")
        found += [(each.split()[-1], body.strip()) for each in selectors if each.strip() and "@" not in each]
    rules: dict[str, list[tuple[int, str]]] = {}
    for rank, (selector, body) in enumerate(sorted(found, key=lambda rule: ("#" in rule[0], "." in rule[0]))):
        rules.setdefault(selector, []).append((rank, body))
    return rules


def _without_percent(root: Element) -> int:
    """Convert the lengths of shapes to numbers; remove shapes with percentages, and return their number."""
    count = 0
    for parent in list(root.iter()):
        for shape in list(parent):
            if tag_of(shape) not in SHAPE_TAGS:
                continue
            lengths = {key: length_of(shape.get(key)) for key in LENGTH_ATTRIBUTES if shape.get(key) is not None}
            if None in lengths.values():
                parent.remove(shape)
                count += 1
                continue
            for key, value in lengths.items():
                shape.set(key, repr(value))
            # A corner radius of 0 means plain corners.
            if tag_of(shape) == "rect" and not (lengths.get("rx") and lengths.get("ry", lengths.get("rx"))):
                for key in ("rx", "ry"):
                    shape.attrib.pop(key, None)
    return count
