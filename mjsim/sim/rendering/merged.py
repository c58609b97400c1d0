"""Geoms that pictures show as part of a merged mesh, and the meshes: which of them are drawn."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.compile import merged_into

SEEN, SEEN_ONLY = 0, 1
"""Groups of visible geoms that collide, and of those that do not."""
UNSEEN = 5
"""Group of geoms excluded from one image."""


class Merged:
    """The merged meshes of a compiled model; changes its groups in place."""

    def __init__(self, model: mujoco.MjModel) -> None:
        """Find the meshes and their parts; a model not from mjsim has none."""
        self._model = model
        self._mesh_of = merged_into(model)
        self.parts = np.flatnonzero(self._mesh_of > 0)
        """Geoms that a mesh shows."""
        self._meshes = np.flatnonzero(self._mesh_of < 0)
        solid = (model.geom_contype | model.geom_conaffinity) != 0
        self.groups_apart = np.where(self._mesh_of > 0, np.where(solid, SEEN, SEEN_ONLY), model.geom_group)
        """Group of each geom where all parts are drawn one by one, shape (ngeom,)."""

    @property
    def intact(self) -> bool:
        """Whether all meshes are drawn, and none of their parts by itself."""
        return not (self._model.geom_group[self._meshes] == UNSEEN).any()

    @contextmanager
    def shown_apart(self) -> Iterator[None]:
        """Draw the parts instead of their meshes, so that each pixel has the geom that it shows."""
        groups = self._model.geom_group.copy()
        self._take_apart(self._mesh_of[self.parts])
        try:
            yield
        finally:
            self._model.geom_group[:] = groups

    def take_out(self, geoms: NDArray[np.intp]) -> None:
        """Draw the meshes of some geoms part by part from now on, so that these geoms can be removed."""
        numbers = self._mesh_of[geoms]
        self._take_apart(numbers[numbers > 0])

    def _take_apart(self, numbers: NDArray[np.intp]) -> None:
        group = self._model.geom_group
        whole = self._meshes[np.isin(-self._mesh_of[self._meshes], numbers)]
        whole = whole[group[whole] != UNSEEN]
        parts = self.parts[np.isin(self._mesh_of[self.parts], -self._mesh_of[whole])]
        group[whole], group[parts] = UNSEEN, self.groups_apart[parts]


def visible_parts(model: mujoco.MjModel, groups: Sequence[int]) -> NDArray[np.intp]:
    """Return the geoms that views of some groups show, with the parts of merged meshes instead of these."""
    mesh_of, seen = merged_into(model), np.isin(model.geom_group, groups)
    return np.flatnonzero((seen & (mesh_of >= 0)) | np.isin(-mesh_of, mesh_of[seen & (mesh_of < 0)]))
