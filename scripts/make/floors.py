"""Draws the textures of assets/floors and assets/walls; they repeat without a seam.

    python scripts/make/floors.py

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
SMALL = 512
"""Side of the other textures [px]."""
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


def draw_slabs(
    rng: Generator,
    *,
    base: tuple[float, float, float],
    rows: int,
    columns: int,
    stagger: bool,
    joint: float,
    spread: float,
    grain: float,
) -> NDArray[np.uint8]:
    """Return slabs laid in rows: flagstones, tiles or bricks, RGB (SMALL, SMALL, 3).

    Args:
        rng: Of the shades of the slabs and of their grain.
        base: RGB of the middle slab.
        rows: Of slabs in one tile of the texture.
        columns: Of slabs in a row.
        stagger: Whether every other row is moved by half a slab.
        joint: How much darker the joints are than the slabs.
        spread: Deviation of the slabs' shades.
        grain: Deviation inside a slab.
    """
    y, x = np.mgrid[0:SMALL, 0:SMALL] / SMALL
    row = np.floor(y * rows).astype(int)
    along = x * columns + (0.5 * (row % 2) if stagger else 0.0)
    column = np.floor(along).astype(int) % columns
    shade = rng.normal(0.0, spread, (rows, columns))[row, column]
    warmth = rng.normal(0.0, spread / 3, (rows, columns))[row, column]
    # How far a pixel is from the nearest joint [px].
    across = np.minimum(along % 1.0, 1.0 - along % 1.0) * SMALL / columns
    depth = np.minimum(np.minimum(y * rows % 1.0, 1.0 - y * rows % 1.0) * SMALL / rows, across)
    shade -= joint * np.exp(-((depth / 2.0) ** 2))
    shade += grain * smooth_noise(rng, (SMALL, SMALL), (2.0, 2.0)) + grain * smooth_noise(
        rng, (SMALL, SMALL), (12.0, 12.0)
    )
    return finished(base, shade, warmth)


def draw_cloth(rng: Generator) -> NDArray[np.uint8]:
    """Return a carpet of short loops, RGB (SMALL, SMALL, 3)."""
    y, x = np.mgrid[0:SMALL, 0:SMALL]
    loops = 4.0 * np.sin(x * (np.pi / 4)) * np.sin(y * (np.pi / 4))
    shade = (
        loops
        + 5.0 * smooth_noise(rng, (SMALL, SMALL), (1.0, 1.0))
        + 3.0 * smooth_noise(rng, (SMALL, SMALL), (20.0, 20.0))
    )
    return finished((104.0, 118.0, 134.0), shade, 0.0 * shade)


def draw_screed(rng: Generator) -> NDArray[np.uint8]:
    """Return polished concrete with clouds and a few specks, RGB (SMALL, SMALL, 3)."""
    shape = (SMALL, SMALL)
    clouds = 5.0 * smooth_noise(rng, shape, (60.0, 60.0)) + 2.5 * smooth_noise(rng, shape, (9.0, 9.0))
    specks = -9.0 * (smooth_noise(rng, shape, (1.2, 1.2)) > 2.4)
    return finished((168.0, 168.0, 164.0), clouds + specks + rng.normal(0.0, 1.5, shape), 0.0 * clouds)


def finished(base: tuple[float, float, float], shade: Array, warmth: Array) -> NDArray[np.uint8]:
    """Return the picture of a base colour with shades and warmths, each (rows, columns)."""
    picture = np.array(base) + shade[..., None] * (1.0, 0.98, 0.95) + warmth[..., None] * (1.0, 0.0, -1.0)
    return np.clip(picture, 0, 255).astype(np.uint8)


def write(path: str, picture: NDArray[np.uint8], quality: int) -> None:
    """Write an RGB picture as JPEG below assets."""
    place = Path(__file__).parents[2] / "assets" / path
    place.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(place), cv2.cvtColor(picture, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, quality])


def main() -> None:
    """Write all textures."""
    write("floors/oak.jpg", draw_oak(np.random.default_rng(7)), 88)
    stone = {"base": (176.0, 166.0, 150.0), "rows": 4, "columns": 3, "stagger": True}
    write("floors/stone.jpg", draw_slabs(np.random.default_rng(1), **stone, joint=42, spread=9, grain=3.5), 85)
    tiles = {"base": (206.0, 206.0, 200.0), "rows": 4, "columns": 4, "stagger": False}
    write("floors/tiles.jpg", draw_slabs(np.random.default_rng(2), **tiles, joint=30, spread=3, grain=1.5), 85)
    brick = {"base": (160.0, 110.0, 92.0), "rows": 12, "columns": 4, "stagger": True}
    write("walls/brick.jpg", draw_slabs(np.random.default_rng(3), **brick, joint=-45, spread=10, grain=3.0), 85)
    write("floors/carpet.jpg", draw_cloth(np.random.default_rng(4)), 80)
    write("floors/concrete.jpg", draw_screed(np.random.default_rng(5)), 85)


if __name__ == "__main__":
    main()
