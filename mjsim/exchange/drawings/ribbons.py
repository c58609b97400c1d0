"""Finds walls along arbitrary curves: two lines that bend in parallel, such as ellipses and splines; all in metres."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mjsim.exchange.drawings.curved_walls import Curve
from mjsim.exchange.drawings.drawing import MAX_BOW as CURVED
from mjsim.exchange.drawings.strokes import Pieces, runs
from mjsim.exchange.drawings.wall_faces import MAX_THICKNESS, MIN_THICKNESS
from mjsim.exchange.maps import DIGITS, WALL_HEIGHT, Cells, distinct
from mjsim.geometry import Array
from mjsim.world import Wall

MAX_STEP = 0.1
"""Maximum spacing of the points at which two faces are compared [m]."""
SHORTEST, MIN_NAMED = 6.0, 1.0
"""Minimum length of a wall along its centreline, where names do not mark walls and where they do [m]."""
MAX_THICKNESS_DEVIATION = 0.2
"""Maximum deviation of its thickness from the median [fraction of it]."""
MAX_BOW = 0.005
"""Maximum deviation of the straight segments from the curve [m]."""
LINE_DISTANCE = 0.015
"""Lines this close to the wall are part of it [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Ribbon:
    """A wall along a curve."""

    points: Array
    """Centreline, shape (n, 2) [m]; the last point of a ring equals the first."""
    width: float

    def holds(self, points: Array) -> Cells:
        """Return which points, shape (..., 2) [m], lie in the wall or on its faces."""
        import shapely

        line = shapely.LineString(self.points)
        size = float(np.ptp(self.points, axis=0).max())
        reach = self.width * (1 + MAX_THICKNESS_DEVIATION) / 2 + LINE_DISTANCE + CURVED * size
        return np.asarray(shapely.distance(line, shapely.points(points)) <= reach)

    def wall(self, thickness: float | None) -> Wall:
        """Return a wall of short straight segments; the thickness is as drawn unless given [m]."""
        ring = bool(np.allclose(self.points[0], self.points[-1]))
        corners = distinct(self.points, closed=ring)
        return Wall(points=corners, closed=ring, thickness=round(thickness or self.width, DIGITS), height=WALL_HEIGHT)


def ribbons_of(
    strokes: Sequence[Array], closed: Sequence[bool], curves: Sequence[Curve], *, named: bool
) -> list[Ribbon]:
    """Return the walls whose two faces, bending in parallel, are among the strokes; longest first.

    Args:
        strokes: Corners of each stroke, shape (n, 2) [m].
        closed: Whether each stroke is closed.
        curves: Walls along arcs that are already known.
        named: Whether names mark these strokes as walls.
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
        if -length >= (MIN_NAMED if named else SHORTEST) and not used & {place, index}:
            found.append(ribbon)
            used |= {place, index}
    return found


def without_ribbons(pieces: Pieces, ribbons: Sequence[Ribbon]) -> Pieces:
    """Return the straight segments that are not part of walls along curves."""
    if not ribbons:
        return pieces
    points = np.concatenate([pieces.ends, pieces.ends.mean(axis=1, keepdims=True)], axis=1)
    return pieces.where(~np.any([ribbon.holds(points).all(axis=1) for ribbon in ribbons], axis=0))


def _length(points: Array) -> float:
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


def _between(one: Array, other: Array) -> Ribbon | None:
    """Return the wall between two faces, shape (n, 2) each [m]; None if they do not bend in parallel."""
    import shapely

    first, second = shapely.LineString(one), shapely.LineString(other)
    if first.distance(second) > MAX_THICKNESS:
        return None
    places = shapely.get_coordinates(shapely.segmentize(first, MAX_STEP))
    along = shapely.line_locate_point(second, shapely.points(places))
    facing = shapely.get_coordinates(shapely.line_interpolate_point(second, along))
    # There is no wall beyond an end of the other face.
    beside = (along > 0.0) & (along < second.length) | bool(np.allclose(other[0], other[-1]))
    widths = np.hypot(*(facing - places).T)
    if np.count_nonzero(beside) < 4:
        return None
    width = float(np.median(widths[beside]))
    even = beside & (np.abs(widths - width) <= MAX_THICKNESS_DEVIATION * width)
    if not MIN_THICKNESS <= width <= MAX_THICKNESS or np.count_nonzero(even) < 0.8 * np.count_nonzero(beside):
        return None
    middle = ((places + facing) / 2)[beside]
    return Ribbon(shapely.get_coordinates(shapely.simplify(shapely.LineString(middle), MAX_BOW)), width)
