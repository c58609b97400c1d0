"""Joins straight walls into runs: walls share the corner at which they meet, or end on another wall's centreline."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mjsim.exchange.maps.cell_shapes import Bar
from mjsim.geometry import Array

STEEP = math.sin(math.radians(15.0))
"""Walls that meet at a smaller angle are not joined (sine of the angle)."""
MAX_CORNER_DISTANCE = 1.0
"""Maximum distance from the end of a wall to the corner [cells]."""
MAX_THICKNESS_DIFFERENCE = 0.8
"""Walls whose thicknesses differ by more are not joined into one run [cells]."""

End = tuple[int, int]
"""Index of the wall, and 0 for its start or 1 for its end."""


@dataclass(frozen=True, slots=True, eq=False)
class WallRun:
    """A run of walls with shared corners and one thickness."""

    points: Array
    """Corners of the centreline, shape (n, 2), in the unit of the walls."""
    closed: bool
    thickness: float


def runs_of(bars: Sequence[Bar]) -> list[WallRun]:
    """Return the runs formed by straight walls, longest first, in the unit of the walls."""
    ends = np.array([bar.ends for bar in bars]).reshape(-1, 2, 2)
    partner: dict[End, End] = {}
    for _, end, other, corner in sorted(_meetings(bars, ends), key=lambda meeting: meeting[0]):
        if end in partner or other in partner:
            continue
        if other[1] < 2:
            partner[end], partner[other] = other, end
            ends[other] = corner
        else:
            partner[end] = other
        ends[end] = corner
    corners = {end: other for end, other in partner.items() if other[1] < 2}
    runs = [_run(chain, ends, bars) for chain in _chains(len(bars), corners)]
    return sorted(runs, key=lambda run: -float(np.hypot(*np.diff(run.points, axis=0).T).sum()))


def _meetings(bars: Sequence[Bar], ends: Array) -> list[tuple[float, End, End, Array]]:
    """Return where walls end at others: distance, end, the other's end or (other, 2), and the point, shape (2,)."""
    if not bars:
        return []
    from shapely import STRtree, polygons

    outlines = polygons([bar.outline(grown=2 * MAX_CORNER_DISTANCE) for bar in bars])
    found = []
    for one, other in STRtree(outlines).query(outlines, predicate="intersects").T.tolist():
        if one == other:
            continue
        a, b = bars[one], bars[other]
        sine = float(a.along[0] * b.along[1] - a.along[1] * b.along[0])
        if abs(sine) < STEEP:
            continue
        offset = np.array([b.x - a.x, b.y - a.y])
        u_a = float(offset[0] * b.along[1] - offset[1] * b.along[0]) / sine
        u_b = float(offset[0] * a.along[1] - offset[1] * a.along[0]) / sine
        reach_a, reach_b = _reach(a, b, sine), _reach(b, a, sine)
        gap_a, gap_b = abs(abs(u_a) - a.length / 2), abs(abs(u_b) - b.length / 2)
        if gap_a > reach_a or abs(u_b) > b.length / 2 + reach_b or a.length < gap_a:
            continue
        end, place = (one, int(u_a > 0)), np.array([a.x, a.y]) + a.along * u_a
        if gap_b <= reach_b and abs(a.width - b.width) <= MAX_THICKNESS_DIFFERENCE and one < other:
            found.append((gap_a + gap_b, end, (other, int(u_b > 0)), place))
        elif gap_b > reach_b:
            found.append((100.0 + gap_a, end, (other, 2), place))
    return found


def _reach(a: Bar, b: Bar, sine: float) -> float:
    """Return how far from the crossing of the centrelines wall `a` may end if it ends at `b`."""
    return (b.width + a.width * math.sqrt(max(0.0, 1.0 - sine**2))) / abs(sine) / 2 + MAX_CORNER_DISTANCE


def _chains(count: int, corners: dict[End, End]) -> list[tuple[list[End], bool]]:
    """Return chains of consecutive walls, each with the end at which it is entered, and whether the chain is closed."""
    waiting = set(range(count))
    chains = []
    starts = [(wall, end) for wall in range(count) for end in (0, 1) if (wall, end) not in corners]
    for wall, end in [*starts, *((wall, 0) for wall in range(count))]:
        if wall not in waiting:
            continue
        chain, current = [], (wall, end)
        while current[0] in waiting:
            chain.append(current)
            waiting.discard(current[0])
            if (leaving := (current[0], 1 - current[1])) not in corners:
                break
            current = corners[leaving]
        chains.append((chain, len(chain) > 2 and corners.get((chain[-1][0], 1 - chain[-1][1])) == chain[0]))
    return chains


def _run(chain: tuple[list[End], bool], ends: Array, bars: Sequence[Bar]) -> WallRun:
    walls, closed = chain
    points = [ends[wall, end] for wall, end in walls]
    if not closed:
        points.append(ends[walls[-1][0], 1 - walls[-1][1]])
    lengths = np.array([bars[wall].length for wall, _ in walls])
    thickness = float(np.average([bars[wall].width for wall, _ in walls], weights=lengths))
    return WallRun(np.array(points), closed, thickness)
