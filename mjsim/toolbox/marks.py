"""Words of MATLAB's figures in matplotlib's: line formats, properties, and text in TeX."""

import re
from collections.abc import Mapping, Sequence
from itertools import takewhile
from typing import Any

import numpy as np

from mjsim.geometry import Array
from mjsim.toolbox.calls import FigureCall

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


STYLES = ("bf", "it", "rm", "sl")
"""Commands that change a font."""
FONTS = re.compile(r"\\(?:fontsize|fontname|color)\s*(?:\[\w+\])?\{[^{}]*\}")
"""Commands that change a font, or its colour, with their value."""
STYLED = re.compile(r"\{(\\(?:bf|it|rm|sl)\b ?)+([^{}]*)\}")
LAST_OF_MATHTEXT = "\u2e7f"
"""Letters beyond this are not in the fonts of mathtext."""
LOWER = str.maketrans("0123456789+-=()aeoxhklmnpst", "₀₁₂₃₄₅₆₇₈₉₊₋₌₍₎ₐₑₒₓₕₖₗₘₙₚₛₜ")
UPPER = str.maketrans("0123456789+-=()n", "⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻⁼⁽⁾ⁿ")


def is_text(value: Any) -> bool:
    """Whether an argument is text."""
    return isinstance(value, str)


def data_of(call: FigureCall) -> list[Array]:
    """Return the arrays before the first text; others are values of properties."""
    return list(takewhile(lambda each: isinstance(each, np.ndarray), call.arguments))


def words_of(call: FigureCall) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the keywords of the line format and the properties behind the data, and the latter as they are written."""
    rest = list(call.arguments[len(data_of(call)) :])
    style = line_format(rest[0]) if rest and is_text(rest[0]) else None
    rest = rest[1:] if style is not None or len(rest) % 2 else rest
    given = {name.lower(): value for name, value in zip(rest[::2], rest[1::2], strict=False) if is_text(name)}
    return {**(style or {}), **properties_of(rest)}, given


def as_columns(value: Any) -> Array:
    """Return data of a line as columns, shape (k, lines)."""
    array = np.asarray(value, dtype=float)
    return array.reshape(-1, 1) if array.ndim < 2 or 1 in array.shape else array


def line_format(text: str) -> dict[str, Any] | None:
    """Return the keywords of a line format such as 'r--o', with a name as Octave has it in 'r;name;'; else None."""
    found: dict[str, Any] = {}
    rest, *label = text.split(";")
    if len(label) == 2 and not label[1]:
        found["label"] = label[0]
    elif label:
        return None
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
        value = np.clip(value, 0.0, 1.0) if "color" in key else value
        return value.ravel().tolist() if value.size > 1 else float(value.ravel()[0]) if value.size else None
    if "color" in key and isinstance(value, str):
        plain = value if re.fullmatch("none|#[0-9a-fA-F]{6}", value) else None
        return COLORS.get(value) or NAMED.get(value.lower(), plain)
    return MARKERS.get(value, value) if key == "marker" else value


def math_text(text: str) -> str:
    """Return text of MATLAB's TeX in matplotlib's: symbols, subscripts and superscripts.

    Beside characters that mathtext lacks, such as Chinese ones, they are Unicode characters.
    """
    if "$" not in text:
        text = STYLED.sub(r"\2", FONTS.sub("", text))
    if any(letter > LAST_OF_MATHTEXT for letter in text):
        return SYMBOL.sub(_letters, text.replace("$", "").replace("\\circ", "\N{DEGREE SIGN}"))
    text = text if "$" in text else text.replace("\\|", "\N{DOUBLE VERTICAL LINE}")
    if "$" in text or not SYMBOL.search(text):
        plain = text.replace("$$", "$") if text.count("$") % 2 == 0 else text.replace("$", r"\$")
        return plain if _parses(plain) else text.replace("$", "").replace("\\", "")

    def symbol(match: re.Match[str]) -> str:
        name, mark, content = match.groups()
        if name is not None:
            return _command(name)
        inner = content[1:-1] if content.startswith("{") else content
        return f"$\\mathregular{{{mark}{{{inner}}}}}$" if "\\" not in inner else f"${mark}{{{inner}}}$"

    made = SYMBOL.sub(symbol, text).replace("$$", "")
    return made if _parses(made) else text.replace("\\", "")


def _letters(match: re.Match[str]) -> str:
    """Return a symbol, a subscript or a superscript as letters of Unicode."""
    from matplotlib._mathtext_data import tex2uni

    name, mark, content = match.groups()
    if name is not None:
        return "" if name in STYLES else chr(tex2uni[name]) if name in tex2uni else name
    if content.startswith("\\"):
        return SYMBOL.sub(_letters, content)
    inner = SYMBOL.sub(_letters, content[1:-1]) if content.startswith("{") else content
    return inner.translate(LOWER if mark == "_" else UPPER)


def _command(name: str) -> str:
    if name in STYLES:
        return ""
    return {"deg": "$^\\circ$"}.get(name, f"$\\{name}$")


def _parses(text: str) -> bool:
    from matplotlib.mathtext import MathTextParser

    try:
        for line in text.split("\n"):
            MathTextParser("path").parse(line)
    except ValueError:
        return False
    return True
