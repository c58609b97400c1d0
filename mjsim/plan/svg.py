"""Writes shapes and words as SVG, to scale."""

from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import groupby
from xml.etree.ElementTree import Element, SubElement, indent, register_namespace, tostring

import numpy as np

from mjsim.geometry import Array
from mjsim.plan.look import Rgb, Theme, blend, color, hex_of
from mjsim.plan.shapes import PlanItem, Words

SVG_NAMESPACE = "http://www.w3.org/2000/svg"
SVG_UNITS = 100.0
"""Units of the drawing per metre."""


class SvgPlan:
    """A drawing in SVG that shows bounds of the world at a scale."""

    def __init__(self, bounds: Array, *, ratio: float, theme: Theme = "light") -> None:
        """Start an empty drawing.

        Args:
            bounds: Minimum and maximum of (x, y), shape (2, 2) [m].
            ratio: Scale denominator: one metre is 1000 / ratio millimetres on paper.
            theme: Theme of the paper.
        """
        self.metres, self._theme, self._groups = ratio / 1000.0, theme, Counter[str]()
        left, top = bounds[0, 0], -bounds[1, 1]
        size = bounds[1] - bounds[0]
        width, height = (size / self.metres).tolist()
        box = " ".join(_number(value) for value in (left, top, *size.tolist()))
        self.root = _element("svg", width=f"{width:g}mm", height=f"{height:g}mm", viewBox=box)
        paper = hex_of(color("paper", theme))
        self.root.append(_element("rect", x=_number(left), y=_number(top), width="100%", height="100%", fill=paper))

    def group(self, name: str) -> Element:
        """Return a new group; its id is the name, with a number unless it is the first of that name."""
        self._groups[name] += 1
        group = _element("g", id=name if self._groups[name] == 1 else f"{name}-{self._groups[name]}")
        self.root.append(group)
        return group

    def draw(self, shapes: Iterable[PlanItem]) -> None:
        """Draw shapes in their order, in groups by what they show."""
        for name, group in groupby(shapes, key=lambda shape: shape.group):
            parent = self.group(name)
            for shape in group:
                self._draw_shape(parent, shape)

    def _draw_shape(self, group: Element, shape: PlanItem) -> None:
        paint = shape.paint(self._theme)
        parts = [part for part in shape.placed(self.metres) if len(part)]
        if shape.kind == "dots":
            # A line without length and with round ends is a dot of the line's width.
            path = " ".join(f"M{_point(point)}h0" for part in parts for point in part)
            dots = SubElement(group, f"{{{SVG_NAMESPACE}}}path", d=path, stroke=_ink(paint.fill))
            dots.set("stroke-width", _number(paint.width * self.metres))
            dots.set("stroke-linecap", "round")
            return
        for part in parts:
            ink, fill = _ink(paint.line), _ink(paint.fill if shape.kind == "area" else None)
            dash = paint.dash * self.metres
            add_line(group, part, ink, paint.width * self.metres, closed=shape.kind == "area", fill=fill, dash=dash)

    def write(
        self, group: Element, text: str, at: Array, height: float, ink: str = "ink", *, align: float = 0.0
    ) -> None:
        """Add a line of text.

        Args:
            group: Group that contains it.
            text: The text.
            at: Start, centre or end of its baseline, world frame, shape (2,) [m].
            height: Height of the font [m].
            ink: Its colour, one of `INKS`.
            align: 0 if the text starts at the point, 0.5 if it is centred on it, 1 if it ends there.
        """
        shown = color(ink, self._theme) if ink in ("ink", "muted") else self._darkened(ink)
        words = _element("text", x=_number(at[0]), y=_number(-at[1]), fill=hex_of(shown))
        words.set("font-size", _number(height))
        words.set("font-family", "sans-serif")
        if align:
            words.set("text-anchor", "middle" if align == 0.5 else "end")
        words.text = text
        group.append(words)

    def _darkened(self, ink: str) -> Rgb:
        return blend(color(ink, self._theme), color("ink", self._theme), 0.5)

    def name(self, words: Sequence[Words]) -> None:
        """Write names beside their objects."""
        group = self.group("names")
        for each in words:
            height = each.size * self.metres
            away = np.array(each.reach) + (each.gap + 0.9) * self.metres + height / 2
            at = each.at + each.side * away - (0.0, 0.35 * height)
            self.write(group, each.text, at, height, each.ink, align=_alignment(float(each.side[0])))

    def data(self) -> bytes:
        """Return the contents of the file."""
        indent(self.root)
        register_namespace("", SVG_NAMESPACE)
        return bytes(tostring(self.root, encoding="utf-8", xml_declaration=True))


def add_line(
    group: Element,
    points: Array,
    ink: str,
    width: float,
    *,
    closed: bool = False,
    fill: str = "none",
    dash: float = 0.0,
) -> None:
    """Add a polyline through corners, shape (n, 2), with a width [m]; the gaps between dashes are half as long."""
    shape = _element("polygon" if closed else "polyline", fill=fill, stroke=ink)
    shape.set("stroke-width", _number(width))
    if dash:
        shape.set("stroke-dasharray", f"{_number(dash)} {_number(dash / 2)}")
    shape.set("points", " ".join(map(_point, points)))
    group.append(shape)


def _alignment(side: float) -> float:
    return 0.5 if abs(side) < 0.5 else 0.0 if side > 0.0 else 1.0


def _ink(shown: Rgb | None) -> str:
    return "none" if shown is None else hex_of(shown)


def _element(tag: str, **attributes: str) -> Element:
    return Element(f"{{{SVG_NAMESPACE}}}{tag}", attributes)


def _number(metres: float) -> str:
    return f"{metres * SVG_UNITS + 0.0:.7g}"


def _point(point: Array) -> str:
    return f"{_number(float(point[0]))},{_number(-float(point[1]))}"
