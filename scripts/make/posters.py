"""Draw the posters of the gallery: procedural prints of our own, the same bytes every time.

Each has a big motif that people recognise, on a ground of shards of all sizes in contrasting tones, so that
features are found over the whole picture, near and far.

    python scripts/make/posters.py [FOLDER]
"""

import colorsys
import sys
from pathlib import Path

import cv2
import numpy as np
from museum_motifs import MUSEUM
from numpy.random import Generator
from numpy.typing import NDArray
from poster_motifs import MOTIFS
from poster_shapes import Layer, Outline, bar, disc, poly, star

Picture = NDArray[np.uint8]
Color = tuple[int, int, int]

ALL = MOTIFS | MUSEUM
"""Motif by name; a new one is added at the end, since its position determines format and colours."""
LONG_SIDE = 480
"""[px]"""
SHAPES = ((360, 480), (480, 400), (440, 440), (400, 480), (480, 360))
"""Width and height, taken in turn [px]."""
FINE = 2
"""Drawn this many times larger, then averaged down."""
SHIFT = 4
"""Fractional bits of OpenCV's coordinates."""


def draw_poster(name: str) -> Picture:
    """Return the poster of that name, RGB, shape (height, width, 3)."""
    index = list(ALL).index(name)
    rng = np.random.default_rng([2026, *name.encode()])
    width, height = SHAPES[index % len(SHAPES)]
    palette = make_palette(index, rng)
    canvas = draw_shards(rng, np.zeros((height * FINE, width * FINE, 3), dtype=np.uint8), palette["ground"])
    for tone, outline in ALL[name]:
        lay_on(canvas, rng, (tone, outline), palette)
    return np.asarray(cv2.resize(canvas, (width, height), interpolation=cv2.INTER_AREA), dtype=np.uint8)


def make_palette(index: int, rng: Generator) -> dict[str, list[Color]]:
    """Return tones for the ground and for each part of the motif; neighbours in the list differ in hue."""
    hue = (index * 0.618034) % 1.0
    night = index % 3 == 1
    lightness = (0.12, 0.25, 0.42, 0.62) if night else (0.93, 0.78, 0.6, 0.34)
    ground = [shade(hue + rng.uniform(-0.06, 0.06), value, 0.55) for value in lightness]
    ground.append(shade(hue + 0.5, 0.6 if night else 0.45, 0.6))
    bold = hue + 0.42 + rng.uniform(-0.06, 0.06)
    return {
        "ground": ground,
        "main": [shade(bold, value, 0.85) for value in ((0.62, 0.5, 0.78, 0.36) if night else (0.45, 0.32, 0.6, 0.2))],
        "dark": [shade(hue + 0.1, value, 0.5) for value in (0.14, 0.07, 0.27, 0.42)],
        "light": [shade(bold + 0.1, value, 0.7) for value in (0.92, 0.83, 0.97, 0.66)],
        "accent": [shade(hue + 0.18, value, 0.9) for value in (0.55, 0.42, 0.7, 0.28)],
    }


def shade(hue: float, lightness: float, saturation: float) -> Color:
    """Return a colour as RGB of 0 to 255."""
    red, green, blue = colorsys.hls_to_rgb(hue % 1.0, lightness, saturation)
    return round(255 * red), round(255 * green), round(255 * blue)


def draw_shards(rng: Generator, canvas: Picture, tones: list[Color]) -> Picture:
    """Return a picture of the canvas's size full of shards, from large to small, none like another.

    Args:
        rng: Source of all chance.
        canvas: Gives the size only.
        tones: Colours; the first is the most frequent.
    """
    height, width = canvas.shape[:2]
    picture = np.full(canvas.shape, tones[0], dtype=np.uint8)
    weights = np.linspace(1.6, 0.7, len(tones))
    largest, smallest = 0.17 * FINE * LONG_SIDE, 0.014 * FINE * LONG_SIDE
    count = 10 + int(width * height / (27.0 * FINE) ** 2)
    # Nearly as much area in small shards as in large ones, so that there is texture at every distance.
    reach = smallest * (largest / smallest) ** rng.beta(0.9, 1.5, count)
    for radius in np.sort(reach)[::-1]:
        middle = rng.uniform(0.0, 1.0, 2) * (width, height)
        color = tones[int(rng.choice(len(tones), p=weights / weights.sum()))]
        fill(picture, middle + shard(rng) * radius, color)
    return picture


def shard(rng: Generator) -> Outline:
    """Return one random outline of about unit radius."""
    kind = rng.integers(6)
    if kind == 0:
        return disc(0.0, 0.0, 0.8)
    if kind == 1:
        turn = rng.uniform(0.0, np.pi)
        return bar(-np.cos(turn), -np.sin(turn), np.cos(turn), np.sin(turn), 0.45, rng.uniform(0.1, 0.7))
    if kind == 2:
        return star(0.0, 0.0, int(rng.integers(4, 8)), 1.0, 0.45, rng.uniform(0.0, 90.0))
    corners = np.sort(rng.uniform(0.0, 2.0 * np.pi, int(rng.integers(3, 6))))
    return poly(*((float(np.cos(t)), float(np.sin(t))) for t in corners))


def lay_on(canvas: Picture, rng: Generator, layer: Layer, palette: dict[str, list[Color]]) -> None:
    """Print one part of the motif over the canvas, with a rim so that it stands out."""
    tone, outline = layer
    size = np.array([canvas.shape[1], canvas.shape[0]])
    # A motif is stretched by a quarter of what the format is longer one way than the other.
    points = outline * (0.73 * size.min() + 0.25 * size) + size / 2
    left, top = np.maximum(np.floor(points.min(axis=0)).astype(int), 0)
    right, bottom = np.minimum(np.ceil(points.max(axis=0)).astype(int) + 1, size)
    part = canvas[top:bottom, left:right]
    mask = np.zeros(part.shape, dtype=np.uint8)
    fill(mask, points - (left, top), (255, 255, 255))
    share = mask / 255.0
    part[:] = np.rint(draw_shards(rng, part, palette[tone]) * share + part * (1.0 - share)).astype(np.uint8)
    rim = palette["light"][0] if tone == "dark" else palette["dark"][1]
    cv2.polylines(canvas, [whole(points)], True, rim, 3 * FINE, cv2.LINE_AA, SHIFT)


def fill(canvas: Picture, points: Outline, color: Color) -> None:
    """Fill a polygon, corners in pixels, edges smooth."""
    cv2.fillPoly(canvas, [whole(points)], color, cv2.LINE_AA, SHIFT)


def whole(points: Outline) -> NDArray[np.int32]:
    """Return pixels as OpenCV's fixed-point numbers."""
    return np.asarray(np.rint(points * 2**SHIFT), dtype=np.int32)


def main() -> None:
    """Write all posters into the folder named on the command line, else into assets/posters."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[2] / "assets" / "posters"
    folder.mkdir(parents=True, exist_ok=True)
    for name in ALL:
        picture = cv2.cvtColor(draw_poster(name), cv2.COLOR_RGB2BGR)
        _, data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 88])
        (folder / f"{name}.jpg").write_bytes(data.tobytes())


if __name__ == "__main__":
    main()
