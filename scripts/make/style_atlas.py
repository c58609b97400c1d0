#!/usr/bin/env python3
"""Draws assets/style: one picture of the small things of rooms, such as sockets, papers and books, and where each is.

.venv/bin/python scripts/make/style_atlas.py

All is drawn from seeded noise. No picture has the square dark frame of a marker, nor the shapes of a poster.
"""

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

import cv2
import numpy as np
import style_parts as parts
from numpy.random import Generator
from style_drawing import Picture, blank

FOLDER = Path(__file__).resolve().parents[2] / "assets" / "style"
WIDTH, BORDER = 1024, 3
"""Width of the picture and the border that repeats the edge of each part, so that neighbours do not bleed in [px]."""
QUALITY = 90
"""Quality of the JPEG."""
SWATCHES = {
    "white": (236, 236, 232),
    "cream": (226, 218, 200),
    "gray": (150, 152, 154),
    "dark": (58, 60, 64),
    "wood": (139, 98, 62),
    "steel": (172, 176, 180),
    "red": (178, 42, 36),
    "green": (40, 128, 72),
    "blue": (52, 92, 150),
    "yellow": (226, 184, 44),
    "paper": (238, 235, 226),
}
"""Plain colours, RGB."""

DRAWN: Mapping[str, tuple[Callable[[Generator], Picture], int]] = {
    "view_town": (partial(parts.view, town=True), 2),
    "view_park": (partial(parts.view, town=False), 2),
    "blinds": (parts.blinds, 1),
    "curtain": (parts.curtain, 1),
    "leaf_office": (partial(parts.leaf, color=(176, 150, 118), panels=False), 1),
    "leaf_home": (partial(parts.leaf, color=(232, 228, 216), panels=True), 1),
    "noted": (parts.noted, 3),
    "written": (parts.written, 2),
    "books": (parts.books, 5),
    "folders": (parts.folders, 2),
    "screen": (parts.screen, 3),
    "keyboard": (parts.keyboard, 1),
    "sheet": (parts.sheet, 6),
    "radiator": (parts.radiator, 1),
    "socket": (partial(parts.socket, count=1), 1),
    "sockets": (partial(parts.socket, count=2), 1),
    "switch": (parts.switch, 1),
    "duct": (parts.duct, 1),
    "door_sign": (parts.door_sign, 6),
    "exit": (parts.exit_sign, 1),
    "fire": (partial(parts.notice, color=(176, 40, 34), word="FIRE"), 1),
    "safety": (partial(parts.notice, color=(40, 84, 150), word="SAFETY"), 1),
    "danger": (partial(parts.notice, color=(206, 120, 30), word="CAUTION"), 1),
    "clock": (parts.clock, 1),
    "painting": (parts.painting, 6),
    "panel": (parts.panel_of_text, 3),
    "label": (parts.label, 4),
    "vent": (parts.vent, 1),
    "carton": (parts.carton, 4),
    "hazard": (parts.hazard, 1),
    "extinguisher": (parts.extinguisher, 1),
    "lamp": (parts.lamp, 1),
    "skirting_white": (partial(parts.skirting, color=(228, 228, 222)), 1),
    "skirting_wood": (partial(parts.skirting, color=(132, 92, 58)), 1),
    "skirting_dark": (partial(parts.skirting, color=(78, 80, 84)), 1),
}
"""How each kind is drawn, and in how many variants, which are named KIND/1, KIND/2 and so on."""


def pictures() -> dict[str, Picture]:
    """Return all parts by name."""
    found = {name: blank(8, 8, color) for name, color in SWATCHES.items()}
    for kind, (draw, count) in DRAWN.items():
        for number in range(1, count + 1):
            rng = np.random.default_rng([number, *kind.encode()])
            found[f"{kind}/{number}"] = draw(rng)
    return found


def packed(drawn: Mapping[str, Picture]) -> tuple[Picture, dict[str, list[int]]]:
    """Return one picture with all parts, in rows, and x, y, width and height of each [px]."""
    places: dict[str, list[int]] = {}
    x = y = row = 0
    for name, part in sorted(drawn.items(), key=lambda item: (-item[1].shape[0], item[0])):
        height, width = part.shape[0] + 2 * BORDER, part.shape[1] + 2 * BORDER
        if x + width > WIDTH:
            x, y, row = 0, y + row, 0
        places[name] = [x + BORDER, y + BORDER, part.shape[1], part.shape[0]]
        x, row = x + width, max(row, height)
    atlas = np.zeros((y + row, WIDTH, 3), dtype=np.uint8)
    for name, (left, top, width, height) in places.items():
        bordered = cv2.copyMakeBorder(drawn[name], *[BORDER] * 4, cv2.BORDER_REPLICATE)
        atlas[top - BORDER : top + height + BORDER, left - BORDER : left + width + BORDER] = bordered
    return atlas, places


def main() -> None:
    """Write the picture and the places."""
    atlas, places = packed(pictures())
    FOLDER.mkdir(exist_ok=True)
    options = [
        cv2.IMWRITE_JPEG_QUALITY,
        QUALITY,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444,
    ]
    cv2.imwrite(str(FOLDER / "atlas.jpg"), cv2.cvtColor(atlas, cv2.COLOR_RGB2BGR), options)
    lines = ",\n".join(f' "{name}": {place}' for name, place in sorted(places.items()))
    (FOLDER / "atlas.json").write_text("{\n" + lines + "\n}\n", encoding="utf-8")


if __name__ == "__main__":
    main()
