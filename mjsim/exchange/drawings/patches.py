"""Finds doorways painted over walls in the background colour; in metres."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from mjsim.exchange.drawings.drawing import Line
from mjsim.exchange.drawings.drawn_openings import MIN_WIDTH, Hole
from mjsim.exchange.maps import Bar
from mjsim.geometry import Array

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

MIN_PEN = 0.02
"""Minimum width of a line that paints over others [m]."""
MAX_OVERHANG = 0.05
"""Lines that extend beyond a patch by less belong to it [m]."""
MIN_HIDING_SHARE = 0.5
"""A line drawn over at least this fraction of a patch hides it again [fraction of its length]."""


def painted_over(
    bars: Sequence[Bar], patches: Sequence[Line], walls: Sequence[Line], *, filled: bool = False
) -> list[Hole]:
    """Return the doorways where walls are painted over.

    Args:
        bars: Walls.
        patches: Lines and areas in the background colour.
        walls: Lines of walls; a patch hides those drawn before it.
        filled: Whether walls are filled: then their whole thickness must be hidden, otherwise one face is enough.
    """
    import shapely

    holes = []
    for patch in patches:
        shape = _shape(patch)
        before = shapely.union_all([_ring(line) for line in walls if line.path < patch.path])
        # A threshold or a door leaf within the patch is not a wall.
        after = [_ring(line) for line in walls if line.path > patch.path]
        later = shapely.union_all(
            [line for line in after if line.is_ring or not shape.buffer(MAX_OVERHANG).covers(line)]
        )
        for bar in bars:
            if (ends := _hidden(bar, shape, whole=filled)) is not None:
                strip = shapely.LineString(ends).buffer(bar.width / 2 + MIN_PEN)
                limit = MIN_HIDING_SHARE * math.dist(*ends)
                if strip.intersection(before).length > limit > strip.intersection(later).length:
                    holes.append(Hole(ends, window=False))
    return holes


def _hidden(bar: Bar, shape: "BaseGeometry", *, whole: bool) -> Array | None:
    """Return the section of a centreline where a shape hides the wall or one of its faces, shape (2, 2), or None."""
    import shapely

    left = np.array([-bar.along[1], bar.along[0]])
    spans = []
    for offset in (-0.45, 0.0, 0.45) if whole else (-0.5, 0.0, 0.5):
        line = shapely.LineString(bar.ends + left * (offset * bar.width))
        covered = shapely.get_coordinates(line.intersection(shape))
        along = (covered - bar.ends[0]) @ bar.along if len(covered) > 1 else np.zeros(1)
        spans.append((float(np.ptp(along)), float(along.min())))
    width, first = min(spans) if whole else max(spans)
    if width < MIN_WIDTH:
        return None
    return np.asarray(bar.ends[0] + np.outer([first, first + width], bar.along))


def _shape(patch: Line) -> "BaseGeometry":
    """Return the area that a patch covers."""
    import shapely

    if patch.closed and patch.dark is not None:
        return shapely.make_valid(shapely.Polygon(patch.points))
    return _ring(patch).buffer(max(MIN_PEN, patch.width / 2), cap_style="flat")


def _ring(line: Line) -> "BaseGeometry":
    import shapely

    points = np.concatenate([line.points, line.points[:1]]) if line.closed else line.points
    return shapely.LineString(points)
