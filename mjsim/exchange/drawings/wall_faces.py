"""Finds walls drawn by their faces: two parallel lines become a wall with a thickness; all lengths in metres."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mjsim.exchange.drawings.strokes import Indices, Pieces
from mjsim.exchange.maps import Bar, Cells, bar_between
from mjsim.geometry import Array

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

MIN_THICKNESS, MAX_THICKNESS = 0.04, 0.5
"""Minimum and maximum distance between the faces of a wall [m]."""
PARALLEL = math.sin(math.radians(1.5))
"""Maximum sine of the angle between two faces."""
TOUCHING, LEVEL = 0.02, 0.005
"""Collinear lines are merged if their ends are this close, and if they are this close to each other's line [m]."""
MIN_LENGTH_RATIO = 0.8
"""Minimum ratio of length to thickness of a wall."""
MAX_OUTER_RATIO = 2.5
"""Pairs with the largest length plus this many thicknesses are walls: so the outer two of parallel lines form one."""
MAX_COVERED_SHARE = 0.3
"""A pair is dropped if longer parallel walls cover more than this fraction of it."""
COMMON, SIMILAR_WIDTH = 0.08, 0.015
"""Fraction of the pairs' total length that makes a thickness usual; a pair matches if it differs by less [m]."""
MIN_ROOM_WIDTH, MIN_ENCLOSED_SHARE = 1.5, 0.25
"""Minimum width of a room's outline [m], and the fraction of its length that must be faces of walls."""
MAX_GAP = 0.7
"""Longest gap across which a wall continues if one of its faces does [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Paired:
    """Walls, and which pieces are their faces."""

    bars: list[Bar]
    faces: Cells
    """Whether each piece is a face of a wall, shape (n,)."""


def merged(pieces: Pieces) -> Pieces:
    """Return pieces, with collinear ones that touch or overlap merged."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    one, other = _close_pairs(pieces.ends, TOUCHING)
    sine, offset, overlap = _relations(pieces.ends, one, other)
    same = (np.abs(sine) < math.sin(math.radians(0.7))) & (np.abs(offset) < LEVEL) & (overlap > -TOUCHING)
    count = len(pieces.ends)
    graph = coo_matrix((np.ones(same.sum()), (one[same], other[same])), shape=(count, count))
    _, label = connected_components(graph, directed=False)
    order = np.argsort(label, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(label[order])) + 1) if count else []
    ends = [_spanned(pieces.ends[group]) for group in groups]
    return Pieces(np.array(ends).reshape(-1, 2, 2), np.array([pieces.owner[group[0]] for group in groups], dtype=int))


def paired(pieces: Pieces, *, solid: "BaseGeometry | None" = None, usual_only: bool = False) -> Paired:
    """Return the walls whose faces are parallel pieces; of three side by side, the outer two form a wall.

    Args:
        pieces: Straight segments.
        solid: Filled area; if given, the space between two faces must lie in it.
        usual_only: Whether to drop pairs whose distance is not a usual thickness.
    """
    import shapely

    one, other = _close_pairs(pieces.ends, MAX_THICKNESS)
    sine, offset, overlap = _relations(pieces.ends, one, other)
    widths = np.abs(offset)
    good = (
        (np.abs(sine) < PARALLEL)
        & (widths >= MIN_THICKNESS)
        & (widths <= MAX_THICKNESS)
        & (overlap >= MIN_LENGTH_RATIO * widths)
    )
    one, other, widths, overlap = one[good], other[good], widths[good], overlap[good]
    bars = [_between(pieces.ends[i], pieces.ends[j]) for i, j in zip(one, other, strict=True)]
    if solid is not None:
        shapely.prepare(solid)
        inside = shapely.covers(solid, shapely.polygons([bar.outline(grown=-0.01) for bar in bars])) if bars else []
        usable = np.flatnonzero(inside)
        bars, one, other = [bars[k] for k in usable], one[usable], other[usable]
        widths, overlap = widths[usable], overlap[usable]
    if usual_only:
        usual = _usual(widths, overlap)
        usable = np.flatnonzero([any(abs(width - common) <= SIMILAR_WIDTH for common in usual) for width in widths])
        bars, one, other = [bars[k] for k in usable], one[usable], other[usable]
    chosen = _without_overlaps(bars)
    faces = np.zeros(len(pieces.ends), dtype=bool)
    for index in chosen:
        faces[[one[index], other[index]]] = True
    return Paired([bars[index] for index in chosen], faces | _within(pieces, [bars[k] for k in chosen]))


def _close_pairs(ends: Array, reach: float) -> tuple[Indices, Indices]:
    """Return the index pairs of pieces within `reach` of each other [m], the smaller index first."""
    import shapely

    lines = shapely.linestrings(ends)
    one, other = shapely.STRtree(lines).query(lines, predicate="dwithin", distance=reach)
    return one[one < other], other[one < other]


