"""The motifs of the posters: outlines in a unit box, x right, y down, the middle at (0, 0), reach about 0.45."""

import numpy as np
from numpy.typing import NDArray

Outline = NDArray[np.float64]
"""Corners of a filled shape, shape (n, 2)."""
Layer = tuple[str, Outline]
"""A tone of the palette (main, dark, light, accent) and what is filled with it, from back to front."""


def poly(*points: tuple[float, float]) -> Outline:
    """Return the polygon through these corners."""
    return np.array(points)


def oval(x: float, y: float, a: float, b: float, turn_deg: float = 0.0) -> Outline:
    """Return an ellipse of half axes a and b."""
    t = np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)
    return np.asarray(_turned(np.stack([a * np.cos(t), b * np.sin(t)], axis=1), turn_deg) + np.array([x, y]))


def disc(x: float, y: float, r: float) -> Outline:
    """Return a circle."""
    return oval(x, y, r, r)


def star(x: float, y: float, points: int, outer: float, inner: float, turn_deg: float = 0.0) -> Outline:
    """Return a star, the first point up."""
    t = np.arange(2 * points) * np.pi / points - np.pi / 2.0
    r = np.where(np.arange(2 * points) % 2 == 0, outer, inner)
    return np.asarray(_turned(np.stack([r * np.cos(t), r * np.sin(t)], axis=1), turn_deg) + np.array([x, y]))


def bar(x1: float, y1: float, x2: float, y2: float, width: float, end: float | None = None) -> Outline:
    """Return a straight bar, of another width at its end when given."""
    start, stop = np.array([x1, y1]), np.array([x2, y2])
    along = (stop - start) / np.linalg.norm(stop - start)
    side = np.array([-along[1], along[0]]) / 2.0
    last = width if end is None else end
    return np.array([start + side * width, stop + side * last, stop - side * last, start - side * width])


def arc(x: float, y: float, r: float, first_deg: float, last_deg: float, width: float) -> Outline:
    """Return a piece of a ring; angles clockwise from the x axis."""
    t = np.radians(np.linspace(first_deg, last_deg, 48))
    circle = np.stack([np.cos(t), np.sin(t)], axis=1)
    return np.asarray(np.concatenate([circle * (r + width / 2), circle[::-1] * (r - width / 2)]) + np.array([x, y]))


def pie(x: float, y: float, r: float, first_deg: float, last_deg: float) -> Outline:
    """Return the segment of a disc between two angles, closed by its chord."""
    t = np.radians(np.linspace(first_deg, last_deg, 48))
    return np.stack([np.cos(t), np.sin(t)], axis=1) * r + (x, y)


def _turned(points: Outline, turn_deg: float) -> Outline:
    c, s = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))
    return np.asarray(points @ np.array([[c, s], [-s, c]]))


def eyes(y: float, apart: float, r: float) -> list[Layer]:
    """Return a pair of eyes."""
    return [
        layer
        for x in (-apart, apart)
        for layer in (("light", disc(x, y, r)), ("dark", disc(x + 0.15 * r, y + 0.1 * r, 0.6 * r)))
    ]


