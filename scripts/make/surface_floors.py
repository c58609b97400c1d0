"""Draws floors of oak, stone, tiles, carpet and concrete, and a wall of bricks, with little contrast."""

import itertools
from functools import partial

import numpy as np
from numpy.random import Generator
from surface_noise import Drawing, Rgb, Texture, finished, slabs, smooth_noise

SIZE = 1024
"""Side of a texture [px]; 2 m of floor."""
SMALL = 512
"""Side of the other textures [px]."""
BOARDS = 10
"""Rows of boards in one tile: 20 cm wide each."""


def draw_oak(rng: Generator) -> Texture:
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
    base: Rgb,
    rows: int,
    columns: int,
    stagger: bool,
    joint: float,
    spread: float,
    grain: float,
) -> Texture:
    """Return slabs laid in rows: flagstones, tiles or bricks, RGB (SMALL, SMALL, 3).

    Args:
        rng: Generator of the shades of the slabs and of their grain.
        base: RGB of the middle slab.
        rows: Number of rows of slabs in one tile of the texture.
        columns: Number of slabs in a row.
        stagger: Whether every other row is moved by half a slab.
        joint: How much darker the joints are than the slabs.
        spread: Deviation of the slabs' shades.
        grain: Deviation inside a slab.
    """
    shade, warmth, depth = slabs(rng, SMALL, rows=rows, columns=columns, stagger=stagger, spread=spread)
    shade -= joint * np.exp(-((depth / 2.0) ** 2))
    shade += grain * smooth_noise(rng, (SMALL, SMALL), (2.0, 2.0)) + grain * smooth_noise(
        rng, (SMALL, SMALL), (12.0, 12.0)
    )
    return finished(base, shade, warmth)


def draw_cloth(rng: Generator) -> Texture:
    """Return a carpet of short loops, RGB (SMALL, SMALL, 3)."""
    y, x = np.mgrid[0:SMALL, 0:SMALL]
    loops = 4.0 * np.sin(x * (np.pi / 4)) * np.sin(y * (np.pi / 4))
    shade = (
        loops
        + 5.0 * smooth_noise(rng, (SMALL, SMALL), (1.0, 1.0))
        + 3.0 * smooth_noise(rng, (SMALL, SMALL), (20.0, 20.0))
    )
    return finished((104.0, 118.0, 134.0), shade, 0.0 * shade)


def draw_screed(rng: Generator) -> Texture:
    """Return polished concrete with clouds and a few specks, RGB (SMALL, SMALL, 3)."""
    shape = (SMALL, SMALL)
    clouds = 5.0 * smooth_noise(rng, shape, (60.0, 60.0)) + 2.5 * smooth_noise(rng, shape, (9.0, 9.0))
    specks = -9.0 * (smooth_noise(rng, shape, (1.2, 1.2)) > 2.4)
    return finished((168.0, 168.0, 164.0), clouds + specks + rng.normal(0.0, 1.5, shape), 0.0 * clouds)


_STONE = {"base": (176.0, 166.0, 150.0), "rows": 4, "columns": 3, "stagger": True, "joint": 42, "spread": 9}
_TILES = {"base": (206.0, 206.0, 200.0), "rows": 4, "columns": 4, "stagger": False, "joint": 30, "spread": 3}
_BRICK = {"base": (160.0, 110.0, 92.0), "rows": 12, "columns": 4, "stagger": True, "joint": -45, "spread": 10}
FLOORS: dict[str, Drawing] = {
    "floors/oak.jpg": Drawing(draw_oak, 7, 88),
    "floors/stone.jpg": Drawing(partial(draw_slabs, **_STONE, grain=3.5), 1, 85),
    "floors/tiles.jpg": Drawing(partial(draw_slabs, **_TILES, grain=1.5), 2, 85),
    "walls/brick.jpg": Drawing(partial(draw_slabs, **_BRICK, grain=3.0), 3, 85),
    "floors/carpet.jpg": Drawing(draw_cloth, 4, 80),
    "floors/concrete.jpg": Drawing(draw_screed, 5, 85),
}
"""How each is drawn."""
