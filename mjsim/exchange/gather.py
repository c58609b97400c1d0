"""Fragments that lie in one line -> the wall or the thing that they are parts of; all lengths in cells."""

import heapq
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mjsim.exchange.shapes import Bar
from mjsim.geometry import Array

COVERED = 0.6
"""Fragments are parts of one when they cover at least so much of its length."""
HELD = 0.95
"""Share of their cells that what stands for them must hold, with a cell around it."""
BULGE = 1.0
"""One may be so much wider than the wider of its fragments [cells]."""
MOST_FRAGMENTS = 6_000
"""More are left as they are."""


@dataclass(frozen=True, slots=True, eq=False)
class _Line:
    """Fragments taken as one: their cells, and the rectangle that holds nearly all of them."""

    points: Array
    bar: Bar

    @property
    def covered(self) -> float:
        """Share of the length along which there are cells, 0 to 1."""
        u = (self.points - [self.bar.x, self.bar.y]) @ self.bar.along
        return len(np.unique(np.round(u))) / max(1.0, self.bar.length)


def gathered(parts: Sequence[Array], *, gap: float) -> tuple[list[Bar], list[Array]]:
    """Return rectangles for fragments that lie in one line, and the other fragments.

    Args:
        parts: Middles of cells of each fragment, shape (n, 2).
        gap: Between two fragments of one wall at most.
    """
    if not 1 < len(parts) <= MOST_FRAGMENTS:
        return [], list(parts)
    lines: dict[int, _Line] = {index: _Line(part, _bar(part)) for index, part in enumerate(parts)}
    waiting = [(distance, one, other) for one, other, distance in _near(lines, range(len(parts)), gap)]
    heapq.heapify(waiting)
    fresh = len(parts)
    while waiting:
        _, one, other = heapq.heappop(waiting)
        if one not in lines or other not in lines or (line := _joined(lines[one], lines[other])) is None:
            continue
        del lines[one], lines[other]
        lines[fresh] = line
        for first, second, distance in _near(lines, [fresh], gap):
            heapq.heappush(waiting, (distance, first, second))
        fresh += 1
    made = [_slimmed(line) for index, line in lines.items() if index >= len(parts)]
    return made, [line.points for index, line in lines.items() if index < len(parts)]


def _slimmed(line: _Line) -> Bar:
    """Return the rectangle of a line, as wide as its cells are on average where it has any."""
    bar = line.bar
    width = len(line.points) / max(1.0, line.covered * bar.length)
    return Bar(bar.x, bar.y, bar.heading, bar.length, min(bar.width, max(1.0, width)))


def _joined(one: _Line, other: _Line) -> _Line | None:
    """Return both fragments as one line; None when they are not in line or too sparse."""
    points = np.concatenate([one.points, other.points])
    line = _Line(points, _bar(points))
    bulge = max(one.bar.width, other.bar.width) + BULGE
    longer = line.bar.length > max(one.bar.length, other.bar.length)
    if line.bar.width > bulge or line.covered < COVERED or not longer:
        return None
    c, s = line.bar.along
    off = np.abs((points - [line.bar.x, line.bar.y]) @ [-s, c])
    return line if np.mean(off <= _slimmed(line).width / 2 + 1.0) >= HELD else None


def _bar(points: Array) -> Bar:
    """Return the rectangle along the main axis of cells that holds all but the outermost twentieth on each side."""
    middle = points.mean(axis=0)
    offsets = points - middle
    cov = offsets.T @ offsets
    heading = float(np.arctan2(2 * cov[0, 1], cov[0, 0] - cov[1, 1]) / 2)
    c, s = np.cos(heading), np.sin(heading)
    u, v = (offsets @ [[c, -s], [s, c]]).T
    low, high = np.quantile(v, [0.05, 0.95])
    first, last = float(u.min()), float(u.max())
    x, y = (middle + [[c, -s], [s, c]] @ np.array([(first + last) / 2, (low + high) / 2])).tolist()
    return Bar(x, y, heading, last - first + 1.0, float(high - low) + 1.0)


def _near(lines: dict[int, _Line], asked: Sequence[int] | range, gap: float) -> list[tuple[int, int, float]]:
    """Return pairs of lines of which the first is asked for, and how far they are apart."""
    import shapely

    names = list(lines)
    outlines = shapely.polygons([lines[name].bar.outline() for name in names])
    place = {name: index for index, name in enumerate(names)}
    tree = shapely.STRtree(outlines)
    sought = [place[name] for name in asked]
    found = tree.query(outlines[sought], predicate="dwithin", distance=gap).T
    pairs = {(min(sought[a], b), max(sought[a], b)) for a, b in found.tolist() if sought[a] != b}
    return [(names[a], names[b], float(outlines[a].distance(outlines[b]))) for a, b in sorted(pairs)]
