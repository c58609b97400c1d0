"""Doors and windows of a drawing: where symbols lie on walls, or lines cross the gap between two walls; in metres."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mjsim.exchange.drawings.strokes import Arc, Pieces
from mjsim.exchange.drawings.wall_faces import PARALLEL, gaps, joined
from mjsim.exchange.maps import Bar
from mjsim.geometry import Array
from mjsim.world import Opening, Wall

MIN_WIDTH, MAX_WIDTH = 0.4, 4.0
"""Minimum and maximum width of an opening [m]."""
MAX_SYMBOL_DISTANCE = 0.12
"""Maximum distance of a symbol from the face of its wall [m]."""
MIN_SPANNED_SHARE = 0.5
"""Minimum fraction of a gap that the symbol in it spans."""
SILL_HEIGHT, HEAD = 0.9, 2.0
"""Height of sill and head of windows [m]."""
MAX_LONGER = 0.5
"""Maximum length by which a symbol is longer than the gap that it spans [m]."""
MARGIN = 0.02
"""Minimum distance between an opening and the end of its wall segment [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Hole:
    """A doorway or a window in a wall."""

    ends: Array
    """Both ends on the centreline of the wall, shape (2, 2) [m]."""
    window: bool


def doors_and_windows(
    bars: Sequence[Bar], pieces: Pieces, arcs: Sequence[Arc], doors: Sequence[Array], windows: Sequence[Array]
) -> tuple[list[Bar], list[Hole]]:
    """Return walls continued through their doors and windows, and these openings.

    Args:
        bars: Walls.
        pieces: Straight segments that may be panes and posts.
        arcs: Door-swing arcs.
        doors: Corners of other door symbols, shape (n, 2) each [m].
        windows: Corners of window symbols, shape (n, 2) each [m].
    """
    bars, holes = list(bars), []
    symbols = [np.stack([arc.middle, end]) for arc in arcs for end in arc.ends]
    while found := _filled_gaps(bars, pieces, [*symbols, *doors], windows):
        taken = {k for one, other, _ in found for k in (one, other)}
        joints = [joined(bars[one], bars[other]) for one, other, _ in found]
        bars = [bar for k, bar in enumerate(bars) if k not in taken] + joints
        holes += [hole for _, _, hole in found]
    lines = _Lines.of([bar.ends for bar in bars], [bar.width for bar in bars])
    for arc in arcs:
        options = [np.stack([arc.middle, end]) for end in arc.ends]
        spots = [spot for ends in options if (spot := _spot(lines, ends)) is not None]
        if spots:
            holes.append(Hole(min(spots, key=lambda spot: spot[0])[1], window=False))
    for corners, window in [*((corners, False) for corners in doors), *((corners, True) for corners in windows)]:
        if (spot := _spot(lines, corners)) is not None:
            holes.append(Hole(spot[1], window))
    holes += [Hole(ends, window=True) for bar in bars for ends in _panes(bar, pieces)]
    return bars, _distinct(holes)


def with_openings(walls: Sequence[Wall], holes: Sequence[Hole]) -> list[Wall]:
    """Return walls with their openings; an opening that does not fit in any wall is left out."""
    numbers = [(index, segment) for index, wall in enumerate(walls) for segment in range(len(wall.segments()))]
    ends = [np.array(segment) for wall in walls for segment in wall.segments()]
    segments = _Lines.of(ends, [walls[index].thickness for index, _ in numbers])
    openings: dict[int, list[Opening]] = {}
    for hole in holes:
        if (place := _place(segments, hole)) is None:
            continue
        (index, segment), at, width = numbers[place[0]], *place[1:]
        others = [other for other in openings.get(index, []) if other.segment == segment]
        if any(at < other.at + other.width + MARGIN and other.at < at + width + MARGIN for other in others):
            continue
        opening = Opening(segment=segment, at=at, width=width)
        pane = opening.model_copy(update={"sill": SILL_HEIGHT, "head": HEAD})
        openings.setdefault(index, []).append(pane if hole.window else opening)
    return [
        wall.model_copy(update={"openings": tuple(sorted(openings.get(index, ()), key=lambda o: (o.segment, o.at)))})
        for index, wall in enumerate(walls)
    ]


def _filled_gaps(
    bars: Sequence[Bar], pieces: Pieces, doors: Sequence[Array], windows: Sequence[Array]
) -> list[tuple[int, int, Hole]]:
    """Return pairs of walls with a symbol between them and the opening there; each wall is in at most one pair."""
    found: list[tuple[int, int, Hole]] = []
    taken: set[int] = set()
    near_doors, near_windows = _boxes(doors), _boxes(windows)
    for one, other, ends in gaps(bars, MAX_WIDTH):
        if one in taken or other in taken or not MIN_WIDTH <= math.dist(*ends) <= MAX_WIDTH:
            continue
        width = bars[one].width
        # No symbol that spans a gap has a corner farther away than this: see `_spans`.
        box = ends.min(axis=0), ends.max(axis=0), math.dist(*ends) + width / 2 + MAX_SYMBOL_DISTANCE + MAX_LONGER
        close_doors, close_windows = (
            [symbols[k] for k in _meeting(boxes, *box)]
            for symbols, boxes in ((doors, near_doors), (windows, near_windows))
        )
        hole = _hole_in(ends, width, pieces, close_doors, close_windows)
        if hole is not None:
            taken |= {one, other}
            found.append((one, other, hole))
    return found


def _boxes(symbols: Sequence[Array]) -> tuple[Array, Array]:
    """Return the lowest and the highest corner of n symbols, shape (n, 2) each [m]."""
    lows, highs = [corners.min(axis=0) for corners in symbols], [corners.max(axis=0) for corners in symbols]
    return np.array(lows).reshape(-1, 2), np.array(highs).reshape(-1, 2)


def _meeting(boxes: tuple[Array, Array], low: Array, high: Array, reach: float) -> list[int]:
    """Return the numbers of the boxes that meet another one, grown by `reach` [m]."""
    return np.flatnonzero(((boxes[0] <= high + reach) & (boxes[1] >= low - reach)).all(axis=1)).tolist()


def _hole_in(
    ends: Array, width: float, pieces: Pieces, doors: Sequence[Array], windows: Sequence[Array]
) -> Hole | None:
    """Return the doorway or window that the symbols in a gap stand for; each of two leaves may be half a doorway."""
    reach = width / 2 + MAX_SYMBOL_DISTANCE
    if any(_spans(ends, corners, reach) for corners in windows):
        return Hole(ends, window=True)
    whole = any(_spans(ends, corners, reach) for corners in doors)
    halves = 0 if whole else sum(_spans(ends, corners, reach, share=0.35) for corners in doors)
    if whole or halves > 1:
        return Hole(ends, window=False)
    # A doorway may also have threshold lines.
    return Hole(ends, window=True) if _has_panes(ends, width, pieces) else None


def _along(ends: Array, points: Array) -> tuple[Array, Array]:
    """Return the positions of points along a line from its first end, and their offsets to its left [m]."""
    unit = (ends[1] - ends[0]) / math.dist(*ends)
    offset = points - ends[0]
    return offset @ unit, offset @ np.array([-unit[1], unit[0]])


def _spans(ends: Array, corners: Array, reach: float, *, share: float = MIN_SPANNED_SHARE) -> bool:
    """Return whether a symbol lies in a gap: close to its line, and along enough of it."""
    u, v = _along(ends, corners)
    length = math.dist(*ends)
    if np.abs(v).min() > reach or (len(corners) == 2 and np.abs(v).max() > reach):
        return False
    overlap = min(length, float(u.max())) - max(0.0, float(u.min()))
    return overlap >= share * length and float(np.ptp(u)) <= length + MAX_LONGER


def _has_panes(ends: Array, width: float, pieces: Pieces) -> bool:
    """Return whether at least two lines cross a gap from end to end within the thickness of the wall."""
    return lines_through(ends, width, pieces) >= 2


def lines_through(ends: Array, width: float, pieces: Pieces) -> int:
    """Return the number of lines that run from one end of a wall section to the other within its thickness."""
    u, v = _along(ends, pieces.ends.reshape(-1, 2))
    u, v = u.reshape(-1, 2), v.reshape(-1, 2)
    length = math.dist(*ends)
    inside = (np.abs(v).max(axis=1) <= width / 2 + 0.02) & (np.ptp(v, axis=1) <= 0.02)
    through = (u.min(axis=1) <= 0.1 * length) & (u.max(axis=1) >= 0.9 * length)
    return int(np.count_nonzero(inside & through))


@dataclass(frozen=True, slots=True, eq=False)
class _Lines:
    """Centrelines of n walls, as arrays."""

    starts: Array
    """(n, 2) [m]"""
    units: Array
    """Directions, (n, 2)."""
    lengths: Array
    widths: Array
    """(n,) [m]"""

    @classmethod
    def of(cls, ends: Sequence[Array], widths: Sequence[float]) -> "_Lines":
        """Return lines from both ends of each, shape (2, 2) [m], and their widths [m]."""
        places = np.array(ends, dtype=float).reshape(-1, 2, 2)
        way = places[:, 1] - places[:, 0]
        lengths = np.hypot(way[:, 0], way[:, 1])
        return cls(places[:, 0], way / lengths[:, None], lengths, np.array(widths, dtype=float))

    def along(self, points: Array) -> tuple[Array, Array]:
        """Return the positions of k points along each line, and their offsets to its left, shape (n, k) [m]."""
        offset = points - self.starts[:, None]
        u = (offset * self.units[:, None]).sum(axis=2)
        return u, offset[..., 1] * self.units[:, :1] - offset[..., 0] * self.units[:, 1:]


def _spot(lines: _Lines, corners: Array) -> tuple[float, Array] | None:
    """Return the distance of a symbol from its wall and its extent on it, shape (2, 2) [m]; None if on no wall."""
    u, v = lines.along(corners)
    low, high, sides = u.min(axis=1), u.max(axis=1), np.abs(v)
    fits = (low >= -MARGIN) & (high <= lines.lengths + MARGIN) & (high - low >= MIN_WIDTH) & (high - low <= MAX_WIDTH)
    if len(corners) == 2:
        distance = sides.max(axis=1)
        fits &= np.ptp(v, axis=1) <= np.maximum(0.2 * math.dist(*corners), lines.widths)
    else:
        distance = sides.min(axis=1)
    fits &= distance <= lines.widths / 2 + MAX_SYMBOL_DISTANCE
    if not fits.any():
        return None
    best = int(np.argmin(np.where(fits, distance, math.inf)))
    return float(distance[best]), lines.starts[best] + np.outer([low[best], high[best]], lines.units[best])


def _panes(bar: Bar, pieces: Pieces) -> list[Array]:
    """Return where panes lie in a wall between two posts that cross it, shape (2, 2) each [m]."""
    u, v = _along(bar.ends, pieces.ends.reshape(-1, 2))
    u, v = u.reshape(-1, 2), v.reshape(-1, 2)
    inside = (
        (np.abs(v).max(axis=1) <= bar.width / 2 + 0.01) & (u.min(axis=1) > -0.01) & (u.max(axis=1) < bar.length + 0.01)
    )
    posts = inside & (np.ptp(u, axis=1) < 0.01) & (np.ptp(v, axis=1) > 0.8 * bar.width)
    panes = inside & (np.ptp(v, axis=1) < 0.01) & (np.abs(v).max(axis=1) < bar.width / 2 - 0.01)
    places = np.unique(np.round(u[posts].mean(axis=1), 3))
    found = []
    for low, high in itertools.pairwise(places.tolist()):
        slack = 0.1 * (high - low)
        across = (u[panes].min(axis=1) <= low + slack) & (u[panes].max(axis=1) >= high - slack)
        if MIN_WIDTH <= high - low <= MAX_WIDTH and across.any():
            found.append(bar.ends[0] + np.outer([low, high], bar.along))
    return found


def _distinct(holes: Sequence[Hole]) -> list[Hole]:
    """Return openings without those that overlap an earlier one; two leaves side by side become one doorway."""
    distinct: list[Hole] = []
    for hole in holes:
        for index, other in enumerate(distinct):
            u, v = _along(other.ends, hole.ends)
            length = math.dist(*other.ends)
            if np.abs(v).max() > 0.1 or float(u.max()) < -0.05 or float(u.min()) > length + 0.05:
                continue
            if not (hole.window or other.window) and float(u.max()) - float(u.min()) > 0.0:
                unit = (other.ends[1] - other.ends[0]) / length
                low, high = min(0.0, float(u.min())), max(length, float(u.max()))
                if high - low <= MAX_WIDTH:
                    distinct[index] = Hole(other.ends[0] + np.outer([low, high], unit), window=False)
            break
        else:
            distinct.append(hole)
    return distinct


def _place(segments: _Lines, hole: Hole) -> tuple[int, float, float] | None:
    """Return the number of the segment that contains an opening, where it starts along it, and its width [m]."""
    u, v = segments.along(hole.ends)
    distance, low = np.abs(v).max(axis=1), np.maximum(MARGIN, u.min(axis=1))
    length = np.minimum(segments.lengths - MARGIN, u.max(axis=1)) - low
    width = np.round(length, 3)
    fits = np.ptp(v, axis=1) <= np.maximum(0.02, 5 * PARALLEL * np.ptp(u, axis=1))
    fits &= (distance <= segments.widths / 2 + 0.02) & (width >= 0.3) & (length >= 0.7 * math.dist(*hole.ends))
    if not fits.any():
        return None
    best = int(np.argmin(np.where(fits, distance, math.inf)))
    return best, round(float(low[best]), 3), float(width[best])