def _relations(ends: Array, one: Indices, other: Indices) -> tuple[Array, Array, Array]:
    """Return the sine of the angle of two pieces, the offset of the second to the left [m], and their overlap [m]."""
    start, along = ends[one, 0], ends[one, 1] - ends[one, 0]
    unit = along / np.maximum(1e-12, np.hypot(*along.T))[:, None]
    left = np.stack([-unit[:, 1], unit[:, 0]], axis=-1)
    step = ends[other, 1] - ends[other, 0]
    sine = (unit[:, 0] * step[:, 1] - unit[:, 1] * step[:, 0]) / np.maximum(1e-12, np.hypot(*step.T))
    places = ends[other] - start[:, None]
    u = np.einsum("kij,kj->ki", places, unit)
    offset = np.einsum("kij,kj->ki", places, left).mean(axis=1)
    length = np.hypot(*along.T)
    overlap = np.minimum(u.max(axis=1), length) - np.maximum(u.min(axis=1), 0.0)
    return sine, offset, overlap


def _spanned(ends: Array) -> Array:
    """Return the line that spans collinear pieces, shape (2, 2)."""
    lengths = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    start, end = ends[int(np.argmax(lengths))]
    unit = (end - start) / max(1e-12, math.hypot(*(end - start)))
    u = (ends.reshape(-1, 2) - start) @ unit
    return np.array([start + unit * u.min(), start + unit * u.max()])


def _between(one: Array, other: Array) -> Bar:
    """Return the wall between two faces, shape (2, 2) each, over their common length."""
    longer, shorter = (one, other) if math.dist(*one) >= math.dist(*other) else (other, one)
    unit = (longer[1] - longer[0]) / math.dist(*longer)
    left = np.array([-unit[1], unit[0]])
    u = np.sort((shorter - longer[0]) @ unit)
    first, last = max(0.0, float(u[0])), min(math.dist(*longer), float(u[1]))
    offset = float(((shorter - longer[0]) @ left).mean())
    start = longer[0] + left * offset / 2
    return bar_between(start + unit * first, start + unit * last, abs(offset))


def _usual(widths: Array, overlap: Array) -> list[float]:
    """Return the distances that are common among pairs, weighted by length [m]."""
    order = np.argsort(widths)
    widths, weights = widths[order], overlap[order]
    first, last = (
        np.searchsorted(widths, widths - SIMILAR_WIDTH),
        np.searchsorted(widths, widths + SIMILAR_WIDTH, side="right"),
    )
    found: list[float] = []
    while weights.any():
        sums = np.concatenate([[0.0], np.cumsum(weights)])
        best = int(np.argmax(sums[last] - sums[first]))
        similar = slice(first[best], last[best])
        if weights[similar].sum() < COMMON * overlap.sum():
            break
        found.append(float(np.average(widths[similar], weights=weights[similar])))
        weights[similar] = 0.0
    return found


def _without_overlaps(bars: Sequence[Bar]) -> list[int]:
    """Return the indices of the bars that no parallel bars before them cover; the longest and thickest come first."""
    import shapely

    if not bars:
        return []
    outlines = shapely.polygons([bar.outline() for bar in bars])
    shapely.prepare(outlines)
    tree = shapely.STRtree(outlines)
    order = sorted(range(len(bars)), key=lambda k: -bars[k].length - MAX_OUTER_RATIO * bars[k].width)
    rank = {index: place for place, index in enumerate(order)}
    chosen: set[int] = set()
    for index in order:
        bar = bars[index]
        others = [k for k in tree.query(outlines[index]).tolist() if rank[k] < rank[index] and k in chosen]
        parallel = [k for k in others if abs(math.sin(bars[k].heading - bar.heading)) < 0.1]
        hidden = shapely.union_all(outlines[parallel]).intersection(outlines[index]).area if parallel else 0.0
        crossed = shapely.union_all(outlines[others]).intersection(outlines[index]).area if others else 0.0
        if hidden <= MAX_COVERED_SHARE * outlines[index].area and crossed <= 0.9 * outlines[index].area:
            chosen.add(index)
    return [index for index in order if index in chosen]


def _within(pieces: Pieces, bars: Sequence[Bar]) -> Cells:
    """Return which pieces lie entirely in or on walls: end faces, layers of insulation, window posts."""
    import shapely

    if not bars:
        return np.zeros(len(pieces.ends), dtype=bool)
    # Layers of insulation continue around corners.
    longer = [Bar(bar.x, bar.y, bar.heading, bar.length + 2 * bar.width, bar.width) for bar in bars]
    shape = shapely.union_all(shapely.polygons([bar.outline(grown=0.03) for bar in longer]))
    shapely.prepare(shape)
    return np.asarray(shapely.covers(shape, shapely.linestrings(pieces.ends)), dtype=bool)


def continued(bars: Sequence[Bar], pieces: Pieces) -> list[Bar]:
    """Return walls, joined where they are parts of one: where a face continues or another wall crosses."""
    bars = list(bars)
    while pairs := _joints(bars, pieces):
        taken = {index for pair in pairs for index in pair}
        joints = [joined(bars[one], bars[other]) for one, other in pairs]
        bars = [bar for index, bar in enumerate(bars) if index not in taken] + joints
    return bars


