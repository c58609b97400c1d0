"""What modules show, such as a planned path or a grid, on the plan of a film."""

from collections.abc import Iterator

import cv2
import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.interface import ShownGrid, ShownLines, ShownPoints
from mjsim.plan import PlanItem
from mjsim.video.moment import Moment

MIN_OCCUPANCY = 0.5
"""Regions of a grid from this occupancy on are outlined."""
OUTLINE_SUBDIVISIONS = 4
"""Parts into which a side of a cell is divided for its outline."""


def shown_items(moment: Moment) -> Iterator[PlanItem]:
    """Yield the points, lines and grids that the modules of a robot show; texts are for the studio."""
    frames = {"world": Pose(0.0, 0.0, 0.0), "estimate": _pose(moment.estimate), "base": _pose(moment.truth)}
    for item in moment.shown:
        place = frames[item.frame]
        if place is None:
            continue
        if isinstance(item, ShownGrid):
            yield PlanItem(role="shown cells", parts=_outlines(item), place=place @ item.origin)
        elif isinstance(item, ShownLines) and len(item.points):
            flat = item.points[:, :2]
            parts = [flat] if item.joined else list(flat.reshape(-1, 2, 2))
            yield PlanItem(role="shown lines", kind="line", parts=parts, place=place, tint=item.color)
        elif isinstance(item, ShownPoints) and len(item.points):
            yield PlanItem(role="shown points", kind="dots", parts=(item.points[:, :2],), place=place, tint=item.color)


def _pose(values: Array) -> Pose | None:
    return Pose.from_array(values) if np.isfinite(values).all() else None


def _outlines(grid: ShownGrid) -> list[Array]:
    """Return the outlines of the occupied cells in the frame of the grid, shape (n, 2) each [m]."""
    fine = np.kron(grid.cells >= MIN_OCCUPANCY, np.ones((OUTLINE_SUBDIVISIONS, OUTLINE_SUBDIVISIONS))).astype(np.uint8)
    found, _ = cv2.findContours(fine, cv2.RETR_LIST, cv2.CHAIN_APPROX_SIMPLE)
    return [(outline[:, 0].astype(float) + 0.5) * (grid.resolution / OUTLINE_SUBDIVISIONS) for outline in found]
