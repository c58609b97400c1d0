"""Draws the floor textures of assets/floors; they repeat without a seam.

    python scripts/make_floors.py

Contrast is low on purpose: pictures on the walls should be the most striking thing that a camera sees.
"""

import itertools
from pathlib import Path

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

Array = NDArray[np.float64]

SIZE = 1024
"""Side of a texture [px]; 2 m of floor."""
BOARDS = 10
"""Rows of boards in one tile: 20 cm wide each."""


def smooth_noise(rng: Generator, shape: tuple[int, int], blur: tuple[float, float]) -> Array:
    """Return noise of unit deviation that repeats, blurred by (rows, columns) [px], shape (rows, columns)."""
    rows = np.fft.fftfreq(shape[0])[:, None] * blur[0]
    columns = np.fft.rfftfreq(shape[1])[None, :] * blur[1]
    filtered = np.fft.rfft2(rng.normal(size=shape)) * np.exp(-2.0 * np.pi**2 * (rows**2 + columns**2))
    noise = np.fft.irfft2(filtered, s=shape)
    return np.asarray((noise - noise.mean()) / noise.std())


def draw_oak(rng: Generator) -> NDArray[np.uint8]:
    """Return boards of oak, laid along the rows with their ends staggered, RGB (SIZE, SIZE, 3)."""
    base = np.array([196.0, 168.0, 132.0])
    shade = np.zeros((SIZE, SIZE))
    warmth = np.zeros((SIZE, SIZE))
    edges = np.linspace(0, SIZE, BOARDS + 1).astype(int)
    for row, (top, bottom) in enumerate(itertools.pairwise(edges)):
        height = bottom - top
        first = (row * 389) % SIZE
        ends = [first, first + SIZE // 2 + int(rng.integers(-90, 90))]
        grain = smooth_noise(rng, (height, SIZE), (1.2, 60.0)) + 0.7 * smooth_noise(rng, (height, SIZE), (5.0, 160.0))
        strip, tint = 4.0 * grain, np.zeros((height, SIZE))
        for start, stop in ((ends[0], ends[1]), (ends[1], ends[0] + SIZE)):
            columns = np.arange(start, stop) % SIZE
            strip[:, columns] += rng.normal(0.0, 6.0)
            tint[:, columns] = rng.normal(0.0, 2.0)
            strip[:, columns[:2]] -= 22.0
        strip[:2] -= 18.0
        shade[top:bottom], warmth[top:bottom] = strip, tint
    picture = base + shade[..., None] * (1.0, 0.96, 0.88) + warmth[..., None] * (1.0, 0.0, -1.0)
    return np.clip(picture, 0, 255).astype(np.uint8)


def main() -> None:
    """Write all floors."""
    folder = Path(__file__).parents[1] / "assets" / "floors"
    folder.mkdir(parents=True, exist_ok=True)
    picture = cv2.cvtColor(draw_oak(np.random.default_rng(7)), cv2.COLOR_RGB2BGR)
    cv2.imwrite(str(folder / "oak.jpg"), picture, [cv2.IMWRITE_JPEG_QUALITY, 88])


if __name__ == "__main__":
    main()
