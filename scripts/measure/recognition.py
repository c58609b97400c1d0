#!/usr/bin/env python3
"""Measure whether pictures are recognised as well before walls with a material as before plain ones.

.venv/bin/python scripts/measure/recognition.py [--views 200] [MATERIAL ...]

The same views of a room with posters are drawn with each material on its walls, and with plain walls of the same mean
colour: descriptors at the edge of a picture depend on the brightness around it. Printed are the share of the posters
wholly in view that are found, the number of wrong sightings, the range error, and the number of SIFT features that
match a poster where its pose says, each before the material and before plain walls.
"""

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.resources import files

import cv2
import numpy as np
from numpy.typing import NDArray

from mjsim.algorithms.beacon_vision.beacon_vision import PictureBeacons
from mjsim.algorithms.beacon_vision.planar_pose import project
from mjsim.bench.views import INTRINSICS, KNOWN, PICTURES, ROOM, SIZES, Shot, Studio, polar
from mjsim.geometry import Array
from mjsim.interface import Picture
from mjsim.models import read_picture

MATERIALS = ("plaster", "plaster_white", "wallpaper", "concrete", "brick", "wood", "tiles", "metal")
RATIO, NEAR = 0.8, 4.0
"""Lowe's ratio of accepted matches, and the largest distance of a correct one from its place [px]."""


@dataclass(frozen=True, slots=True)
class Score:
    """What was recognised in one view."""

    whole: int
    """Number of searched posters wholly in view."""
    found: int
    wrong: int
    errors: tuple[float, ...]
    """Range errors of those found [m]."""
    matches: int
    """Number of correct SIFT matches."""


def main() -> None:
    """Print a row for each material."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("materials", nargs="*", default=MATERIALS)
    parser.add_argument("--views", type=int, default=200)
    chosen = parser.parse_args()
    finder = PictureBeacons({name: (PICTURES[name], SIZES[name][0]) for name in KNOWN})
    known = {name: sift(PICTURES[name]) for name in KNOWN}
    print("| walls | recall | wrong | range error, median [mm] | correct SIFT matches |")
    print("|---|---|---|---|---|")
    for material in chosen.materials:
        color = "#" + bytes(np.rint(mean_color(material)).astype(np.uint8)).hex()
        looks = f"texture: materials/{material}.jpg, tile: 1.6", f"color: '{color}'"
        scores = [[score(shot, finder, known) for shot in shots(look, chosen.views)] for look in looks]
        print(f"| {material} {row(*scores)}", flush=True)


def mean_color(material: str) -> Array:
    """Return the mean of a material, red, green, blue, shape (3,)."""
    file = files("mjsim.assets") / "materials" / f"{material}.jpg"
    return read_picture(file.read_bytes()).mean(axis=(0, 1))


def row(textured: Sequence[Score], plain: Sequence[Score]) -> str:
    """Return the figures of the views before a material and before plain walls as cells of a table."""
    both = textured, plain
    recall = [sum(each.found for each in scores) / sum(each.whole for each in scores) for scores in both]
    wrong = [sum(each.wrong for each in scores) for scores in both]
    errors = [1e3 * np.median([abs(error) for each in scores for error in each.errors]) for scores in both]
    matches = [sum(each.matches for each in scores) for scores in both]
    return (
        f"| {recall[0]:.1%}, {recall[1]:.1%} | {wrong[0]}, {wrong[1]} | {errors[0]:.1f}, {errors[1]:.1f}"
        f" | {matches[0]}, {matches[1]}: {matches[0] / matches[1]:.0%} |"
    )


def shots(look: str, views: int) -> Iterator[Shot]:
    """Yield views of the room with walls of a look, the same ones for each."""
    studio, rng = Studio(ROOM.replace("closed: true", f"closed: true, {look}")), np.random.default_rng(5)
    for view in range(views):
        name, distance, yaw = KNOWN[view % len(KNOWN)], rng.uniform(1.2, 6.5), rng.uniform(-45.0, 45.0)
        yield studio.before(name, float(distance), float(yaw), aside_deg=float(rng.uniform(-15.0, 15.0)), rng=rng)
    studio.canvas.close()


def score(shot: Shot, finder: PictureBeacons, known: dict[str, tuple[Array, NDArray[np.float32]]]) -> Score:
    """Return what is recognised in a view."""
    wanted, right, errors = shot.whole & set(known), set(), []
    found = finder.detect(shot.image, INTRINSICS)
    for each in found:
        measured, true = polar(each.position)[0], polar(shot.positions[each.name])[0]
        if np.linalg.norm(each.position - shot.positions[each.name]) < 0.1 * true:
            right.add(each.name)
            errors.append(measured - true)
    matches = correct_matches(shot, sorted(wanted), known)
    return Score(len(wanted), len(right & wanted), len(found) - len(right), tuple(errors), matches)


def sift(picture: Picture) -> tuple[Array, NDArray[np.float32]]:
    """Return the SIFT features of an RGB picture: their positions, shape (n, 2) [px], and descriptors."""
    points, descriptors = cv2.SIFT.create().detectAndCompute(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY), None)
    return np.array([each.pt for each in points]).reshape(-1, 2), np.asarray(descriptors, dtype=np.float32)


def correct_matches(shot: Shot, names: Sequence[str], known: dict[str, tuple[Array, NDArray[np.float32]]]) -> int:
    """Return the number of features of an image that match a poster's where its true pose says."""
    points, descriptors = sift(shot.image)
    count = 0
    for name in names:
        own, own_descriptors = known[name]
        pairs = cv2.BFMatcher().knnMatch(own_descriptors, descriptors, k=2)
        good = [(best.queryIdx, best.trainIdx) for best, second in pairs if best.distance < RATIO * second.distance]
        if good:
            ours, seen = np.array(good).T
            places = project(on_poster(shot, name, own[ours]), INTRINSICS)
            count += int((np.linalg.norm(places - points[seen], axis=1) < NEAR).sum())
    return count


def on_poster(shot: Shot, name: str, pixels: Array) -> Array:
    """Return the positions of pixels of a poster in the optical frame, shape (n, 3) [m]."""
    height, width = PICTURES[name].shape[:2]
    right, down = ((pixels + 0.5) / (width, height) - 0.5).T * np.array(SIZES[name])[:, None]
    return shot.positions[name] + np.outer(right, shot.right) + np.outer(down, [0.0, 1.0, 0.0])


if __name__ == "__main__":
    main()
