"""Doorways painted over walls in the colour of the paper; in metres."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from mjsim.exchange.drawing import Line
from mjsim.exchange.openings import NARROWEST, Hole
from mjsim.exchange.shapes import Bar
from mjsim.geometry import Array

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

PEN = 0.02
"""What is painted by a line is at least so broad [m]."""
WITHIN = 0.05
"""What reaches no farther beyond a patch belongs to it [m]."""
AGAIN = 0.5
"""What is drawn later over so much of a patch stands [fraction of its length]."""


def painted_over(
    bars: Sequence[Bar], patches: Sequence[Line], walls: Sequence[Line], *, filled: bool = False
) -> list[Hole]:
    """Return the doorways where walls are painted over.

    Args:
        bars: Walls.
        patches: What is painted in the colour of the paper.
        walls: Lines of walls; a patch hides those that are drawn before it.
        filled: Whether walls are filled: then all of a wall's thickness must be hidden, else a face is enough.
    """
    import shapely

    holes = []
    for patch in patches:
        shape = _shape(patch)
        before = shapely.union_all([_ring(line) for line in walls if line.path < patch.path])
        # A threshold or a leaf within the patch is no wall.
        after = [_ring(line) for line in walls if line.path > patch.path]
        later = shapely.union_all([line for line in after if line.is_ring or not shape.buffer(WITHIN).covers(line)])
        for bar in bars:
            if (ends := _hidden(bar, shape, whole=filled)) is not None:
                strip = shapely.LineString(ends).buffer(bar.width / 2 + PEN)
                most = AGAIN * math.dist(*ends)
                if strip.intersection(before).length > most > strip.intersection(later).length:
                    holes.append(Hole(ends, window=False))
    return holes


def _hidden(bar: Bar, shape: "BaseGeometry", *, whole: bool) -> Array | None:
    """Return the part of a wall's middle line where a shape hides it, or a face of it, shape (2, 2); None for none."""
    import shapely

    left = np.array([-bar.along[1], bar.along[0]])
    spans = []
    for aside in (-0.45, 0.0, 0.45) if whole else (-0.5, 0.0, 0.5):
        line = shapely.LineString(bar.ends + left * (aside * bar.width))
        covered = shapely.get_coordinates(line.intersection(shape))
        along = (covered - bar.ends[0]) @ bar.along if len(covered) > 1 else np.zeros(1)
        spans.append((float(np.ptp(along)), float(along.min())))
    width, first = min(spans) if whole else max(spans)
    if width < NARROWEST:
        return None
    return np.asarray(bar.ends[0] + np.outer([first, first + width], bar.along))


def _shape(patch: Line) -> "BaseGeometry":
    """Return what a patch covers."""
    import shapely

    if patch.closed and patch.dark is not None:
        return shapely.make_valid(shapely.Polygon(patch.points))
    return _ring(patch).buffer(max(PEN, patch.width / 2), cap_style="flat")


def _ring(line: Line) -> "BaseGeometry":
    import shapely

    points = np.concatenate([line.points, line.points[:1]]) if line.closed else line.points
    return shapely.LineString(points)
