"""Walls along any curve: two lines that bend side by side, as ellipses and splines do; all in metres."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mjsim.exchange.curves import Curve
from mjsim.exchange.drawing import BOW as CURVED
from mjsim.exchange.faces import FARTHEST, NEAREST
from mjsim.exchange.maps import DIGITS, WALL_HEIGHT, distinct
from mjsim.exchange.pixels import Cells
from mjsim.exchange.strokes import Pieces, runs
from mjsim.geometry import Array
from mjsim.world import Wall

LONGEST_STEP = 0.1
"""Between the places at which two faces are compared [m]."""
SHORTEST, SHORTEST_NAMED = 6.0, 1.0
"""Of a wall along its middle, where no name says what walls are and where one does [m]."""
EVEN = 0.2
"""Its thickness is nowhere more different from the usual [fraction of it]."""
BOW = 0.005
"""Straight lines stray so far from the curve at most [m]."""
SLACK = 0.015
"""What lies so near to it is part of it [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Ribbon:
    """A wall along a curve."""

    points: Array
    """Its middle line, shape (n, 2) [m]; a ring ends where it begins."""
    width: float

    def holds(self, points: Array) -> Cells:
        """Say which points, shape (..., 2), lie in it or on its faces."""
        import shapely

        line = shapely.LineString(self.points)
        size = float(np.ptp(self.points, axis=0).max())
        reach = self.width * (1 + EVEN) / 2 + SLACK + CURVED * size
        return np.asarray(shapely.distance(line, shapely.points(points)) <= reach)

    def wall(self, thickness: float | None) -> Wall:
        """Return it as a wall of short straight segments, as thick as it is drawn unless given."""
        ring = bool(np.allclose(self.points[0], self.points[-1]))
        corners = distinct(self.points, closed=ring)
        return Wall(points=corners, closed=ring, thickness=round(thickness or self.width, DIGITS), height=WALL_HEIGHT)


def ribbons_of(
    strokes: Sequence[Array], closed: Sequence[bool], curves: Sequence[Curve], *, named: bool
) -> list[Ribbon]:
    """Return the walls that strokes draw by two faces that bend side by side, the longest first.

    Args:
        strokes: Corners, shape (n, 2) each.
        closed: Whether each is.
        curves: Walls along arcs, which are found already.
        named: Whether names say that these are walls.
    """
    rings = [
        np.concatenate([points, points[:1]]) if ring else points for points, ring in zip(strokes, closed, strict=True)
    ]
    bends = [
        run
        for corners in rings
        for run, curved in runs(corners)
        if curved and not any(curve.holds(run).all() for curve in curves)
    ]
    options = []
    for index, one in enumerate(bends):
        for place, other in enumerate(bends[:index]):
            if (ribbon := _between(one, other)) is not None:
                options.append((-_length(ribbon.points), place, index, ribbon))
    found: list[Ribbon] = []
    used: set[int] = set()
    for length, place, index, ribbon in sorted(options, key=lambda option: option[:3]):
        if -length >= (SHORTEST_NAMED if named else SHORTEST) and not used & {place, index}:
            found.append(ribbon)
            used |= {place, index}
    return found


def without_ribbons(pieces: Pieces, ribbons: Sequence[Ribbon]) -> Pieces:
    """Return straight lines that are no parts of walls along curves."""
    if not ribbons:
        return pieces
    points = np.concatenate([pieces.ends, pieces.ends.mean(axis=1, keepdims=True)], axis=1)
    return pieces.where(~np.any([ribbon.holds(points).all(axis=1) for ribbon in ribbons], axis=0))


def _length(points: Array) -> float:
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


def _between(one: Array, other: Array) -> Ribbon | None:
    """Return the wall between two faces, shape (n, 2) each; None when they do not bend side by side."""
    import shapely

    first, second = shapely.LineString(one), shapely.LineString(other)
    if first.distance(second) > FARTHEST:
        return None
    places = shapely.get_coordinates(shapely.segmentize(first, LONGEST_STEP))
    along = shapely.line_locate_point(second, shapely.points(places))
    facing = shapely.get_coordinates(shapely.line_interpolate_point(second, along))
    # Behind an end of the other face there is no wall.
    beside = (along > 0.0) & (along < second.length) | bool(np.allclose(other[0], other[-1]))
    apart = np.hypot(*(facing - places).T)
    if np.count_nonzero(beside) < 4:
        return None
    width = float(np.median(apart[beside]))
    even = beside & (np.abs(apart - width) <= EVEN * width)
    if not NEAREST <= width <= FARTHEST or np.count_nonzero(even) < 0.8 * np.count_nonzero(beside):
        return None
    middle = ((places + facing) / 2)[beside]
    return Ribbon(shapely.get_coordinates(shapely.simplify(shapely.LineString(middle), BOW)), width)
