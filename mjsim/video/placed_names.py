"""Places names on a sheet of paper: beside their objects, over as little ink as possible, never over each other."""

from collections.abc import Sequence

import cv2
import numpy as np

from mjsim.geometry import Array
from mjsim.plan import Rgb, Words, blend, color
from mjsim.video.ink import INK, MUTED, PAPER
from mjsim.video.paper import Paper

MAX_NAMES = 1000
"""With more objects than this, the plan is drawn without names, which would be unreadable."""
NAME_DISTANCES = (0.9, 2.0, 3.5, 6.0, 9.0)
"""Possible distances of a name from the named point [mm]; for the last two, a hairline connects them."""
LED = 5.0
FAINT = blend(MUTED, PAPER, 0.4)
NAME_ANGLES = (0, 30, -30, 60, -60, 90, -90, 135, -135, 180)
"""Angles relative to the preferred side at which a name may be placed [deg]."""
MAX_DARK_LEVEL = 150
"""Pixels darker than this should not be covered."""
COVER_COST = 4.0
"""Cost of covering all of it; another side or distance costs 0.02 to 0.2."""


def write_words(drawing: Paper, words: Sequence[Words]) -> list[Array]:
    """Write names in order of priority; a name without a free position is left out.

    Returns:
        The boxes of the written names, minimum and maximum of (x, y), shape (2, 2) each [px].
    """
    ink = np.asarray(cv2.integral((drawing.image.min(axis=-1) < MAX_DARK_LEVEL).astype(np.uint8)), dtype=float)
    boxes: list[Array] = []
    for each in words:
        places, costs = _places(drawing, each, size_of(drawing, each))
        costs = costs + _covered(places, ink, boxes, spacing=0.3 * drawing.density)
        best = int(np.argmin(costs))
        if np.isfinite(costs[best]):
            _write(drawing, each, places[best])
            boxes.append(places[best])
    return boxes


def _places(drawing: Paper, name: Words, size: Array) -> tuple[Array, Array]:
    """Return the candidate boxes of a name, shape (n, 2, 2) [px], and the cost of each."""
    at, half, reach = drawing.view.pixels(name.at), size / 2, _reach(drawing, name)
    fits = name.inside and size[0] < 2 * reach[0] and 3.0 * drawing.density < 2 * reach[1]
    right_on = [(at, 0.0)] if fits or not name.side.any() else []
    side = np.array([name.side[0], -name.side[1]]) if name.side.any() else np.array([0.0, 1.0])
    around = []
    for rank, away in enumerate(NAME_DISTANCES):
        for turn in NAME_ANGLES:
            c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
            toward = np.array([c * side[0] - s * side[1], s * side[0] + c * side[1]])
            # Far enough for the name to be beside the object, or above or below it.
            distance = np.min((reach + away * drawing.density + half) / np.maximum(np.abs(toward), 1e-9))
            around.append((at + toward * distance, 0.02 * rank + 0.0006 * abs(turn)))
    middles = np.array([middle for middle, _ in right_on + around])
    boxes = np.stack([middles - half, middles + half], axis=1)
    return boxes, np.array([cost for _, cost in right_on + around])


def _covered(places: Array, ink: Array, taken: Sequence[Array], *, spacing: float) -> Array:
    """Return the cost of covering the ink under boxes; infinite over another name or outside the sheet."""
    height, width = ink.shape[0] - 1, ink.shape[1] - 1
    rejected = (places[:, 0] < 0).any(axis=1) | (places[:, 1] > (width, height)).any(axis=1)
    low = np.clip(np.floor(places[:, 0]), 0, (width, height)).astype(int)
    high = np.clip(np.ceil(places[:, 1]), 0, (width, height)).astype(int)
    (x0, y0), (x1, y1) = low.T, high.T
    dark = ink[y1, x1] - ink[y0, x1] - ink[y1, x0] + ink[y0, x0]
    share = COVER_COST * dark / np.prod(places[:, 1] - places[:, 0], axis=1)
    if taken:
        low_others, high_others = np.array(taken).transpose(1, 0, 2)
        overlap = np.minimum(places[:, None, 1], high_others) - np.maximum(places[:, None, 0], low_others)
        rejected = rejected | (overlap > -spacing).all(axis=-1).any(axis=1)
    return np.where(rejected, np.inf, share)


def _write(drawing: Paper, name: Words, box: Array) -> None:
    at, reach = drawing.view.pixels(name.at), _reach(drawing, name)
    last = np.clip(at, box[0], box[1])
    first = np.clip(last, at - reach, at + reach)
    if np.hypot(*(last - first)) > LED * drawing.density:
        drawing.line(drawing.view.world(0.9 * np.stack([first, last]) + 0.1 * np.stack([last, first])), FAINT, 0.12)
    size = round(name.size * drawing.density)
    x, y = (box[0, 0] + box[1, 0]) / 2, box[1, 1] - 0.2 * size
    drawing.letters.write(drawing.image, name.text, (x, y), size, _shade(name), align=0.5)


def size_of(drawing: Paper, name: Words) -> Array:
    """Return width and height of a name, shape (2,) [px]."""
    size = name.size * drawing.density
    return np.array([drawing.letters.width(name.text, round(size)), size])


def _reach(drawing: Paper, name: Words) -> Array:
    return np.array(name.reach) * drawing.view.scale + name.gap * drawing.density


def _shade(name: Words) -> Rgb:
    """Return the colour of a name, dark enough to be read."""
    return color(name.ink) if name.ink in ("ink", "muted") else blend(color(name.ink), INK, 0.5)
