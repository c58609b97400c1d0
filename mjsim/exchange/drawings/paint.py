"""Darkness and opacity of the colours of a drawing."""

import re

NAMED = {
    "black": 1.0, "white": 0.0, "none": 0.0, "transparent": 0.0, "gray": 0.5, "grey": 0.5, "silver": 0.25,
    "dimgray": 0.59, "dimgrey": 0.59, "darkgray": 0.34, "darkgrey": 0.34, "lightgray": 0.17, "lightgrey": 0.17,
    "red": 0.7, "green": 0.72, "blue": 0.93, "navy": 0.96, "maroon": 0.85, "brown": 0.75, "slategray": 0.52,
    "darkslategray": 0.74,
}  # fmt: skip
"""Darkness of the most common named colours [1 - luma]."""


def darkness_of(color: str | None) -> float:
    """Return the darkness of a fill, 0 for white to 1 for black; None is black, as in SVG.

    References:
        ITU-R BT.601, luma of red, green and blue.
    """
    if color is None:
        return 1.0
    text = color.strip().lower()
    if (known := NAMED.get(text)) is not None:
        return known
    if found := re.fullmatch(r"#([0-9a-f]{3,8})", text):
        digits = found[1]
        short = [digit * 2 for digit in digits[:3]]
        parts = short if len(digits) < 6 else [digits[k : k + 2] for k in (0, 2, 4)]
        return _darkness(*(int(part, 16) / 255 for part in parts))
    numbers = re.findall(r"[\d.]+(%?)", text)
    if text.startswith("rgb") and len(numbers) >= 3:
        values = re.findall(r"([\d.]+)(%?)", text)[:3]
        return _darkness(*(min(1.0, float(value) / (100 if percent else 255)) for value, percent in values))
    return 0.5


def opacity_of(color: str | None) -> float:
    """Return the opacity of a colour, 0 to 1: of `rgba(...)` and `#rrggbbaa`; 1 for all others."""
    text = (color or "").strip().lower()
    if found := re.fullmatch(r"#(?:[0-9a-f]{3}([0-9a-f])|[0-9a-f]{6}([0-9a-f]{2}))", text):
        return int(found[1] * 2 if found[1] else found[2], 16) / 255
    numbers = re.findall(r"[\d.]+%?", text) if text.startswith(("rgba", "hsla", "rgb(")) else []
    return share_of(numbers[3]) if len(numbers) == 4 else 1.0


def share_of(text: str | None) -> float:
    """Return a fraction, 0 to 1, given as a number or in percent; 1 if none is given."""
    found = re.fullmatch(r"\s*(\d*\.?\d+)(%?)\s*", text or "")
    return min(1.0, float(found[1]) / (100.0 if found[2] else 1.0)) if found else 1.0


def _darkness(red: float, green: float, blue: float) -> float:
    return 1.0 - (0.299 * red + 0.587 * green + 0.114 * blue)
