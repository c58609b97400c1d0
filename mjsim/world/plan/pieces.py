"""Cuts walls into solid prisms, mitred at corners and with openings cut out.

Shared by the scene, the plan and the checks; plain floats, so that ten thousand segments take a fraction of a second.
"""

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from mjsim.geometry import Array
from mjsim.world.items import Opening, Wall

MITRE_LIMIT = math.sqrt(2.0)
"""Maximum distance from a corner to its tip, in half thicknesses: that of a right angle. Sharper corners are cut off
there."""
SLIVER = 1e-6
"""Shorter or lower pieces are left out [m]."""

Pair = tuple[float, float]


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """A solid part of a wall segment: a prism with a convex four-sided outline."""

    segment: int
    """Index of the wall segment, from 0."""
    start: Array
    """Start on the centreline, world frame, shape (2,) [m]."""
    end: Array
    """End on the centreline, world frame, shape (2,) [m]."""
    low: float
    """Height of its lower face [m]."""
    high: float
    """Height of its upper face [m]."""
    outline: Array
    """Start right, end right, end left, start left: counter-clockwise, world frame, shape (4, 2) [m]; mitred at joined
    corners."""


@dataclass(frozen=True, slots=True)
class _Segment:
    """A segment of a wall in its own frame: along the centreline, and to the left of it."""

    start: tuple[float, float]
    along: tuple[float, float]
    """Unit vector, world frame."""
    length: float

    def point(self, along: float, left: float) -> tuple[float, float]:
        """Return a point of the segment's frame in the world frame [m]."""
        (x, y), (c, s) = self.start, self.along
        return x + along * c - left * s, y + along * s + left * c


def wall_pieces(wall: Wall) -> list[Piece]:
    """Return the solid pieces of a wall, segment by segment, from its first corner to its last.

    Consecutive pieces share an edge exactly, at corners along the mitre. At a corner of more than a right angle, the
    pieces end square, and bars form its tip; at a corner of segments too short for a mitre, or beside an opening,
    square ends overlap. The prisms of a wall leave no gap.
    """
    segments = [_segment(start, end) for start, end in wall.segments()]
    openings: list[list[Opening]] = [[] for _ in segments]
    for opening in wall.openings:
        openings[opening.segment].append(opening)
    parts = [
        list(solid_parts(segment.length, wall.height, holes)) for segment, holes in zip(segments, openings, strict=True)
    ]
    half, whole = wall.thickness / 2, [(0.0, wall.height)]
    corners = [_FREE] * (len(segments) + 1)
    pieces: list[Piece] = []
    for index in range(0 if wall.closed else 1, len(segments)):
        before, after = segments[index - 1], segments[index]
        ends = [part[2:] for part in parts[index - 1] if part[1] >= before.length]
        starts = [part[2:] for part in parts[index] if part[0] <= 0.0]
        corners[index] = _corner(before, after, half, even=ends == starts == whole)
        if corners[index].sharp:
            pieces += sharp_tip(index, (after.start, before.along, after.along), half, ends, starts)
    corners[-1] = corners[0]
    for index, segment in enumerate(segments):
        for first, last, low, high in parts[index]:
            outline = _outline(segment, half, (corners[index], corners[index + 1]), (first, last))
            start, end = np.array((segment.point(first, 0.0), segment.point(last, 0.0)))
            pieces.append(Piece(index, start, end, low, high, outline))
    return sorted(pieces, key=lambda piece: piece.segment)


def sharp_tip(
    segment: int,
    corner: tuple[Pair, Pair, Pair],
    half: float,
    ends: Sequence[Pair],
    starts: Sequence[Pair],
) -> Iterator[Piece]:
    """Yield the bars that form the tip of a corner that turns by more than a right angle.

    One bar extends each of the two segments, as far as the cut-off and no deeper than the other segment's face; one
    runs from the corner straight to the cut-off.

    Args:
        segment: Segment index of the pieces.
        corner: Position of the corner [m], direction of the segment that arrives, and of the one that leaves.
        half: Half the thickness [m].
        ends: Height intervals in which the first segment is solid at the corner [m].
        starts: The same for the next segment.
    """
    (x, y), (ax, ay), (bx, by) = corner
    cosine, side = ax * bx + ay * by, -1.0 if ax * by - ay * bx > 0.0 else 1.0
    c, s = math.sqrt(max(1.0 + cosine, 0.0) / 2), math.sqrt((1.0 - cosine) / 2)
    far = half * (MITRE_LIMIT - c) / s
    deep = (half - far * 2.0 * s * c) / -cosine
    across = side * (half - deep) / 2
    cut = half * MITRE_LIMIT / math.hypot(ax - bx, ay - by)
    for (ux, uy), (nx, ny), heights in (((ax, ay), (-ay, ax), ends), ((-bx, -by), (-by, bx), starts)):
        back = x + nx * across - ux * half, y + ny * across - uy * half
        ahead = x + nx * across + ux * far, y + ny * across + uy * far
        for low, high in heights:
            yield bar(segment, back, ahead, (half + deep) / 2, (low, high))
    for low, high in ends:
        yield bar(segment, (x, y), (x + (ax - bx) * cut, y + (ay - by) * cut), half * s - far * c, (low, high))


