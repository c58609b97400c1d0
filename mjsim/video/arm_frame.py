"""The composed picture of arms that stand: an oblique view, and their joints and tools over time beside it."""

from collections.abc import Iterator, Sequence

import numpy as np

from mjsim.interface import Picture
from mjsim.plan import GROUPS, parse_color
from mjsim.record import Recording
from mjsim.video.curve_chart import CurveChart
from mjsim.video.film_frame import DENSITY
from mjsim.video.ink import INK, PAGE, PAPER, SEMIBOLD, Letters
from mjsim.video.moment import Moment
from mjsim.video.oblique import ObliqueView, StandingArm, standing_arms
from mjsim.video.paper import Paper
from mjsim.video.picture_layout import COLUMN_WIDTH, GAP, HEAD, HEIGHT, MARGIN, WIDTH
from mjsim.video.plan_parts import draw_scale_bar
from mjsim.video.view import PlanView

CHARTED = 2
"""Maximum number of arms with charts."""


class ArmFrame:
    """Composes pictures of standing arms, 1280 x 720."""

    def __init__(self, recording: Recording) -> None:
        """Choose scales that fit the whole motion; the recording has an arm that stands."""
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
