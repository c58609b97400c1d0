"""Symbols of doors and windows among lines of which names say nothing, or too much; in metres."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mjsim.exchange.drawing import Line
from mjsim.exchange.furnishing import TOUCHING, touching
from mjsim.exchange.pixels import Cells
from mjsim.exchange.roles import Role
from mjsim.exchange.strokes import Arc, Pieces, split
from mjsim.geometry import Array

LARGER = 2.6
"""A block is a door when it is no larger than so many times the radius of the arc in it: two leaves, and a frame."""
LEAF = 0.08
"""What lies so near to where a leaf stands open or shut, and is no longer, is part of it [m]."""
BESIDE = 0.2
"""The lines of one symbol are no farther apart [m]."""
PANES = 3
"""Lines from end to end of a window at least: a rectangle alone is a doorway."""
SPANS = 0.9
"""A pane is at least so much of the length of its window."""


def with_symbols(lines: Sequence[Line]) -> list[Line]:
    """Return lines with the roles of doors and windows where geometry tells them.

    Blocks with the way of a leaf are doors, whatever the layer that they are on. Of symbols on layers of doors and
    windows, those with the way of a leaf are doors, those with three lines from end to end windows, others doors.
    """
    found = list(lines)
    for group in _groups([(n, line) for n, line in enumerate(lines) if line.part], TOUCHING):
        if _is_door([lines[n] for n in group]):
            _become(found, group, "door")
    for reach, symbol in ((TOUCHING, _is_door), (BESIDE, None)):
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
    """Return straight lines without those of the leaves of doors: from where they hang to an end of their way."""
    part = np.zeros(len(pieces.ends), dtype=bool)
    for arc in arcs:
        for end in arc.ends:
            part |= _on(pieces, arc.middle, end)
    return pieces.where(~part)


def _on(pieces: Pieces, start: Array, end: Array) -> Cells:
    """Say which pieces lie along a line, within its length."""
    length = math.dist(start, end)
    unit = (end - start) / max(1e-9, length)
    u = (pieces.ends - start) @ unit
    v = (pieces.ends - start) @ np.array([-unit[1], unit[0]])
    within = (u.min(axis=1) >= -LEAF) & (u.max(axis=1) <= length + LEAF) & (np.abs(v).max(axis=1) <= LEAF)
    return np.asarray(within)


def _groups(lines: Sequence[tuple[int, Line]], reach: float) -> list[list[int]]:
    """Return the numbers of the lines of each placed block without a name that says more, and of each other group."""
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
    """Return whether a symbol has the way of a leaf and is no larger than a door."""
    size = float(np.ptp(np.concatenate([line.points for line in symbol]), axis=0).max())
    arcs = split([line.points for line in symbol], [line.closed for line in symbol])[1]
    return any(size <= LARGER * arc.radius for arc in arcs)


def _has_panes(symbol: Sequence[Line]) -> bool:
    """Return whether more lines than those of a rectangle lead from one end of a symbol to the other."""
    pieces, _ = split([line.points for line in symbol], [line.closed for line in symbol])
    points = pieces.ends.reshape(-1, 2)
    span = float(np.hypot(*np.ptp(points, axis=0))) if len(points) else 0.0
    return int(np.count_nonzero(pieces.lengths >= SPANS * span)) >= PANES
