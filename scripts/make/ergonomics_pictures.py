"""Write docs/images/ergonomics: what `mjsim ergonomics` draws of the worlds that docs/ergonomics.md shows.

python scripts/make/ergonomics_pictures.py
"""

import tempfile
from pathlib import Path

import cv2

from mjsim.ergonomics import write_ergonomics
from mjsim.world import load_checked

PICTURES = Path(__file__).resolve().parents[2] / "docs" / "images" / "ergonomics"
SHOWN = {
    "driving_seat": ("outside", "left_eye", "posture", "reach", "sight"),
    "forklift": ("outside", "left_eye"),
    "control_desk": ("outside", "left_eye"),
}
"""World -> its pictures."""


def main() -> None:
    """Write the pictures."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    for world, kinds in SHOWN.items():
        with tempfile.TemporaryDirectory() as folder:
            (person,) = write_ergonomics(load_checked(world), Path(folder))
            for kind in kinds:
                picture = cv2.imread(f"{folder}/{person}_{kind}.png")
                quality = [cv2.IMWRITE_JPEG_QUALITY, 85]
                cv2.imwrite(str(PICTURES / f"{world}-{kind}.jpg"), picture, quality)
        print(world)


if __name__ == "__main__":
    main()
