"""Merges adjacent rectangles that form one object, such as strips of a shelf along a wall; all lengths in cells."""

import math
from collections.abc import Sequence

import numpy as np

from mjsim.exchange.maps.cell_shapes import Bar, cells_in
from mjsim.exchange.maps.map_pixels import Cells
from mjsim.geometry import Array

PARALLEL_TOLERANCE = 0.15
"""Rectangles whose directions differ by less are parallel [rad]."""
MAX_GAP = 1.5
"""Maximum gap between two rectangles of one object [cells]."""
MIN_OVERLAP = 0.7
"""Minimum length of the shorter and minimum overlap of both [fraction of the longer]."""
MIN_FILLED_SHARE = 0.85
"""Minimum occupied fraction of the area of the merged rectangle."""


def unstacked(bars: Sequence[Bar], cells: Cells) -> list[Bar]:
    """Return bars, merging adjacent or nested ones where the merged rectangle is occupied.

    Args:
        bars: Rectangles that represent the cells.
        cells: Occupied cells, shape (rows, columns).
    """
    import shapely

    left = list(bars)
    while len(left) > 1:
        outlines = shapely.polygons([bar.outline() for bar in left])
        one, other = shapely.STRtree(outlines).query(outlines, predicate="dwithin", distance=MAX_GAP)
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
    """Return the bar around two adjacent bars; None if they are not adjacent, or it is not sufficiently occupied."""
    longer, shorter = (one, other) if one.length >= other.length else (other, one)
    if shorter.length < MIN_OVERLAP * longer.length or abs(math.sin(one.heading - other.heading)) > PARALLEL_TOLERANCE:
        return None
    c, s = longer.along
    corners: Array = (np.concatenate([one.outline(), other.outline()]) - [longer.x, longer.y]) @ [[c, -s], [s, c]]
    middle, sides = (corners.min(axis=0) + corners.max(axis=0)) / 2, np.ptp(corners, axis=0)
    if shorter.length < MIN_OVERLAP * sides[0]:
        return None
    x, y = (np.array([[c, -s], [s, c]]) @ middle + [longer.x, longer.y]).tolist()
    whole = Bar(x, y, longer.heading, float(sides[0]), float(sides[1]))
    window, inner = cells_in(whole.outline(), cells.shape)
    count, occupied = (int(np.count_nonzero(each)) for each in (inner, inner & cells[window]))
    return whole if occupied >= MIN_FILLED_SHARE * max(1, count) else None
