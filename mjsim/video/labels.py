"""Places names on a plan so that they do not overlap."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mjsim.geometry import Array
from mjsim.interface import Picture
from mjsim.video.ink import Color, Letters


@dataclass(frozen=True, slots=True, eq=False)
class Label:
    """A name to write near a point."""

    text: str
    at: Array
    """The labelled point, shape (2,) [px]."""
    side: Array
    """Preferred side, a unit vector in the picture; zeros for centred on the point."""
    size: int
    """Height of the font [px]."""
    color: Color


def place_labels(image: Picture, labels: Sequence[Label], letters: Letters, taken: Sequence[Array]) -> list[Array]:
    """Write each name where it covers the least of what is already drawn.

    Args:
        image: Picture to write into.
        labels: The names, in order of priority.
        letters: The font.
        taken: Boxes to keep free, minimum and maximum of (x, y), shape (2, 2) each [px].

    Returns:
        The boxes of the names in the order of `labels`, shape (2, 2) each [px].
    """
    boxes = list(taken)
    for label in labels:
        size = np.array([letters.width(label.text, label.size), label.size])
        places = [_box(label, size, away, turn) for away in (8, 14, 22, 32) for turn in (0, 35, -35, 70, -70)]
        obstacles = np.array(boxes).reshape(-1, 2, 2)
        limits = np.array([[2.0, 2.0], [image.shape[1] - 2.0, image.shape[0] - 2.0]])
        costs = [_covered(place, obstacles, limits) + 0.01 * rank for rank, place in enumerate(places)]
        best = places[int(np.argmin(costs))]
        letters.write(image, label.text, (best[0, 0], best[1, 1] - 0.2 * label.size), label.size, label.color)
        boxes.append(best)
    return boxes[len(taken) :]


def _box(label: Label, size: Array, away: float, turn: float) -> Array:
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    side = np.array([[c, -s], [s, c]]) @ label.side
    if not side.any():
        side, away = np.array([s, 0.0 if turn == 0 else c]), away if turn else 0.0
    # The box touches a circle of radius `away` around the point on the given side.
    middle = label.at + side * away + np.sign(np.round(side, 2)) * np.abs(side) * size / 2
    return np.stack([middle - size / 2, middle + size / 2])


def _covered(box: Array, obstacles: Array, limits: Array) -> float:
    overlap = np.minimum(box[1], obstacles[:, 1]) - np.maximum(box[0], obstacles[:, 0])
    outside = np.maximum(limits[0] - box[0], 0.0).sum() + np.maximum(box[1] - limits[1], 0.0).sum()
    return float(np.prod(np.maximum(overlap, 0.0), axis=1).sum() + 100.0 * outside)
