"""Joins collinear fragments into the wall or object that they are parts of; all lengths in cells."""

import heapq
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mjsim.exchange.maps.cell_shapes import Bar
from mjsim.geometry import Array

MIN_COVERED_SHARE = 0.4
"""Minimum fraction of the length that fragments of one object cover."""
MIN_PAIR_SHARE = 0.6
"""The same for two fragments: two that are farther apart are separate objects, such as the legs of a chair."""
MIN_INSIDE_SHARE = 0.95
"""Minimum fraction of their cells inside the rectangle, with a margin of one cell."""
MAX_EXTRA_WIDTH = 1.0
"""Maximum excess of the joined width over that of the wider fragment [cells]."""
MAX_FRAGMENTS = 6_000
"""Above this number, fragments are not joined."""


@dataclass(frozen=True, slots=True, eq=False)
class _Line:
    """Joined fragments: their cells, and the rectangle that contains nearly all of them."""

    parts: tuple[Array, ...]
    """Centres of the cells of each fragment, shape (n, 2) [cells]."""
    points: Array
    """Centres of the cells of all fragments, shape (n, 2) [cells]."""
    bar: Bar

    @property
    def whole(self) -> bool:
        """Whether its fragments are parts of one object."""
        return self.covered >= (MIN_PAIR_SHARE if len(self.parts) == 2 else MIN_COVERED_SHARE)

    @property
    def covered(self) -> float:
        """Fraction of the length that has occupied cells, 0 to 1."""
        u = (self.points - [self.bar.x, self.bar.y]) @ self.bar.along
        return len(np.unique(np.round(u))) / max(1.0, self.bar.length)


def gathered(parts: Sequence[Array], *, gap: float) -> tuple[list[Bar], list[Array]]:
    """Return rectangles for collinear fragments, and the remaining fragments.

    Args:
        parts: Centres of the cells of each fragment, shape (n, 2) [cells].
        gap: Maximum gap between two fragments of one wall [cells].
    """
    if not 1 < len(parts) <= MAX_FRAGMENTS:
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
        for distance, neighbour in places.added(fresh, line.bar, gap):
            heapq.heappush(waiting, (distance, neighbour, fresh))
        fresh += 1
    made = [line for line in lines.values() if len(line.parts) > 1 and line.whole]
    others = [part for line in lines.values() if len(line.parts) == 1 or not line.whole for part in line.parts]
    return [_slimmed(line) for line in made], others


def _slimmed(line: _Line) -> Bar:
    """Return the rectangle of a line, as wide as its cells are on average where there are any."""
    bar = line.bar
    width = len(line.points) / max(1.0, line.covered * bar.length)
    return Bar(bar.x, bar.y, bar.heading, bar.length, min(bar.width, max(1.0, width)))


def _joined(one: _Line, other: _Line) -> _Line | None:
    """Return two fragments as one line; None if they are not collinear or too sparse."""
    points = np.concatenate([one.points, other.points])
    line = _Line((*one.parts, *other.parts), points, _bar(points))
    bulge = max(one.bar.width, other.bar.width) + MAX_EXTRA_WIDTH
    longer = line.bar.length > max(one.bar.length, other.bar.length)
    if line.bar.width > bulge or line.covered < MIN_COVERED_SHARE or not longer:
        return None
    c, s = line.bar.along
    distances = np.abs((points - [line.bar.x, line.bar.y]) @ [-s, c])
    return line if np.mean(distances <= _slimmed(line).width / 2 + 1.0) >= MIN_INSIDE_SHARE else None


def _bar(points: Array) -> Bar:
    """Return the rectangle along the principal axis of cells, without the outermost twentieth on each side."""
    middle = points.mean(axis=0)
    offsets = points - middle
    scatter = offsets.T @ offsets
    heading = float(np.arctan2(2 * scatter[0, 1], scatter[0, 0] - scatter[1, 1]) / 2)
    c, s = np.cos(heading), np.sin(heading)
    u, v = (offsets @ [[c, -s], [s, c]]).T
    low, high = np.quantile(v, [0.05, 0.95])
    first, last = float(u.min()), float(u.max())
    x, y = (middle + [[c, -s], [s, c]] @ np.array([(first + last) / 2, (low + high) / 2])).tolist()
    return Bar(x, y, heading, last - first + 1.0, float(high - low) + 1.0)


class _Places:
    """Positions of lines, for finding those near another."""

    def __init__(self, capacity: int) -> None:
        self._middles = np.zeros((capacity, 2))
        # Half the diagonal of each; nothing is near a removed line.
        self._reach = np.full(capacity, -np.inf)
        self._outlines: dict[int, Any] = {}

    def added(self, index: int, bar: Bar, gap: float) -> list[tuple[float, int]]:
        """Add a line; return distance and index of the earlier lines within `gap`."""
        import shapely

        outline = shapely.Polygon(bar.outline())
        middle, reach = np.array([bar.x, bar.y]), float(np.hypot(bar.length, bar.width)) / 2
        close = np.flatnonzero(np.hypot(*(self._middles - middle).T) <= gap + reach + self._reach).tolist()
        found = [(float(outline.distance(self._outlines[other])), other) for other in close]
        self._middles[index], self._reach[index], self._outlines[index] = middle, reach, outline
        return [(distance, other) for distance, other in found if distance <= gap]

    def remove(self, index: int) -> None:
        """Remove a line."""
        self._reach[index] = -np.inf
        del self._outlines[index]
