"""Rectangles side by side that stand for one thing, as strips of a shelf that leans on a wall; all lengths in cells."""

import math
from collections.abc import Sequence

import numpy as np

from mjsim.exchange.pixels import Cells
from mjsim.exchange.shapes import Bar, cells_in
from mjsim.geometry import Array

ALONG = 0.15
"""Those whose directions differ by less are parallel [rad]."""
GAP = 1.5
"""Between two of one thing at most [cells]."""
SAME = 0.7
"""Each of two is at least so long, and lies beside the other for so much of it [fraction of the longer]."""
FILLED = 0.85
"""Fraction of what both cover together that is occupied."""


def unstacked(bars: Sequence[Bar], cells: Cells) -> list[Bar]:
    """Return bars with those made one that lie side by side, or within each other, where what they cover is occupied.

    Args:
        bars: What stands for the cells.
        cells: Occupied ones, shape (rows, columns).
    """
    import shapely

    left = list(bars)
    while len(left) > 1:
        outlines = shapely.polygons([bar.outline() for bar in left])
        one, other = shapely.STRtree(outlines).query(outlines, predicate="dwithin", distance=GAP)
        taken: set[int] = set()
        made: list[Bar] = []
        for i, j in zip(one[one < other].tolist(), other[one < other].tolist(), strict=True):
            if not taken & {i, j} and (bar := _both(left[i], left[j], cells)) is not None:
                taken |= {i, j}
                made.append(bar)
        if not made:
            break
        left = [bar for index, bar in enumerate(left) if index not in taken] + made
    return left


def _both(one: Bar, other: Bar, cells: Cells) -> Bar | None:
    """Return the bar around two that lie side by side; None when they do not, or it is not all occupied."""
    longer, shorter = (one, other) if one.length >= other.length else (other, one)
    if shorter.length < SAME * longer.length or abs(math.sin(one.heading - other.heading)) > ALONG:
        return None
    c, s = longer.along
    corners: Array = (np.concatenate([one.outline(), other.outline()]) - [longer.x, longer.y]) @ [[c, -s], [s, c]]
    middle, sides = (corners.min(axis=0) + corners.max(axis=0)) / 2, np.ptp(corners, axis=0)
    if shorter.length < SAME * sides[0]:
        return None
    x, y = (np.array([[c, -s], [s, c]]) @ middle + [longer.x, longer.y]).tolist()
    whole = Bar(x, y, longer.heading, float(sides[0]), float(sides[1]))
    window, inner = cells_in(whole.outline(), cells.shape)
    count, occupied = (int(np.count_nonzero(each)) for each in (inner, inner & cells[window]))
    return whole if occupied >= FILLED * max(1, count) else None
