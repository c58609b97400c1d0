"""Junctions of walls: ends that touch, ends at another wall's face, ends that meet at an angle.

Each free end is extended only as far as needed: to the outer face of another end, so that both form a corner, or into
the middle of a wall. The extensions are additional pieces of the extended wall.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from mjsim.world.items import Wall
from mjsim.world.plan.pieces import SLIVER, Pair, Piece, bar, sharp_tip, wall_pieces

TOUCH = 0.02
"""An end within this distance of another wall is meant to touch it [m]."""
SHALLOW = math.sin(math.radians(10.0))
"""Sine of the angle below which a wall runs alongside another instead of meeting it."""


@dataclass(frozen=True, slots=True)
class _Line:
    """A segment of a wall, world frame."""

    wall: int
    segment: int
    start: Pair
    along: Pair
    """Unit vector."""
    length: float
    half: float
    """Half the thickness [m]."""
    height: float
    free: tuple[bool, bool]
    """Whether its start and its end are free ends of the wall."""

    def end(self) -> Pair:
        """Return its end [m]."""
        return self.start[0] + self.along[0] * self.length, self.start[1] + self.along[1] * self.length


@dataclass(frozen=True, slots=True)
class _End:
    """An end of a wall."""

    line: _Line
    at: Pair
    out: Pair
    """Unit vector along the wall, outward."""
    heights: list[Pair]
    """Height intervals in which it is solid, from bottom to top [m]."""

    def bars(self, reach: float, heights: Sequence[Pair]) -> Iterator[Piece]:
        """Yield pieces that extend it by `reach` [m]."""
        (x, y), (ux, uy) = self.at, self.out
        back = min(self.line.half, self.line.length / 2)
        start, end = (x - ux * back, y - uy * back), (x + ux * reach, y + uy * reach)
        return (bar(self.line.segment, start, end, self.line.half, levels) for levels in heights)


def solid_pieces(walls: Sequence[Wall]) -> list[list[Piece]]:
    """Return the solid pieces of each wall, including those that join it to the walls it meets."""
    pieces = [wall_pieces(wall) for wall in walls]
    lines = [line for number, wall in enumerate(walls) for line in _lines(number, wall)]
    ends = [end for line in lines for end in _ends(line, pieces[line.wall])]
    for end, line in _touching(ends, lines):
        pieces[end.line.wall] += _joined(end, line, walls[line.wall])
    return pieces


def _lines(number: int, wall: Wall) -> Iterator[_Line]:
    segments = wall.segments()
    for index, ((x, y), (end_x, end_y)) in enumerate(segments):
        length = math.hypot(end_x - x, end_y - y)
        along = (end_x - x) / length, (end_y - y) / length
        free = not wall.closed and index == 0, not wall.closed and index == len(segments) - 1
        yield _Line(number, index, (x, y), along, length, wall.thickness / 2, wall.height, free)


def _ends(line: _Line, pieces: Sequence[Piece]) -> Iterator[_End]:
    (ux, uy), (starts, ends) = line.along, line.free
    if starts:
        levels = [
            (p.low, p.high) for p in pieces if p.segment == line.segment and math.dist(p.start, line.start) < SLIVER
        ]
        yield _End(line, line.start, (-ux, -uy), levels)
    if ends:
        at = line.end()
        levels = [(p.low, p.high) for p in pieces if p.segment == line.segment and math.dist(p.end, at) < SLIVER]
        yield _End(line, at, (ux, uy), levels)


def _touching(ends: Sequence[_End], lines: Sequence[_Line]) -> Iterator[tuple[_End, _Line]]:
    """Yield each end with each segment that it may meet, except those that its own corners already join."""
    if not ends or len(lines) < 2:
        return
    import shapely

    tree = shapely.STRtree(shapely.linestrings([(line.start, line.end()) for line in lines]))
    reach = max(line.half for line in lines) + TOUCH
    points = shapely.points([end.at for end in ends])
    for number, other in tree.query(points, predicate="dwithin", distance=reach).T.tolist():
        end, line = ends[number], lines[other]
        if end.line.wall != line.wall or abs(end.line.segment - line.segment) > 1:
            yield end, line


def _joined(end: _End, line: _Line, wall: Wall) -> Iterator[Piece]:
    """Yield the pieces that join an end to a segment of a wall; none if they do not meet."""
    (ux, uy), (free_start, free_end) = line.along, line.free
    if free_start and math.dist(end.at, line.start) <= TOUCH:
        yield from _corner(end, line, line.start, (ux, uy))
    elif free_end and math.dist(end.at, line.end()) <= TOUCH:
        yield from _corner(end, line, line.end(), (-ux, -uy))
    else:
        yield from _into_side(end, line, wall)


def _corner(end: _End, line: _Line, at: Pair, along: Pair) -> Iterator[Piece]:
    """Yield the pieces of one end for a corner of two ends; the other end contributes its own.

    Args:
        end: The end to extend.
        line: The segment that it meets.
        at: The end of that segment [m].
        along: Unit vector from there along the segment.
    """
    (ux, uy), half, other = end.out, end.line.half, line.half
    cosine, sine = ux * along[0] + uy * along[1], abs(ux * along[1] - uy * along[0])
    ahead = (at[0] - end.at[0]) * ux + (at[1] - end.at[1]) * uy
    reach = min(max((other - half * abs(cosine)) / sine, 0.0), max(half, other)) if sine > 1e-6 else 0.0
    if reach + ahead > SLIVER:
        yield from end.bars(reach + ahead, end.heights)
    if cosine < -1e-9 and sine > 1e-3:
        yield from sharp_tip(end.line.segment, (end.at, end.out, along), min(half, other), end.heights, ())


def _into_side(end: _End, line: _Line, wall: Wall) -> Iterator[Piece]:
    """Yield the pieces that extend an end into a segment at or just ahead of it."""
    (ux, uy), (vx, vy) = end.out, line.along
    dx, dy = end.at[0] - line.start[0], end.at[1] - line.start[1]
    beside, sine, cosine = abs(vx * dy - vy * dx), abs(vx * uy - vy * ux), ux * vx + uy * vy
    towards = (vx * dy - vy * dx) * (vx * uy - vy * ux) < 0.0
    if not towards or sine < SHALLOW or not SLIVER < beside <= line.half + TOUCH + SLIVER:
        return
    # Until a corner of the end reaches the far face, and at least to the near face.
    reach = min(beside, line.half + beside - end.line.half * abs(cosine)) / sine
    reach = max(reach, (beside - line.half) / sine)
    hit = vx * dx + vy * dy + reach * cosine
    slack = [0.0 if free else line.half for free in line.free]
    if not -slack[0] <= hit <= line.length + slack[1]:
        return
    openings = (opening for opening in wall.openings if opening.segment == line.segment)
    if any(o.at - end.line.half < hit < o.at + o.width + end.line.half for o in openings):
        return
    yield from end.bars(reach, [(low, min(high, line.height)) for low, high in end.heights if low < line.height])
