"""Specks of a map: occupied cells that are noise, told from small things by how many of them chance would make."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjsim.errors import UsageError
from mjsim.exchange.pixels import Cells
from mjsim.world import Grid

REACHES = (4, 2, 1)
"""Cells are near to each other, and in one group, when they are no farther apart; the less, the denser the noise."""
SPARSE = 0.5
"""Noise has fewer cells than this near each of its own, or its groups grow without bound."""
SOLVED = 20
"""Steps after which the fraction of noise no longer changes."""
MORE, SOME = 3.0, 2.0
"""So many times as many, and so many more, as chance makes are no noise."""
MOST_SPECK = 12
"""More cells near to each other are never taken for noise."""
MOST_PARTS = 20_000
"""More parts that hang together make no map."""


@dataclass(frozen=True, slots=True, eq=False)
class Cleaned:
    """The occupied cells of a grid without noise."""

    cells: Cells
    """Shape (rows, columns)."""
    noise: float
    """Fraction of the free ground that noise occupies, 0 to 1."""


def without_specks(grid: Grid) -> Cleaned:
    """Return the occupied cells of a grid that are no noise.

    Raises:
        UsageError: They are in more parts than those of a building.
    """
    ground = _ground(grid)
    dense = _noise(grid.occupied, ground, REACHES[-1])
    reach = next((reach for reach in REACHES if _neighbours(reach) * dense < SPARSE), REACHES[-1])
    noise = _noise(grid.occupied, ground, reach)
    groups, sizes = _groups(grid.occupied, reach)
    kept = sizes >= _least(sizes, _neighbours(reach) * noise)
    kept[0] = False
    if (parts := int(np.count_nonzero(kept))) > MOST_PARTS:
        raise UsageError(
            f"the map has {parts} parts, and that of a building at most {MOST_PARTS}; clean it in an image editor"
        )
    return Cleaned(np.asarray(kept[groups] & grid.occupied, dtype=bool), noise)


def has_lone_things(grid: Grid, single: int, *, noise: float) -> bool:
    """Return whether a map has more single cells near others than noise puts there: legs, edges that few beams hit.

    Args:
        grid: The map.
        single: How many single cells there are that hang together with nothing, near others.
        noise: Fraction of the free ground that noise occupies, 0 to 1.
    """
    import cv2

    side = 2 * REACHES[0] + 1
    around = cv2.dilate(grid.occupied.astype(np.uint8), np.ones((side, side), dtype=np.uint8))
    near = int(np.count_nonzero((around > 0) & grid.free))
    return single > MORE * noise * near + SOME


def _ground(grid: Grid) -> Cells:
    """Return the cells that are free, or beside one: what is occupied there stands on free ground."""
    import cv2

    return np.asarray(cv2.dilate(grid.free.astype(np.uint8), np.ones((3, 3), dtype=np.uint8)) > 0)


def _noise(occupied: Cells, ground: Cells, reach: int) -> float:
    """Return the fraction of the ground that noise occupies, by how many cells on it have no other near, 0 to 1.

    Noise of share p leaves p (1 - p)^n of the cells alone among n neighbours, at most where p is 1 / (n + 1).
    """
    _, sizes = _groups(occupied & ground, reach)
    alone = int(np.count_nonzero(sizes == 1)) / max(1, int(np.count_nonzero(ground)))
    neighbours, noise = _neighbours(reach), alone
    for _ in range(SOLVED):
        noise = min(1.0 / (neighbours + 1), alone / (1.0 - noise) ** neighbours)
    return noise


def _neighbours(reach: int) -> int:
    """Return how many cells are that near to one."""
    return (2 * reach + 1) ** 2 - 1


def _least(sizes: NDArray[Any], near: float) -> int:
    """Return how many occupied cells must lie near to each other to be more than noise.

    Noise makes groups of k cells by chance, too; the size is the least of which a map of this size has fewer than one
    by chance, or has many more than chance makes.

    Args:
        sizes: How many cells each group has.
        near: Cells of noise near each cell on average.
    """
    lonely = int(np.count_nonzero(sizes == 1))
    for size in range(2, MOST_SPECK):
        expected = lonely * near ** (size - 1)
        if expected < 1.0 or np.count_nonzero(sizes == size) > MORE * expected + SOME:
            return size
    return MOST_SPECK


def _groups(cells: Cells, reach: int) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return the group of each cell, those near to each other being in one, and how many cells each group has."""
    import cv2

    near = cv2.dilate(cells.astype(np.uint8), np.ones((reach, reach), dtype=np.uint8))
    count, groups = cv2.connectedComponents(near, connectivity=8)
    return groups, np.bincount(groups[cells], minlength=count)
