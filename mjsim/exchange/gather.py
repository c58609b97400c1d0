"""Fragments that lie in one line -> the wall or the thing that they are parts of; all lengths in cells."""

import heapq
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mjsim.exchange.shapes import Bar
from mjsim.geometry import Array

COVERED = 0.4
"""Fragments are parts of one when they cover at least so much of its length."""
PAIRED = 0.6
"""Two alone must cover so much of it: those farther apart are two things, as legs of a chair are."""
HELD = 0.95
"""Fraction of their cells that what stands for them must hold, with a cell around it."""
BULGE = 1.0
"""One may be so much wider than the wider of its fragments [cells]."""
MOST_FRAGMENTS = 6_000
"""More are left as they are."""


@dataclass(frozen=True, slots=True, eq=False)
class _Line:
    """Fragments taken as one: their cells, and the rectangle that holds nearly all of them."""

    parts: tuple[Array, ...]
    """Middles of cells of each fragment, shape (n, 2)."""
    points: Array
    """Those of all fragments."""
    bar: Bar

    @property
    def whole(self) -> bool:
        """Whether its fragments are parts of one thing."""
        return self.covered >= (PAIRED if len(self.parts) == 2 else COVERED)

    @property
    def covered(self) -> float:
        """Fraction of the length along which there are cells, 0 to 1."""
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
    lines: dict[int, _Line] = {index: _Line((part,), part, _bar(part)) for index, part in enumerate(parts)}
    places = _Places(2 * len(parts))
    waiting = [(distance, other, one) for one in lines for distance, other in places.added(one, lines[one].bar, gap)]
    heapq.heapify(waiting)
    fresh = len(parts)
    while waiting:
        _, one, other = heapq.heappop(waiting)
        if one not in lines or other not in lines or (line := _joined(lines[one], lines[other])) is None:
            continue
        for index in (one, other):
            del lines[index]
            places.remove(index)
        lines[fresh] = line
        for distance, near in places.added(fresh, line.bar, gap):
            heapq.heappush(waiting, (distance, near, fresh))
        fresh += 1
    made = [line for line in lines.values() if len(line.parts) > 1 and line.whole]
    others = [part for line in lines.values() if len(line.parts) == 1 or not line.whole for part in line.parts]
    return [_slimmed(line) for line in made], others


def _slimmed(line: _Line) -> Bar:
    """Return the rectangle of a line, as wide as its cells are on average where it has any."""
    bar = line.bar
    width = len(line.points) / max(1.0, line.covered * bar.length)
    return Bar(bar.x, bar.y, bar.heading, bar.length, min(bar.width, max(1.0, width)))


def _joined(one: _Line, other: _Line) -> _Line | None:
    """Return both fragments as one line; None when they are not in line or too sparse."""
    points = np.concatenate([one.points, other.points])
    line = _Line((*one.parts, *other.parts), points, _bar(points))
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


class _Places:
    """Where lines are, to look up those that are near to another."""

    def __init__(self, most: int) -> None:
        self._middles = np.zeros((most, 2))
        # Half the diagonal of each; none is near to one that is not there.
        self._reach = np.full(most, -np.inf)
        self._outlines: dict[int, Any] = {}

    def added(self, index: int, bar: Bar, gap: float) -> list[tuple[float, int]]:
        """Add a line, and return how far off those before are that are no farther than a gap, and which."""
        import shapely

        outline = shapely.Polygon(bar.outline())
        middle, reach = np.array([bar.x, bar.y]), float(np.hypot(bar.length, bar.width)) / 2
        near = np.flatnonzero(np.hypot(*(self._middles - middle).T) <= gap + reach + self._reach).tolist()
        found = [(float(outline.distance(self._outlines[other])), other) for other in near]
        self._middles[index], self._reach[index], self._outlines[index] = middle, reach, outline
        return [(distance, other) for distance, other in found if distance <= gap]

    def remove(self, index: int) -> None:
        """Forget a line."""
        self._reach[index] = -np.inf
        del self._outlines[index]
