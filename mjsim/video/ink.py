"""Colours and text for all drawings; colours are RGB and distinguishable for the colour-blind."""

from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from mjsim.errors import UsageError
from mjsim.interface import Picture
from mjsim.output import write_file

Color = tuple[int, int, int]

# Okabe and Ito, "Color Universal Design" (2008), for meaningful colours; muted greys for the rest.
TRUTH: Color = (0, 114, 178)
ESTIMATE: Color = (213, 94, 0)
SEEN: Color = (0, 158, 115)
BEACON: Color = (230, 159, 0)
SCANNED: Color = (204, 121, 167)
ODOMETRY: Color = (140, 145, 152)

INK: Color = (35, 39, 46)
MUTED: Color = (98, 104, 114)
HAIR: Color = (224, 222, 216)
PAGE: Color = (244, 243, 239)
PAPER: Color = (255, 255, 255)
WALL: Color = (74, 79, 87)

REGULAR, SEMIBOLD = 400, 600

FRACTION_BITS = 4
"""Fraction bits of OpenCV's fixed-point coordinates; 1/16 px keeps slow motion smooth."""


def parse_color(text: str) -> Color:
    """Return the colour of '#rrggbb'."""
    red, green, blue = bytes.fromhex(text.removeprefix("#"))
    return red, green, blue


def blend(color: Color, other: Color, share: float) -> Color:
    """Return a mixture of two colours; `share` in [0, 1] is the fraction of the other one."""
    mixed = [round((1.0 - share) * a + share * b) for a, b in zip(color, other, strict=True)]
    return mixed[0], mixed[1], mixed[2]


def fixed(points: NDArray[Any]) -> NDArray[np.int32]:
    """Return pixel coordinates as OpenCV's fixed-point numbers, same shape."""
    scaled = np.rint(np.clip(points, -30000.0, 30000.0) * (1 << FRACTION_BITS))
    return np.asarray(scaled, dtype=np.int32)


def draw_polyline(image: Picture, points: NDArray[Any], color: Color, *, width: int = 1, closed: bool = False) -> None:
    """Draw an anti-aliased line through pixels, shape (n, 2)."""
    if len(points) > 1:
        cv2.polylines(image, [fixed(points)], closed, color, width, cv2.LINE_AA, FRACTION_BITS)


def fixed_polylines(image: Picture, outlines: NDArray[Any], color: Color) -> None:
    """Draw many closed outlines with equal numbers of points, in pixels, shape (k, n, 2)."""
    cv2.polylines(image, list(fixed(outlines)), True, color, 1, cv2.LINE_AA, FRACTION_BITS)


def fill_polygons(image: Picture, outlines: list[NDArray[Any]], color: Color) -> None:
    """Fill closed outlines in pixels, shape (n, 2) each; an outline inside another is a hole."""
    if outlines:
        cv2.fillPoly(image, [fixed(outline) for outline in outlines], color, cv2.LINE_AA, FRACTION_BITS)


def draw_disc(image: Picture, middle: NDArray[Any], radius: float, color: Color, *, width: int = -1) -> None:
    """Draw a circle around a pixel, shape (2,); filled unless a line width is given."""
    x, y = fixed(np.asarray(middle)).tolist()
    cv2.circle(image, (x, y), round(radius * (1 << FRACTION_BITS)), color, width, cv2.LINE_AA, FRACTION_BITS)


def draw_dots(image: Picture, middles: NDArray[Any], color: Color) -> None:
    """Draw small dots about pixels, shape (n, 2)."""
    height, width = image.shape[:2]
    for middle in middles[((middles >= 0.0) & (middles < (width, height))).all(axis=1)]:
        draw_disc(image, middle, 1.6, color)


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
        color: Color = INK,
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
        raise UsageError(f"cannot write a picture as '{path}'; name it .png or .jpg")
    done, data = cv2.imencode(suffix, cv2.cvtColor(page, cv2.COLOR_RGB2BGR))
    assert done, "a picture of ours can always be encoded"
    return data.tobytes()
