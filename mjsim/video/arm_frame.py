"""The composed picture of stationary arms: an oblique view, and charts of their joints and tools beside it."""

from collections.abc import Iterator, Sequence

import numpy as np

from mjsim.geometry import Array
from mjsim.interface import Picture
from mjsim.plan import GROUPS, Rgb, parse_color
from mjsim.record import Recording
from mjsim.video.chart import BOTTOM, LEFT, RIGHT, TOP
from mjsim.video.film_frame import DENSITY
from mjsim.video.ink import HAIR, INK, MUTED, PAGE, PAPER, SEMIBOLD, Letters, draw_polyline
from mjsim.video.moment import Moment
from mjsim.video.oblique import ObliqueView, StandingArm, standing_arms
from mjsim.video.paper import Paper
from mjsim.video.picture_layout import COLUMN_WIDTH, GAP, HEAD, HEIGHT, MARGIN, WIDTH
from mjsim.video.plan_parts import draw_scale_bar
from mjsim.video.plan_view import PlanView, format_metres, round_step


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


CHARTED = 2
"""Maximum number of arms with charts."""


class ArmFrame:
    """Composes pictures of stationary arms, 1280 x 720."""

    def __init__(self, recording: Recording) -> None:
        """Choose scales that fit the whole motion; the recording has a stationary arm."""
        self._letters = Letters()
        self._page = np.full((HEIGHT, WIDTH, 3), PAGE, np.uint8)
        arms = standing_arms(recording)
        self._view = ObliqueView(recording, arms)
        left = WIDTH - 2 * MARGIN - GAP - COLUMN_WIDTH
        self._seen = self._page[HEAD : HEIGHT - MARGIN, MARGIN : MARGIN + left]
        self._plan = PlanView.fit(self._view.bounds, left, self._seen.shape[0], margin=14)
        self._letters.write(self._page, recording.world.name, (MARGIN, 31), 22, weight=SEMIBOLD)
        shown = arms[:CHARTED]
        rows = (HEIGHT - MARGIN - HEAD + GAP) // (2 * len(shown)) - GAP
        self._charts = [
            (self._page[y : y + rows, -MARGIN - COLUMN_WIDTH : -MARGIN], chart)
            for y, chart in zip(range(HEAD, HEIGHT, rows + GAP), self._made(recording, shown, rows), strict=False)
        ]

    def draw(self, moment: Moment, row: int) -> Picture:
        """Return the picture of a moment, RGB, shape (720, 1280, 3); every call returns the same array."""
        self._seen[:] = PAPER
        Paper(self._seen, self._plan, self._letters, DENSITY).draw(self._view.items(moment, row))
        height, width = self._seen.shape[:2]
        draw_scale_bar(self._seen, self._plan.scale, self._letters, (width - 12, height - 12))
        for part, chart in self._charts:
            chart.draw(part, row)
        strip = self._page[10:42, WIDTH - MARGIN - 100 : WIDTH - MARGIN]
        strip[:] = PAGE
        self._letters.write(strip, f"{moment.time:.1f} s", (100, 21), 14, INK, align=1.0)
        return self._page

    def _made(self, recording: Recording, arms: Sequence[StandingArm], height: int) -> Iterator[CurveChart]:
        """Yield the charts of joints and tool of each arm."""
        for arm in arms:
            slides = np.array([link.slide for link in arm.item.arm.links])
            unit = "mm" if slides.all() else "deg, mm" if slides.any() else "deg"
            scale = np.where(slides, 1000.0, 180.0 / np.pi)
            joints = [
                (name, parse_color(GROUPS[k % len(GROUPS)]), scale[k] * arm.positions[:, k])
                for k, name in enumerate(recording.joints[arm.name].names)
            ]
            tool = [(name, parse_color(GROUPS[k]), arm.tool[:, k]) for k, name in enumerate("xyz")]
            for title, curves in ((f"{arm.name}: joints [{unit}]", joints), (f"{arm.name}: tool [m]", tool)):
                yield CurveChart(title, recording.time, curves, self._letters, width=COLUMN_WIDTH, height=height)
