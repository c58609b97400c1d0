"""Root locus of a loop: closed-loop poles over the gain, at gains close enough for a smooth drawing, and its marks."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, linear_sum_assignment

from mjsim.geometry import Array
from mjsim.lab.plane import on_boundary, outward

MAX_SEGMENT = 0.02
"""Longest segment of a branch, as a fraction of the width of the picture."""
TURN = math.radians(5.0)
"""Largest turn between two segments of a branch, except where branches meet."""
MIN_SEGMENT = 1e-6
"""Segments shorter than this fraction of the picture are not refined: numerical noise."""
MARGIN = 1.35
"""Half the width of the picture, as a multiple of the most distant point that it must show."""
MIN_EXTENT = 1.5
"""Branches are followed at least to this multiple of half the width of the picture."""
MAX_EXTENT = 12.0
"""Those that leave the picture are followed to this multiple of half its width, until the others reach their zeros."""
MAX_MARK_DISTANCE = 3.5
"""Marks further out than this multiple of the most distant pole or zero are outside the picture."""
MAX_GAINS = 4000
"""Maximum number of gains."""
Gains = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class LocusMark:
    """A point of a root locus, with its gain."""

    gain: float
    point: complex
    """[rad/s]"""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RootLocus:
    """The closed-loop poles under u = k (r - y), for gains k from 0."""

    gains: Gains
    """Increasing from 0, shape (g,)."""
    branches: Array
    """Complex, shape (n, g) [rad/s]."""
    extent: float
    """Half the width and height of the picture, about the origin [rad/s]."""
    crossings: tuple[LocusMark, ...]
    """Where branches cross the imaginary axis, or the unit circle in discrete time."""
    breakaways: tuple[LocusMark, ...]
    """Where branches meet."""
    centroid: float | None
    """Intersection of the asymptotes [rad/s]; None if no branch goes to infinity."""
    asymptotes: tuple[float, ...]
    """Directions of the asymptotes [rad]."""
    unity: Array
    """Closed-loop poles at gain 1, complex, shape (n,) [rad/s]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Loop:
    """A loop in state space, and as g (s - zeros) / (s - poles)."""

    A: Array
    B: Array
    C: Array
    D: float
    poles: Array
    zeros: Array
    g: float
    dt: float
    """Sampling period; 0 in continuous time [s]."""

    def roots(self, gains: Gains) -> Array:
        """Return the closed-loop poles, shape (gains, n)."""
        fed = gains / (1.0 + self.D * gains)
        return np.asarray(np.linalg.eigvals(self.A - fed[:, None, None] * (self.B @ self.C)), dtype=complex)

    @property
    def ends(self) -> float:
        """The gain at which a closed-loop pole passes through infinity; infinite if there is none."""
        return -1.0 / self.D if self.D < 0.0 else math.inf


def root_locus(loop: Any) -> RootLocus:
    """Return the root locus of a state space of python-control with one input and one output.

    A loop with a direct term below 0 has a pole at infinity at one gain; its locus ends before this gain.

    References:
        Evans, Control System Synthesis by Root Locus Method, Transactions of the AIEE 69 (1950).
    """
    poles = np.asarray(loop.poles(), dtype=complex)
    zeros = finite_zeros(loop)
    g, D, dt = _leading(loop, poles, zeros), float(loop.D[0, 0]), float(loop.dt or 0.0)
    plant = _Loop(A=loop.A, B=loop.B, C=loop.C, D=D, poles=poles, zeros=zeros, g=g, dt=dt)
    # The unit circle is shown.
    size = float(np.abs(np.concatenate([poles, zeros])).max(initial=1.0 if dt else 0.0)) or 1.0
    breakaways = _breakaways(plant, size)
    excess = len(poles) - len(zeros)
    centroid = _without_rounding(float((poles.sum() - zeros.sum()).real) / excess, size) if excess else None
    extent = MARGIN * max(
        size, *(abs(mark.point) for mark in breakaways if abs(mark.point) < MAX_MARK_DISTANCE * size), 0.0
    )
    gains, branches = _traced(plant, extent, breakaways)
    crossings = _crossings(plant, gains, branches, extent)
    far = max((abs(mark.point) for mark in crossings if abs(mark.point) < MAX_MARK_DISTANCE * size), default=0.0)
    if MARGIN * far > extent:
        extent = MARGIN * far
        gains, branches = _traced(plant, extent, breakaways)
        crossings = _crossings(plant, gains, branches, extent)
    return RootLocus(
        gains=gains,
        branches=branches,
        extent=extent,
        crossings=crossings,
        breakaways=breakaways,
        centroid=centroid,
        asymptotes=tuple((2 * k + (plant.g > 0.0)) * math.pi / excess for k in range(excess)),
        unity=np.sort_complex(plant.roots(np.ones(1))[0]) if plant.ends > 1.0 else np.array([], dtype=complex),
    )


