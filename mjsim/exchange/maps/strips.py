"""Fits walls to centrelines: to both sides of the wall, square to the main direction, extended to the wall's ends."""

import math
from collections.abc import Sequence

import numpy as np

from mjsim.exchange.maps.cell_shapes import Bar, bar_between, cells_in
from mjsim.exchange.maps.map_pixels import Cells
from mjsim.geometry import Array

SAMPLE_SPACING = 0.25
"""Spacing of sample points [cells]."""
GAP, BLIND_GAP = 2.5, 10.0
"""Maximum gap within a wall, where cells are known and where they are unknown [cells]."""
SQUARE = math.radians(2.0)
"""A long wall within this angle of the main direction or its perpendicular is aligned with it [rad]."""
SQUARE_DRIFT = 1.0
"""A short wall is aligned if it deviates by less than this over its length [cells]."""
LEVEL = math.radians(0.3)
"""The main direction is rounded to the grid axes within this angle [rad]."""
MIN_NEW_SHARE = 0.3
"""A wall is accepted if at least this fraction of it is not explained by earlier walls."""
MAX_FREE = 0.2
"""Maximum fraction of a wall in cells that the map knows as free."""


def along_walls(slim: Cells, cells: Cells, lines: Sequence[Array], free: Cells, *, thickest: float) -> list[Bar]:
    """Return walls along lines, largest first, without those already explained by others.

    Args:
        slim: Cells of walls only, shape (rows, columns).
        cells: The same, plus objects that touch walls and into which walls may continue.
        lines: Both ends of each line, shape (2, 2) [cells].
        free: Cells where no wall may be, shape (rows, columns).
        thickest: Thickness of the thickest wall [cells].
    """
    fits = [fit for line in lines if (fit := _fitted(slim, line, thickest)) is not None]
    main = _main_direction(fits)
    bars = [_followed(cells, free, _squared(slim, fit, main, thickest)) for fit in fits]
    explained = np.zeros_like(cells)
    chosen = []
    for bar in sorted(bars, key=_area, reverse=True):
        window, inner = cells_in(bar.outline(), cells.shape)
        count = max(1, int(np.count_nonzero(inner)))
        new = int(np.count_nonzero(inner & cells[window] & ~explained[window]))
        if new >= MIN_NEW_SHARE * count and np.count_nonzero(inner & free[window]) <= MAX_FREE * count:
            chosen.append(bar)
            window, covered = cells_in(bar.outline(grown=0.75), cells.shape)
            explained[window] |= covered
    return chosen


def _area(bar: Bar) -> float:
    return bar.length * bar.width


def _fitted(cells: Cells, line: Array, thickest: float) -> Bar | None:
    """Return the wall around a line: the line moved to its centre, with the distance between its sides as width."""
    bar = bar_between(line[0], line[1], 1.0)
    for _ in range(3):
        sides = _sides(cells, bar, thickest)
        if sides is None:
            return None
        u, middle, width = sides
        slope, offset = (0.0, float(np.median(middle)))
        if bar.length >= 4.0 and len(u) >= 4:
            for _ in range(2):
                slope, offset = np.polyfit(u, middle, 1).tolist()
                stray = np.abs(middle - slope * u - offset)
                good = stray <= max(0.5, 2.0 * float(np.median(stray)))
                u, middle, width = u[good], middle[good], width[good]
        left, rise = np.array([-bar.along[1], bar.along[0]]), slope * bar.length / 2
        start, end = bar.ends
        bar = bar_between(start + left * (offset - rise), end + left * (offset + rise), float(width.mean()))
    return bar


def _sides(cells: Cells, bar: Bar, thickest: float) -> tuple[Array, Array, Array] | None:
    """Return cross-sections of the wall along a line: positions from its centre, offsets of the wall, widths."""
    reach = thickest + 1.0
    count = max(3, round(bar.length))
    inset = min(bar.length / 6, thickest / 2)
    u = np.linspace(-bar.length / 2 + inset, bar.length / 2 - inset, count)
    v = np.arange(SAMPLE_SPACING / 2, reach, SAMPLE_SPACING)
    across = np.concatenate([-v[::-1], v])
    inside = _values_at(cells, bar, u[:, None], across)
    up, down = inside[:, len(v) :], inside[:, : len(v)][:, ::-1]
    high = np.where(up.all(axis=1), len(v), np.argmin(up, axis=1)) * SAMPLE_SPACING
    low = np.where(down.all(axis=1), len(v), np.argmin(down, axis=1)) * SAMPLE_SPACING
    width = high + low
    found = width > 0
    if np.count_nonzero(found) < 2:
        return None
    good = found & (width <= 1.4 * np.median(width[found]) + 0.5) & (width <= thickest)
    if not good.any():
        return None
    return u[good], (high - low)[good] / 2, width[good]