CREATURES: dict[str, list[Layer]] = {
    "lion": [
        ("accent", star(0, 0, 17, 0.48, 0.36)),
        ("main", disc(-0.22, -0.24, 0.09)),
        ("main", disc(0.22, -0.24, 0.09)),
        ("main", oval(0, 0.02, 0.29, 0.3)),
        *eyes(-0.06, 0.12, 0.06),
        ("light", oval(0, 0.18, 0.15, 0.11)),
        ("dark", poly((-0.07, 0.07), (0.07, 0.07), (0, 0.16))),
        ("dark", arc(0, 0.16, 0.08, 20, 160, 0.03)),
    ],
    "owl": [
        ("main", oval(0, 0.06, 0.32, 0.4)),
        ("main", poly((-0.3, -0.42), (-0.04, -0.28), (-0.28, -0.08))),
        ("main", poly((0.3, -0.42), (0.04, -0.28), (0.28, -0.08))),
        ("dark", oval(-0.27, 0.12, 0.09, 0.26, 12)),
        ("dark", oval(0.27, 0.12, 0.09, 0.26, -12)),
        *eyes(-0.13, 0.14, 0.14),
        ("accent", poly((-0.06, -0.04), (0.06, -0.04), (0, 0.1))),
        ("accent", oval(0, 0.27, 0.15, 0.14)),
    ],
    "cat": [
        ("dark", poly((-0.4, -0.45), (-0.08, -0.27), (-0.36, 0.02))),
        ("dark", poly((0.4, -0.45), (0.08, -0.27), (0.36, 0.02))),
        ("dark", oval(0, 0.06, 0.4, 0.36)),
        ("accent", oval(-0.16, 0.0, 0.11, 0.09, 20)),
        ("accent", oval(0.16, 0.0, 0.11, 0.09, -20)),
        ("dark", oval(-0.16, 0.0, 0.03, 0.09)),
        ("dark", oval(0.16, 0.0, 0.03, 0.09)),
        ("light", oval(0, 0.23, 0.16, 0.1)),
        ("main", poly((-0.06, 0.13), (0.06, 0.13), (0, 0.21))),
        *(("light", bar(s * 0.14, 0.22, s * 0.46, y, 0.02)) for s in (-1, 1) for y in (0.12, 0.22, 0.32)),
    ],
    "fish": [
        ("accent", poly((0.2, 0), (0.46, -0.26), (0.38, 0), (0.46, 0.26))),
        ("accent", poly((-0.12, -0.2), (0.12, -0.38), (0.16, -0.12))),
        ("main", oval(-0.06, 0, 0.36, 0.24)),
        ("light", pie(-0.06, 0, 0.24, 20, 160)),
        ("dark", arc(-0.42, 0, 0.26, -45, 45, 0.03)),
        ("light", disc(-0.28, -0.06, 0.06)),
        ("dark", disc(-0.29, -0.06, 0.035)),
        ("accent", poly((0.0, 0.0), (0.2, 0.08), (0.02, 0.16))),
    ],
    "whale": [
        ("main", oval(-0.08, 0.08, 0.34, 0.24)),
        ("main", bar(0.1, 0.1, 0.38, -0.1, 0.3, 0.08)),
        ("main", poly((0.34, -0.06), (0.28, -0.3), (0.38, -0.2), (0.48, -0.3), (0.44, -0.02))),
        ("light", pie(-0.08, 0.1, 0.22, 15, 170)),
        ("dark", disc(-0.28, 0.04, 0.035)),
        ("accent", arc(-0.22, -0.3, 0.1, 180, 360, 0.05)),
        ("accent", arc(-0.02, -0.3, 0.1, 180, 360, 0.05)),
        ("accent", bar(-0.12, -0.14, -0.12, -0.32, 0.05)),
    ],
    "snail": [
        ("main", poly((-0.44, 0.3), (-0.36, 0.2), (-0.3, -0.12), (-0.2, -0.12), (-0.16, 0.16), (0.44, 0.3))),
        ("main", bar(-0.28, -0.1, -0.38, -0.32, 0.03)),
        ("main", bar(-0.22, -0.1, -0.2, -0.34, 0.03)),
        ("dark", disc(-0.38, -0.33, 0.04)),
        ("dark", disc(-0.2, -0.35, 0.04)),
        ("accent", disc(0.1, 0, 0.27)),
        ("light", disc(0.08, 0.02, 0.2)),
        ("dark", disc(0.1, 0.03, 0.14)),
        ("accent", disc(0.09, 0.05, 0.08)),
    ],
    "butterfly": [
        ("main", oval(-0.24, -0.16, 0.22, 0.2, 30)),
        ("main", oval(0.24, -0.16, 0.22, 0.2, -30)),
        ("accent", oval(-0.18, 0.2, 0.16, 0.2, 30)),
        ("accent", oval(0.18, 0.2, 0.16, 0.2, -30)),
        *(("light", disc(s * 0.27, -0.18, 0.1)) for s in (-1, 1)),
        *(("dark", disc(s * 0.27, -0.18, 0.05)) for s in (-1, 1)),
        *(("dark", disc(s * 0.19, 0.22, 0.07)) for s in (-1, 1)),
        ("dark", oval(0, 0.02, 0.045, 0.3)),
        *(("dark", bar(0, -0.24, s * 0.12, -0.44, 0.025)) for s in (-1, 1)),
    ],
    "penguin": [
        ("dark", oval(0, 0.02, 0.28, 0.44)),
        ("dark", oval(-0.29, 0.06, 0.07, 0.24, 18)),
        ("dark", oval(0.29, 0.06, 0.07, 0.24, -18)),
        ("light", oval(0, 0.12, 0.2, 0.31)),
        *eyes(-0.24, 0.09, 0.06),
        ("accent", poly((-0.07, -0.2), (0.07, -0.2), (0, -0.08))),
        ("accent", oval(-0.12, 0.44, 0.11, 0.05)),
        ("accent", oval(0.12, 0.44, 0.11, 0.05)),
    ],
    "ladybird": [
        ("dark", disc(0, -0.27, 0.17)),
        *(("dark", bar(0, y, s * 0.47, y + s * 0.03, 0.04)) for s in (-1, 1) for y in (-0.1, 0.1, 0.28)),
        ("main", oval(0, 0.08, 0.36, 0.36)),
        ("dark", bar(0, -0.28, 0, 0.45, 0.03)),
        *(
            ("dark", disc(x, y, r))
            for x, y, r in ((-0.17, -0.07, 0.08), (0.2, 0.0, 0.07), (-0.2, 0.2, 0.06), (0.14, 0.26, 0.09))
        ),
        ("light", disc(-0.08, -0.33, 0.04)),
        ("light", disc(0.08, -0.33, 0.04)),
    ],
}

