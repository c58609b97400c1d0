"""What modules show, such as a planned path or a grid, on the plan of a film."""

from collections.abc import Iterator

import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.interface import ShownGrid, ShownLines, ShownPoints
from mjsim.plan import PlanItem
from mjsim.video.moment import Moment

OCCUPIED = 0.5
"""Cells of a grid from this occupancy on are drawn."""


def shown_items(moment: Moment) -> Iterator[PlanItem]:
    """Yield the points, lines and grids that the modules of a robot show; texts are for the studio."""
    frames = {"world": Pose(0.0, 0.0, 0.0), "estimate": _pose(moment.estimate), "base": _pose(moment.truth)}
    for item in moment.shown:
        place = frames[item.frame]
        if place is None:
            continue
        if isinstance(item, ShownGrid):
            yield PlanItem(role="shown cells", parts=_runs(item), place=place @ item.origin)
        elif isinstance(item, ShownLines) and len(item.points):
            flat = item.points[:, :2]
            parts = [flat] if item.joined else list(flat.reshape(-1, 2, 2))
            yield PlanItem(role="shown lines", kind="line", parts=parts, place=place, tint=item.color)
        elif isinstance(item, ShownPoints) and len(item.points):
            yield PlanItem(role="shown points", kind="dots", parts=(item.points[:, :2],), place=place, tint=item.color)


def _pose(values: Array) -> Pose | None:
    return Pose.from_array(values) if np.isfinite(values).all() else None


def _runs(grid: ShownGrid) -> list[Array]:
    """Return the occupied cells as rectangles, neighbours in a row joined, in the frame of the grid, (4, 2) each."""
    edges = np.diff(np.pad(grid.cells >= OCCUPIED, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    rows, starts = np.nonzero(edges == 1)
    _, ends = np.nonzero(edges == -1)
    corners = [(starts, rows), (ends, rows), (ends, rows + 1), (starts, rows + 1)]
    return list(grid.resolution * np.moveaxis(np.array(corners, dtype=float), -1, 0))
