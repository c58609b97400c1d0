#!/usr/bin/env python3
"""Measure how often pictures are recognised in rendered views, by the distance predicted from the picture alone.

.venv/bin/python scripts/measure/pictures.py [--views 8]
"""

import argparse
import math
from collections.abc import Mapping

import numpy as np

from mjsim.algorithms.beacon_vision.beacon_vision import PictureBeacons
from mjsim.algorithms.beacon_vision.picture_quality import PictureQuality, picture_qualities
from mjsim.bench.odd_pictures import borderline
from mjsim.bench.views import HANGING, INTRINSICS, POSTERS, ROOM, Studio, polar, read_posters
from mjsim.interface import Picture
from mjsim.models import encode_png

SIDE = 0.3
"""Root of the area of a picture [m]."""
SHARES = (0.4, 0.6, 0.8, 1.0, 1.25, 1.6)
"""Distances, relative to that predicted."""
HOPELESS = (0.5, 0.8, 1.2, 2.0, 3.0, 4.5)
"""Distances of pictures for which none is predicted [m]."""


def main() -> None:
    """Print a line for each picture, and the mean of those recognised."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--views", type=int, default=8, help="of each picture at each distance")
    views = parser.parse_args().views
    posters = read_posters(tuple(sorted(path.stem for path in POSTERS.glob("*.jpg")))[::3])
    for title, pictures in {"shipped posters": posters, "borderline": borderline()}.items():
        print(f"{title:20} least side  distance  found at {' '.join(f'{share:5g}' for share in SHARES)} of it")
        rates = []
        studio = _studio(pictures)
        qualities = {name: picture_qualities({name: picture})[name] for name, picture in pictures.items()}
        for name, quality in qualities.items():
            found, wrong = _rates(studio, name, pictures[name], quality, views)
            distance = INTRINSICS.fx * SIDE / quality.least_side
            shown = " ".join(f"{100 * each:4.0f}%" for each in found)
            left = f"{name:20} {quality.least_side:7.0f} px {distance:7.1f} m           {shown}"
            print(f"{left}  wrong {wrong}  {quality.fault or ''}", flush=True)
            if math.isfinite(quality.least_side):
                rates.append(found)
        print(f"{'mean':49} {' '.join(f'{100 * each:4.0f}%' for each in np.mean(rates, axis=0))}", flush=True)
        studio.canvas.close()


def _studio(pictures: Mapping[str, Picture]) -> Studio:
    """Return a long room with the pictures on one wall."""
    files = {f"{name}.png": encode_png(picture) for name, picture in pictures.items()}
    sizes = {name: (SIDE * _aspect(picture), SIDE / _aspect(picture)) for name, picture in pictures.items()}
    hanging = "".join(
        f"  - {{name: '{name}', image: '{name}.png', at: [0.07, {2.0 + 1.5 * k}],"
        f" width: {sizes[name][0]:.6f}, center: 1.2}}\n"
        for k, name in enumerate(pictures)
    )
    end = 4.0 + 1.5 * len(pictures)
    text = ROOM.replace(HANGING, hanging).replace("[9, -4], [9, 24], [0, 24]", f"[20, -4], [20, {end}], [0, {end}]")
    return Studio(text, sizes, files)


def _aspect(picture: Picture) -> float:
    return math.sqrt(picture.shape[1] / picture.shape[0])


def _rates(studio: Studio, name: str, picture: Picture, quality: PictureQuality, views: int) -> tuple[list[float], int]:
    """Return the share of views in which a picture is found, for each distance, and the number of wrong places."""
    rng = np.random.default_rng([*name.encode()])
    finder = PictureBeacons({name: (picture, SIDE * _aspect(picture))})
    far = INTRINSICS.fx * SIDE / quality.least_side
    wrong, rates = 0, []
    for distance in [share * far for share in SHARES] if far else HOPELESS:
        found = 0
        for yaw in np.linspace(-35.0, 35.0, views):
            shot = studio.before(name, float(distance * rng.uniform(0.97, 1.03)), float(yaw), rng=rng)
            for each in finder.detect(shot.image, INTRINSICS):
                (measured, _), (true, _) = polar(each.position), polar(shot.positions[name])
                right = abs(measured / true - 1.0) < 0.1
                found, wrong = found + right, wrong + (not right)
        rates.append(found / views)
    return rates, wrong


if __name__ == "__main__":
    main()