def bar(segment: int, start: Pair, end: Pair, half: float, heights: Pair) -> Piece:
    """Return a piece with a rectangular outline, from both ends of its centreline and half its width [m]."""
    line = _segment(start, end)
    outline = [line.point(x, y) for x, y in ((0.0, -half), (line.length, -half), (line.length, half), (0.0, half))]
    return Piece(segment, np.array(start), np.array(end), *heights, np.array(outline))


def solid_parts(
    length: float, height: float, openings: Sequence[Opening]
) -> Iterator[tuple[float, float, float, float]]:
    """Yield the solid parts of a segment between openings, as (along start, along end, low, high) [m], in order.

    Openings may overlap each other and may extend past the segment; the excess is ignored.
    """
    if not openings and min(length, height) >= SLIVER:
        yield 0.0, length, 0.0, height
        return
    cuts = {0.0, length}
    for opening in openings:
        cuts |= {min(opening.at, length), min(opening.at + opening.width, length)}
    edges = sorted(cuts)
    for first, last in itertools.pairwise(edges):
        if last - first < SLIVER:
            continue
        middle = (first + last) / 2
        gaps = sorted((o.sill, o.head) for o in openings if o.at < middle < o.at + o.width)
        floor = 0.0
        for sill, head in [*gaps, (height, height)]:
            if min(sill, height) - floor > SLIVER:
                yield first, last, floor, min(sill, height)
            floor = max(floor, head)


@dataclass(frozen=True, slots=True)
class _Corner:
    """Distances by which two segments extend past their common corner [m]."""

    left: float
    """On the left side; when mitred, the right side extends by the negative of it."""
    right: float
    sharp: bool = False
    """Whether to add a tip."""


_FREE = _Corner(0.0, 0.0)


def _segment(start: Sequence[float], end: Sequence[float]) -> _Segment:
    dx, dy = end[0] - start[0], end[1] - start[1]
    length = math.hypot(dx, dy)
    return _Segment((start[0], start[1]), (dx / length, dy / length), length)


def _corner(a: _Segment, b: _Segment, half: float, *, even: bool) -> _Corner:
    """Return how two segments are joined: by a mitre of half the thickness times the tangent of half their turn.

    Args:
        a: A segment.
        b: The next segment.
        half: Half their thickness [m].
        even: Whether neither has an opening at the corner.
    """
    cross = a.along[0] * b.along[1] - a.along[1] * b.along[0]
    cosine = a.along[0] * b.along[0] + a.along[1] * b.along[1]
    shortest = min(a.length, b.length)
    if cosine < -1e-9 and shortest >= half:
        return _Corner(0.0, 0.0, sharp=True)
    tangent = cross / (1.0 + cosine) if cosine > -0.999999 else math.inf
    reach = half * min(abs(tangent), 1.0)
    if not even or reach > shortest / 2 or abs(tangent) > 1.000001:
        return _Corner(reach, reach)
    return _Corner(-half * tangent, half * tangent)


def _outline(segment: _Segment, half: float, ends: tuple[_Corner, _Corner], span: tuple[float, float]) -> Array:
    first, last = span
    before = ends[0] if first <= 0.0 else _FREE
    after = ends[1] if last >= segment.length else _FREE
    # Openings near both ends would invert the outline: then the piece ends inside its solid neighbour.
    thin = (last - first) / 4
    right = min(first - before.right, last - thin), max(last + after.right, first + thin)
    left = min(first - before.left, last - thin), max(last + after.left, first + thin)
    return np.array(
        [
            segment.point(right[0], -half),
            segment.point(right[1], -half),
            segment.point(left[1], half),
            segment.point(left[0], half),
        ]
    )
