"""Converts lines of a drawing to a world: walls drawn by one line or two faces, openings, columns, furniture."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.drawings.curved_walls import Curve, curves_of, walls_of, without_curves
from mjsim.exchange.drawings.drawing import (
    MAX_CORNERS,
    Drawing,
    Line,
    corner_and_scale,
    drawn_thickness,
    joined,
    wall_along,
)
from mjsim.exchange.drawings.drawn_openings import MAX_WIDTH, Hole, doors_and_windows, lines_through, with_openings
from mjsim.exchange.drawings.filled import MIN_DARKNESS, bars_of_filled, rest_of_filled
from mjsim.exchange.drawings.furnishing import (
    HEIGHT,
    Outline,
    Thing,
    column_of,
    distinct_outlines,
    outlines_of,
    thing_of,
    with_parts,
)
from mjsim.exchange.drawings.patches import painted_over
from mjsim.exchange.drawings.plan_counts import FINER, UNEVEN, count_walls, left_out, listed
from mjsim.exchange.drawings.rectilinear import is_rectangle
from mjsim.exchange.drawings.ribbons import Ribbon, ribbons_of, without_ribbons
from mjsim.exchange.drawings.sorting import (
    Pens,
    SortedLines,
    by_pen,
    cleared,
    length_of_lines,
    require_sparse,
    sorted_lines,
    with_large_rooms,
    with_rooms,
)
from mjsim.exchange.drawings.strokes import LEAF_TOLERANCE, Arc, Pieces, patterned, split
from mjsim.exchange.drawings.symbols import MIN_PANES, with_symbols, without_jambs, without_leaves
from mjsim.exchange.drawings.wall_faces import Paired, continued, merged, paired, sides_of_rooms
from mjsim.exchange.maps import DIGITS, WALL_HEIGHT, Bar, distinct, runs_of
from mjsim.geometry import Array
from mjsim.inventory import FileItem, inventory
from mjsim.world import BoxObstacle, Wall, World, solid

CELL_SIDE = 0.05
"""Walls are joined at corners as those of a map with cells of this size [m]."""
BY_FACES = 0.3
"""Fraction of the total line length that must be faces for walls to count as drawn by their faces."""
MIN_SINGLE_LINE = 0.5
"""Minimum length at which a line on a wall layer is a wall by itself [m]."""
BY_SIZE = (0.3, 3.0)
"""Sizes of closed shapes and blocks in rooms that count as furniture even if no name says so [m]."""
MIN_FLOOR_SHARE, FLOOR_GAP = 0.9, 0.05
"""A closed shape is the floor of a room if at least this fraction of its outline is this close to walls [m]."""
MIN_DOUBLED_SHARE = 0.03
"""Overlapping lines are merged if they make up at least this fraction of the total length."""
MIN_BROAD_SHARE = 0.5
"""Where no names mark walls, hairlines are not walls if the length of broad lines is at least this multiple of theirs.
"""
MIN_FILLED_RATIO = 2.0
"""Unnamed lines are not walls if the length of filled walls is at least this multiple of theirs."""
MIN_COVERED_SHARE = 0.8
"""A wall is a duplicate of filled shapes if they cover at least this fraction of its area."""


@dataclass(frozen=True, slots=True, eq=False)
class FloorPlan:
    """The result of importing a drawing."""

    world: World
    scale: float
    """Metres per unit of the drawing."""
    corner: tuple[float, float]
    """Point of the drawing that is [0, 0] in the world [units of the drawing]."""
    items: Sequence[FileItem]
    """What became of the contents of the drawing."""


def read_plan(
    drawing: Drawing,
    *,
    name: str = "world",
    scale: float | None = None,
    thickness: float | None = None,
    furniture: bool = True,
) -> FloorPlan:
    """Return the world of a drawing; the lower left corner of its walls becomes [0, 0].

    Args:
        drawing: The drawing.
        name: Name of the world.
        scale: Metres per unit of the drawing; by default as the drawing states.
        thickness: Thickness of the walls [m]; by default as drawn, or 0.1 m for a wall drawn as one hairline.
        furniture: Whether to turn furniture into obstacles.

    Raises:
        UsageError: The drawing has no lines or too many, or its size is not that of a building.
    """
    lines = with_rooms([line for line in drawing.lines if len(line.points) > 1])
    walls = [line for line in lines if line.role == "wall"] or [line for line in lines if line.role is None]
    if not walls:
        seen = f" ({'; '.join(inventory(drawing.items))})" if drawing.items else ""
        raise UsageError(f"'{drawing.name}' has no lines to make walls of{seen}; draw each wall as a line")
    if (count := sum(len(line.points) for line in lines)) > 2 * MAX_CORNERS:
        raise UsageError(f"'{drawing.name}' has {count} corners; walls have at most {MAX_CORNERS}, name their --layer")
    _, metres = corner_and_scale(drawing, walls, scale)
    counts = left_out(lines)
    lines = [replace(line, points=line.points * metres, width=line.width * metres) for line in lines]
    require_sparse(lines, drawing.name)
    found = sorted_lines(with_symbols(with_large_rooms(with_parts(lines))))
    if not found.walls:
        raise UsageError(f"'{drawing.name}' has no lines for walls except white ones; draw walls in another colour")
    if not found.named:
        found = cleared(found, counts)
    corner = np.concatenate([line.points for line in found.walls]).min(axis=0)
    moved = found.moved(corner)
    made, holes = _walls(moved, thickness, counts)
    if not made:
        raise UsageError(f"'{drawing.name}' has no line longer than a centimetre at {metres:g}m per unit")
    named = [wall.model_copy(update={"name": f"wall-{index}"}) for index, wall in enumerate(made, start=1)]
    named = with_openings(named, holes)
    things = _things(moved, named, furniture, counts)
    count_walls(named, counts)
    if not counts["doorway"] and (swings := len(_arcs(moved.doors))):
        counts["door swing beside no gap of a wall"] += swings
    others = len({line.path for line in found.others}) if found.named else 0
    world = World(name=name, walls=tuple(named), obstacles=tuple(things))
    place = (corner / metres).tolist()
    return FloorPlan(world, metres, (place[0], place[1]), [*listed(counts, others), *drawing.items])


def _walls(lines: SortedLines, thickness: float | None, counts: Counter[str]) -> tuple[list[Wall], list[Hole]]:
    """Return the walls and their openings."""
    pens = by_pen(lines.walls)
    solid_bars, columns, inside = bars_of_filled(pens.filled)
    lines.columns.extend(columns)
    counts[FINER] += sum(not line.closed for line in pens.finer)
    pieces, arcs, curves, ribbons = _fine_lines(pens.hair, named=lines.named)
    all_arcs = [*arcs, *_arcs([*lines.doors, *lines.others, *pens.light, *pens.finer])]
    pieces = without_leaves(pieces, all_arcs)
    solid_bars = [
        bar for bar in solid_bars if bar.width > LEAF_TOLERANCE or len(without_leaves(_as_pieces([bar]), all_arcs).ends)
    ]
    pattern, patterns = patterned(pieces)
    counts["pattern of hatches or stairs"] += patterns
    pieces = merged(pieces.where(~pattern))
    bars, straight = _straight_walls(pieces, pens, solid_bars, arcs, lines, counts, bent=bool(curves or ribbons))
    singles = _by_lines(straight, thickness)
    seen = _bars_of_walls(singles)
    join = partial(
        doors_and_windows,
        pieces=_joined_pieces(pieces, lines),
        arcs=all_arcs,
        doors=[outline.points for outline in outlines_of(lines.doors, "door")],
        windows=[outline.points for outline in outlines_of(lines.windows, "window")],
    )
    bars, holes = join(bars)
    whole, more = join(seen) if seen else ([], [])
    if len(whole) < len(seen):  # Doors in the gaps between walls join them.
        singles = _by_bars(whole, thickness)
    more += painted_over(solid_bars, lines.patches, pens.filled, filled=True)
    more += painted_over([bar for bar in [*bars, *seen] if bar not in solid_bars], lines.patches, lines.walls)
    curved = [ribbon.wall(thickness) for ribbon in ribbons]
    walls = [*_by_bars(bars, thickness), *walls_of(curves, bars, thickness), *curved, *singles]
    if walls and thickness is None:
        lines.columns.extend(rest_of_filled(inside, walls))
    return walls, [*holes, *more]


def _fine_lines(lines: Sequence[Line], *, named: bool) -> tuple[Pieces, list[Arc], list[Curve], list[Ribbon]]:
    """Return what hairlines consist of: straight pieces, door swings, round walls and walls between two curves."""
    strokes, rings = [line.points for line in lines], [line.closed for line in lines]
    curves = curves_of(strokes, rings)
    pieces, arcs = without_curves(*split(strokes, rings), curves)
    ribbons = ribbons_of(strokes, rings, curves, named=named)
    return without_ribbons(pieces, ribbons), arcs, curves, ribbons


def _straight_walls(
    pieces: Pieces,
    pens: Pens,
    filled: Sequence[Bar],
    arcs: Sequence[Arc],
    lines: SortedLines,
    counts: Counter[str],
    *,
    bent: bool,
) -> tuple[list[Bar], list[Line]]:
    """Return walls that are filled or have two faces, and the lines that are walls by themselves.

    Args:
        pieces: Straight pieces of hairlines.
        pens: Lines by how they are drawn.
        filled: Filled walls.
        arcs: Door swings of hairlines.
        lines: Lines by their roles.
        counts: Counts of what was left out are added here.
        bent: Whether hairlines draw walls that are not straight.
    """
    found, straight = paired(pieces, usual_only=not lines.named), list(pens.broad)
    faces = float(pieces.lengths[found.faces].sum())
    if bent or faces >= BY_FACES * max(1e-9, float(pieces.lengths.sum())) or (filled and not lines.named):
        seen = _outside_of(_continued_walls(found, pieces, lines, counts), filled, pieces)
        if lines.named or _total(filled) <= MIN_FILLED_RATIO * _total(seen):
            return [*filled, *seen], straight
        counts["pair of lines beside filled walls"] += len(seen)
    elif lines.named or length_of_lines(pens.broad) < MIN_BROAD_SHARE * length_of_lines(pens.hair):
        straight += _without(pens.hair, arcs)
    return [*filled], straight


def _total(bars: Sequence[Bar]) -> float:
    return sum(bar.length for bar in bars)


def _outside_of(bars: Sequence[Bar], filled: Sequence[Bar], pieces: Pieces) -> list[Bar]:
    """Return walls drawn by lines that neither duplicate filled shapes nor are windows between them."""
    import shapely

    if not filled:
        return list(bars)
    covered = shapely.union_all(shapely.polygons([bar.outline(grown=0.02) for bar in filled]))
    found = []
    for bar in bars:
        outline = shapely.Polygon(bar.outline())
        window = bar.length <= MAX_WIDTH and lines_through(bar.ends, bar.width, pieces) >= MIN_PANES
        if not window and outline.intersection(covered).area < MIN_COVERED_SHARE * outline.area:
            found.append(bar)
    return found


def _continued_walls(found: Paired, pieces: Pieces, lines: SortedLines, counts: Counter[str]) -> list[Bar]:
    """Return the walls of pairs of faces, and of single lines where names mark them as walls."""
    bars = continued(found.bars, pieces)
    left = pieces.where(~found.faces)
    long = left.where(left.lengths >= MIN_SINGLE_LINE)
    if not lines.named:
        rings = [line.points for line in lines.walls if line.closed]
        of_room = sides_of_rooms(rings, found.bars, long)
        if of_room.any():
            bars = continued([*bars, *(Bar(*_bar_values(ends)) for ends in long.ends[of_room])], pieces)
        counts["wall drawn by one line"] += int(of_room.sum())
        long = long.where(~of_room)
    if lines.named and len(long.ends):
        single = [Bar(*_bar_values(ends)) for ends in long.ends]
        counts["wall drawn by one line"] += len(single)
        bars += single
    else:
        counts["line without a second face"] += len(long.ends)
    return bars


def _as_pieces(bars: Sequence[Bar]) -> Pieces:
    """Return the centrelines of walls."""
    return Pieces(np.array([bar.ends for bar in bars]).reshape(-1, 2, 2), np.arange(len(bars)))


def _bar_values(ends: Array) -> tuple[float, float, float, float, float]:
    middle, along = ends.mean(axis=0), ends[1] - ends[0]
    thin = drawn_thickness(0.0)
    return float(middle[0]), float(middle[1]), math.atan2(along[1], along[0]), math.hypot(*along), thin


def _without(lines: Sequence[Line], arcs: Sequence[Arc]) -> list[Line]:
    """Return lines other than door-swing arcs, leaves and jambs of doorways."""
    pieces, _ = split([line.points for line in lines], [line.closed for line in lines])
    kept = set(without_jambs(without_leaves(pieces, arcs), arcs).owner.tolist())
    return [line for index, line in enumerate(lines) if index in kept]


def _arcs(lines: Sequence[Line]) -> list[Arc]:
    """Return the door-swing arcs among lines that are not walls."""
    return split([line.points for line in lines], [line.closed for line in lines])[1]


def _joined_pieces(pieces: Pieces, lines: SortedLines) -> Pieces:
    """Return all straight lines that may be window panes."""
    others, _ = split([line.points for line in lines.windows], [line.closed for line in lines.windows])
    return Pieces(np.concatenate([pieces.ends, others.ends]), np.concatenate([pieces.owner, others.owner]))


def _by_lines(lines: Sequence[Line], thickness: float | None) -> list[Wall]:
    """Return walls along lines, thickest first; walls that meet end to end are joined."""
    drawn: dict[float, list[Line]] = {}
    for line in lines:
        width = drawn_thickness(line.width) if thickness is None else thickness
        drawn.setdefault(width, []).append(line)
    walls: list[Wall] = []
    for width, group in sorted(drawn.items(), reverse=True):
        pieces, _ = split([line.points for line in group], [line.closed for line in group])
        if _is_doubled(pieces):
            ends = merged(pieces).ends
            walls += _by_bars([Bar(*_bar_values(each)[:4], width) for each in ends], thickness)
        else:
            walls += [wall for line in joined(group) if (wall := wall_along(line, width)) is not None]
    return walls


def _is_doubled(pieces: Pieces) -> bool:
    """Return whether lines overlap, as outlines of adjacent rooms do."""
    import shapely

    whole = float(pieces.lengths.sum())
    return (
        float(shapely.union_all(shapely.linestrings(np.round(pieces.ends, 3))).length) < (1 - MIN_DOUBLED_SHARE) * whole
    )


def _by_bars(bars: Sequence[Bar], thickness: float | None) -> list[Wall]:
    """Return the runs formed by straight walls, joined as those of a map."""
    small = [
        Bar(
            bar.x / CELL_SIDE,
            bar.y / CELL_SIDE,
            bar.heading,
            bar.length / CELL_SIDE,
            (thickness or bar.width) / CELL_SIDE,
        )
        for bar in bars
    ]
    walls = []
    for run in runs_of(small):
        corners = distinct(run.points * CELL_SIDE, closed=run.closed)
        if len(corners) > 1:
            width = round(run.thickness * CELL_SIDE, DIGITS)
            closed = run.closed and len(corners) > 2
            walls.append(Wall(points=corners, closed=closed, thickness=width, height=WALL_HEIGHT))
    return walls


def _bars_of_walls(walls: Sequence[Wall]) -> list[Bar]:
    """Return the segments of walls as bars."""
    found = []
    for wall in walls:
        for segment in wall.segments():
            x, y, heading, length, _ = _bar_values(np.array(segment))
            found.append(Bar(x, y, heading, length, wall.thickness))
    return found


def _things(lines: SortedLines, walls: Sequence[Wall], furniture: bool, counts: Counter[str]) -> list[Thing]:
    """Return columns, and furniture if requested."""
    columns = outlines_of(lines.columns, "column")
    things = [thing for n, outline in enumerate(columns, start=1) if (thing := column_of(outline, n)) is not None]
    counts["column"] += len(things)
    pieces = _furniture(lines, walls, counts)
    if not furniture:
        counts["unwanted piece of furniture"] += len(pieces)
        return things
    numbers: Counter[str] = Counter()
    for outline in pieces:
        numbers[outline.name] += 1
        thing = thing_of(outline, height=HEIGHT, number=numbers[outline.name])
        if thing is not None:
            things.append(thing)
            counts["piece of furniture"] += 1
            counts[UNEVEN] += isinstance(thing, BoxObstacle) and not is_rectangle(outline.strokes)
    return things


def _furniture(lines: SortedLines, walls: Sequence[Wall], counts: Counter[str]) -> list[Outline]:
    """Return the furniture: what names mark as such, and closed shapes and blocks of that size outside walls.

    A shape with walls all around it is the floor of a room.
    """
    import shapely

    unnamed = [*lines.others, *([] if lines.named else lines.walls)]
    small = [line for line in unnamed if float(np.ptp(line.points, axis=0).max()) <= BY_SIZE[1]]
    closed = [line for line in small if (line.closed or line.part) and (line.dark or 0.0) < MIN_DARKNESS]
    closed = [line for line in closed if line.part or not _arcs([line])]
    shape = solid(World(walls=tuple(walls)))
    # The sections between openings are still part of the wall.
    whole = solid(World(walls=tuple(wall.model_copy(update={"openings": ()}) for wall in walls)))
    inside, around = shape.convex_hull, whole.buffer(FLOOR_GAP)
    rings = {id(line): shapely.linearrings(line.points) for line in closed if line.closed}
    floors = {n for n, ring in rings.items() if ring.intersection(around).length >= MIN_FLOOR_SHARE * ring.length}
    counts["floor of a room"] += len(floors)
    closed = [line for line in closed if id(line) not in floors]
    found = outlines_of(lines.furniture, "furniture")
    for outline in outlines_of(closed, "thing"):
        hull = shapely.MultiPoint(outline.points).convex_hull
        size = np.ptp(outline.points, axis=0)
        fits = BY_SIZE[0] <= float(size.max()) <= BY_SIZE[1] and float(size.min()) >= BY_SIZE[0] / 2
        if fits and inside.covers(hull) and hull.intersection(whole).area <= 0.2 * hull.area:
            found.append(outline)
    return distinct_outlines([part for outline in found for part in outline.parts])
