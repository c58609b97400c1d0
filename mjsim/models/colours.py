"""Colours: of a material or a light of SDF, of a script of Gazebo, and as text."""

import math
from collections.abc import Iterable, Mapping
from xml.etree.ElementTree import Element

SCRIPTS: Mapping[str, str] = {
    "grey": "#b3b3b3",
    "darkgrey": "#2d2d2d",
    "white": "#ffffff",
    "flatblack": "#1a1a1a",
    "black": "#000000",
    "red": "#ff0000",
    "green": "#00ff00",
    "blue": "#0000ff",
    "yellow": "#ffff00",
    "orange": "#ff8800",
    "purple": "#ff00ff",
    "turquoise": "#00ffff",
    "wood": "#8a6f4d",
    "bricks": "#a05a44",
    "skyblue": "#2133e6",
}
"""Names of materials of Gazebo, without 'Gazebo/'."""


def color_of(element: Element) -> str | None:
    """Return the colour of a visual or a light as '#rrggbb'; None if it has none."""
    for key in ("material/diffuse", "diffuse", "material/ambient"):
        words = (element.findtext(key) or "").split()
        try:
            shares = [float(word) for word in words[:3]]
        except ValueError:
            continue
        if len(shares) == 3 and all(map(math.isfinite, shares)):
            return hex_of(shares)
    script = (element.findtext("material/script/name") or "").rpartition("/")[2].lower()
    return SCRIPTS.get(script)


def hex_of(shares: Iterable[float]) -> str:
    """Return red, green and blue as '#rrggbb'; below 0 is 0, above 1 is 1."""
    return "#" + "".join(f"{round(255 * min(max(share, 0.0), 1.0)):02x}" for share in shares)
