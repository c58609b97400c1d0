"""Sorts the lines of a drawing, in metres, by role: by names, by pens, by what is painted over."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.drawings.drawing import MIN_PEN, Line
from mjsim.exchange.drawings.filled import MAX_MEAN_WIDTH, MIN_DARKNESS
from mjsim.exchange.drawings.sheet_frame import without_frames, without_outliers
from mjsim.exchange.drawings.strokes import split
from mjsim.exchange.drawings.united import MIN_SLENDERNESS
from mjsim.exchange.drawings.wall_faces import TOUCHING, merged, paired, sides_of_rooms
from mjsim.exchange.maps import Bar, fitted_rectangle
from mjsim.geometry import Array

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

SAMPLE_LINES, MAX_PAIRS = 200, 5e6
"""Number of sampled lines from which the number of pairs that may cross is estimated, and its maximum."""
MAX_PEN_RATIO = 0.5
"""A pen of at most this fraction of the broadest one is finer than those for walls."""
MIN_THICK_SHARE = 0.5
"""Finer lines are no walls if the length of those with broad pens is at least this multiple of theirs."""
MIN_ROOM_WIDTH = 2.3
"""A wider outline with the name of a kitchen or bath is that of the room, not of furniture [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class SortedLines:
    """The lines of a drawing in metres, by role."""

    walls: list[Line]
    doors: list[Line]
    windows: list[Line]
    furniture: list[Line]
    columns: list[Line]
    others: list[Line]
    """Lines on layers with unknown names."""
    patches: list[Line]
    """Areas in the background colour that hide others."""
    named: bool
    """Whether names of layers show which lines are walls."""

    def moved(self, corner: Array) -> "SortedLines":
        """Return lines translated so that a point of the drawing, shape (2,) [m], is at [0, 0]."""

        def move(group: list[Line]) -> list[Line]:
            return [replace(line, points=line.points - corner) for line in group]

        return replace(
            self,
            walls=move(self.walls),
            doors=move(self.doors),
            windows=move(self.windows),
            furniture=move(self.furniture),
            columns=move(self.columns),
            others=move(self.others),
            patches=move(self.patches),
        )


@dataclass(frozen=True, slots=True, eq=False)
class Pens:
    """Lines of walls by how they are drawn."""

    hair: list[Line]
    broad: list[Line]
    """Lines as wide as a wall."""
    filled: list[Line]
    """Outlines of dark fills."""
    light: list[Line] = field(default_factory=list)
    """Outlines of light fills, which are not walls: floors, objects, door-swing arcs."""
    finer: list[Line] = field(default_factory=list)
    """Lines of pens that are finer than those for walls: objects, door-swing arcs."""


def with_rooms(lines: Sequence[Line]) -> list[Line]:
    """Return lines with room outlines as walls if no names mark walls; otherwise these are notes."""
    if any(line.role == "wall" for line in lines):
        return [replace(line, role="note") if line.role == "room" else line for line in lines]
    return [replace(line, role=None if line.closed else "note") if line.role == "room" else line for line in lines]


def with_large_rooms(lines: Sequence[Line]) -> list[Line]:
    """Return lines in metres with outlines too large for furniture as walls, if no names mark walls."""
    if any(line.role == "wall" for line in lines):
        return list(lines)

    def is_room(line: Line) -> bool:
        return line.role == "furniture" and line.closed and float(np.ptp(line.points, axis=0).min()) >= MIN_ROOM_WIDTH

    return [replace(line, role=None) if is_room(line) else line for line in lines]


def sorted_lines(lines: Sequence[Line]) -> SortedLines:
    """Return lines by role; if none is a wall, those without a role are."""
    patches = [line for line in lines if line.blank and line.role in (None, "wall")]
    painted = {id(line) for line in patches}
    by_role: dict[str | None, list[Line]] = {}
    for line in lines:
        if id(line) not in painted:
            by_role.setdefault(line.role, []).append(line)
    known = "wall" in by_role
    nothing = by_role.get(None, [])
    return SortedLines(
        walls=by_role["wall"] if known else nothing,
        doors=by_role.get("door", []),
        windows=by_role.get("window", []),
        furniture=by_role.get("furniture", []),
        columns=by_role.get("column", []),
        others=nothing if known else [],
        patches=patches,
        named=known,
    )


def cleared(lines: SortedLines, counts: Counter[str]) -> SortedLines:
    """Return lines without sheet frames and items outside the building, if no names mark walls."""
    walls = without_frames(lines.walls)
    counts["line of a frame"] += len(lines.walls) - len(walls)
    inner = without_outliers(walls)
    counts["line outside the building"] += len(walls) - len(inner)
    return replace(lines, walls=inner)


def by_pen(lines: Sequence[Line]) -> Pens:
    """Return lines of walls by how they are drawn: thin, broad, or as outlines of fills."""
    inked = any(_is_filled(line) for line in lines)
    lines = [_darkened(line, inked) for line in lines]
    filled = [line for line in lines if _is_filled(line)]
    light = [
        line
        for line in lines
        if line.dark is not None and (inked or line.width == 0.0) and line.closed and not _is_filled(line)
    ]
    filling = {id(line) for line in _between(light, filled)}
    filled += [replace(line, dark=max(MIN_DARKNESS, line.dark or 0.0)) for line in light if id(line) in filling]
    light = [line for line in light if id(line) not in filling]
    chosen = {id(line) for line in (*filled, *light)} | filling
    drawn = [line for line in lines if id(line) not in chosen]
    thin = {id(line) for line in _finer(drawn)}
    finer = [line for line in drawn if id(line) in thin]
    drawn = [line for line in drawn if id(line) not in thin]
    broad = [line for line in drawn if line.width >= MIN_PEN]
    hair = [line for line in drawn if line.width < MIN_PEN]
    if broad and _are_faces(broad):
        hair, broad = [*hair, *broad], []
    # Where adjacent floors are painted, the walls are the gaps between them.
    return Pens(hair, broad, filled, light, finer) if hair or broad or filled else Pens(light, [], [])


def _finer(lines: Sequence[Line]) -> list[Line]:
    """Return what is drawn with finer pens than walls, where no names mark walls and several pens are that broad."""
    widest = max((line.width for line in lines), default=0.0)
    finer = [line for line in lines if line.width <= MAX_PEN_RATIO * widest]
    if not any(line.width >= MIN_PEN for line in finer) or any(line.role == "wall" for line in lines):
        return []
    thick = length_of_lines(lines) - length_of_lines(finer)
    return finer if thick >= MIN_THICK_SHARE * length_of_lines(finer) else []


def _darkened(line: Line, inked: bool) -> Line:
    """Return a slender rectangle without stroke as dark: it exists for its fill, unless other walls are darker."""
    if line.dark is None or line.width > 0.0 or (inked and line.role != "wall"):
        return line
    bar = fitted_rectangle(line.points)
    return (
        replace(line, dark=max(line.dark, 0.5))
        if bar is not None and bar.length >= MIN_SLENDERNESS * bar.width
        else line
    )


def _between(light: Sequence[Line], filled: Sequence[Line]) -> list[Line]:
    """Return light slender rectangles that connect filled shapes: windows, or walls of another kind."""
    import shapely

    if not light or not filled:
        return []
    dark = shapely.union_all([shapely.make_valid(shapely.Polygon(line.points)) for line in filled])
    found = []
    for line in light:
        bar = fitted_rectangle(line.points)
        if bar is not None and bar.length >= MIN_SLENDERNESS * bar.width and bar.width <= MAX_MEAN_WIDTH:
            found += [line] if _abuts(bar, dark) else []
    return found


def _abuts(bar: Bar, shape: "BaseGeometry") -> bool:
    """Return whether a shape lies beyond both ends of a bar."""
    import shapely

    corners = bar.outline()
    sides = [shapely.LineString(corners[[1, 2]]), shapely.LineString(corners[[3, 0]])]
    return all(side.distance(shape) <= TOUCHING for side in sides)


def _is_filled(line: Line) -> bool:
    return len(line.points) > 2 and line.dark is not None and line.dark >= MIN_DARKNESS


def length_of_lines(lines: Sequence[Line]) -> float:
    """Return the total length of lines [m]."""
    closed = [np.concatenate([line.points, line.points[:1]]) if line.closed else line.points for line in lines]
    return sum(float(np.hypot(*np.diff(points, axis=0).T).sum()) for points in closed)


def _are_faces(lines: Sequence[Line]) -> bool:
    """Return whether broad lines lie in pairs that are clearly farther apart than the lines are wide."""
    pieces, _ = split([line.points for line in lines], [line.closed for line in lines])
    pieces = merged(pieces)
    found = paired(pieces)
    width = float(np.median([line.width for line in lines]))
    rooms = sides_of_rooms([line.points for line in lines if line.closed], found.bars, pieces)
    share = float(pieces.lengths[found.faces | rooms].sum()) / max(1e-9, float(pieces.lengths.sum()))
    return share > 0.6 and bool(found.bars) and float(np.median([bar.width for bar in found.bars])) >= 2.5 * width


def require_sparse(lines: Sequence[Line], name: str) -> None:
    """Check that lines do not all cross each other, since geometry is computed with each pair that may meet.

    Raises:
        UsageError: They do.
    """
    low, high = (
        np.concatenate([extreme(line.points[:-1], line.points[1:]) for line in lines])
        for extreme in (np.minimum, np.maximum)
    )
    some = slice(None, None, max(1, len(low) // SAMPLE_LINES))
    meet = (low[some, None] <= high).all(axis=2) & (low <= high[some, None]).all(axis=2)
    pairs = float(meet.mean()) * len(low) ** 2
    if pairs > MAX_PAIRS:
        raise UsageError(
            f"'{name}' has {pairs / 1e6:.0f} million pairs of lines that may cross; name the --layer of its walls"
        )