PLANTS: dict[str, list[Layer]] = {
    "pine": [
        ("dark", bar(0, 0.2, 0, 0.46, 0.12)),
        ("main", poly((0, -0.1), (0.38, 0.34), (-0.38, 0.34))),
        ("light", poly((0, -0.26), (0.3, 0.12), (-0.3, 0.12))),
        ("main", poly((0, -0.46), (0.22, -0.1), (-0.22, -0.1))),
        *(("accent", disc(x, y, 0.04)) for x, y in ((-0.14, 0.24), (0.12, 0.2), (0.0, 0.02), (0.05, -0.2))),
    ],
    "cactus": [
        ("accent", poly((-0.22, 0.24), (0.22, 0.24), (0.16, 0.46), (-0.16, 0.46))),
        ("main", oval(0, -0.06, 0.12, 0.36)),
        ("main", bar(0, 0.08, -0.3, 0.08, 0.1)),
        ("main", oval(-0.3, -0.02, 0.07, 0.17)),
        ("main", bar(0, -0.06, 0.28, -0.06, 0.1)),
        ("main", oval(0.28, -0.16, 0.07, 0.17)),
        ("dark", bar(-0.04, -0.32, -0.04, 0.22, 0.02)),
        ("dark", bar(0.04, -0.32, 0.04, 0.22, 0.02)),
        ("light", star(0, -0.42, 6, 0.1, 0.04)),
    ],
    "mushroom": [
        ("light", bar(0, -0.02, 0, 0.44, 0.2, 0.3)),
        ("main", pie(0, 0.04, 0.46, 180, 360)),
        ("dark", oval(0, 0.04, 0.46, 0.07)),
        *(
            ("light", disc(x, y, r))
            for x, y, r in ((-0.24, -0.14, 0.08), (0.04, -0.27, 0.09), (0.28, -0.12, 0.06), (-0.02, -0.1, 0.05))
        ),
        ("accent", poly((-0.44, 0.46), (-0.3, 0.24), (-0.2, 0.46))),
    ],
    "daisy": [
        ("dark", bar(0, 0.1, 0.06, 0.48, 0.05)),
        ("accent", oval(0.18, 0.36, 0.14, 0.06, -30)),
        *(
            ("light" if k % 2 else "main", oval(0.24 * np.sin(t), -0.1 - 0.24 * np.cos(t), 0.07, 0.14, np.degrees(t)))
            for k, t in enumerate(np.arange(10) * np.pi / 5)
        ),
        ("accent", disc(0, -0.1, 0.14)),
        ("dark", disc(0.02, -0.08, 0.07)),
    ],
    "tulip": [
        ("dark", bar(0, 0.0, 0, 0.48, 0.05)),
        ("accent", oval(-0.16, 0.28, 0.07, 0.22, -30)),
        ("accent", oval(0.16, 0.32, 0.07, 0.2, 30)),
        ("main", pie(0, -0.12, 0.28, 0, 180)),
        ("main", poly((-0.28, -0.1), (-0.26, -0.46), (-0.08, -0.12))),
        ("main", poly((0.28, -0.1), (0.26, -0.46), (0.08, -0.12))),
        ("light", poly((-0.16, -0.1), (0, -0.46), (0.16, -0.1), (0, 0.12))),
    ],
    "pear": [
        ("main", oval(0, 0.16, 0.32, 0.3)),
        ("main", oval(0, -0.14, 0.17, 0.24)),
        ("light", oval(-0.12, 0.14, 0.1, 0.16, 20)),
        ("dark", bar(0, -0.34, 0.05, -0.48, 0.04)),
        ("accent", oval(0.17, -0.4, 0.14, 0.06, -20)),
    ],
    "cherries": [
        ("dark", bar(-0.2, 0.1, 0.06, -0.42, 0.03)),
        ("dark", bar(0.22, 0.16, 0.06, -0.42, 0.03)),
        ("accent", oval(0.24, -0.38, 0.2, 0.08, 12)),
        ("main", disc(-0.22, 0.2, 0.2)),
        ("main", disc(0.24, 0.26, 0.18)),
        ("light", oval(-0.28, 0.14, 0.05, 0.08, 30)),
        ("light", oval(0.19, 0.2, 0.05, 0.07, 30)),
    ],
}

