"""The look of all plans and plots: what each role is drawn in, on white and on dark paper.

Colours distinguish meanings also for the colour-blind; see Okabe and Ito, "Color Universal Design" (2008), and Tol,
"Colour Schemes" (2021).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import Literal

Rgb = tuple[int, int, int]
"""Red, green and blue, 0 to 255."""
Theme = Literal["light", "dark"]


@dataclass(frozen=True, slots=True)
class Ink:
    """A colour by its meaning, '#rrggbb': the same hue, lighter, on dark paper."""

    light: str
    dark: str


INKS: Mapping[str, Ink] = MappingProxyType(
    {
        "truth": Ink("#0072b2", "#4aa8e0"),
        "estimate": Ink("#d55e00", "#f0803c"),
        "odometry": Ink("#8a8a8a", "#a8a8a8"),
        "beacon": Ink("#e69f00", "#f0b429"),
        "seen": Ink("#009e73", "#2fc79b"),
        "scanned": Ink("#cc79a7", "#dd93bb"),
        "bump": Ink("#882255", "#d2709f"),
        "final": Ink("#332288", "#9a8be0"),
        "glass": Ink("#56b4e9", "#7cc8f2"),
        "lamp": Ink("#b8a700", "#e5d64a"),
        "ink": Ink("#23272e", "#eceae4"),
        "muted": Ink("#626872", "#a9aeb7"),
        "wall": Ink("#4a4f57", "#b3b8c1"),
        "paper": Ink("#ffffff", "#24272c"),
    }
)
"""Landmarks and sightings are 'seen', points of lidars 'scanned'; 'final' is the path that an estimator returns at the
end."""
GROUPS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#8c6d1f", "#332288", "#882255")
"""Colours of runs or robots that are drawn together: colour then tells these apart, and line style the quantities;
further ones repeat them."""


@dataclass(frozen=True, slots=True)
class Mix:
    """A colour made of two inks; 'tint' stands for a thing's own colour."""

    ink: str
    other: str = "paper"
    share: float = 0.0
    """Fraction of the other one, in [0, 1]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Style:
    """How a role is drawn."""

    fill: Mix | None = None
    line: Mix | None = None
    width: float = 0.2
    """Thickness of lines, and diameter of dots [mm on paper]."""
    dash: float = 0.0
    """Length of dashes, whose gaps are half as long [mm on paper]; 0 for a solid line."""
    group: str = "things"
    """Group of a drawing that contains it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Paint:
    """A style in the colours of a theme."""

    fill: Rgb | None
    line: Rgb | None
    width: float
    dash: float


def _edged(fill: Mix, line: Mix, width: float = 0.2, *, dash: float = 0.0, group: str = "things") -> Style:
    return Style(fill=fill, line=line, width=width, dash=dash, group=group)


