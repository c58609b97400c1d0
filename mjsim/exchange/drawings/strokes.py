"""Splits lines of a drawing, in metres, into straight pieces, door-swing arcs, patterns and frames."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mjsim.exchange.maps import Cells
from mjsim.geometry import Array

Indices = NDArray[np.int64]

SMOOTH = math.radians(32.0)
"""Straight lines that bend by less at each corner, always in the same direction, are a curve [rad]."""
DOOR_RADII = (0.45, 1.7)
"""Minimum and maximum width of a door leaf [m]."""
DOOR_SWEEP = (math.radians(40.0), math.radians(125.0))
"""Minimum and maximum angle of a door-swing arc without a leaf [rad]."""
LEAF_SWEEP = (math.radians(4.0), math.radians(185.0))
"""The same with a leaf, a line from the hinge to an end of the arc or to a place on it [rad]."""
LEAF_TOLERANCE = 0.08
"""Lines this close to the open or closed position of a leaf, and no longer than it, are part of it [m].

A half-open leaf is longer than the radius of its arc by at most this."""
MAX_SHORT = 0.03
"""Maximum length by which a half-open leaf is shorter than the radius of its arc [m]."""
ROUND_TOLERANCE = 0.03
"""Maximum deviation of an arc from its circle, as a fraction of its radius."""
STEP_SPACING = (0.18, 0.42)
"""Minimum and maximum spacing of stair steps [m]."""
SPACING_TOLERANCE = 0.15
"""Maximum relative difference of spacings and lengths in a pattern."""
MIN_HATCH_LINES, MANY_STEPS = 5, 4
"""Minimum number of evenly spaced parallel lines in a hatch, and in stairs."""


@dataclass(frozen=True, slots=True, eq=False)
class Pieces:
    """Straight pieces with both ends, and the stroke of each."""

    ends: Array
    """Shape (n, 2, 2) [m]."""
    owner: Indices
    """Index of the stroke, shape (n,)."""

    def where(self, mask: Cells) -> "Pieces":
        """Return the pieces where `mask`, shape (n,), is true."""
        return Pieces(self.ends[mask], self.owner[mask])

    @property
    def lengths(self) -> Array:
        """Length of each piece, shape (n,) [m]."""
        return np.asarray(np.hypot(*(self.ends[:, 1] - self.ends[:, 0]).T))


@dataclass(frozen=True, slots=True, eq=False)
class Arc:
    """A circular arc, such as a door-swing arc."""

    middle: Array
    """Centre of the circle, the hinge of a door, shape (2,) [m]."""
    radius: float
    points: Array
    """Points along the arc, shape (n, 2) [m]."""
    first: float
    """Angle of its first point from the centre [rad]."""
    sweep: float
    """Angle that it sweeps from there, counter-clockwise [rad]."""
    owner: int
    """Index of the stroke."""

    @property
    def ends(self) -> Array:
        """Both ends, shape (2, 2) [m]."""
        return np.asarray(self.points[[0, -1]])


def split(strokes: Sequence[Array], closed: Sequence[bool]) -> tuple[Pieces, list[Arc]]:
    """Return the straight pieces of strokes, and the possible door-swing arcs, which are not among the pieces."""
    pieces: list[Array] = []
    owners: list[int] = []
    arcs: list[Arc] = []
    unsure: list[Arc] = []
    for index, (points, ring) in enumerate(zip(strokes, closed, strict=True)):
        corners = np.concatenate([points, points[:1]]) if ring else points
        for run, curved in runs(corners):
            arc = arc_through(run, index) if curved else None
            if arc is not None and is_door_arc(arc):
                arcs.append(arc)
            elif arc is not None and is_door_arc(arc, LEAF_SWEEP):
                unsure.append(arc)
            else:
                pieces += list(np.stack([run[:-1], run[1:]], axis=1))
                owners += [index] * (len(run) - 1)
    ends = np.array(pieces, dtype=float).reshape(-1, 2, 2)
    for arc in unsure:
        if _has_leaf(arc, ends):
            arcs.append(arc)
        else:
            pieces += list(np.stack([arc.points[:-1], arc.points[1:]], axis=1))
            owners += [arc.owner] * (len(arc.points) - 1)
    ends = np.array(pieces, dtype=float).reshape(-1, 2, 2)
    found = Pieces(ends, np.array(owners, dtype=int))
    return found.where(found.lengths > 1e-6), arcs


def _has_leaf(arc: Arc, ends: Array) -> bool:
    """Return whether a straight piece, of shape (n, 2, 2) [m], runs from the hinge to an end of an arc or along it."""
    starts = np.concatenate([ends, ends[:, ::-1]])
    at_hinge = starts[np.hypot(*(starts[:, 0] - arc.middle).T) <= LEAF_TOLERANCE]
    to_end = any((np.hypot(*(at_hinge[:, 1] - end).T) <= LEAF_TOLERANCE).any() for end in arc.ends)
    return to_end or len(leaf_tips(ends, arc)) > 0


def leaf_tips(pieces: Array, arc: Arc) -> Array:
    """Return the ends of pieces from the hinge of an arc to a place on it, as of half-open leaves, shape (n, 2) [m].

    Args:
        pieces: Ends of straight pieces, shape (n, 2, 2) [m].
        arc: A door-swing arc.
    """
    ends = np.concatenate([pieces, pieces[:, ::-1]])
    along = ends[:, 1] - arc.middle
    at_hinge = np.hypot(*(ends[:, 0] - arc.middle).T) <= LEAF_TOLERANCE
    turn = (np.arctan2(along[:, 1], along[:, 0]) - arc.first) % (2.0 * math.pi)
    beyond = np.hypot(*along.T) - arc.radius
    reaches = (beyond >= -MAX_SHORT) & (beyond <= LEAF_TOLERANCE)
    return np.asarray(ends[at_hinge & reaches & (turn <= arc.sweep), 1])


def runs(corners: Array) -> list[tuple[Array, bool]]:
    """Return the sections of a polyline between its sharp corners, and whether each is a curve."""
    steps = np.diff(corners, axis=0)
    steps = steps[np.hypot(*steps.T) > 1e-9]
    if len(steps) < 3:
        return [(corners, False)]
    headings = np.arctan2(steps[:, 1], steps[:, 0])
    bends = (np.diff(headings) + math.pi) % (2 * math.pi) - math.pi
    lengths = np.hypot(*steps.T)
    places = np.concatenate([corners[:1], corners[0] + np.cumsum(steps, axis=0)])
    found, first = [], 0
    for index in range(len(bends) + 1):
        last = index == len(bends)
        gentle = not last and 1e-3 < abs(bends[index]) < SMOOTH
        similar = not last and max(lengths[index : index + 2]) < 3.0 * min(lengths[index : index + 2])
        same = last or index == first or bends[index] * bends[index - 1] > 0
        if last or not (gentle and similar and same):
            run = places[first : index + 2]
            found.append((run, len(run) > 3))
            first = index + 1
    return found


def arc_through(points: Array, owner: int) -> Arc | None:
    """Return the arc through points, shape (n, 2) [m]; None if they do not lie on a circle."""
    shifted = points - points[0]
    A = np.column_stack([2 * shifted, np.ones(len(points))])
    (x, y, rest), *_ = np.linalg.lstsq(A, (shifted**2).sum(axis=1), rcond=None)
    radius = math.sqrt(max(0.0, rest + x * x + y * y))
    away = shifted - [x, y]
    if np.abs(np.hypot(*away.T) - radius).max() > ROUND_TOLERANCE * radius:
        return None
    turns = np.unwrap(np.arctan2(away[:, 1], away[:, 0]))
    sweep = float(turns[-1] - turns[0])
    first = float(turns[0] if sweep > 0 else turns[-1])
    return Arc(points[0] + [x, y], radius, points, first, abs(sweep), owner)


def is_door_arc(arc: Arc, sweep: tuple[float, float] = DOOR_SWEEP) -> bool:
    """Return whether an arc may be a door-swing arc, by its radius and the angle that it sweeps [rad]."""
    return DOOR_RADII[0] <= arc.radius <= DOOR_RADII[1] and sweep[0] <= arc.sweep <= sweep[1]


def patterned(pieces: Pieces) -> tuple[Cells, int]:
    """Return which pieces are parts of hatches or stairs, shape (n,), and the number of such patterns."""
    lengths = pieces.lengths
    along = pieces.ends[:, 1] - pieces.ends[:, 0]
    headings = np.arctan2(along[:, 1], along[:, 0]) % math.pi
    found, count = np.zeros(len(lengths), dtype=bool), 0
    order = np.lexsort((lengths, np.round(headings / math.radians(1.0))))
    groups = np.split(order, np.flatnonzero(_changes(headings[order], lengths[order])) + 1)
    for group in groups:
        for run in _ladders(pieces, group):
            found[run] = True
            count += 1
    return found, count


def _changes(headings: Array, lengths: Array) -> Cells:
    """Return where the next piece differs in direction or length, shape (n - 1,)."""
    turned = np.abs(np.diff(headings)) > math.radians(1.5)
    return np.asarray(turned | (np.diff(lengths) > SPACING_TOLERANCE * lengths[:-1]) | (np.diff(lengths) < 0))


def _ladders(pieces: Pieces, group: Indices) -> list[Indices]:
    """Return the runs of evenly spaced, adjacent pieces of equal direction and length."""
    if len(group) < MANY_STEPS:
        return []
    start, end = pieces.ends[group[0]]
    unit = (end - start) / max(1e-9, math.hypot(*(end - start)))
    middles = pieces.ends[group].mean(axis=1)
    u, v = middles @ unit, middles @ [-unit[1], unit[0]]
    length = float(pieces.lengths[group].mean())
    ladders: list[Indices] = []
    for column in _columns(u, 0.6 * length):
        order = column[np.argsort(v[column])]
        gaps = np.diff(v[order])
        first = 0
        for index in range(len(gaps) + 1):
            even = (
                index < len(gaps)
                and index > first
                and abs(gaps[index] - gaps[first]) <= SPACING_TOLERANCE * gaps[first] + 2e-3
            )
            if index == len(gaps) or (index > first and not even):
                if _is_pattern(index - first + 1, gaps[first:index], length):
                    ladders.append(group[order[first : index + 1]])
                first = index
    return ladders


def _is_pattern(count: int, gaps: Array, length: float) -> bool:
    if not len(gaps) or gaps.mean() < 5e-3:
        return False
    spacing = float(gaps.mean())
    steps = STEP_SPACING[0] <= spacing <= STEP_SPACING[1] and 0.6 <= length <= 4.0
    return count >= (MANY_STEPS if steps else MIN_HATCH_LINES) and spacing <= STEP_SPACING[1]


def _columns(u: Array, reach: float) -> list[Indices]:
    """Return the indices of positions that are close to each other along a line."""
    order = np.argsort(u)
    return np.split(order, np.flatnonzero(np.diff(u[order]) > reach) + 1)