SKIES: dict[str, list[Layer]] = {
    "sunrise": [
        ("accent", star(0, 0.12, 14, 0.5, 0.32)),
        ("main", disc(0, 0.12, 0.28)),
        ("dark", poly((-0.5, 0.2), (0.5, 0.14), (0.5, 0.48), (-0.5, 0.48))),
        ("light", bar(-0.4, 0.3, 0.2, 0.28, 0.03)),
        ("light", bar(-0.1, 0.4, 0.42, 0.36, 0.03)),
    ],
    "moon": [
        ("light", disc(-0.06, 0, 0.4)),
        ("dark", disc(0.14, -0.08, 0.33)),
        ("accent", star(0.2, -0.12, 5, 0.15, 0.06)),
        ("main", star(0.38, 0.22, 5, 0.1, 0.04)),
        ("main", star(0.02, -0.02, 5, 0.06, 0.025)),
    ],
    "comet": [
        ("accent", poly((-0.16, 0.0), (0.46, -0.44), (0.04, 0.14))),
        ("light", poly((-0.18, 0.08), (0.34, -0.2), (-0.04, 0.22))),
        ("main", star(-0.2, 0.2, 8, 0.27, 0.16)),
        ("light", disc(-0.2, 0.2, 0.09)),
    ],
    "volcano": [
        ("dark", poly((-0.14, -0.1), (0.14, -0.1), (0.46, 0.46), (-0.46, 0.46))),
        (
            "main",
            poly((-0.14, -0.1), (0.14, -0.1), (0.2, 0.24), (0.06, 0.06), (0.0, 0.32), (-0.08, 0.06), (-0.16, 0.14)),
        ),
        ("accent", star(0, -0.26, 7, 0.22, 0.1)),
        ("light", star(0, -0.26, 7, 0.1, 0.05, 20)),
    ],
    "alps": [
        ("dark", poly((-0.5, 0.36), (-0.18, -0.3), (0.14, 0.36))),
        ("main", poly((-0.14, 0.36), (0.2, -0.44), (0.5, 0.36))),
        ("light", poly((0.1, -0.2), (0.2, -0.44), (0.3, -0.18), (0.23, -0.25), (0.19, -0.12), (0.15, -0.24))),
        ("light", poly((-0.26, -0.13), (-0.18, -0.3), (-0.1, -0.13), (-0.17, -0.19))),
        ("accent", disc(-0.34, -0.34, 0.11)),
        ("accent", poly((-0.5, 0.34), (0.5, 0.3), (0.5, 0.46), (-0.5, 0.46))),
    ],
    "thunder": [
        *(("dark", disc(x, y, r)) for x, y, r in ((-0.22, -0.2, 0.19), (0.04, -0.27, 0.2), (0.26, -0.18, 0.17))),
        (
            "accent",
            poly((0.02, -0.16), (0.2, -0.16), (0.1, 0.08), (0.24, 0.08), (-0.12, 0.48), (-0.02, 0.18), (-0.14, 0.18)),
        ),
        *(("light", bar(x, 0.1, x - 0.06, 0.26, 0.03)) for x in (-0.3, -0.2, 0.32)),
    ],
    "balloon": [
        ("main", disc(0, -0.14, 0.33)),
        ("main", poly((-0.28, 0.04), (0.28, 0.04), (0.09, 0.28), (-0.09, 0.28))),
        ("accent", oval(0, -0.1, 0.18, 0.36)),
        ("light", oval(0, -0.1, 0.07, 0.37)),
        ("dark", bar(-0.08, 0.26, -0.06, 0.36, 0.02)),
        ("dark", bar(0.08, 0.26, 0.06, 0.36, 0.02)),
        ("dark", poly((-0.1, 0.34), (0.1, 0.34), (0.07, 0.47), (-0.07, 0.47))),
    ],
    "kite": [
        ("main", poly((0.08, -0.46), (0.36, -0.16), (0.0, 0.24), (-0.22, -0.2))),
        ("light", poly((0.08, -0.46), (0.36, -0.16), (0.06, -0.18))),
        ("accent", poly((0.06, -0.18), (0.0, 0.24), (-0.22, -0.2))),
        ("dark", bar(0.0, 0.24, -0.2, 0.46, 0.03)),
        ("accent", poly((-0.06, 0.22), (-0.06, 0.4), (-0.16, 0.3))),
        ("main", poly((-0.2, 0.36), (-0.06, 0.42), (-0.16, 0.5))),
    ],
}

