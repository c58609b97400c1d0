"""Words of MATLAB's figures in matplotlib's: line formats, properties, and text in TeX."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

COLORS: Mapping[str, str] = {
    "r": "#d00000", "g": "#00a000", "b": "#0000e0", "c": "#00b5b5", "m": "#c000c0", "y": "#d0b000", "k": "black",
    "w": "white",
}  # fmt: skip
NAMED = {name: COLORS[letter] for name, letter in
         {"red": "r", "green": "g", "blue": "b", "cyan": "c", "magenta": "m", "yellow": "y", "black": "k",
          "white": "w"}.items()}  # fmt: skip
MARKERS = {"*": "*", "p": "*", "h": "h", "s": "s", "d": "D"}
PROPERTIES: Mapping[str, str] = {
    "linewidth": "linewidth", "markersize": "markersize", "linestyle": "linestyle", "marker": "marker",
    "markerfacecolor": "markerfacecolor", "markeredgecolor": "markeredgecolor", "color": "color",
    "facecolor": "facecolor", "edgecolor": "edgecolor", "facealpha": "alpha", "fontsize": "fontsize",
    "fontweight": "fontweight", "fontangle": "fontstyle", "displayname": "label", "rotation": "rotation",
    "horizontalalignment": "ha", "verticalalignment": "va",
}  # fmt: skip
"""Properties of MATLAB in lower case -> keywords of matplotlib; others are left out."""
SYMBOL = re.compile(r"\\([A-Za-z]+)|([_^])(\{[^{}]*\}|\\[A-Za-z]+|.)")


def line_format(text: str) -> dict[str, Any] | None:
    """Return the keywords of a line format such as 'r--o'; None if it is none."""
    found: dict[str, Any] = {}
    rest = text
    while rest:
        style = next((each for each in ("--", "-.", "-", ":") if rest.startswith(each)), None)
        if style:
            found["linestyle"], rest = style, rest[len(style) :]
        elif rest[0] in COLORS:
            found["color"], rest = COLORS[rest[0]], rest[1:]
        elif rest[0] in ".ox+*sdv^<>ph":
            found["marker"], rest = MARKERS.get(rest[0], rest[0]), rest[1:]
        else:
            return None
    if "marker" in found and "linestyle" not in found:
        found["linestyle"] = "none"
    return found


def properties_of(words: Sequence[Any], allowed: Sequence[str] = tuple(PROPERTIES)) -> dict[str, Any]:
    """Return the keywords of pairs of names and values."""
    found = {}
    for name, value in zip(words[::2], words[1::2], strict=False):
        key = name.lower() if isinstance(name, str) else ""
        if key in allowed and key in PROPERTIES:
            found[PROPERTIES[key]] = _value(PROPERTIES[key], value)
    return found


def _value(key: str, value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.ravel().tolist() if value.size > 1 else float(value.ravel()[0]) if value.size else None
    if "color" in key and isinstance(value, str):
        return COLORS.get(value) or NAMED.get(value.lower(), "none" if value == "none" else None)
    return MARKERS.get(value, value) if key == "marker" else value


def math_text(text: str) -> str:
    """Return text of MATLAB's TeX in matplotlib's: symbols, subscripts and superscripts."""
    if "$" in text or not SYMBOL.search(text):
        return text.replace("$$", "$") if text.count("$") % 2 == 0 else text.replace("$", r"\$")

    def symbol(match: re.Match[str]) -> str:
        name, mark, content = match.groups()
        if name is not None:
            return _command(name)
        inner = content[1:-1] if content.startswith("{") else content
        return f"$\\mathregular{{{mark}{{{inner}}}}}$" if "\\" not in inner else f"${mark}{{{inner}}}$"

    made = SYMBOL.sub(symbol, text).replace("$$", "")
    return made if _parses(made) else text.replace("\\", "")


def _command(name: str) -> str:
    if name in ("bf", "it", "rm", "sl"):
        return ""
    return {"deg": "$^\\circ$"}.get(name, f"$\\{name}$")


def _parses(text: str) -> bool:
    from matplotlib.mathtext import MathTextParser

    try:
        MathTextParser("path").parse(text)
    except ValueError:
        return False
    return True
