"""Walls cut into solid prisms: mitred at their corners, pierced by their openings.

The mathematics that the scene, the plan and the checks share; plain floats, so that ten thousand segments take
a fraction of a second.
"""

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from mjsim.geometry import Array
from mjsim.world.structure import Opening, Wall

SHARPEST_MITRE = 3.0
"""Largest mitre, as a multiple of half the thickness (a turn of 143 degrees); sharper corners overlap instead."""
SLIVER = 1e-6
"""Shorter or lower pieces are left out [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """A solid part of one segment of a wall: a prism on a convex four-sided outline."""

    segment: int
    """Which segment of the wall, counted from 0."""
    start: Array
    """Where it begins on the centreline, world frame, shape (2,) [m]."""
    end: Array
    """Where it ends on the centreline, world frame, shape (2,) [m]."""
    low: float
    """Height of its lower face [m]."""
    high: float
    """Height of its upper face [m]."""
    outline: Array
    """Start right, end right, end left, start left: counter-clockwise, shape (4, 2) [m]; mitred at joined corners."""


@dataclass(frozen=True, slots=True)
class _Segment:
    """A segment of a wall in its own frame: along the centreline, and to the left of it."""

    start: tuple[float, float]
    along: tuple[float, float]
    """Unit vector."""
    length: float

    def point(self, along: float, left: float) -> tuple[float, float]:
        """Return a point of the segment's frame in the world frame [m]."""
        (x, y), (c, s) = self.start, self.along
        return x + along * c - left * s, y + along * s + left * c


def wall_pieces(wall: Wall) -> list[Piece]:
    """Return the solid pieces of a wall, segment by segment, from its first corner to its last.

    Consecutive pieces share their edge exactly, at corners along the mitre; a corner too sharp for a mitre,
    or of segments too short for it, is filled by letting both ends overlap. The prisms of a wall leave no gap.
    """
    segments = [_segment(start, end) for start, end in wall.segments()]
    half = wall.thickness / 2
    joints = [_joint(a, b, half) for a, b in zip(segments, segments[1:] + segments[:1], strict=True)]
    if not wall.closed:
        joints[-1] = _Joint(0.0, 0.0)
    pieces: list[Piece] = []
    for index, segment in enumerate(segments):
        ends = (joints[index - 1] if index or wall.closed else _Joint(0.0, 0.0)), joints[index]
        openings = [opening for opening in wall.openings if opening.segment == index]
        for first, last, low, high in solid_parts(segment.length, wall.height, openings):
            outline = _outline(segment, half, ends, (first, last))
            start, end = np.array(segment.point(first, 0.0)), np.array(segment.point(last, 0.0))
            pieces.append(Piece(index, start, end, low, high, outline))
    return pieces


def solid_parts(
    length: float, height: float, openings: Sequence[Opening]
) -> Iterator[tuple[float, float, float, float]]:
    """Yield what openings leave of a segment, as (along start, along end, low, high) [m], in order along it.

    Openings may overlap each other and may reach past the segment; what is beyond is ignored.
    """
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
class _Joint:
    """How far two segments reach past their common corner [m]."""

    left: float
    """On the left side; the right side reaches as far the other way when mitred."""
    right: float


def _segment(start: Sequence[float], end: Sequence[float]) -> _Segment:
    dx, dy = end[0] - start[0], end[1] - start[1]
    length = math.hypot(dx, dy)
    return _Segment((start[0], start[1]), (dx / length, dy / length), length)


def _joint(a: _Segment, b: _Segment, half: float) -> _Joint:
    """Return the mitre of two consecutive segments: half the thickness times the tangent of half their turn."""
    cross = a.along[0] * b.along[1] - a.along[1] * b.along[0]
    cosine = a.along[0] * b.along[0] + a.along[1] * b.along[1]
    tangent = cross / (1.0 + cosine) if cosine > -0.999999 else math.inf
    reach = half * abs(tangent)
    if abs(tangent) > SHARPEST_MITRE or reach > min(a.length, b.length) / 2:
        square = min(reach, half)
        return _Joint(square, square)
    return _Joint(-half * tangent, half * tangent)


def _outline(segment: _Segment, half: float, ends: tuple[_Joint, _Joint], span: tuple[float, float]) -> Array:
    first, last = span
    before = ends[0] if first <= 0.0 else _Joint(0.0, 0.0)
    after = ends[1] if last >= segment.length else _Joint(0.0, 0.0)
    # An opening inside a mitre would turn the outline inside out: the piece then ends in the neighbour's solid.
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