_EDGE, _INK, _PAPER = Mix("tint", "ink", 0.45), Mix("ink"), Mix("paper")
_LOW, _LEAF = Mix("wall", "paper", 0.6), Mix("tint", "ink", 0.25)
ROLES: Mapping[str, Style] = MappingProxyType(
    {
        "floor grid": Style(line=Mix("muted", "paper", 0.65), width=0.12, group="floor"),
        "patch": _edged(Mix("tint", "paper", 0.72), Mix("tint", "paper", 0.3), 0.15, dash=1.2),
        "low wall": _edged(_LOW, _LOW, 0.1, group="low walls"),
        "obstacle": _edged(Mix("tint", "paper", 0.5), _EDGE),
        "movable": _edged(Mix("tint", "paper", 0.5), _EDGE, 0.3, dash=1.2),
        "hanging": Style(line=Mix("tint", "ink", 0.3), width=0.12, dash=0.8),
        "tread": Style(line=_EDGE, width=0.15),
        "way up": _edged(_EDGE, _EDGE, 0.25),
        # A thin wall must not fade when it is narrower than a pixel.
        "wall": _edged(Mix("wall"), Mix("wall"), 0.1, group="walls"),
        "window": Style(line=Mix("glass"), width=0.3, group="windows"),
        # Only in the studio, so that openings can be found.
        "gap": Style(line=Mix("muted", "paper", 0.4), width=0.15, dash=0.6, group="openings"),
        "swing": Style(line=Mix("muted"), width=0.12, group="doors"),
        "leaf": _edged(_LEAF, _LEAF, 0.3, group="doors"),
        "route": _edged(Mix("muted"), Mix("muted"), 0.3, dash=0.7),
        "lamp": _edged(Mix("lamp"), Mix("lamp"), group="lamps"),
        "person": _edged(Mix("tint", "paper", 0.5), _EDGE, 0.15, group="people"),
        "robot": _edged(Mix("tint", "paper", 0.5), _INK, 0.3, group="robots"),
        "heading": _edged(_INK, _INK, 0.4, group="robots"),
        "link": _edged(Mix("tint", "paper", 0.35), _INK, group="robots"),
        "tool": Style(fill=_INK, group="robots"),
        "beacon": Style(line=Mix("beacon"), width=0.7, group="beacons"),
        "tick": Style(line=Mix("beacon"), width=0.4, group="beacons"),
        "marker": Style(line=_PAPER, width=0.25, group="beacons"),
        "reflector": _edged(_PAPER, Mix("beacon"), 0.3, group="beacons"),
        # Of a run. Truth is wide and light below a thin estimate, so that it stays visible under a good one.
        "odometry path": Style(line=Mix("odometry"), width=0.25, group="paths"),
        "true path": Style(line=Mix("truth", "paper", 0.55), width=0.9, group="paths"),
        "estimated path": Style(line=Mix("estimate"), width=0.3, group="paths"),
        "tool path": Style(line=Mix("estimate"), width=0.45, group="paths"),
        "shown cells": Style(line=Mix("muted"), width=0.15, group="map"),
        "shown lines": Style(line=Mix("tint"), width=0.2, group="map"),
        "shown points": Style(fill=Mix("tint"), width=0.9, group="map"),
        "scan": Style(fill=Mix("scanned"), width=0.55, group="scans"),
        "sighting": Style(line=Mix("seen"), width=0.2, group="sightings"),
        "landmark": Style(fill=Mix("seen"), width=0.9, group="map"),
        "landmark ellipse": Style(line=Mix("seen"), width=0.15, group="map"),
        "true robot": Style(fill=Mix("truth"), group="robots"),
        "other robot": Style(fill=Mix("muted"), group="robots"),
        "nose": Style(line=_PAPER, width=0.35, group="robots"),
        "estimated robot": Style(line=Mix("estimate"), width=0.35, group="robots"),
        "pose ellipse": Style(line=Mix("estimate"), width=0.15, group="robots"),
    }
)
"""The style of each role."""


@cache
def color(ink: str, theme: Theme = "light") -> Rgb:
    """Return the colour of an ink."""
    return parse_color(getattr(INKS[ink], theme))


@cache
def paint_of(role: str, *, tint: str = "", level: float = 1.0, theme: Theme = "light") -> Paint:
    """Return how a role is painted.

    Args:
        role: One of `ROLES`.
        tint: Own colour of the thing, '#rrggbb'.
        level: Strength of its fill, from 0, that of paper, to 1.
        theme: Theme of the paper.
    """
    style = ROLES[role]
    fill, line = (None if mix is None else _mixed(mix, tint, theme) for mix in (style.fill, style.line))
    faded = fill if fill is None else blend(color("paper", theme), fill, level)
    return Paint(fill=faded, line=line, width=style.width, dash=style.dash)


def _mixed(mix: Mix, tint: str, theme: Theme) -> Rgb:
    first, other = (parse_color(tint) if ink == "tint" else color(ink, theme) for ink in (mix.ink, mix.other))
    return blend(first, other, mix.share)


def parse_color(text: str) -> Rgb:
    """Return the colour of '#rrggbb'."""
    red, green, blue = bytes.fromhex(text.removeprefix("#"))
    return red, green, blue


def hex_of(shown: Rgb) -> str:
    """Return a colour as '#rrggbb'."""
    return f"#{bytes(shown).hex()}"


def blend(one: Rgb, other: Rgb, share: float) -> Rgb:
    """Return a mixture of two colours; `share` in [0, 1] is the fraction of the other one."""
    mixed = [round((1.0 - share) * a + share * b) for a, b in zip(one, other, strict=True)]
    return mixed[0], mixed[1], mixed[2]
