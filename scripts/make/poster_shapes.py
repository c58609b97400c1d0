"""Shapes of which the posters' motifs are made: outlines in a unit box, x right, y down, the middle at (0, 0)."""

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
