"""A chart of values over a whole run that are known beforehand; each frame shows them up to its time."""

from collections.abc import Sequence

import numpy as np

from mjsim.geometry import Array
from mjsim.interface import Picture
from mjsim.plan import Rgb
from mjsim.video.chart import BOTTOM, LEFT, RIGHT, TOP
from mjsim.video.ink import HAIR, INK, MUTED, PAPER, SEMIBOLD, Letters, draw_polyline
from mjsim.video.view import format_metres, round_step


class CurveChart:
    """Curves over time with their names in their colours."""

    def __init__(
        self,
        title: str,
        time: Array,
        curves: Sequence[tuple[str, Rgb, Array]],
        letters: Letters,
        *,
        width: int,
        height: int,
    ) -> None:
        """Draw the frame.

        Args:
            title: What the values are, with their unit.
            time: Shape (N,) [s].
            curves: Name, colour, and values of each, shape (N,).
            letters: The font.
            width: [px]
            height: [px]
        """
        self._time, self._letters = time, letters
        self._page = np.full((height, width, 3), PAPER, np.uint8)
        values = np.concatenate([each for _, _, each in curves])
        low, high = float(np.nanmin(values, initial=0.0)), float(np.nanmax(values, initial=0.0))
        self._step = round_step(max(high - low, 1e-3) / max(2, (height - TOP - BOTTOM) // 30))
        self._low, self._high = np.floor(low / self._step) * self._step, np.ceil(high / self._step) * self._step
        columns = LEFT + (width - LEFT - RIGHT - 1) * (time - time[0]) / max(float(time[-1] - time[0]), 1e-9)
        self._curves = [(color, np.stack([columns, self._row(each)], axis=-1)) for _, color, each in curves]
        self._draw_frame(title, [(name, color) for name, color, _ in curves])

    def draw(self, image: Picture, row: int) -> None:
        """Draw the curves up to a row into a picture of the chart's size."""
        image[:] = self._page
        for color, points in self._curves:
            known = points[: row + 1]
            known = known[np.isfinite(known).all(axis=1)]
            # The last point of each pixel column.
            known = known[np.append(np.diff(np.floor(known[:, 0])) > 0.0, [True] * bool(len(known))).astype(bool)]
            draw_polyline(image, known, color, width=2)

    def _row(self, values: Array | float) -> Array:
        bottom = self._page.shape[0] - BOTTOM - 1
        return np.asarray(bottom - (bottom - TOP) * (np.asarray(values) - self._low) / (self._high - self._low))

    def _draw_frame(self, title: str, names: Sequence[tuple[str, Rgb]]) -> None:
        page, letters = self._page, self._letters
        height, width = page.shape[:2]
        letters.write(page, title, (14, 20), 13, INK, weight=SEMIBOLD)
        x = width - RIGHT
        for name, color in reversed(names):
            letters.write(page, name, (x, 20), 12, color, weight=SEMIBOLD, align=1.0)
            x -= letters.width(name, 12, weight=SEMIBOLD) + 12
        for value in np.arange(self._low, self._high + self._step / 2, self._step):
            row = round(float(self._row(value)))
            page[row, LEFT : width - RIGHT] = MUTED if abs(value) < self._step / 2 else HAIR
            letters.write(page, format_metres(value, self._step), (LEFT - 8, row + 4), 11, MUTED, align=1.0)
        first, last = float(self._time[0]), float(self._time[-1])
        step = round_step(max(last - first, 1e-3) / 8)
        for value in np.arange(np.ceil(first / step) * step, last + 1e-9, step):
            column = round(LEFT + (width - LEFT - RIGHT - 1) * (value - first) / max(last - first, 1e-9))
            page[height - BOTTOM : height - BOTTOM + 4, column] = MUTED
            name = f"{value:g}" + (" s" if value + step > last else "")
            letters.write(page, name, (min(column, width - RIGHT - 8), height - 7), 11, MUTED, align=0.5)
