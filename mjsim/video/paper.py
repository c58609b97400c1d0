"""A drawing to scale on paper: positions are in metres, line widths in millimetres."""

import struct
import zlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from mjsim.geometry import Array
from mjsim.interface import Picture
from mjsim.output import write_file
from mjsim.plan import Paint, PlanItem, Rgb
from mjsim.video.ink import (
    PAPER,
    Letters,
    draw_disc,
    draw_polyline,
    draw_polylines,
    each_of,
    encoded_picture,
    fill_polygons,
)
from mjsim.video.plan_view import PlanView

DPI = 200
"""Pixels per inch of paper."""
HEAD = 1.6
"""Length of an arrow's head [mm]."""


def px(millimetres: float) -> float:
    """Return a length on paper in pixels."""
    return millimetres * DPI / 25.4


@dataclass(frozen=True, slots=True, eq=False)
class Paper:
    """A sheet of paper and the section of the world on it; points are in the world frame, shape (..., 2) [m]."""

    image: Picture
    view: PlanView
    letters: Letters
    density: float = DPI / 25.4
    """Pixels per millimetre of paper."""

    def metres(self, millimetres: float) -> float:
        """Return the length in the world of a length on paper [m]."""
        return millimetres * self.density / self.view.scale

    def draw(self, shapes: Iterable[PlanItem]) -> None:
        """Draw shapes in their order."""
        metres = self.metres(1.0)
        for shape in shapes:
            paint, parts = shape.paint(), each_of(self.view.pixels, shape.placed(metres))
            if shape.kind == "dots":
                self._draw_dots(np.concatenate(parts), paint)
                continue
            closed, width = shape.kind == "area", self._width(paint.width)
            if closed and paint.fill is not None:
                for part in parts:
                    fill_polygons(self.image, [part], paint.fill)
            if paint.line is not None and paint.dash:
                for part in parts:
                    ring = np.concatenate([part, part[:1]]) if closed else part
                    for piece in _dashes(ring, paint.dash * self.density, paint.dash * self.density / 2):
                        draw_polyline(self.image, piece, paint.line, width=width)
            elif paint.line is not None:
                draw_polylines(self.image, parts, paint.line, width=width, closed=closed)

    def _draw_dots(self, middles: Array, paint: Paint) -> None:
        height, width = self.image.shape[:2]
        for middle in middles[((middles >= 0.0) & (middles < (width, height))).all(axis=1)]:
            draw_disc(self.image, middle, paint.width / 2 * self.density, paint.fill or PAPER)

    def _width(self, millimetres: float) -> int:
        return max(round(millimetres * self.density), 1)

    def fill(self, outline: ArrayLike, color: Rgb) -> None:
        """Fill a closed outline."""
        self.fill_all([outline], color)

    def fill_all(self, outlines: Iterable[ArrayLike], color: Rgb) -> None:
        """Fill closed outlines; one inside another is a hole."""
        fill_polygons(self.image, [self.view.pixels(outline) for outline in outlines], color)

    def line(self, points: ArrayLike, color: Rgb, thickness: float = 0.2, *, closed: bool = False) -> None:
        """Draw a line with a thickness [mm]."""
        draw_polyline(self.image, self.view.pixels(points), color, width=self._width(thickness), closed=closed)

    def dashes(self, points: ArrayLike, color: Rgb, thickness: float = 0.2, *, dash: float = 1.2) -> None:
        """Draw a dashed line; dashes are `dash` long [mm], gaps half as long."""
        for piece in _dashes(self.view.pixels(points), dash * self.density, dash * self.density / 2):
            draw_polyline(self.image, piece, color, width=self._width(thickness))

    def disc(self, middle: ArrayLike, radius: float, color: Rgb, *, thickness: float | None = None) -> None:
        """Draw a circle with a radius [m], filled unless a thickness [mm] is given."""
        width = -1 if thickness is None else self._width(thickness)
        draw_disc(self.image, self.view.pixels(middle), radius * self.view.scale, color, width=width)

    def arrow(self, ends: ArrayLike, color: Rgb, thickness: float = 0.25) -> None:
        """Draw an arrow from the first of two points to the second; if there is no space, only its head."""
        tail, tip = self.view.pixels(ends)
        length = float(np.hypot(*(tip - tail)))
        if length < 1e-6:
            return
        along = (tip - tail) / length
        across, head = np.array([-along[1], along[0]]), min(HEAD * self.density, length)
        foot = tip - head * along
        draw_polyline(self.image, np.stack([tail, foot]), color, width=self._width(thickness))
        fill_polygons(self.image, [np.stack([tip, foot + 0.38 * head * across, foot - 0.38 * head * across])], color)

    def inner(self, left: float, top: float, right: float, bottom: float) -> "Paper":
        """Return the section of the sheet within margins [mm]; it shares the picture of this sheet."""
        x0, y0 = round(px(left)), round(px(top))
        image = self.image[y0 : self.image.shape[0] - round(px(bottom)), x0 : self.image.shape[1] - round(px(right))]
        return Paper(image, self.view.part(x0, y0, image.shape[1], image.shape[0]), self.letters, self.density)


def blank(view: PlanView) -> Paper:
    """Return an empty sheet of a view's size."""
    return Paper(np.full((view.height, view.width, 3), PAPER, np.uint8), view, Letters())


def write_sheet(path: str | Path, page: Picture, *, overwrite: bool = False) -> None:
    """Write a picture as PNG or JPEG; a PNG contains its size on paper, so that it prints to scale.

    Raises:
        UsageError: The file exists and `overwrite` is false, has another suffix, or cannot be written.
    """
    data = encoded_picture(path, page)
    if Path(path).suffix.lower() == ".png":
        # The PNG specification, 11.3.5.3: pixels per metre in x and y, unit 1. It follows the header chunk.
        body = b"pHYs" + struct.pack(">IIB", *(round(DPI / 0.0254),) * 2, 1)
        chunk = struct.pack(">I", 9) + body + struct.pack(">I", zlib.crc32(body))
        data = data[:33] + chunk + data[33:]
    write_file(path, data, overwrite=overwrite)


def _dashes(points: Array, dash: float, gap: float) -> Iterator[Array]:
    """Yield the segments of a dashed line through pixels, shape (n, 2)."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    for start in np.arange(0.0, float(along[-1]), dash + gap):
        inside = (along > start) & (along < start + dash)
        ends = [start, *along[inside], min(start + dash, float(along[-1]))]
        yield np.stack([np.interp(ends, along, column) for column in points.T], axis=-1)
