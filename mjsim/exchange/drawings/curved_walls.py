"""Finds curved walls: two concentric arcs are the faces of a wall of short straight segments; all lengths in metres."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from mjsim.exchange.drawings.drawing import MAX_BOW as CURVED
from mjsim.exchange.drawings.strokes import Arc, Pieces, arc_through, is_door_arc, runs
from mjsim.exchange.drawings.wall_faces import MAX_OUTER_RATIO, MAX_THICKNESS, MIN_THICKNESS
from mjsim.exchange.maps import WALL_HEIGHT, Bar, Cells, distinct
from mjsim.geometry import Array
from mjsim.world import Wall

ONE_MIDDLE = 0.03
"""Maximum distance between the centres of the two faces [m]."""
MIN_LENGTH = 0.3
"""Minimum length shared by both faces, along the centreline [m]."""
MIN_LEAF_GAP = 0.08
"""Two door-swing arcs that are closer together than this do not form a wall [m]."""
MAX_BOW = 0.005
"""Maximum deviation of the straight segments from the curve [m]."""
LINE_DISTANCE = 0.015
"""Lines this close to a curved wall are part of it [m]."""
MAX_STRAY = 0.02
"""Maximum deviation of the faces of a curved wall from a circle [m]."""
FULL_TURN = 2 * math.pi - 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """A wall along an arc."""

    middle: Array
    """Centre of the arc, shape (2,) [m]."""
    inner: float
    outer: float
    """Radii of its outer and inner face [m]."""
    first: float
    sweep: float
    """Start angle, and angle swept from there, counter-clockwise [rad]."""

    def holds(self, points: Array) -> Cells:
        """Return which points, shape (..., 2) [m], lie in the wall or on its faces."""
        x, y = np.moveaxis(points - self.middle, -1, 0)
        away = np.hypot(x, y)
        # The faces are drawn as straight segments, whose midpoints lie closer to the centre.
        slack = LINE_DISTANCE + 2 * CURVED * self.outer
        over = slack / self.inner
        turn = (np.arctan2(y, x) - self.first + over) % (2 * math.pi)
        level = (away >= self.inner - slack) & (away <= self.outer + slack)
        return np.asarray(level & ((turn <= self.sweep + 2 * over) | (self.sweep > FULL_TURN)))


def curves_of(strokes: Sequence[Array], closed: Sequence[bool]) -> list[Curve]:
    """Return the curved walls whose two faces are among the strokes; of three arcs side by side the outer two are used.

    Args:
        strokes: Corners of each stroke, shape (n, 2) [m].
        closed: Whether each stroke is closed.
    """
    arcs = list(_arcs(strokes, closed))
    options = []
    for index, one in enumerate(arcs):
        for place, other in enumerate(arcs[:index]):
            if (curve := _between(one, other)) is not None:
                width, middle = curve.outer - curve.inner, (curve.outer + curve.inner) / 2
                options.append((-curve.sweep * middle - MAX_OUTER_RATIO * width, place, index, curve))
    found: list[Curve] = []
    used: set[int] = set()
    for _, place, index, curve in sorted(options, key=lambda option: option[:3]):
        if place not in used and index not in used:
            found.append(curve)
            used |= {place, index}
            used |= {number for number, arc in enumerate(arcs) if curve.holds(arc.points).all()}
    return found


def without_curves(pieces: Pieces, arcs: Sequence[Arc], curves: Sequence[Curve]) -> tuple[Pieces, list[Arc]]:
    """Return the straight segments and door-swing arcs that are not part of curved walls."""
    if not curves:
        return pieces, list(arcs)
    points = np.concatenate([pieces.ends, pieces.ends.mean(axis=1, keepdims=True)], axis=1)
    part = np.any([curve.holds(points).all(axis=1) for curve in curves], axis=0)
    others = [arc for arc in arcs if not any(curve.holds(arc.points).all() for curve in curves)]
    return pieces.where(~part), others


def walls_of(curves: Sequence[Curve], bars: Sequence[Bar], thickness: float | None) -> list[Wall]:
    """Return curved walls as walls of short straight segments, extended to straight walls that they meet at an angle.

    Args:
        curves: The curved walls [m].
        bars: The straight walls [m].
        thickness: Thickness of the walls [m]; by default as drawn.
    """
    found = []
    for curve in curves:
        radius, width = (curve.inner + curve.outer) / 2, curve.outer - curve.inner
        step = 2 * math.acos(max(0.0, 1 - MAX_BOW / radius))
        turns = curve.first + np.linspace(0.0, curve.sweep, max(3, math.ceil(curve.sweep / step) + 1))
        points = curve.middle + radius * np.stack([np.cos(turns), np.sin(turns)], axis=-1)
        ring = curve.sweep > FULL_TURN
        if not ring:
            points = np.concatenate([_led_on(points[1::-1], bars, width), points, _led_on(points[-2:], bars, width)])
        corners = distinct(points, closed=ring)
        size = round(thickness or width, 3)
        found.append(Wall(points=corners, closed=ring, thickness=size, height=WALL_HEIGHT))
    return found


def _led_on(last: Array, bars: Sequence[Bar], width: float) -> Array:
    """Return where to extend a wall, last segment of shape (2, 2), so that it meets others: shape (0 or 1, 2)."""
    end, along = last[1], (last[1] - last[0]) / max(1e-9, math.dist(*last))
    for bar in bars:
        u, v = np.abs(np.array([[1, 0], [0, 1]]) @ _inside(bar, end))
        within = u <= bar.length / 2 + width and v <= (bar.width + width) / 2
        if within and abs(float(along @ bar.along)) < math.cos(math.radians(12.0)):
            return np.asarray(end + along * min(width, bar.width) / 2).reshape(1, 2)
    return np.zeros((0, 2))


def _inside(bar: Bar, point: Array) -> Array:
    """Return a point in the frame of a bar: along and across it, from its centre, shape (2,)."""
    c, s = bar.along
    return np.asarray(np.array([[c, s], [-s, c]]) @ (point - [bar.x, bar.y]))


def _arcs(strokes: Sequence[Array], closed: Sequence[bool]) -> Iterator[Arc]:
    for index, (points, ring) in enumerate(zip(strokes, closed, strict=True)):
        corners = np.concatenate([points, points[:1]]) if ring else points
        for run, curved in runs(corners):
            arc = arc_through(run, index) if curved else None
            if arc is not None and _stray(arc) <= MAX_STRAY:
                yield arc


def _stray(arc: Arc) -> float:
    return float(np.abs(np.hypot(*(arc.points - arc.middle).T) - arc.radius).max())


def _between(one: Arc, other: Arc) -> Curve | None:
    """Return the curved wall between two faces, over their common length; None if they do not form a wall."""
    inner, outer = sorted((one.radius, other.radius))
    thickness = outer - inner
    leaves = is_door_arc(one) and is_door_arc(other)
    if not (MIN_LEAF_GAP if leaves else MIN_THICKNESS) <= thickness <= MAX_THICKNESS or inner < thickness:
        return None
    if math.dist(one.middle, other.middle) > ONE_MIDDLE:
        return None
    first, sweep = _common(one, other)
    if sweep * (inner + outer) / 2 < max(MIN_LENGTH, thickness):
        return None
    return Curve((one.middle + other.middle) / 2, inner, outer, first, sweep)


def _common(one: Arc, other: Arc) -> tuple[float, float]:
    """Return start and sweep of the angle range that two arcs share [rad]."""
    if one.sweep > FULL_TURN:
        return other.first, other.sweep
    if other.sweep > FULL_TURN:
        return one.first, one.sweep
    behind = (other.first - one.first) % (2 * math.pi)
    options = []
    for start in (behind, behind - 2 * math.pi):
        low, high = max(0.0, start), min(one.sweep, start + other.sweep)
        options.append((high - low, one.first + low))
    sweep, first = max(options)
    return first, sweep