def sides_of_rooms(rings: Sequence[Array], bars: Sequence[Bar], pieces: Pieces) -> Cells:
    """Return which pieces are sides of rooms, shape (n,): of outlines whose other sides are faces of walls.

    Args:
        rings: Corners of closed lines, shape (n, 2) each [m].
        bars: Walls between two faces.
        pieces: Straight segments.
    """
    import shapely

    large = [shapely.Polygon(ring) for ring in rings if len(ring) > 3 and np.ptp(ring, axis=0).min() >= MIN_ROOM_WIDTH]
    if not large or not bars:
        return np.zeros(len(pieces.ends), dtype=bool)
    walls = shapely.union_all([shapely.Polygon(bar.outline(grown=TOUCHING)) for bar in bars])
    shares = [room.exterior.intersection(walls).length / room.exterior.length for room in large]
    rooms = [room.exterior for room, share in zip(large, shares, strict=True) if share >= MIN_ENCLOSED_SHARE]
    if not rooms:
        return np.zeros(len(pieces.ends), dtype=bool)
    places = np.concatenate([pieces.ends, pieces.ends.mean(axis=1, keepdims=True)], axis=1).reshape(-1, 2)
    on = np.zeros(len(places), dtype=bool)
    on[shapely.STRtree(rooms).query(shapely.points(places), predicate="dwithin", distance=TOUCHING)[0]] = True
    return np.asarray(on.reshape(-1, 3).all(axis=1))


def joined(one: Bar, other: Bar) -> Bar:
    """Return the wall that spans two collinear walls."""
    ends = np.array([one.ends, other.ends])
    start, end = _spanned(ends)
    width = (one.width * one.length + other.width * other.length) / (one.length + other.length)
    return bar_between(start, end, width)


def gaps(bars: Sequence[Bar], widest: float) -> list[tuple[int, int, Array]]:
    """Return pairs of collinear walls with both ends of the gap between them, shape (2, 2), narrowest first."""
    found = []
    if len(bars) < 2:
        return []
    ends = np.array([bar.ends for bar in bars])
    for one, other in zip(*(index.tolist() for index in _close_pairs(ends, widest)), strict=True):
        a, b = bars[one], bars[other]
        if abs(math.sin(a.heading - b.heading)) > PARALLEL or abs(a.width - b.width) > max(
            SIMILAR_WIDTH, 0.15 * a.width
        ):
            continue
        c, s = a.along
        places = (b.ends - [a.x, a.y]) @ np.array([[c, -s], [s, c]])
        if np.abs(places[:, 1]).max() > max(0.015, 0.1 * a.width):
            continue
        low, high = sorted(places[:, 0].tolist())
        begin, end = (a.length / 2, low) if (low + high) > 0 else (high, -a.length / 2)
        if end - begin <= widest:
            found.append((one, other, np.array([a.x, a.y]) + np.outer([begin, end], a.along)))
    return sorted(found, key=lambda gap: math.dist(*gap[2]))


def _joints(bars: Sequence[Bar], pieces: Pieces) -> list[tuple[int, int]]:
    """Return pairs of walls that are parts of one; each wall is in at most one pair."""
    import shapely

    if len(bars) < 2:
        return []
    outlines = shapely.polygons([bar.outline(grown=0.01) for bar in bars])
    tree = shapely.STRtree(outlines)
    found: dict[int, int] = {}
    for one, other, ends in gaps(bars, MAX_GAP):
        if one in found or other in found:
            continue
        gap = shapely.LineString(ends)
        fillers = [k for k in tree.query(gap, predicate="intersects").tolist() if k not in (one, other)]
        filled = fillers and shapely.union_all(outlines[fillers]).intersection(gap).length > 0.9 * gap.length
        if filled or _overlaps(bars[one], bars[other]) or _spanned_by(bars[one], ends, pieces):
            found[one], found[other] = other, one
    return [(one, other) for one, other in found.items() if one < other]


def _overlaps(one: Bar, other: Bar) -> bool:
    return (
        float(np.abs((np.array([other.x, other.y]) - [one.x, one.y]) @ one.along))
        <= (one.length + other.length) / 2 + TOUCHING
    )


def _spanned_by(bar: Bar, ends: Array, pieces: Pieces) -> bool:
    """Return whether a face of a wall continues across a gap."""
    middle, unit = ends.mean(axis=0), bar.along
    half = math.dist(*ends) / 2
    places = pieces.ends - middle
    u, v = places @ unit, places @ np.array([-unit[1], unit[0]])
    level = np.abs(np.abs(v) - bar.width / 2).max(axis=1) < 0.015
    return bool((level & (u.min(axis=1) <= -half + TOUCHING) & (u.max(axis=1) >= half - TOUCHING)).any())
