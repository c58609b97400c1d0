"""Recognises door and window symbols by geometry where layers have unknown names, or several roles; in metres."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mjsim.exchange.drawings.drawing import Line
from mjsim.exchange.drawings.furnishing import MAX_GAP, touching
from mjsim.exchange.drawings.layer_roles import Role
from mjsim.exchange.drawings.strokes import LEAF_TOLERANCE, Arc, Pieces, leaf_tips, split
from mjsim.exchange.maps import Cells
from mjsim.geometry import Array

MAX_BLOCK_RATIO = 2.6
"""Maximum size of a door block, as a multiple of the radius of its arc: two leaves and a frame."""
MAX_JAMB = 0.4
"""Maximum length of a line across the end of a doorway [m]."""
MAX_LINE_DISTANCE = 0.2
"""Maximum distance between the lines of one symbol [m]."""
MIN_PANES = 3
"""Minimum number of lines along a window; two, of a plain rectangle, are a doorway."""
MIN_PANE_SHARE = 0.9
"""Minimum length of a pane, as a fraction of the window's length."""


def with_symbols(lines: Sequence[Line]) -> list[Line]:
    """Return lines with the roles of doors and windows where geometry shows them.

    Blocks with a door-swing arc are doors on any layer. On layers for both doors and windows, symbols with a door-swing
    arc are doors, those with three lines from end to end are windows, and the rest are doors.
    """
    found = list(lines)
    for group in _groups([(n, line) for n, line in enumerate(lines) if line.part], MAX_GAP):
        if _is_door([lines[n] for n in group]):
            _become(found, group, "door")
    for reach, symbol in ((MAX_GAP, _is_door), (MAX_LINE_DISTANCE, None)):
        for group in _groups([(n, line) for n, line in enumerate(found) if line.role == "opening"], reach):
            members = [lines[n] for n in group]
            if symbol is None:
                _become(found, group, "window" if _has_panes(members) else "door")
            elif symbol(members):
                _become(found, group, "door")
    return found


def _become(lines: list[Line], group: Sequence[int], role: Role) -> None:
    for index in group:
        lines[index] = replace(lines[index], role=role)


def without_leaves(pieces: Pieces, arcs: Sequence[Arc]) -> Pieces:
    """Return straight pieces without those of door leaves, which run from the hinge to the door-swing arc."""
    part = np.zeros(len(pieces.ends), dtype=bool)
    for arc in arcs:
        for end in (*arc.ends, *leaf_tips(pieces.ends, arc)):
            part |= _on(pieces, arc.middle, end)
    return pieces.where(~part)


def without_jambs(pieces: Pieces, arcs: Sequence[Arc]) -> Pieces:
    """Return straight pieces without the short ones across the ends of a doorway."""
    middles, part = pieces.ends.mean(axis=1), np.zeros(len(pieces.ends), dtype=bool)
    for place in (place for arc in arcs for place in (arc.middle, *arc.ends)):
        part |= np.hypot(*(middles - place).T) <= LEAF_TOLERANCE
    return pieces.where(~(part & (pieces.lengths <= MAX_JAMB)))


def _on(pieces: Pieces, start: Array, end: Array) -> Cells:
    """Return which pieces lie along a line, within its length."""
    length = math.dist(start, end)
    unit = (end - start) / max(1e-9, length)
    u = (pieces.ends - start) @ unit
    v = (pieces.ends - start) @ np.array([-unit[1], unit[0]])
    within = (
        (u.min(axis=1) >= -LEAF_TOLERANCE)
        & (u.max(axis=1) <= length + LEAF_TOLERANCE)
        & (np.abs(v).max(axis=1) <= LEAF_TOLERANCE)
    )
    return np.asarray(within)


def _groups(lines: Sequence[tuple[int, Line]], reach: float) -> list[list[int]]:
    """Return the line numbers of each block instance without a more specific name, and of each group of other lines."""
    blocks: dict[int, list[int]] = {}
    loose: list[tuple[int, Line]] = []
    for number, line in lines:
        if line.part and line.role in (None, "wall", "opening"):
            blocks.setdefault(line.part, []).append(number)
        elif not line.part:
            loose.append((number, line))
    numbers = {id(line): number for number, line in loose}
    groups = touching([line for _, line in loose], reach=reach)
    return [*blocks.values(), *([numbers[id(line)] for line in group] for group in groups)]


def _is_door(symbol: Sequence[Line]) -> bool:
    """Return whether a symbol has a door-swing arc and is no larger than a door."""
    size = float(np.ptp(np.concatenate([line.points for line in symbol]), axis=0).max())
    arcs = split([line.points for line in symbol], [line.closed for line in symbol])[1]
    return any(size <= MAX_BLOCK_RATIO * arc.radius for arc in arcs)


def _has_panes(symbol: Sequence[Line]) -> bool:
    """Return whether more lines than those of a rectangle run from one end of a symbol to the other."""
    pieces, _ = split([line.points for line in symbol], [line.closed for line in symbol])
    points = pieces.ends.reshape(-1, 2)
    span = float(np.hypot(*np.ptp(points, axis=0))) if len(points) else 0.0
    return int(np.count_nonzero(pieces.lengths >= MIN_PANE_SHARE * span)) >= MIN_PANES
