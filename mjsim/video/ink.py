"""Colours, lines and text in pictures; colours are RGB."""

from collections.abc import Callable, Sequence
from itertools import accumulate, pairwise
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from mjsim.errors import UsageError
from mjsim.interface import Picture
from mjsim.output import write_file
from mjsim.plan import Rgb, color
from mjsim.sentences import Sentence

TRUTH, ESTIMATE, ODOMETRY = color("truth"), color("estimate"), color("odometry")
BEACON, SEEN, SCANNED, BUMP = color("beacon"), color("seen"), color("scanned"), color("bump")
INK, MUTED, PAPER = color("ink"), color("muted"), color("paper")
HAIR: Rgb = (224, 222, 216)
PAGE: Rgb = (244, 243, 239)

REGULAR, SEMIBOLD = 400, 600

FRACTION_BITS = 4
"""Fraction bits of OpenCV's fixed-point coordinates; 1/16 px keeps slow motion smooth."""


def fixed(points: NDArray[Any]) -> NDArray[np.int32]:
    """Return pixel coordinates as OpenCV's fixed-point numbers, same shape."""
    scaled = np.rint(np.clip(points, -30000.0, 30000.0) * (1 << FRACTION_BITS))
    return np.asarray(scaled, dtype=np.int32)


def draw_polyline(image: Picture, points: NDArray[Any], color: Rgb, *, width: int = 1, closed: bool = False) -> None:
    """Draw an anti-aliased line through pixels, shape (n, 2)."""
    draw_polylines(image, [points], color, width=width, closed=closed)


def draw_polylines(
    image: Picture, lines: Sequence[NDArray[Any]], color: Rgb, *, width: int = 1, closed: bool = False
) -> None:
    """Draw anti-aliased lines through pixels, shape (n, 2) each."""
    if sum(map(len, lines)) > 1:
        cv2.polylines(image, each_of(fixed, lines), closed, color, width, cv2.LINE_AA, FRACTION_BITS)


def each_of(convert: Callable[[NDArray[Any]], NDArray[Any]], parts: Sequence[NDArray[Any]]) -> list[NDArray[Any]]:
    """Return parts, shape (n, 2) each, converted all at once, which is faster than one by one."""
    if len(parts) == 1:
        return [convert(parts[0])]
    ends = [0, *accumulate(map(len, parts))]
    points = convert(np.concatenate(parts))
    return [points[start:end] for start, end in pairwise(ends)]


def fill_polygons(image: Picture, outlines: list[NDArray[Any]], color: Rgb) -> None:
    """Fill closed outlines in pixels, shape (n, 2) each; an outline inside another is a hole."""
    if outlines:
        cv2.fillPoly(image, [fixed(outline) for outline in outlines], color, cv2.LINE_AA, FRACTION_BITS)


def draw_disc(image: Picture, middle: NDArray[Any], radius: float, color: Rgb, *, width: int = -1) -> None:
    """Draw a circle around a pixel, shape (2,); filled unless a line width is given."""
    x, y = fixed(np.asarray(middle)).tolist()
    cv2.circle(image, (x, y), round(radius * (1 << FRACTION_BITS)), color, width, cv2.LINE_AA, FRACTION_BITS)


class Letters:
    """Text in the font included in OpenCV; not thread-safe, use one per thread."""

    def __init__(self) -> None:
        self._face = cv2.FontFace("sans")

    def width(self, text: str, size: int, *, weight: int = REGULAR) -> int:
        """Return the width of a text [px]."""
        box = cv2.getTextSize((1, 1), text, (0, 0), self._face, size, weight)
        return int(box[0] + box[2])

    def write(
        self,
        image: Picture,
        text: str,
        at: tuple[float, float],
        size: int,
        color: Rgb = INK,
        *,
        weight: int = REGULAR,
        align: float = 0.0,
    ) -> None:
        """Write a line of text.

        Args:
            image: Picture to write into.
            text: The text.
            at: x [px], and y of the baseline [px].
            size: Height of the font [px].
            color: RGB.
            weight: REGULAR or SEMIBOLD.
            align: Fraction of the text that lies left of x: 0 left-aligned, 0.5 centred, 1 right-aligned.
        """
        shift = align * self.width(text, size, weight=weight) if align else 0.0
        cv2.putText(image, text, (round(at[0] - shift), round(at[1])), color, self._face, size, weight)


def write_picture(path: str | Path, page: Picture, *, overwrite: bool = False) -> None:
    """Write an RGB picture as PNG or JPEG, depending on the suffix.

    Raises:
        UsageError: The file exists and `overwrite` is false, has another suffix, or cannot be written.
    """
    write_file(path, encoded_picture(path, page), overwrite=overwrite)


def encoded_picture(path: str | Path, page: Picture) -> bytes:
    """Return a picture encoded as PNG or JPEG, depending on the suffix; raises UsageError for another suffix."""
    suffix = Path(path).suffix.lower()
    if suffix not in (".png", ".jpg", ".jpeg"):
        raise UsageError(Sentence("cannot write a picture as '{path}'; name it .png or .jpg", path))
    done, data = cv2.imencode(suffix, cv2.cvtColor(page, cv2.COLOR_RGB2BGR))
    assert done, "a picture of ours can always be encoded"
    return data.tobytes()
