"""Draw docs/images/materials.jpg: two metres of each shipped material in the size of the table of docs/materials.md.

python scripts/make/material_pictures.py
"""

import re
from pathlib import Path

import cv2
import numpy as np

from mjsim.interface import Picture

ROOT = Path(__file__).parents[2]
PAGE, OUT = ROOT / "docs" / "materials.md", ROOT / "docs" / "images" / "materials.jpg"
METRES, SIDE, COLUMNS, TITLE = 2.0, 220, 5, 26
"""Side of a picture [m], [px], pictures in a row, and height of their titles [px]."""


def main() -> None:
    """Draw and write it."""
    rows = re.findall(r"^\| `(\w+)` \| ([\d.]+) \|", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    cells = [_titled(name, _patch(name, float(tile))) for name, tile in rows]
    cells += [np.full_like(cells[0], 255)] * (-len(cells) % COLUMNS)
    rows_of_cells = [np.hstack(cells[first : first + COLUMNS]) for first in range(0, len(cells), COLUMNS)]
    cv2.imwrite(str(OUT), np.vstack(rows_of_cells), [cv2.IMWRITE_JPEG_QUALITY, 85])
    print(OUT)


def _patch(name: str, tile: float) -> Picture:
    """Return `METRES` of a material, BGR."""
    texture = cv2.imread(str(ROOT / "assets" / "materials" / f"{name}.jpg"))
    size = max(1, round(SIDE * tile / METRES))
    small = cv2.resize(texture, (size, size), interpolation=cv2.INTER_AREA)
    times = -(-SIDE // size)
    return np.tile(small, (times, times, 1))[:SIDE, :SIDE]


def _titled(name: str, patch: Picture) -> Picture:
    framed = cv2.copyMakeBorder(patch, 4, TITLE, 4, 4, cv2.BORDER_CONSTANT, value=(255, 255, 255))
    cv2.putText(framed, name, (6, SIDE + 22), cv2.FONT_HERSHEY_SIMPLEX, 0.5, (40, 40, 40), 1, cv2.LINE_AA)
    return framed


if __name__ == "__main__":
    main()