def _values_at(cells: Cells, bar: Bar, u: Array, v: Array) -> Cells:
    """Return whether points along and across a bar, from its centre, are in occupied cells."""
    c, s = bar.along
    column = np.floor(bar.x + u * c - v * s).astype(int)
    row = np.floor(bar.y + u * s + v * c).astype(int)
    rows, columns = cells.shape
    inside = (column >= 0) & (column < columns) & (row >= 0) & (row < rows)
    return np.asarray(inside & cells[row.clip(0, rows - 1), column.clip(0, columns - 1)])


def _main_direction(bars: Sequence[Bar]) -> float | None:
    """Return the direction parallel or perpendicular to most length, in [-pi/4, pi/4) [rad]; None without walls."""
    long = [bar for bar in bars if bar.length >= 6.0]
    if not long:
        return None
    turns = np.array([bar.heading for bar in long]) % (math.pi / 2)
    weights = np.array([bar.length for bar in long]) ** 2
    differences = np.abs((turns[:, None] - turns + math.pi / 4) % (math.pi / 2) - math.pi / 4)
    similar = differences <= SQUARE
    best = int(np.argmax(similar @ weights))
    offsets = (turns - turns[best] + math.pi / 4) % (math.pi / 2) - math.pi / 4
    main = turns[best] + float(np.average(offsets[similar[best]], weights=weights[similar[best]]))
    main = (main + math.pi / 4) % (math.pi / 2) - math.pi / 4
    return 0.0 if abs(main) < LEVEL else main


def _squared(cells: Cells, bar: Bar, main: float | None, thickest: float) -> Bar:
    """Return a wall aligned with the main direction or its perpendicular if it nearly is, and centred again."""
    if main is None:
        return bar
    deviation = (bar.heading - main + math.pi / 4) % (math.pi / 2) - math.pi / 4
    if abs(deviation) > max(SQUARE, math.atan2(SQUARE_DRIFT, bar.length)):
        return bar
    turned = Bar(bar.x, bar.y, bar.heading - deviation, bar.length, bar.width)
    sides = _sides(cells, turned, thickest)
    if sides is None:
        return bar
    offset, width = float(np.mean(sides[1])), float(np.mean(sides[2]))
    c, s = turned.along
    return Bar(bar.x - s * offset, bar.y + c * offset, turned.heading, bar.length, width)


def _followed(cells: Cells, free: Cells, bar: Bar) -> Bar:
    """Return a wall extended or cut at both ends to where its cells end."""
    farthest = math.hypot(*cells.shape)
    reach = bar.length + BLIND_GAP
    while True:
        ahead, behind = _ends(cells, free, bar, reach=reach)
        # Cells beyond such a long gap are not part of the wall.
        if max(ahead, behind) + BLIND_GAP < reach or reach > farthest:
            break
        reach *= 2.0
    if ahead + behind < 1.0:
        return bar
    middle = np.array([bar.x, bar.y])
    return bar_between(middle - bar.along * behind, middle + bar.along * ahead, bar.width)


def _ends(cells: Cells, free: Cells, bar: Bar, *, reach: float) -> tuple[float, float]:
    """Return how far a wall extends ahead of and behind its centre, within the search range [cells]."""
    count = math.ceil(reach / SAMPLE_SPACING)
    u = np.asarray((np.arange(-count, count) + 0.5)[:, None] * SAMPLE_SPACING, dtype=float)
    across = np.array([-0.4, -0.2, 0.0, 0.2, 0.4]) * bar.width
    solid = np.count_nonzero(_values_at(cells, bar, u, across), axis=1) >= 3
    seen = np.count_nonzero(_values_at(free, bar, u, across), axis=1) >= 3
    ahead = _goes_on(solid[count:], seen[count:])
    behind = _goes_on(solid[:count][::-1], seen[:count][::-1])
    return ahead, behind


def _goes_on(solid: Cells, seen: Cells) -> float:
    """Return how far a wall extends, from the samples along it that are solid and those seen to be free."""
    filled = np.concatenate([[-1], np.flatnonzero(solid)])
    gaps = np.diff(filled) - 1
    freed = np.concatenate([[0], np.cumsum(seen)])
    free_gaps = freed[filled[1:]] - freed[filled[:-1] + 1]
    ends = np.flatnonzero((gaps > BLIND_GAP / SAMPLE_SPACING) | (free_gaps > GAP / SAMPLE_SPACING))
    last = filled[ends[0]] if len(ends) else filled[-1]
    return float(last + 1) * SAMPLE_SPACING