def _without_rounding(value: float, size: float) -> float:
    return value if abs(value) > 1e-12 * size else 0.0


def finite_zeros(loop: Any) -> Array:
    """Return the zeros of a loop without those that are infinite except for rounding, complex, shape (m,) [rad/s]."""
    zeros = np.asarray(loop.zeros(), dtype=complex)
    size = float(np.abs(loop.poles()).max(initial=0.0)) or 1.0
    return np.asarray(zeros[np.abs(zeros) < 1e7 * size])


def _leading(loop: Any, poles: Array, zeros: Array) -> float:
    """Return g of g (s - zeros) / (s - poles), from the response at a frequency far from both."""
    s = 3.0 * (float(np.abs(np.concatenate([poles, zeros])).max(initial=0.0)) or 1.0)
    logs = np.log(s - poles).sum() - np.log(s - zeros).sum()
    return float((complex(loop(s)) * np.exp(logs)).real)


def _breakaways(plant: _Loop, size: float) -> tuple[LocusMark, ...]:
    """Return where two or more closed-loop poles are equal: the derivative of the loop by s is 0, its gain above 0."""
    if len(plant.poles) < 2:
        return ()
    # Scaled by their size, coefficients remain moderate.
    p, z = (np.atleast_1d(np.poly(roots / size)) for roots in (plant.poles, plant.zeros))
    found: list[LocusMark] = []
    for s in np.roots(np.polysub(np.polymul(np.polyder(p), z), np.polymul(p, np.polyder(z)))) * size:
        point = _polished(plant, complex(s), size)
        gain = _gain_at(plant, point)
        known = any(abs(point - mark.point) < 1e-4 * size for mark in found)
        if not known and gain.real > 0.0 and abs(gain.imag) < 1e-6 * gain.real and 0.0 < gain.real < plant.ends:
            found.append(LocusMark(gain=gain.real, point=point))
    # Multiple poles of the loop itself, at gain 0, are roots too.
    least = 1e-9 * size ** (len(plant.poles) - len(plant.zeros)) / abs(plant.g)
    return tuple(sorted((mark for mark in found if mark.gain > least), key=lambda mark: mark.gain))


def _gain_at(plant: _Loop, s: complex) -> complex:
    """Return the gain at which s is a closed-loop pole; above 0 on the locus."""
    if not (s - plant.zeros).all():
        return complex(math.inf)
    logs = np.log(s - plant.poles + 0j).sum() - np.log(s - plant.zeros).sum() if (s - plant.poles).all() else -math.inf
    return complex(-np.exp(logs) / plant.g)


def _polished(plant: _Loop, s: complex, size: float) -> complex:
    """Improve a root of the loop's logarithmic derivative, sum 1 / (s - p) - sum 1 / (s - z), by Newton's method."""
    start = s
    for _ in range(3):
        p, z = s - plant.poles, s - plant.zeros
        if min(np.abs(p).min(), np.abs(z).min(initial=math.inf)) < 1e-9 * size:
            return start
        slope = -(1 / p**2).sum() + (1 / z**2).sum()
        s = s - ((1 / p).sum() - (1 / z).sum()) / slope if slope else s
    s = s if abs(s - start) < 1e-3 * size else start
    return complex(s.real) if abs(s.imag) < 1e-7 * size else complex(s)


def _traced(plant: _Loop, extent: float, breakaways: Sequence[LocusMark]) -> tuple[Gains, Array]:
    """Return gains and branches, refined until no segment is too long and no vertex turns too far."""
    if not len(plant.poles):
        return np.zeros(1), np.zeros((0, 1), dtype=complex)
    gains, roots = _coarse(plant, extent, breakaways)
    met = {mark.gain for mark in breakaways}
    while True:
        branches = _followed(roots)
        places = _too_coarse(gains, branches, extent, met)
        if not len(places) or len(gains) > MAX_GAINS:
            return gains, _snapped(gains, branches, breakaways)
        low, high = gains[places], gains[places + 1]
        # Gains over decades are halved in the logarithm; next to a meeting of branches only the difference counts.
        middle = np.where(high > 4.0 * low, np.sqrt(np.maximum(low, high / 64.0) * high), (low + high) / 2.0)
        gains = np.insert(gains, places + 1, middle)
        roots = np.insert(branches.T, places + 1, plant.roots(middle), axis=0)


