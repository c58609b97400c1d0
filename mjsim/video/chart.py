"""Chart of the position error, drawn incrementally during the run."""

import numpy as np
from numpy.typing import ArrayLike

from mjsim.geometry import Array
from mjsim.interface import Picture
from mjsim.plan import Rgb
from mjsim.video.ink import ESTIMATE, HAIR, INK, MUTED, ODOMETRY, PAPER, SEMIBOLD, Letters, draw_polyline
from mjsim.video.moment import Moment
from mjsim.video.plan_view import format_metres, round_step

LEFT, RIGHT, TOP, BOTTOM = 52, 14, 32, 24
"""Margins around the curves [px]."""
MIN_WIDE_WIDTH = 480
"""In a chart narrower than this, the current errors are below the title [px]."""
MIN_STEP = 3.0
"""Minimum step by which curves are extended [px]."""


class ErrorChart:
    """Errors of estimate and dead reckoning over time; the scales grow when errors exceed them."""

    def __init__(self, width: int, height: int, letters: Letters, *, seconds: float) -> None:
        """Create an empty chart.

        Args:
            width: [px]
            height: [px]
            letters: Font.
            seconds: Time at the right edge [s].
        """
        self._page = np.empty((height, width, 3), np.uint8)
        self._letters = letters
        self._seconds, self._limit = seconds, 0.05
        self._figures = 20 if width >= MIN_WIDE_WIDTH else 42
        """Baseline of the current errors, beside the title or below it [px]."""
        self._top = TOP + self._figures - 20
        self._times: list[float] = []
        self._errors: tuple[list[float], list[float]] = ([], [])
        self._curves_to = 0
        """Index of the instant up to which the curves are drawn."""
        self._draw_frame()

    def add(self, moment: Moment) -> None:
        """Extend the curves by one instant."""
        values = [float(np.hypot(*(pose - moment.truth)[:2])) for pose in (moment.odometry, moment.estimate)]
        if not np.isfinite(values).all():
            return
        self._times.append(moment.time)
        for errors, value in zip(self._errors, values, strict=True):
            errors.append(value)
        if max(values) > self._limit or moment.time > self._seconds + 1e-6:
            self._limit = max(self._limit, 1.4 * max(values))
            self._seconds = max(self._seconds, 1.5 * moment.time if moment.time > self._seconds + 1e-6 else 0.0)
            self._draw_frame()
            self._draw_curves(0)
        elif float(self._column(moment.time) - self._column(self._times[self._curves_to])) >= MIN_STEP:
            self._draw_curves(self._curves_to)

    def draw(self, image: Picture) -> None:
        """Draw the chart with the current errors into a picture of its size."""
        image[:] = self._page
        if not self._times:
            return
        x = image.shape[1] - RIGHT
        for name, color, errors in (("odometry", ODOMETRY, self._errors[0]), ("estimate", ESTIMATE, self._errors[1])):
            text = f"{name} {errors[-1]:.3f} m"
            self._letters.write(image, text, (x, self._figures), 13, _darker(color), weight=SEMIBOLD, align=1.0)
            x -= 150

    def _draw_frame(self) -> None:
        page, letters = self._page, self._letters
        height, width = page.shape[:2]
        page[:] = PAPER
        letters.write(page, "Position error [m]", (14, 20), 13, INK, weight=SEMIBOLD)
        step = round_step(self._limit / 5)
        for value in np.arange(0.0, self._limit + 1e-9, step):
            row = round(float(self._row(value)))
            page[row, LEFT : width - RIGHT] = HAIR if value else MUTED
            letters.write(page, format_metres(value, step), (LEFT - 8, row + 4), 11, MUTED, align=1.0)
        step = round_step(self._seconds / 8)
        for value in np.arange(0.0, self._seconds + 1e-9, step):
            column = round(float(self._column(value)))
            page[height - BOTTOM : height - BOTTOM + 4, column] = MUTED
            name = f"{value:g}" + (" s" if value + step > self._seconds else "")
            letters.write(page, name, (min(column, width - RIGHT - 8), height - 7), 11, MUTED, align=0.5)

    def _draw_curves(self, first: int) -> None:
        self._curves_to = len(self._times) - 1
        columns = self._column(self._times[first:])
        # The first of every few pixels, and the newest: shorter segments would look like beads.
        drawn = np.append(np.diff(np.floor(columns / MIN_STEP), prepend=-1.0)[:-1] > 0.0, True)
        for errors, color in zip(self._errors, (ODOMETRY, ESTIMATE), strict=True):
            points = np.stack([columns, self._row(errors[first:])], axis=-1)[drawn]
            draw_polyline(self._page, points, color, width=2)

    def _column(self, time: ArrayLike) -> Array:
        return LEFT + (self._page.shape[1] - LEFT - RIGHT - 1) * np.asarray(time, dtype=float) / self._seconds

    def _row(self, error: ArrayLike) -> Array:
        bottom = self._page.shape[0] - BOTTOM - 1
        return bottom - (bottom - self._top) * np.asarray(error, dtype=float) / self._limit


def _darker(color: Rgb) -> Rgb:
    red, green, blue = (round(0.8 * part) for part in color)
    return red, green, blue
