"""The paths of one robot in a film, drawn incrementally."""

import numpy as np

from mjsim.geometry import Array
from mjsim.interface import Picture
from mjsim.plan import paint_of
from mjsim.video.ink import PAPER, draw_polyline
from mjsim.video.moment import Moment
from mjsim.video.state import MAX_TRAIL_STEP
from mjsim.video.view import PlanView

TRAILS = (("odometry", "odometry path", 1, 1), ("truth", "true path", 5, 1), ("estimate", "estimated path", 1, 5))
"""Trail, role, width [px], and number of segments drawn again: the estimate's trail is thin and on top of the
truth's, whose round ends would cover it."""
MIN_TRAIL_STEP = 3.0
"""A trail is extended when its robot has moved this far [px]."""


class Trails:
    """The paths of one robot on a persistent plan, extended incrementally."""

    def __init__(self, plan: Picture, view: PlanView) -> None:
        """Store the plan, which is drawn on."""
        self._plan = plan
        self._view = view
        self._last: dict[str, list[Array]] = {}

    def add(self, moment: Moment) -> None:
        """Extend the trails to the robot's current position."""
        for name, role, width, again in TRAILS:
            pixel = self._view.pixels(getattr(moment, name)[:2])
            if not np.isfinite(pixel).all():
                continue
            last = self._last.setdefault(name, [pixel])
            if name == "truth" and np.abs(pixel - last[-1]).max() > MAX_TRAIL_STEP * self._view.scale:
                self._last[name] = [pixel]
                continue
            if np.abs(pixel - last[-1]).max() >= MIN_TRAIL_STEP:
                draw_polyline(self._plan, np.stack([*last, pixel]), paint_of(role).line or PAPER, width=width)
                self._last[name] = [*last, pixel][-again:]
