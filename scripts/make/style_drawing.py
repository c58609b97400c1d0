"""Strokes of which the small things of rooms are drawn: boxes, frames, uneven colours and lines of text."""

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

Picture = NDArray[np.uint8]
Rgb = tuple[int, int, int]


def blank(width: int, height: int, color: Rgb) -> Picture:
    """Return a picture of one colour."""
    return np.full((height, width, 3), color, dtype=np.uint8)


def box(picture: Picture, x: float, y: float, width: float, height: float, color: Rgb) -> None:
    """Fill a rectangle [px]."""
    cv2.rectangle(picture, (round(x), round(y)), (round(x + width) - 1, round(y + height) - 1), color, -1)


def framed(picture: Picture, width: int, color: Rgb) -> Picture:
    """Return a picture with a frame drawn over its edge, lit from above."""
    height, across = picture.shape[:2]
    cv2.rectangle(picture, (0, 0), (across - 1, height - 1), color, 2 * width - 1)
    lighter, darker = (tuple(int(min(c * f, 255)) for c in color) for f in (1.25, 0.6))
    cv2.line(picture, (0, 0), (across, 0), lighter, 1)
    cv2.rectangle(picture, (width, width), (across - width - 1, height - width - 1), darker, 1)
    return picture


def shade(rng: Generator, color: Rgb, spread: float) -> Rgb:
    """Return a colour a little lighter or darker."""
    return tuple(int(v) for v in np.clip(np.array(color) * rng.normal(1.0, spread), 0, 255))  # type: ignore[return-value]


def clouds(rng: Generator, width: int, height: int, cell: int) -> NDArray[np.float32]:
    """Return smooth noise around 0 with a deviation of about 1, shape (height, width)."""
    coarse = rng.normal(size=(height // cell + 2, width // cell + 2)).astype(np.float32)
    return cv2.resize(coarse, (width, height), interpolation=cv2.INTER_CUBIC)


def grained(rng: Generator, picture: Picture, amount: float) -> Picture:
    """Return a picture with fine and coarse unevenness [grey levels]."""
    height, width = picture.shape[:2]
    noise = rng.normal(size=(height, width)) + clouds(rng, width, height, 12)
    return np.clip(picture + (amount * noise)[..., None], 0, 255).astype(np.uint8)


def lines_of_text(rng: Generator, picture: Picture, area: tuple[int, int, int, int], *, step: int, ink: Rgb) -> None:
    """Write lines of words as they look from afar into x, y, width, height [px]."""
    left, top, width, height = area
    for y in range(top, top + height - step // 2, step):
        x, end = left, left + width * rng.uniform(0.6, 1.0)
        while x < end:
            word = rng.uniform(1.5, 6.0) * step / 2
            box(picture, x, y, min(word, left + width - x), max(step // 3, 1), shade(rng, ink, 0.15))
            x += word + step * 0.5
