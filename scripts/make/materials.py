#!/usr/bin/env python3
"""Draws the textures of assets/materials, assets/floors and assets/walls; they repeat without a seam.

.venv/bin/python scripts/make/materials.py [NAME ...]

Contrast is low on purpose: pictures on the walls should be the most striking thing that a camera sees. Each has fine
detail, for cameras nearby, and large unevenness, for those far away.
"""

import argparse
import itertools
from functools import partial
from pathlib import PurePosixPath

import cv2
import numpy as np
from numpy.random import Generator
from surface_floors import FLOORS
from surface_noise import (
    Array,
    Drawing,
    Rgb,
    Texture,
    cells,
    cloud_noise,
    finished,
    lit_relief,
    scratches,
    slabs,
    smooth_noise,
    specks,
    write,
)

SIDE = 512
"""Side of a texture [px]."""
LARGE = 768
"""Side of one that covers 2 m and more [px]."""
FINE = 256
"""Side of those in models of furniture [px]."""


def plaster(rng: Generator, *, base: Rgb, side: int, roughness: float, marks: int) -> Texture:
    """Return painted plaster: the grain of the roller, patches of uneven paint, dents and marks of use."""
    grain = cloud_noise(rng, side, slope=0.6, coarsest=side / 24)
    patches = cloud_noise(rng, side, slope=1.3, coarsest=2.0, finest=side / 8)
    shade = lit_relief(grain, deviation=roughness) + 3.0 * patches
    dents = specks(rng, side, count=marks, radius=(1.2, 5.0))
    shade += lit_relief(-cv2.GaussianBlur(np.pad(dents, 4, mode="wrap"), (0, 0), 1.0)[4:-4, 4:-4], deviation=1.6)
    shade -= 52.0 * specks(rng, side, count=marks // 2, radius=(1.0, 3.2))
    shade -= 26.0 * scratches(rng, side, count=marks // 12, length=(20, 120), width=0.8)
    return finished(base, shade, 0.8 * cloud_noise(rng, side, slope=1.6, finest=12))


def _sprig(x: Array, y: Array) -> Array:
    """Return a twig with five pairs of leaves and a bud, 0 to 1; x and y are in sizes of it, from its middle."""
    drawn = np.clip((0.018 - np.abs(x - 0.06 * np.sin(4.0 * y))) * 60.0, 0.0, 1.0) * (np.abs(y) < 0.42)
    for step, side in itertools.product(range(5), (-1.0, 1.0)):
        root, turn = 0.36 - 0.16 * step, side * (0.95 - 0.08 * step)
        dx, dy = x - 0.06 * np.sin(4.0 * root) - 0.12 * side, y - root + 0.07
        along, across = dx * np.sin(turn) - dy * np.cos(turn), dx * np.cos(turn) + dy * np.sin(turn)
        leaf = 1.0 - (along / 0.15) ** 2 - (across / 0.045) ** 2
        vein = np.exp(-((across / 0.008) ** 2))
        drawn = np.maximum(drawn, np.clip(leaf * 3.0, 0.0, 1.0) * (1.0 - 0.5 * vein))
    bud = 1.0 - ((x + 0.06 * np.sin(1.7)) / 0.05) ** 2 - ((y + 0.45) / 0.08) ** 2
    return np.asarray(np.maximum(drawn, np.clip(bud * 3.0, 0.0, 1.0)))


def wallpaper(rng: Generator) -> Texture:
    """Return woven paper with twigs in rows, every other row moved by half a step."""
    y, x = np.mgrid[0:SIDE, 0:SIDE] / SIDE
    ornament = np.zeros((SIDE, SIDE))
    for row, column in itertools.product(range(4), range(4)):
        dx = (x - (column + 0.5 * (row % 2)) / 4.0) % 1.0
        dy = (y - row / 4.0) % 1.0
        ornament = np.maximum(ornament, _sprig(4.0 * (dx - (dx > 0.5)) * (-1.0) ** row, 4.0 * (dy - (dy > 0.5)) * 0.95))
    weave = 1.6 * np.sin(x * SIDE * np.pi / 4.0) + 1.6 * np.sin(y * SIDE * np.pi / 4.0)
    uneven = cloud_noise(rng, SIDE, slope=1.2, finest=60)
    shade = weave - 40.0 * ornament * (1.0 + 0.12 * uneven) + 2.2 * uneven + rng.normal(0.0, 1.5, (SIDE, SIDE))
    return finished((210.0, 208.0, 194.0), shade, 3.0 * ornament)


def _grain(rng: Generator, shape: tuple[int, int], *, rings: float, pores: float) -> Array:
    """Return the grain of wood along the columns: rings that bend about knots' height, and pores, mean 0."""
    bend = smooth_noise(rng, shape, (shape[0] / 8, shape[1] / 4.5))
    drift = smooth_noise(rng, shape, (shape[0] / 40, shape[1] / 10))
    across = np.linspace(0.0, 1.0, shape[0], endpoint=False)[:, None]
    phase = 2.0 * np.pi * rings * across + 2.2 * bend + 0.7 * drift
    ring = np.abs(np.sin(phase / 2.0)) ** 0.6 - 0.75
    fibres = smooth_noise(rng, shape, (0.7, 26.0))
    dark = np.clip(smooth_noise(rng, shape, (0.6, 9.0)) - 1.6, 0.0, None)
    return np.asarray(ring * 17.0 + 3.2 * fibres - pores * dark)


def veneer(rng: Generator, *, base: Rgb, rings: int, pores: float, side: int = SIDE) -> Texture:
    """Return a sheet of wood without joints, for furniture and doors."""
    shade = _grain(rng, (side, side), rings=float(rings), pores=pores)
    shade += 3.5 * smooth_noise(rng, (side, side), (60.0, 30.0))
    return finished(base, shade, 2.0 * smooth_noise(rng, (side, side), (20.0, 90.0)))


def boards(rng: Generator) -> Texture:
    """Return floor boards of pine with dark joints and nails, laid along the columns."""
    count, width = 12, LARGE // 12
    shade, warmth = np.zeros((LARGE, LARGE)), np.zeros((LARGE, LARGE))
    for row in range(count):
        strip = 0.8 * _grain(rng, (width, LARGE), rings=3.0, pores=6.0)
        first = int(rng.integers(0, LARGE))
        ends = [first, first + LARGE // 2 + int(rng.integers(-80, 80))]
        for start, stop in ((ends[0], ends[1]), (ends[1], ends[0] + LARGE)):
            columns = np.arange(start, stop) % LARGE
            strip[:, columns] += rng.normal(0.0, 8.0)
            warmth[row * width : (row + 1) * width, columns] = rng.normal(0.0, 3.0)
            strip[:, columns[:2]] = -70.0
            for nail, at in ((width // 4, 9), (3 * width // 4, 9), (width // 4, -8), (3 * width // 4, -8)):
                strip[nail - 1 : nail + 2, columns[at : at + 3]] = -48.0
        strip[:2] = -78.0 + rng.normal(0.0, 5.0, (2, LARGE))
        shade[row * width : (row + 1) * width] = strip
    shade -= 22.0 * scratches(rng, LARGE, count=30, length=(30, 160), width=0.7, wander=0.03)
    return finished((172.0, 134.0, 92.0), shade + 3.0 * cloud_noise(rng, LARGE, slope=1.4, finest=30), warmth)


def tiles(rng: Generator) -> Texture:
    """Return glazed tiles, 4 by 4, with grey joints that are not everywhere equally dirty."""
    shade, warmth, border = slabs(rng, SIDE, rows=4, columns=4, stagger=False, spread=4.0)
    joint = np.clip((2.6 - border) / 1.2, 0.0, 1.0)
    rim = np.exp(-(((border - 4.5) / 1.6) ** 2))
    dirt = cloud_noise(rng, SIDE, slope=1.0, coarsest=2.0)
    shade += 3.0 * cloud_noise(rng, SIDE, slope=1.2, coarsest=3.0) + 7.0 * rim - joint * (66.0 + 10.0 * dirt)
    shade -= 26.0 * specks(rng, SIDE, count=90, radius=(0.8, 2.2)) * (1.0 - joint)
    return finished((214.0, 212.0, 205.0), shade + rng.normal(0.0, 1.2, shade.shape), warmth)


def carpet(rng: Generator) -> Texture:
    """Return a mottled loop carpet of two yarns."""
    y, x = np.mgrid[0:SIDE, 0:SIDE]
    loops = np.sin(x * (np.pi / 4)) * np.sin(y * (np.pi / 4))
    yarn = np.tanh(1.6 * smooth_noise(rng, (SIDE, SIDE), (1.6, 1.6)))
    worn = cloud_noise(rng, SIDE, slope=1.4, finest=40)
    shade = 7.0 * loops + 15.0 * yarn + 5.0 * worn + 4.0 * rng.normal(size=(SIDE, SIDE))
    shade += 42.0 * specks(rng, SIDE, count=420, radius=(0.9, 2.0))
    return finished((98.0, 106.0, 120.0), shade, 4.0 * yarn)


def brick(rng: Generator) -> Texture:
    """Return bricks in stretcher bond, 12 courses, with light mortar."""
    shade, warmth, border = slabs(rng, SIDE, rows=12, columns=4, stagger=True, spread=11.0)
    rough = cloud_noise(rng, SIDE, slope=0.9, coarsest=4.0)
    mortar = np.clip((2.4 + 0.5 * rough - border) / 1.2, 0.0, 1.0)
    face = shade + lit_relief(rough, deviation=6.0) + 5.0 * rough
    face -= 34.0 * specks(rng, SIDE, count=260, radius=(0.8, 2.8))
    picture = finished((158.0, 98.0, 78.0), face, 0.7 * warmth).astype(float)
    joint = finished((178.0, 172.0, 162.0), lit_relief(cloud_noise(rng, SIDE, slope=0.4), deviation=9.0), 0.0 * rough)
    return (picture + mortar[..., None] * (joint - picture)).astype(np.uint8)


def concrete(rng: Generator) -> Texture:
    """Return exposed concrete: clouds, pores, seams of the formwork and its tie holes."""
    rough = lit_relief(cloud_noise(rng, LARGE, slope=0.8, coarsest=30.0), deviation=2.6)
    shade = (
        rough
        + 5.0 * cloud_noise(rng, LARGE, slope=1.1, coarsest=2.0, finest=90.0)
        + rng.normal(0.0, 1.2, (LARGE, LARGE))
    )
    shade -= 48.0 * specks(rng, LARGE, count=420, radius=(0.8, 3.4))
    shade -= 20.0 * scratches(rng, LARGE, count=5, length=(200, 600), width=0.8, wander=0.16)
    y, x = np.mgrid[0:LARGE, 0:LARGE]
    for line in (y, x):
        shade -= 26.0 * np.exp(-((line - LARGE / 2) ** 2) / 2.0)
    for row in (LARGE // 4, 3 * LARGE // 4):
        for column in (LARGE // 4, 3 * LARGE // 4):
            hole = np.hypot(y - row, x - column)
            shade -= 62.0 * np.clip(6.5 - hole, 0.0, 1.0) - 14.0 * np.exp(-(((hole - 8.0) / 1.5) ** 2))
    return finished((160.0, 159.0, 154.0), shade, 1.4 * cloud_noise(rng, LARGE, slope=1.6, finest=12.0))


def metal(rng: Generator) -> Texture:
    """Return brushed steel with scratches and faint stains, brushed along the columns."""
    brushed = smooth_noise(rng, (SIDE, SIDE), (0.5, 70.0)) + 0.6 * smooth_noise(rng, (SIDE, SIDE), (3.0, 120.0))
    shade = 5.5 * brushed + 5.0 * cloud_noise(rng, SIDE, slope=1.6, finest=24.0)
    shade += 44.0 * scratches(rng, SIDE, count=70, length=(15, 150), width=0.6, wander=0.01)
    shade -= 40.0 * specks(rng, SIDE, count=70, radius=(0.8, 2.4))
    return finished((150.0, 154.0, 158.0), shade, -0.15 * shade)


def terrazzo(rng: Generator) -> Texture:
    """Return polished terrazzo: chips of several stones in grey cement."""
    uneven = 3.0 * cloud_noise(rng, SIDE, slope=1.3) + 2.2 * cloud_noise(rng, SIDE, slope=0.4, coarsest=24.0)
    picture = finished((188.0, 184.0, 176.0), uneven, np.zeros((SIDE, SIDE)))
    stones = np.array([(120, 112, 104), (222, 216, 204), (150, 122, 100), (92, 94, 96), (204, 190, 166)], float)
    for count, share in ((900, 0.30), (5200, 0.34)):
        owner, border = cells(rng, SIDE, count)
        gap = rng.uniform(1.2, 3.0, count)[owner]
        chosen = (rng.random(count) < share)[owner]
        color = stones[rng.integers(0, len(stones), count)] + rng.normal(0.0, 9.0, (count, 1))
        strength = chosen * np.clip(border - gap + 0.5, 0.0, 1.0) * 0.8
        picture = (picture + strength[..., None] * (color[owner] - picture)).astype(np.uint8)
    return picture


def fabric(rng: Generator, *, base: float = 176.0, side: int = SIDE) -> Texture:
    """Return a coarse plain weave for seats and screens, light enough to take a colour."""
    y, x = np.mgrid[0:side, 0:side]
    over = ((x // 4 + y // 4) % 2).astype(float)
    warp = over * np.sin((x % 4 + 0.5) * np.pi / 4) + (1 - over) * np.sin((y % 4 + 0.5) * np.pi / 4)
    threads = np.repeat(rng.normal(0.0, 1.0, side // 4), 4)
    slubs = np.where(over > 0, threads[None, :], np.roll(threads, 40)[:, None])
    mottled = smooth_noise(rng, (side, side), (1.5, 5.0)) + smooth_noise(rng, (side, side), (5.0, 1.5))
    shade = 26.0 * (warp - 0.64) + 5.0 * slubs + 6.0 * mottled + 4.0 * cloud_noise(rng, side, slope=1.5, finest=30)
    shade -= 40.0 * specks(rng, side, count=260, radius=(0.9, 2.0))
    return finished((base, base - 2.0, base - 6.0), shade, 1.5 * mottled)


def ceiling_panels(rng: Generator) -> Texture:
    """Return mineral fibre panels with fissures and pinholes in a grid of white rails, 2 by 2."""
    shade, _, border = slabs(rng, SIDE, rows=2, columns=2, stagger=False, spread=1.6)
    fissures = np.clip(smooth_noise(rng, (SIDE, SIDE), (1.0, 3.2)) - 1.55, 0.0, 0.6)
    face = shade - 150.0 * fissures - 96.0 * specks(rng, SIDE, count=2400, radius=(0.8, 1.7))
    face += 2.0 * cloud_noise(rng, SIDE, slope=1.0, coarsest=2.0)
    rail = np.clip(6.0 - border, 0.0, 1.0)
    shadow = np.exp(-(((border - 7.0) / 1.4) ** 2))
    return finished((232.0, 230.0, 224.0), face * (1.0 - rail) + 6.0 * rail - 52.0 * shadow, 0.0 * shade)


def whiteboard(rng: Generator) -> Texture:
    """Return a white enamel board with faint traces of wiped lines."""
    wiped = smooth_noise(rng, (SIDE, SIDE), (3.0, 40.0)) + cloud_noise(rng, SIDE, slope=1.4, finest=20.0)
    traces = scratches(rng, SIDE, count=60, length=(20, 90), width=0.9, wander=0.22)
    shade = 1.6 * wiped - 30.0 * traces - 20.0 * specks(rng, SIDE, count=50, radius=(0.8, 2.0))
    return finished(
        (238.0, 240.0, 241.0), shade + 2.2 * cloud_noise(rng, SIDE, slope=0.5, coarsest=24.0), -8.0 * traces
    )


def cork(rng: Generator) -> Texture:
    """Return pressed cork: granules of several browns with dark borders."""
    owner, border = cells(rng, SIDE, 5200)
    tone = rng.normal(0.0, 15.0, 5200)[owner]
    shade = tone - 34.0 * np.exp(-(((border) / 0.9) ** 2)) + 4.0 * cloud_noise(rng, SIDE, slope=1.2)
    shade -= 46.0 * specks(rng, SIDE, count=300, radius=(0.8, 2.2))
    return finished((182.0, 138.0, 92.0), shade, 0.2 * tone)


def paper(rng: Generator) -> Texture:
    """Return white paper: fibres and a faint unevenness."""
    fibres = scratches(rng, SIDE, count=700, length=(6, 30), width=0.6, wander=0.25)
    shade = 2.4 * cloud_noise(rng, SIDE, slope=0.9, coarsest=2.0) - 14.0 * fibres + rng.normal(0.0, 1.0, (SIDE, SIDE))
    return finished((236.0, 234.0, 226.0), shade, 0.6 * cloud_noise(rng, SIDE, slope=1.5))


MATERIALS: dict[str, Drawing] = {
    "plaster": Drawing(partial(plaster, base=(233, 228, 218), side=LARGE, roughness=3.4, marks=240), 11, 72),
    "plaster_white": Drawing(partial(plaster, base=(238, 237, 233), side=LARGE, roughness=2.6, marks=160), 12, 72),
    "wallpaper": Drawing(wallpaper, 13, 78),
    "wood": Drawing(partial(veneer, base=(142, 98, 62), rings=7, pores=16.0), 14, 78),
    "oak": Drawing(partial(veneer, base=(198, 166, 122), rings=9, pores=22.0), 15, 78),
    "tiles": Drawing(tiles, 16, 76),
    "carpet": Drawing(carpet, 17, 60),
    "brick": Drawing(brick, 18, 72),
    "concrete": Drawing(concrete, 19, 72),
    "metal": Drawing(metal, 20, 74),
    "boards": Drawing(boards, 21, 70),
    "terrazzo": Drawing(terrazzo, 22, 78),
    "fabric": Drawing(fabric, 23, 62),
    "ceiling_panels": Drawing(ceiling_panels, 24, 74),
    "whiteboard": Drawing(whiteboard, 25, 86),
    "cork": Drawing(cork, 26, 64),
    "paper": Drawing(paper, 27, 74),
}
"""How each material is drawn."""
FURNITURE = {
    "furniture/wood.png": Drawing(partial(veneer, base=(232, 232, 232), rings=6, pores=20.0, side=FINE), 31, 0),
    "furniture/fabric.png": Drawing(partial(fabric, base=214.0, side=FINE), 32, 0),
}
"""Greys of the shipped models of furniture, which multiply the colours of their parts."""


def main() -> None:
    """Write the textures that are named; all by default."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help="of materials or floors; default: all")
    names = set(parser.parse_args().names)
    drawings = {f"materials/{name}.jpg": each for name, each in MATERIALS.items()} | FURNITURE | FLOORS
    for path, drawing in drawings.items():
        if not names or PurePosixPath(path).stem in names:
            write(path, drawing)


if __name__ == "__main__":
    main()
