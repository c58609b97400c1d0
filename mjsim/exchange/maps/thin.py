"""Centrelines of occupied areas: thinned to one cell, followed, and cut where they bend."""

import itertools

import numpy as np

from mjsim.exchange.maps.map_pixels import Cells
from mjsim.geometry import Array

MAX_BEND = 1.5
"""Maximum deviation of a line from its cells before it is cut [cells]."""

Cell = tuple[int, int]


def thinned(cells: Cells) -> Cells:
    """Return the cells that remain when layers are removed without breaking connections.

    References:
        Zhang and Suen, A fast parallel algorithm for thinning digital patterns, CACM 27(3), 1984.
    """
    rows, columns = cells.shape
    image = np.zeros((rows + 2, columns + 2), dtype=np.uint8)
    image[1:-1, 1:-1] = cells
    flat, step = image.ravel(), columns + 2
    around = np.array([-step, -step + 1, 1, step + 1, step, step - 1, -1, -step - 1])
    places = np.flatnonzero(flat)
    changed = True
    while changed:
        changed = False
        for first, second in (((0, 2, 4), (2, 4, 6)), ((0, 2, 6), (0, 4, 6))):
            neighbours = flat[places[:, None] + around]
            count = neighbours.sum(axis=1)
            rises = np.count_nonzero((neighbours == 0) & (np.roll(neighbours, -1, axis=1) == 1), axis=1)
            open_sides = (neighbours[:, first].prod(axis=1) == 0) & (neighbours[:, second].prod(axis=1) == 0)
            peeled = (count >= 2) & (count <= 6) & (rises == 1) & open_sides
            flat[places[peeled]] = 0
            places = places[~peeled]
            changed |= bool(peeled.any())
    return np.asarray(image[1:-1, 1:-1].astype(bool))


def lines(cells: Cells, *, spur: float) -> list[Array]:
    """Return the straight lines along thinned cells, both ends each, shape (2, 2), as (column, row) of cell centres.

    Args:
        cells: Thinned cells, as `thinned` returns them.
        spur: Shorter branches with a free end are left out [cells].
    """
    import cv2

    found: list[Array] = []
    for branch, free in _branches(cells):
        if free and len(branch) < spur:
            continue
        points = np.array(branch, dtype=np.float32)[:, ::-1]
        closed = len(branch) > 3 and branch[0] == branch[-1]
        corners = cv2.approxPolyDP(points[:-1] if closed else points, MAX_BEND, closed)[:, 0].astype(float) + 0.5
        if closed:
            corners = np.concatenate([corners, corners[:1]])
        found += [np.array(pair) for pair in itertools.pairwise(corners)]
    return found


def _branches(cells: Cells) -> list[tuple[list[Cell], bool]]:
    """Return the chains of cells between ends and forks, and whether each is a spur: from a fork to a free end."""
    waiting = {(int(row), int(column)) for row, column in zip(*np.nonzero(cells), strict=True)}
    beside = {cell: _beside(cell, waiting) for cell in waiting}
    nodes = [cell for cell, others in beside.items() if len(others) != 2]
    seen: set[tuple[Cell, Cell]] = set()
    found = []
    for start in sorted(nodes):
        for ahead in beside[start]:
            if (start, ahead) not in seen:
                branch = _follow(start, ahead, beside)
                seen |= {(branch[0], branch[1]), (branch[-1], branch[-2])}
                degrees = len(beside[branch[0]]), len(beside[branch[-1]])
                found.append((branch, 1 in degrees and max(degrees) > 2))
        waiting.discard(start)
    for branch, _ in found:
        waiting -= set(branch)
    for start in sorted(waiting):  # rings without a fork
        if start in waiting:
            ring = _follow(start, beside[start][0], beside)
            waiting -= set(ring)
            found.append((ring, False))
    return found


def _follow(start: Cell, ahead: Cell, beside: dict[Cell, list[Cell]]) -> list[Cell]:
    branch = [start, ahead]
    while len(beside[ahead]) == 2 and ahead != start:
        one, other = beside[ahead]
        ahead = other if one == branch[-2] else one
        branch.append(ahead)
    return branch


def _beside(cell: Cell, cells: set[Cell]) -> list[Cell]:
    """Return the neighbours of a cell: across edges, or across a corner where no edge connects them."""
    row, column = cell
    found = [at for at in ((row, column + 1), (row + 1, column), (row, column - 1), (row - 1, column)) if at in cells]
    for down in (-1, 1):
        for right in (-1, 1):
            corner = (row + down, column + right)
            if corner in cells and (row + down, column) not in cells and (row, column + right) not in cells:
                found.append(corner)
    return found
