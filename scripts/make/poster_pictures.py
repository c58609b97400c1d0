"""Draw docs/images/pictures.png: good and bad pictures for beacons, with what `mjsim check` reports about them.

python scripts/make/poster_pictures.py
"""

import re
from pathlib import Path

import cv2
import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np

from mjsim.algorithms.beacon_vision.picture_quality import PictureQuality, picture_qualities
from mjsim.bench.odd_pictures import borderline, odd_pictures
from mjsim.bench.views import read_posters
from mjsim.models import read_picture

OUT = Path(__file__).parents[2] / "docs" / "images" / "pictures.png"
GOOD, BAD = "#0072B2", "#D55E00"


def main() -> None:
    """Draw and write it."""
    mpl.use("Agg")
    odd = odd_pictures()
    pictures = {
        **read_posters(("lion", "owl")),
        **{name: borderline()[name] for name in ("contrast-0.2", "blur-6")},
        **{name: read_picture(odd[f"{name}.png"]) for name in ("disc", "gradient", "barcode", "bricks", "8x6")},
    }
    pictures["owl again"] = np.asarray(cv2.convertScaleAbs(pictures["owl"], alpha=0.7, beta=60), dtype=np.uint8)
    qualities = picture_qualities(pictures)
    figure, axes = plt.subplots(2, 5, figsize=(10.0, 6.2))
    for panel, (name, picture) in zip(axes.flat, pictures.items(), strict=True):
        quality = qualities[name]
        panel.imshow(picture, interpolation="nearest")
        panel.set_xticks([])
        panel.set_yticks([])
        good = quality.fault is None and quality.like is None
        for side in panel.spines.values():
            side.set(color=GOOD if good else BAD, linewidth=3.0)
        panel.set_title(_told(quality), fontsize=9, color=GOOD if good else BAD)
    figure.tight_layout()
    figure.savefig(OUT, dpi=80)
    print(OUT)


def _told(quality: PictureQuality) -> str:
    """Return a line for a picture: its minimum size, or what is wrong with it."""
    if quality.fault is not None:
        return re.split("[,;]", quality.fault)[0].replace(" or ", "\nor ").replace("one direction", "one\ndirection")
    if quality.like is not None:
        return f"looks like {quality.like[0]}\n({quality.like[1]:.0%} alike)"
    return f"recognised from\n{quality.least_side:.0f} px"


if __name__ == "__main__":
    main()