THINGS: dict[str, list[Layer]] = {
    "harbour": [
        ("light", poly((-0.02, -0.46), (-0.02, 0.14), (-0.4, 0.14))),
        ("accent", poly((0.04, -0.34), (0.04, 0.14), (0.36, 0.14))),
        ("dark", bar(0.01, -0.48, 0.01, 0.24, 0.03)),
        ("main", poly((-0.44, 0.2), (0.44, 0.2), (0.28, 0.42), (-0.3, 0.42))),
        ("dark", poly((-0.5, 0.4), (-0.25, 0.34), (0, 0.4), (0.25, 0.34), (0.5, 0.4), (0.5, 0.5), (-0.5, 0.5))),
    ],
    "lighthouse": [
        ("accent", poly((-0.06, -0.32), (-0.5, -0.46), (-0.5, -0.16))),
        ("accent", poly((0.06, -0.32), (0.5, -0.46), (0.5, -0.16))),
        ("light", bar(0, -0.22, 0, 0.42, 0.18, 0.34)),
        ("main", bar(0, -0.1, 0, 0.06, 0.2, 0.25)),
        ("main", bar(0, 0.2, 0, 0.34, 0.28, 0.32)),
        ("dark", bar(-0.14, -0.22, 0.14, -0.22, 0.04)),
        ("light", bar(0, -0.4, 0, -0.24, 0.12)),
        ("main", poly((-0.11, -0.38), (0, -0.49), (0.11, -0.38))),
        ("dark", poly((-0.42, 0.48), (-0.3, 0.38), (0.34, 0.38), (0.44, 0.48))),
    ],
    "rocket": [
        ("accent", poly((-0.1, 0.24), (0.1, 0.24), (0.04, 0.38), (0, 0.5), (-0.05, 0.38))),
        ("dark", poly((-0.12, 0.02), (-0.3, 0.3), (-0.1, 0.24))),
        ("dark", poly((0.12, 0.02), (0.3, 0.3), (0.1, 0.24))),
        ("main", oval(0, -0.1, 0.16, 0.38)),
        ("light", disc(0, -0.16, 0.09)),
        ("dark", disc(0, -0.16, 0.055)),
        ("light", bar(-0.13, 0.1, 0.13, 0.1, 0.04)),
    ],
    "teapot": [
        ("dark", arc(0.32, 0.06, 0.14, -100, 110, 0.06)),
        ("accent", poly((-0.24, 0.02), (-0.46, -0.2), (-0.36, -0.2), (-0.22, 0.22))),
        ("main", oval(0, 0.1, 0.33, 0.28)),
        ("light", oval(0, -0.16, 0.2, 0.08)),
        ("dark", disc(0, -0.27, 0.05)),
        ("light", star(0, 0.1, 6, 0.17, 0.08)),
        ("dark", bar(-0.22, 0.38, 0.22, 0.38, 0.05)),
    ],
    "umbrella": [
        ("main", pie(0, 0.04, 0.46, 180, 360)),
        ("accent", pie(0, 0.04, 0.46, 225, 270)),
        ("light", poly((0, 0.04), (0, -0.42), (0.16, -0.39), (0.3, 0.04))),
        ("dark", bar(0, -0.48, 0, 0.36, 0.035)),
        ("dark", arc(0.09, 0.36, 0.09, 0, 180, 0.035)),
    ],
    "key": [
        ("main", disc(-0.2, -0.2, 0.25)),
        ("dark", disc(-0.2, -0.2, 0.13)),
        ("main", bar(-0.06, -0.06, 0.38, 0.38, 0.1)),
        ("accent", bar(0.2, 0.2, 0.36, 0.04, 0.09)),
        ("accent", bar(0.32, 0.34, 0.46, 0.2, 0.09)),
        ("light", arc(-0.2, -0.2, 0.19, 150, 290, 0.03)),
    ],
    "anchor": [
        ("accent", arc(0, -0.34, 0.09, 0, 360, 0.05)),
        ("main", bar(0, -0.26, 0, 0.38, 0.09)),
        ("main", bar(-0.22, -0.16, 0.22, -0.16, 0.08)),
        ("main", arc(0, 0.08, 0.32, 10, 170, 0.09)),
        ("light", poly((-0.46, 0.18), (-0.32, -0.06), (-0.22, 0.16))),
        ("light", poly((0.46, 0.18), (0.32, -0.06), (0.22, 0.16))),
    ],
    "castle": [
        ("main", poly((-0.3, -0.06), (0.3, -0.06), (0.3, 0.44), (-0.3, 0.44))),
        ("light", bar(-0.32, -0.2, -0.32, 0.44, 0.2)),
        ("light", bar(0.32, -0.14, 0.32, 0.44, 0.2)),
        ("accent", poly((-0.46, -0.18), (-0.32, -0.46), (-0.18, -0.18))),
        ("accent", poly((0.18, -0.12), (0.32, -0.38), (0.46, -0.12))),
        *(("main", bar(x, -0.14, x, -0.04, 0.08)) for x in (-0.14, 0.0, 0.14)),
        ("dark", disc(0, 0.22, 0.1)),
        ("dark", bar(0, 0.22, 0, 0.44, 0.2)),
        ("dark", bar(-0.32, -0.06, -0.32, 0.06, 0.06)),
        ("dark", bar(0.32, 0.06, 0.32, 0.18, 0.06)),
    ],
    "guitar": [
        ("main", disc(-0.14, 0.24, 0.22)),
        ("main", disc(0.0, 0.06, 0.16)),
        ("dark", bar(0.0, 0.08, 0.3, -0.34, 0.07)),
        ("accent", bar(0.28, -0.3, 0.4, -0.48, 0.12)),
        ("light", disc(-0.05, 0.13, 0.08)),
        ("dark", disc(-0.05, 0.13, 0.05)),
        ("accent", bar(-0.27, 0.25, -0.13, 0.35, 0.04)),
    ],
    "windmill": [
        ("light", bar(0, -0.1, 0, 0.46, 0.16, 0.32)),
        ("dark", bar(0, 0.32, 0, 0.46, 0.1)),
        ("accent", poly((-0.1, -0.1), (0, -0.24), (0.1, -0.1))),
        *(
            ("main", bar(0, -0.1, 0.4 * np.cos(t), -0.1 + 0.4 * np.sin(t), 0.04, 0.14))
            for t in np.radians([35, 125, 215, 305])
        ),
        ("dark", disc(0, -0.1, 0.05)),
    ],
    "hourglass": [
        ("main", poly((-0.26, -0.38), (0.26, -0.38), (0.03, 0), (0.26, 0.38), (-0.26, 0.38), (-0.03, 0))),
        ("light", poly((-0.16, -0.22), (0.16, -0.22), (0, 0.02))),
        ("accent", poly((-0.2, 0.38), (0, 0.14), (0.2, 0.38))),
        ("dark", bar(-0.34, -0.42, 0.34, -0.42, 0.09)),
        ("dark", bar(-0.34, 0.42, 0.34, 0.42, 0.09)),
    ],
    "crown": [
        ("main", poly((-0.4, 0.3), (-0.46, -0.24), (-0.2, 0.0), (0, -0.38), (0.2, 0.0), (0.46, -0.24), (0.4, 0.3))),
        ("dark", bar(-0.4, 0.3, 0.4, 0.3, 0.12)),
        *(("accent", disc(x, y, 0.06)) for x, y in ((-0.45, -0.26), (0.0, -0.4), (0.45, -0.26))),
        *(("light", disc(x, 0.12, 0.06)) for x in (-0.24, 0.0, 0.24)),
    ],
}

MOTIFS: dict[str, list[Layer]] = CREATURES | PLANTS | SKIES | THINGS
"""Motif by name, in the order of drawing."""