def _coarse(plant: _Loop, extent: float, breakaways: Sequence[LocusMark]) -> tuple[Gains, Array]:
    """Return a first choice of gains, up to where all branches have left the picture or reached their zeros."""
    excess = len(plant.poles) - len(plant.zeros)
    scale = extent**excess / abs(plant.g)
    grid = scale * np.geomspace(1e-8, 1e10, 181)
    grid = grid[grid < 0.99 * plant.ends] if math.isfinite(plant.ends) else grid
    roots = plant.roots(grid)
    far = np.sort(np.abs(roots), axis=1)
    away = (far > MIN_EXTENT * extent).sum(axis=1) >= excess
    gap = np.abs(roots[:, :, None] - plant.zeros).min(axis=2, initial=math.inf)
    done = (np.abs(roots) > MIN_EXTENT * extent) | (gap < 0.005 * 2 * extent)
    last = int(np.argmax(done.all(axis=1))) if done.all(axis=1).any() else len(grid) - 1
    near = np.flatnonzero(far[:, -1] <= MAX_EXTENT * extent)
    first = int(np.argmax(away)) if away.any() else len(grid) - 1
    last = min(last, max(first, int(near.max(initial=0)))) if excess else last
    gains = np.unique([0.0, *grid[: last + 1 : 4], grid[last], *_within(breakaways, grid[last]), min(1.0, grid[last])])
    return gains, plant.roots(gains)


def _within(marks: Sequence[LocusMark], top: float) -> list[float]:
    return [mark.gain for mark in marks if mark.gain < top]


def _followed(roots: Array) -> Array:
    """Return branches, shape (n, gains): each root is paired with the nearest of the next gain."""
    distance = np.abs(roots[:-1, :, None] - roots[1:, None, :])
    order, branches = np.arange(roots.shape[1]), [roots[0]]
    nearest = distance.argmin(axis=2)
    for row, near in enumerate(nearest):
        step = near if len(set(near.tolist())) == len(near) else linear_sum_assignment(distance[row])[1]
        order = step[order]
        branches.append(roots[row + 1][order])
    return np.array(branches).T


def _too_coarse(gains: Gains, branches: Array, extent: float, met: set[float]) -> NDArray[np.intp]:
    """Return the intervals of gains to halve."""
    steps = np.diff(branches, axis=1)
    lengths = np.abs(steps)
    bad = lengths > MAX_SEGMENT * 2.0 * extent
    before, after = steps[:, :-1], steps[:, 1:]
    turns = np.abs(np.angle(after * np.conj(before)))
    sharp = (turns > TURN) & (np.minimum(lengths[:, :-1], lengths[:, 1:]) > MIN_SEGMENT * extent)
    sharp[:, np.isin(gains[1:-1], list(met))] = False
    longer = lengths[:, :-1] >= lengths[:, 1:]
    bad[:, :-1] |= sharp & longer
    bad[:, 1:] |= sharp & ~longer
    wide = np.diff(gains) > 1e-13 * gains[1:]
    return np.flatnonzero(bad.any(axis=0) & wide)


def _snapped(gains: Gains, branches: Array, breakaways: Sequence[LocusMark]) -> Array:
    """Move branches exactly to the points where they meet: rounding separates equal poles."""
    for mark in breakaways:
        for column in np.flatnonzero(gains == mark.gain):
            distance = np.abs(branches[:, column] - mark.point)
            branches[distance < 10.0 * np.sort(distance)[1] + 1e-12, column] = mark.point
    return branches


def _crossings(plant: _Loop, gains: Gains, branches: Array, extent: float) -> tuple[LocusMark, ...]:
    """Return the points at which branches pass from one half plane into the other."""
    found = []
    for branch in branches:
        beyond = outward(branch, plant.dt)
        side = np.sign(np.where(np.abs(beyond) < 1e-7 * extent, 0.0, beyond))
        known = np.flatnonzero(side)
        for low, high in pairwise(known):
            if side[low] != side[high]:
                found.append(_crossing(plant, (gains[low], gains[high]), (branch[low], branch[high])))
    return tuple(sorted(found, key=lambda mark: (mark.gain, mark.point.imag)))


def _crossing(plant: _Loop, gains: tuple[float, float], ends: tuple[complex, complex]) -> LocusMark:
    """Return the crossing of the imaginary axis, or of the unit circle, between two gains."""

    def nearest(gain: float) -> complex:
        share = (gain - gains[0]) / (gains[1] - gains[0])
        roots = plant.roots(np.array([gain]))[0]
        return complex(roots[int(np.argmin(np.abs(roots - (ends[0] + share * (ends[1] - ends[0])))))])

    gain = float(brentq(lambda k: float(outward(nearest(k), plant.dt)), *gains, xtol=1e-15 * gains[1], rtol=1e-14))
    return LocusMark(gain=gain, point=on_boundary(nearest(gain), plant.dt))
