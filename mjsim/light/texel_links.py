"""Links between neighbouring texels with nothing between them: light is mixed only along links.

A leaf of a door is thinner than a texel. Without links, the light of one side would spread to the other below it.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mjsim.light.charts import Whole
from mjsim.light.light_rays import Light, Room
from mjsim.light.texels import Texels

LINK_HEIGHT = 0.02
"""Height above the surface at which one texel must see the next [m]: more than the gap below a door."""


@dataclass(frozen=True, eq=False)
class Links:
    """Linked pairs of neighbouring texels on the atlas."""

    pairs: Whole
    """Both texels of each pair, those to the right first and then those below, shape (n, 2)."""
    count: int
    """Number of texels."""
    right: NDArray[np.bool_]
    """Whether a texel is linked to the next of its row, shape (rows, columns) of the atlas."""
    down: NDArray[np.bool_]
    """Whether a texel is linked to the next of its column, shape (rows, columns)."""

    @cached_property
    def _mean(self) -> object:
        """Mean over each texel and those linked to it, as a sparse matrix."""
        from scipy.sparse import coo_matrix, diags, identity

        one, other = self.pairs.T
        size = (self.count, self.count)
        both = np.concatenate([one, other]), np.concatenate([other, one])
        near = coo_matrix((np.ones(2 * len(one), np.float32), both), size).tocsr() + identity(
            self.count, np.float32, "csr"
        )
        return diags(1.0 / np.asarray(near.sum(axis=1), dtype=np.float32).ravel()) @ near

    def smoothed(self, values: Light, rounds: int) -> Light:
        """Return values of texels, shape (texels, k), smoothed; each round reaches one texel."""
        for _ in range(rounds):
            values = self._mean @ values  # type: ignore[operator]
        return values

    def reach(self, at: Whole, to: Whole, steps: int) -> NDArray[np.bool_]:
        """Return whether links lead in a straight line from texels to others, shape (n,).

        Args:
            at: Columns and rows on the atlas, shape (n, 2).
            to: Others, at most `steps` away along both, shape (n, 2).
            steps: Number of steps of at most one texel.
        """
        clear, here = np.ones(len(at), dtype=bool), at
        for step in range(1, steps + 1):
            there = np.rint(at + step / steps * (to - at)).astype(np.int64)
            column, row = np.minimum(here, there).T
            clear &= (here[:, 0] == there[:, 0]) | self.right[here[:, 1], column]
            clear &= (here[:, 1] == there[:, 1]) | self.down[row, there[:, 0]]
            here = there
        return clear


def links_of(room: Room, texels: Texels, shape: tuple[int, int], valid: NDArray[np.bool_]) -> Links:
    """Return the links of texels.

    Args:
        room: Surfaces that may stand between them.
        texels: All texels.
        shape: Rows and columns of the atlas; charts do not touch there.
        valid: Texels that count.
    """
    image = np.full((shape[0] + 1, shape[1] + 1), -1)
    image[np.divmod(texels.at[valid], shape[1])] = np.flatnonzero(valid)
    starts = (texels.points + LINK_HEIGHT * texels.normals).astype(np.float32)
    linked, pairs = [], []
    for other in (image[:-1, 1:], image[1:, :-1]):
        one = image[:-1, :-1]
        both = (one >= 0) & (other >= 0)
        way = starts[other[both]] - starts[one[both]]
        length = np.linalg.norm(way, axis=1)
        free = room.is_free(starts[one[both]], way / np.maximum(length, 1e-9)[:, None], length)
        both[both] = free
        linked.append(both)
        pairs.append(np.stack([one[both], other[both]], axis=1))
    return Links(np.concatenate(pairs), len(texels.at), *linked)
